/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Names of ROS 2 (design.ros2.org, "Topic and Service name mapping to DDS"), as texts.
 */
#ifndef TFA_SERVICE_ROS2_NAMES_H
#define TFA_SERVICE_ROS2_NAMES_H

#include <stdbool.h>
#include <stddef.h>

#define TFA_ROS2_NAME_MAX 247 /* bytes of a full name: a DDS topic of 255 with its prefix */

#define TFA_ROS2_DEFAULT_NAMESPACE "/"
#define TFA_ROS2_DEFAULT_NODE "totalforce"
#define TFA_ROS2_LONGEST_NAME "external_base_wrench" /* of those below the node */
#define TFA_ROS2_BLANKS " \t\n\r"                    /* between names in a text */

/** A token: a letter or underscore, then letters, digits and underscores, no two of them. */
bool tfa_ros2_is_node_name(const char *name);

/** Starts with '/', has tokens between single slashes, or is "/" alone. */
bool tfa_ros2_is_namespace(const char *name);

/**
 * Full name of a topic or service: "/x" is taken as it is, "~/x" is below the node, "x" below the
 * namespace.
 * @param full  "/arm/joint_states"; empty if it returns false
 * @return false: not a name, or longer than TFA_ROS2_NAME_MAX
 */
bool tfa_ros2_full_name(const char *name_space, const char *node, const char *name,
                        char full[TFA_ROS2_NAME_MAX + 1]);

#endif
