/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The gateways of the daemon, DDS and ROS 2: made from the configuration, tied to robots and
 * reloads. A build without DDS has none, and refuses a configuration that wants one.
 */
#ifndef TFA_SERVICE_GATEWAYS_H
#define TFA_SERVICE_GATEWAYS_H

#include "control/daemon.h"

struct tfa_dds;
struct tfa_ros2;

/* What the gateways call back with. Zero-initialise but for the daemon. */
typedef struct gateways {
    tfa_daemon *daemon;
    struct tfa_dds *dds;   /* NULL: off */
    struct tfa_ros2 *ros2; /* NULL: off */
    uint32_t dds_count;    /* robots of the DDS gateway: the first of the robot set */
    uint32_t *ros2_robots; /* number in the robot set of each robot of the ROS 2 gateway */
    size_t *ros2_config;   /* and in the configuration */
    uint32_t ros2_count, ros2_domain;
} gateways;

/* Joins the domains: before the workers raise their priority, which Cyclone's threads would
 * inherit. */
TFA_CHECKED int gateways_join(gateways *g);
/* Opens them: when everything can be served. */
TFA_CHECKED int gateways_open(gateways *g);
/* Closes them: the workers still run. */
void gateways_stop(gateways *g);

#endif
