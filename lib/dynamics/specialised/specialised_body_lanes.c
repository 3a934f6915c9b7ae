/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Forward and inverse dynamics of one robot with the bodies of one state in lanes, where the robot
 * has branches that pay (ROBOT_BODY_LANES).
 */
#include "robot_tables.h"

#ifdef ROBOT_BODY_LANES
#define TFA_LANES ROBOT_BODY_LANES

#include "dynamics/specialised/specialised_forward.h"

/* specialised_solve.c */
void tfa_robot_wrenches(const struct tfa_host_api *host, const tfa_request *r, uint32_t k,
                        double x[ROBOT_FREEDOMS]);

/* One body after the other: paths to the world share no lanes. */
static __attribute__((noinline)) void
wrench_forces(num x[ROBOT_UNIT_FREEDOMS], const struct robot_inputs *in,
              const struct tfa_host_api *host, const tfa_request *r, const struct lane_states *at)
{
    double forces[ROBOT_FREEDOMS];
    (void)in;
    tfa_robot_wrenches(host, r, at->lane[0], forces);
    spread_freedoms(x, forces);
}

robot_solve TFA_V(robot_forward);
uint32_t TFA_V(robot_forward)(const struct tfa_host_api *host, const tfa_request *r, uint32_t k,
                              uint32_t count, tfa_reply *reply)
{
    return forward_dynamics(host, r, k, count, reply);
}

robot_solve TFA_V(robot_inverse);
uint32_t TFA_V(robot_inverse)(const struct tfa_host_api *host, const tfa_request *r, uint32_t k,
                              uint32_t count, tfa_reply *reply)
{
    return inverse_dynamics(host, r, k, count, reply);
}

#endif
