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

/* A ROS 2 gateway: of the robots in one domain. */
typedef struct ros2_domain {
    struct gateways *all;
    struct tfa_ros2 *gateway;
    uint32_t id;
    uint32_t *robots; /* in the robot set */
    size_t *config;   /* and in the configuration */
    uint32_t count;
} ros2_domain;

/* Zero-initialise but for the daemon. */
typedef struct gateways {
    tfa_daemon *daemon;
    struct tfa_dds *dds; /* NULL: off */
    uint32_t dds_count;  /* its robots: the first of the robot set */
    ros2_domain *ros2;   /* one for each domain of ROS 2 */
    uint32_t ros2_count;
} gateways;

/* Is what the configuration and the environment say of the gateways possible? Joins nothing. */
TFA_CHECKED int gateways_check(const config *settings);
/* Joins the domains: before the workers raise their priority, which Cyclone's threads would
 * inherit. */
TFA_CHECKED int gateways_join(gateways *g);
/* Opens them: when everything can be served. */
TFA_CHECKED int gateways_open(gateways *g);
/* Closes them: the workers still run. */
void gateways_stop(gateways *g);

#endif
