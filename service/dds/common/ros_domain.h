/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Domain and discovery range of ROS 2 as settings of Cyclone DDS, as rmw_cyclonedds makes them:
 * from the configuration and from ROS_DOMAIN_ID, ROS_AUTOMATIC_DISCOVERY_RANGE, ROS_STATIC_PEERS
 * and the older ROS_LOCALHOST_ONLY (docs.ros.org, "Improved Dynamic Discovery").
 */
#ifndef TFA_SERVICE_DDS_ROS_DOMAIN_H
#define TFA_SERVICE_DDS_ROS_DOMAIN_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <totalforce/status.h>

#include "config/config.h"

/** Longest robot_description that is read, bytes. */
#define TFA_ROS2_DESCRIPTION_MAX (1u << 20)
/** Longest message that the domain must take, bytes: a description, or names of many joints. */
#define TFA_ROS2_SAMPLE_MAX (TFA_ROS2_DESCRIPTION_MAX + 65536u)

/**
 * @param id        of the domain, 0..230
 * @param settings  Cyclone's XML, to stand before that of CYCLONEDDS_URI; release with free; NULL
 *                  on error
 * @param error     the variable or key, its value and the remedy
 * @return TFA_OK; TFA_E_ARGUMENT (a variable is wrong: `error`); TFA_E_MEMORY
 */
TFA_CHECKED int tfa_ros2_domain(const config_ros2 *from, uint32_t *id, char **settings, char *error,
                                size_t size);

/** ROS_LOCALHOST_ONLY=1: the range is LOCALHOST, unless the configuration has one. */
bool tfa_ros2_is_local_only(void);

/** The nodes are of Humble, whose graph messages differ: by the key, else by ROS_DISTRO. */
bool tfa_ros2_is_humble(const config_ros2 *from);

/** Domain of a robot's topics of ROS 2. @param common  that of section "ros2" or the environment */
uint32_t tfa_ros2_domain_of(const config_robot *robot, uint32_t common);

/** True if a robot of the configuration has topics of ROS 2 in this domain. */
bool tfa_ros2_is_in(const config *settings, uint32_t domain, uint32_t common);

#endif
