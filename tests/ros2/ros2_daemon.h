/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The one daemon of a test program, the node beside it, and its robot in this process.
 */
#ifndef TESTS_ROS2_DAEMON_H
#define TESTS_ROS2_DAEMON_H

#include "ros2_arm.h"

extern harness running;
extern arm_node node;
extern tfa_model *model;
extern tfa_workspace *workspace;

/** Makes model and workspace of a bundled robot. */
void load_robot(const char *urdf, const tfa_model_options *options);
/** Endpoints of the node, of a topic "rt/%s/odom", that have matched one of the daemon. */
__attribute__((format(printf, 3, 4))) dds_entity_t
open_writer(const dds_topic_descriptor_t *type, ros2_peer_qos qos, const char *format, ...);
__attribute__((format(printf, 2, 3))) dds_entity_t open_reader(const dds_topic_descriptor_t *type,
                                                               const char *format, ...);
/** Closes and frees all that there is. @return 0 */
int stop(void **state);

#endif
