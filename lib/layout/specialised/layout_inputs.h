/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Between the arrays of a request and the lanes of a robot's specialised kernel.
 */
#ifndef TFA_LAYOUT_INPUTS_H
#define TFA_LAYOUT_INPUTS_H

#include "interface/specialised_abi.h"
#include "layout/state.h"

/* The number of request arrays that stands in every lane: that of states k ..; lanes without a
 * state repeat the last one. */
struct lane_states {
    uint32_t lane[NUM_LANES];
};

TFA_INLINE num gather_input(const struct lane_states *at, const double *array, size_t stride,
                            size_t index)
{
    return array ? num_gather(array + index, stride, at->lane) : num_of(0);
}

TFA_INLINE void gather_position(struct robot_inputs *in, const struct lane_states *at,
                                const tfa_request *r, size_t k)
{
    const struct tfa_coordinate *c = &robot_coordinate[k];
    in->q[k] =
        num_of(c->multiplier) * gather_input(at, r->q, ROBOT_Q_COUNT, c->from) + num_of(c->offset);
}

/* Are the coordinates those of the request, one by one? */
TFA_INLINE int is_identity_map(void)
{
    int identity = NUM_LANES == 1;
#pragma GCC unroll 64
    for (uint32_t k = 0; k < ROBOT_COORDINATES; k++)
        identity &= robot_coordinate[k].from == k && robot_coordinate[k].multiplier == 1 &&
                    robot_coordinate[k].offset == 0;
    return identity;
}

/* Where the coordinates stand. Sines are taken of them by the vector, which would wait for numbers
 * copied one by one. */
TFA_INLINE const num *joint_angles(const struct robot_inputs *in, const struct lane_states *at,
                                   const tfa_request *r)
{
    return is_identity_map() ? (const num *)(r->q + (size_t)ROBOT_Q_COUNT * at->lane[0]) : in->q;
}

TFA_INLINE void gather_positions(struct robot_inputs *in, const struct lane_states *at,
                                 const tfa_request *r)
{
    in->angle = joint_angles(in, at, r);
#pragma GCC unroll 64
    for (size_t k = 0; k < ROBOT_COORDINATES && !is_identity_map(); k++)
        gather_position(in, at, r, k);
    for (size_t k = 0; ROBOT_BASE && k < 7; k++)
        in->base[k] = gather_input(at, r->base_pose, 7, k);
}

/* Base six, then joints; NULL: zero */
TFA_INLINE void gather_freedoms(num *out, const struct lane_states *at, const double *base,
                                const double *joints)
{
#pragma GCC unroll 64
    for (size_t k = 0; k < ROBOT_BASE; k++)
        out[k] = gather_input(at, base, 6, k);
#pragma GCC unroll 64
    for (size_t k = ROBOT_BASE; k < ROBOT_FREEDOMS; k++) {
        const struct tfa_freedom *f = &robot_freedom[k - ROBOT_BASE];
        out[k] = num_of(f->multiplier) * gather_input(at, joints, ROBOT_V_COUNT, f->from);
    }
}

/* tau += sign d qd */
TFA_INLINE void add_damping(num *tau, const num *qd, double sign)
{
    for (size_t k = ROBOT_BASE; ROBOT_DAMPED && k < ROBOT_FREEDOMS; k++)
        tau[k] += num_of(sign * robot_damping[k]) * qd[k];
}

/* Base six, then joints, of the first `count` lanes; either array may be NULL. */
TFA_INLINE void scatter_outputs(const num *x, double *base, double *joints, uint32_t count)
{
    for (uint32_t l = 0; base && l < count; l++)
#pragma GCC unroll 64
        for (size_t j = 0; j < ROBOT_BASE; j++)
            base[6 * l + j] = num_lane(x[j], l);
    for (uint32_t l = 0; joints && l < count; l++)
#pragma GCC unroll 64
        for (size_t j = ROBOT_BASE; j < ROBOT_FREEDOMS; j++)
            joints[(size_t)ROBOT_V_COUNT * l + robot_freedom[j - ROBOT_BASE].from] =
                num_lane(x[j], l);
}

#endif
