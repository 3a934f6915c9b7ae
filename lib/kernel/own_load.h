/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Between the arrays of a request and the lanes of a robot's own kernel.
 */
#ifndef TFA_KERNEL_OWN_LOAD_H
#define TFA_KERNEL_OWN_LOAD_H

#include <string.h>

#include "kernel/own_abi.h"
#include "kernel/state.h"

/* Below 2^900: the sign bit stays clear. A singular robot's answers are above, or not numbers. */
#define OWN_EXPONENT (UINT64_C(0x7ff) << 52)
#define OWN_TOO_LARGE ((uint64_t)(0x800 - (0x3ff + 900)) << 52)

TFA_INLINE int own_is_sound(const num *x, size_t count)
{
    uint64_t sign = 0;
    for (size_t k = 0; k < count * NUM_LANES; k++) {
        uint64_t bits;
        memcpy(&bits, (const char *)x + k * sizeof(double), sizeof bits);
        sign |= (bits & OWN_EXPONENT) + OWN_TOO_LARGE;
    }
    return !(sign >> 63);
}

#ifdef TFA_PACKED
#include "kernel/own_packed_load.h"
#else

/* The number of request arrays that stands in every lane: that of states k ..; lanes without a state
 * repeat the last one. */
struct own_lanes {
    uint32_t lane[NUM_LANES];
};

TFA_INLINE num own_take(const struct own_lanes *at, const double *array, size_t stride,
                        size_t index)
{
    return array ? num_gather(array + index, stride, at->lane) : num_of(0);
}

TFA_INLINE void own_take_coordinate(struct own_inputs *in, const struct own_lanes *at,
                                    const tfa_request *r, size_t k)
{
    const struct tfa_coordinate *c = &own_coordinate[k];
    in->q[k] = num_of(c->multiplier) * own_take(at, r->q, OWN_Q_COUNT, c->from) + num_of(c->offset);
}

/* Are the coordinates those of the request, one by one? */
TFA_INLINE int own_is_straight(void)
{
    int straight = NUM_LANES == 1;
#pragma GCC unroll 64
    for (uint32_t k = 0; k < OWN_COORDINATES; k++)
        straight &= own_coordinate[k].from == k && own_coordinate[k].multiplier == 1 &&
                    own_coordinate[k].offset == 0;
    return straight;
}

/* Where the coordinates stand. Sines are taken of them by the vector, which would wait for numbers copied one
 * by one. */
TFA_INLINE const num *own_angles(const struct own_inputs *in, const struct own_lanes *at,
                                 const tfa_request *r)
{
    return own_is_straight() ? (const num *)(r->q + (size_t)OWN_Q_COUNT * at->lane[0]) : in->q;
}

TFA_INLINE void own_take_coordinates(struct own_inputs *in, const struct own_lanes *at,
                                     const tfa_request *r)
{
    in->angle = own_angles(in, at, r);
#pragma GCC unroll 64
    for (size_t k = 0; k < OWN_COORDINATES && !own_is_straight(); k++)
        own_take_coordinate(in, at, r, k);
    for (size_t k = 0; OWN_BASE && k < 7; k++)
        in->base[k] = own_take(at, r->base_pose, 7, k);
}

/* Base six, then joints; NULL: zero */
TFA_INLINE void own_take_freedoms(num *out, const struct own_lanes *at, const double *base,
                                  const double *joints)
{
#pragma GCC unroll 64
    for (size_t k = 0; k < OWN_BASE; k++)
        out[k] = own_take(at, base, 6, k);
#pragma GCC unroll 64
    for (size_t k = OWN_BASE; k < OWN_FREEDOMS; k++) {
        const struct tfa_freedom *f = &own_freedom[k - OWN_BASE];
        out[k] = num_of(f->multiplier) * own_take(at, joints, OWN_V_COUNT, f->from);
    }
}

/* tau += sign d qd */
TFA_INLINE void own_damp(num *tau, const num *qd, double sign)
{
    for (size_t k = OWN_BASE; OWN_DAMPED && k < OWN_FREEDOMS; k++)
        tau[k] += num_of(sign * own_damping[k]) * qd[k];
}

/* Base six, then joints, of the first `count` lanes; either array may be NULL. */
TFA_INLINE void own_give(const num *x, double *base, double *joints, uint32_t count)
{
    for (uint32_t l = 0; base && l < count; l++)
#pragma GCC unroll 64
        for (size_t j = 0; j < OWN_BASE; j++)
            base[6 * l + j] = num_lane(x[j], l);
    for (uint32_t l = 0; joints && l < count; l++)
#pragma GCC unroll 64
        for (size_t j = OWN_BASE; j < OWN_FREEDOMS; j++)
            joints[(size_t)OWN_V_COUNT * l + own_freedom[j - OWN_BASE].from] = num_lane(x[j], l);
}

#endif
#endif
