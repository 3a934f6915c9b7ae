/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The gateways of the daemon, as one list.
 */
#ifndef TFA_SERVICE_CONTROL_GATEWAYS_H
#define TFA_SERVICE_CONTROL_GATEWAYS_H

#include "control/robot_set.h"
#include "gateway/gateway.h"

/* Checks configuration and environment of the gateways without joining a domain. */
TFA_CHECKED int gateways_check(const config *settings);
/* Checks and logs whether a robot's part of the configuration fits its models. Any thread.
 * @param served  the robot, then its scenes
 * @param text  receives the same without the place in the file; NULL is allowed */
TFA_CHECKED int gateways_check_robot(const config *settings, const config_robot *robot,
                                     const tfa_robot *served, char *text, size_t size);
TFA_CHECKED int gateways_join(tfa_daemon *d);
/* Makes their solvers and opens them: when everything can be served. */
TFA_CHECKED int gateways_start(tfa_daemon *d);
/* Closes them: the workers still run. Their solvers stay: a reload's thread may read the table. */
void gateways_stop(tfa_daemon *d);
/* The slot of this source if it serves the robot, otherwise NULL. */
const gateway_slot *gateways_of_robot(const tfa_daemon *d, uint32_t source, uint32_t robot);

/* The next slot after `last` that serves the robot, of NULL the first; NULL: there is none. */
const gateway_slot *gateways_next(const tfa_daemon *d, uint32_t robot, const gateway_slot *last);

#endif
