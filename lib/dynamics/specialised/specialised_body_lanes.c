/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Forward dynamics of one robot with the bodies of one state in lanes, where the robot has branches
 * that pay (ROBOT_BODY_LANES).
 */
#include "robot_tables.h"

#ifdef ROBOT_BODY_LANES
#define TFA_LANES ROBOT_BODY_LANES

#include "dynamics/specialised/specialised_forward.h"

robot_solve TFA_V(robot_forward);
int TFA_V(robot_forward)(const struct tfa_host_api *host, const tfa_request *r, uint32_t k,
                         uint32_t count, tfa_reply *reply)
{
    return forward_dynamics(host, r, k, count, reply);
}

#endif
