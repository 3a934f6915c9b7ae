/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Forward and inverse dynamics of one robot, and the inputs and outputs that all operations share.
 */
#ifndef TFA_DYNAMICS_SPECIALISED_SPECIALISED_FORWARD_H
#define TFA_DYNAMICS_SPECIALISED_SPECIALISED_FORWARD_H

#include "algorithm.h" /* of the folder aba or crba */
#include "dynamics/specialised/specialised_supports.h"

/* States k .. k + count - 1 of a request; returns those whose answer counts, as bits */
typedef uint32_t robot_solve(const struct tfa_host_api *host, const tfa_request *r, uint32_t k,
                             uint32_t count, tfa_reply *reply);

/* ---- inputs and outputs ---- */

/* Without the states where the sentinel trips: a generic kernel estimates their error. */
TFA_INLINE uint32_t answered_states(const struct state *s, const tfa_request *r, num_mask finite)
{
    if (r->estimate != TFA_ESTIMATE_NEVER)
        finite &= s->margin >= 0;
    return states_of_mask(finite);
}

/* State k and those behind it; lanes that are left over repeat the last one */
TFA_INLINE struct lane_states lanes_of_states(uint32_t k, uint32_t count)
{
    struct lane_states at;
    for (uint32_t l = 0; l < sizeof at.lane / sizeof *at.lane; l++)
        at.lane[l] = k + (l < count ? l : count - 1);
    return at;
}

/* Sines and cosines of coordinates first .. end - 1 */
TFA_INLINE void joint_sincos(struct robot_inputs *in, size_t first, size_t end)
{
    lane_sincos_unpadded((const lane_real *)(in->angle + first), (lane_real *)(in->sine + first),
                         (lane_real *)(in->cosine + first), (end - first) * NUM_LANES);
}

TFA_INLINE void load_positions(struct robot_inputs *in, const tfa_request *r,
                               const struct lane_states *at)
{
    gather_positions(in, at, r, 0, ROBOT_COORDINATES);
    joint_sincos(in, 0, ROBOT_UNIT_COORDINATES);
}

/* x = J^T w of the request's wrenches: specialised_wrenches.h, or specialised_body_lanes.c */
static void wrench_forces(num x[ROBOT_UNIT_FREEDOMS], const struct robot_inputs *in,
                          const struct tfa_host_api *host, const tfa_request *r,
                          const struct lane_states *at);

/* tau += sign J^T w */
TFA_INLINE void add_wrenches(num *tau, double sign, const struct robot_inputs *in,
                             const struct tfa_host_api *host, const tfa_request *r,
                             const struct lane_states *at)
{
    num forces[ROBOT_UNIT_FREEDOMS];
    if (!r->wrench_count)
        return;
    wrench_forces(forces, in, host, r, at);
    for (size_t k = 0; k < ROBOT_UNIT_FREEDOMS; k++)
        tau[k] += num_of(sign) * forces[k];
}

/* As TFA_V(leave_boost) of dynamics/solve/load.h, of the base */
TFA_INLINE void leave_boost(struct robot_inputs *in)
{
    if (!ROBOT_BASE)
        return;
    const vec3 rate =
        v3_cross(v3(in->qd[3], in->qd[4], in->qd[5]), v3(in->qd[0], in->qd[1], in->qd[2]));
    in->qd[0] = in->qd[1] = in->qd[2] = num_of(0);
    in->boost_rate[0] = rate.x;
    in->boost_rate[1] = rate.y;
    in->boost_rate[2] = rate.z;
}

/* To the frame that moves along (sign 1), or to that of the world (-1) */
TFA_INLINE void shift_accelerations(num *qdd, const struct robot_inputs *in, double sign)
{
    for (size_t k = 0; ROBOT_BASE && k < 3; k++)
        qdd[k] += num_of(sign) * in->boost_rate[k];
}

TFA_INLINE void load_forward_inputs(struct robot_inputs *in, const struct tfa_host_api *host,
                                    const tfa_request *r, const struct lane_states *at)
{
    load_positions(in, r, at);
    gather_freedoms(in->qd, at, r->base_twist, r->v);
    gather_freedoms(in->x, at, r->base_wrench, r->tau);
    add_dissipation(in->x, in->qd, -1);
    add_wrenches(in->x, 1, in, host, r, at);
    leave_boost(in);
}

static __attribute__((flatten, noinline)) uint32_t forward_dynamics(const struct tfa_host_api *host,
                                                                    const tfa_request *r,
                                                                    uint32_t k, uint32_t count,
                                                                    tfa_reply *reply)
{
    const struct lane_states at = lanes_of_states(k, count);
    struct robot_inputs in;
    struct state s;
    struct robot_factors factors;
    num qdd[ROBOT_UNIT_FREEDOMS];
    load_forward_inputs(&in, host, r, &at);
    init_state(&s, &in, host, r);
    solve_forward(&s, &factors, in.x, qdd);
    shift_accelerations(qdd, &in, -1);
    scatter_outputs(qdd, &at, reply->base_acceleration, reply->qdd);
    return answered_states(&s, r, finite_states(qdd, ROBOT_UNIT_FREEDOMS));
}

static __attribute__((flatten, noinline)) uint32_t inverse_dynamics(const struct tfa_host_api *host,
                                                                    const tfa_request *r,
                                                                    uint32_t k, uint32_t count,
                                                                    tfa_reply *reply)
{
    const struct lane_states at = lanes_of_states(k, count);
    struct robot_inputs in;
    struct state s;
    num tau[ROBOT_UNIT_FREEDOMS];
    if (r->wrench_count && !ROBOT_HAS_INVERSE_WRENCHES)
        return TFA_SPECIALISED_NO_CODE;
    load_positions(&in, r, &at);
    gather_freedoms(in.qd, &at, r->base_twist, r->v);
    gather_freedoms(in.x, &at, r->base_acceleration, r->qdd);
    leave_boost(&in);
    shift_accelerations(in.x, &in, 1);
    init_state(&s, &in, host, r);
    inverse_rnea(&s, in.x, tau);
    add_dissipation(tau, in.qd, 1);
    if (ROBOT_HAS_INVERSE_WRENCHES)
        add_wrenches(tau, -1, &in, host, r, &at);
    scatter_outputs(tau, &at, reply->base_wrench, reply->tau);
    return states_of_mask(finite_states(tau, ROBOT_UNIT_FREEDOMS));
}

#endif
