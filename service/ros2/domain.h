/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Domain and discovery range of ROS 2 as settings of Cyclone DDS, as rmw_cyclonedds makes them:
 * from the configuration and from ROS_DOMAIN_ID, ROS_AUTOMATIC_DISCOVERY_RANGE and
 * ROS_STATIC_PEERS (docs.ros.org, "Improved Dynamic Discovery").
 */
#ifndef TFA_ROS2_DOMAIN_H
#define TFA_ROS2_DOMAIN_H

#include <stddef.h>
#include <stdint.h>
#include <totalforce/status.h>

#include "config/config.h"

/**
 * @param id        of the domain, 0..230
 * @param settings  Cyclone's XML, to stand before that of CYCLONEDDS_URI; release with free; NULL
 *                  on error
 * @param error     the variable or key, its value and the remedy
 * @return TFA_OK; TFA_E_ARGUMENT (a variable is wrong: `error`); TFA_E_MEMORY
 */
TFA_CHECKED int tfa_ros2_domain(const config_ros2 *from, uint32_t *id, char **settings, char *error,
                                size_t size);

#endif
