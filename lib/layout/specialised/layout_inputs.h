/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Between the arrays of a request and the lanes of a robot's specialised kernel.
 */
#ifndef TFA_LAYOUT_INPUTS_H
#define TFA_LAYOUT_INPUTS_H

#include "interface/specialised_abi.h"
#include "layout/state.h"
#include "spatial/friction.h"
#include "spatial/rows.h"

/* The number of request arrays that stands in every lane: that of states k ..; lanes without a
 * state repeat the last one. */
struct lane_states {
    uint32_t lane[NUM_LANES];
};

/* The states for which a condition holds, as bits */
TFA_INLINE uint32_t states_of_mask(num_mask holds)
{
#if NUM_LANES == 1
    return holds != 0;
#else
    uint32_t states = 0;
    if (num_all(holds))
        return (UINT32_C(1) << NUM_LANES) - 1;
    for (uint32_t l = 0; l < NUM_LANES; l++)
        states |= (uint32_t)(holds[l] & 1) << l;
    return states;
#endif
}

/* out[first] .. out[end - 1]: the same numbers of every state, `stride` each; NULL: zero */
TFA_INLINE void gather_numbers(num *out, const struct lane_states *at, const double *array,
                               size_t stride, size_t first, size_t end)
{
    size_t k = first;
#ifdef NUM_ROW
    if (array && end >= first + NUM_ROW) {
#pragma GCC unroll 64
        for (; k + NUM_ROW <= end; k += NUM_ROW)
            rows_gather(out + k, array + k, stride, at->lane);
        if (k < end)
            rows_gather(out + end - NUM_ROW, array + end - NUM_ROW, stride, at->lane);
        k = end;
    }
#endif
#pragma GCC unroll 64
    for (; k < end; k++)
        out[k] = array ? num_gather(array + k, stride, at->lane) : num_of(0);
}

/* Whether the coordinates are those of the request, one by one */
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

/* Coordinates first .. end - 1, and the base */
TFA_INLINE void gather_positions(struct robot_inputs *in, const struct lane_states *at,
                                 const tfa_request *r, size_t first, size_t end)
{
    num q[ROBOT_Q_COUNT];
    size_t from = ROBOT_Q_COUNT, to = 0;
#pragma GCC unroll 64
    for (size_t k = first; k < end; k++) {
        from = robot_coordinate[k].from < from ? robot_coordinate[k].from : from;
        to = robot_coordinate[k].from >= to ? robot_coordinate[k].from + 1 : to;
    }
    in->angle = joint_angles(in, at, r);
    if (!is_identity_map())
        gather_numbers(q, at, r->q, ROBOT_Q_COUNT, from, to);
#pragma GCC unroll 64
    for (size_t k = first; k < end && !is_identity_map(); k++) {
        const struct tfa_coordinate *c = &robot_coordinate[k];
        in->q[k] = num_of(c->multiplier) * q[c->from] + num_of(c->offset);
    }
    if (ROBOT_BASE)
        gather_numbers(in->base, at, r->base_pose, 7, 0, 7);
}

/* Base six, then joints; NULL: zero */
TFA_INLINE void gather_freedoms(num *out, const struct lane_states *at, const double *base,
                                const double *joints)
{
    num x[ROBOT_V_COUNT];
    gather_numbers(out, at, base, 6, 0, ROBOT_BASE);
    gather_numbers(x, at, joints, ROBOT_V_COUNT, 0, ROBOT_V_COUNT);
#pragma GCC unroll 64
    for (size_t k = ROBOT_BASE; k < ROBOT_FREEDOMS; k++) {
        const struct tfa_freedom *f = &robot_freedom[k - ROBOT_BASE];
        out[k] = num_of(f->multiplier) * x[f->from];
    }
}

/* tau += sign (damping and friction) */
TFA_INLINE void add_dissipation(num *tau, const num *qd, double sign)
{
    const num scale = num_of(robot_friction_velocity);
    for (size_t k = ROBOT_BASE; ROBOT_DAMPED && k < ROBOT_FREEDOMS; k++)
        tau[k] += num_of(sign * robot_damping[k]) * qd[k];
    for (size_t k = ROBOT_BASE; ROBOT_HAS_FRICTION && k < ROBOT_FREEDOMS; k++)
        tau[k] += num_of(sign * robot_friction[k]) * friction_sign(qd[k], scale);
}

/* Base six, then joints; either array may be NULL. */
TFA_INLINE void scatter_outputs(const num *x, const struct lane_states *at, double *base,
                                double *joints)
{
    num y[ROBOT_V_COUNT];
#pragma GCC unroll 64
    for (size_t j = ROBOT_BASE; j < ROBOT_FREEDOMS; j++)
        y[robot_freedom[j - ROBOT_BASE].from] = x[j];
    if (base)
        scatter_numbers(x, at->lane, base, 6, ROBOT_BASE);
    if (joints)
        scatter_numbers(y, at->lane, joints, ROBOT_V_COUNT, ROBOT_V_COUNT);
}

#endif
