/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Operations of one robot by one algorithm (folder aba or crba) over one number type: one state at
 * a time, or a batch of states in lanes. ROBOT_PAYLOADS: with inertias that are read at run time,
 * for payloads; inertias as inputs of all would make inverse dynamics of a humanoid 1.5 times as
 * slow.
 *
 * Compilers are told that numbers are finite and zeros have no sign, or 0 x would not be 0. Numbers
 * that are not finite are found by their bits.
 */
#include "dynamics/specialised/specialised_mass.h"
#include "dynamics/specialised/specialised_tip.h"
#include "dynamics/specialised/specialised_wrenches.h"

/* Where branches pay in lanes, one state by articulated bodies is specialised_body_lanes.c. */
#if ROBOT_HAS_FORWARD &&                                                                           \
    !(defined ROBOT_BODY_LANES && NUM_LANES == 1 && !ROBOT_BY_CRBA && !defined ROBOT_PAYLOADS)
#define ROBOT_FORWARD_HERE
#endif

#ifdef ROBOT_FORWARD_HERE
robot_solve TFA_V(robot_forward);
uint32_t TFA_V(robot_forward)(const struct tfa_host_api *host, const tfa_request *r, uint32_t k,
                              uint32_t count, tfa_reply *reply)
{
    return forward_dynamics(host, r, k, count, reply);
}
#endif

#if defined ROBOT_BODY_LANES && defined ROBOT_INVERSE && NUM_LANES == 1
/* x = J^T w of state k, for specialised_body_lanes.c */
void tfa_robot_wrenches(const struct tfa_host_api *host, const tfa_request *r, uint32_t k,
                        double x[ROBOT_FREEDOMS])
{
    const struct lane_states at = lanes_of_states(k, 1);
    struct robot_inputs in;
    load_positions(&in, r, &at);
    wrench_forces(x, &in, host, r, &at);
}
#endif

#if defined ROBOT_INVERSE || defined ROBOT_PAYLOADS
static __attribute__((flatten, noinline)) uint32_t inverse_dynamics(const struct tfa_host_api *host,
                                                                    const tfa_request *r,
                                                                    uint32_t k, uint32_t count,
                                                                    tfa_reply *reply)
{
    const struct lane_states at = lanes_of_states(k, count);
    struct robot_inputs in;
    struct state s;
    num tau[ROBOT_FREEDOMS];
    if (r->wrench_count && !ROBOT_HAS_INVERSE_WRENCHES)
        return TFA_SPECIALISED_NO_CODE;
    load_positions(&in, r, &at);
    gather_freedoms(in.qd, &at, r->base_twist, r->v);
    gather_freedoms(in.x, &at, r->base_acceleration, r->qdd);
    leave_boost(&in);
    shift_accelerations(in.x, &in, 1);
    init_state(&s, &in, host, r);
    inverse_rnea(&s, in.x, tau);
    add_damping(tau, in.qd, 1);
    if (ROBOT_HAS_INVERSE_WRENCHES)
        add_wrenches(tau, -1, &in, host, r, &at);
    scatter_outputs(tau, &at, reply->base_wrench, reply->tau);
    return states_of_mask(finite_states(tau, ROBOT_FREEDOMS));
}

robot_solve TFA_V(robot_inverse);
uint32_t TFA_V(robot_inverse)(const struct tfa_host_api *host, const tfa_request *r, uint32_t k,
                              uint32_t count, tfa_reply *reply)
{
    return inverse_dynamics(host, r, k, count, reply);
}

robot_solve TFA_V(robot_mass);
uint32_t TFA_V(robot_mass)(const struct tfa_host_api *host, const tfa_request *r, uint32_t k,
                           uint32_t count, tfa_reply *reply)
{
    return mass_matrix(host, r, k, count, reply);
}
#endif

#if !defined ROBOT_PAYLOADS && (NUM_LANES == 1 || ROBOT_HAS_BATCH_TIPS)
robot_solve TFA_V(robot_lambda);
uint32_t TFA_V(robot_lambda)(const struct tfa_host_api *host, const tfa_request *r, uint32_t k,
                             uint32_t count, tfa_reply *reply)
{
    return lambda(host, r, k, count, reply);
}

#ifdef ROBOT_FORWARD_HERE
robot_solve TFA_V(robot_forward_lambda);
uint32_t TFA_V(robot_forward_lambda)(const struct tfa_host_api *host, const tfa_request *r,
                                     uint32_t k, uint32_t count, tfa_reply *reply)
{
    return forward_and_lambda(host, r, k, count, reply);
}
#endif
#endif
