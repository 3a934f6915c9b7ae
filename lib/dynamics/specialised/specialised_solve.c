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

/* Where branches pay in lanes, forward dynamics by articulated bodies and inverse dynamics of one
 * state are those of specialised_body_lanes.c. */
#if !(defined ROBOT_BODY_LANES && NUM_LANES == 1 && !ROBOT_BY_CRBA && !defined ROBOT_PAYLOADS)
#define ROBOT_DYNAMICS_HERE
#endif
#if ROBOT_HAS_FORWARD && defined ROBOT_DYNAMICS_HERE
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
#ifdef ROBOT_DYNAMICS_HERE
robot_solve TFA_V(robot_inverse);
uint32_t TFA_V(robot_inverse)(const struct tfa_host_api *host, const tfa_request *r, uint32_t k,
                              uint32_t count, tfa_reply *reply)
{
    return inverse_dynamics(host, r, k, count, reply);
}
#endif

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
