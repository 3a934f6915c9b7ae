/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The ROS 2 gateway of the daemon: reads states and commands of robots on topics of ROS 2 or
 * Unitree, answers on topics of ROS 2. No part of ROS is needed: Cyclone DDS and the conventions of
 * rmw_cyclonedds (docs/ros2.md).
 *
 * One thread of each domain takes the messages of its robots, and computes with solvers of the
 * gateway's own: it shares nothing with the workers.
 */
#ifndef TFA_SERVICE_DDS_ROS2_ROS2_H
#define TFA_SERVICE_DDS_ROS2_ROS2_H

#include "gateway/gateway.h"

extern const struct gateway tfa_gateway_ros2;

/** gateway.check_robot: names of topics, joints, links, motors, constraints, the scene; joints of
 *  one coordinate; a source for a floating base. Needs no DDS.
 *  @return TFA_OK; TFA_E_ARGUMENT, TFA_E_LINK, TFA_E_JOINT, TFA_E_UNSUPPORTED; TFA_E_MEMORY */
TFA_CHECKED int tfa_ros2_check_robot(const config *settings, const config_robot *robot,
                                     const tfa_robot *served, gateway_error *error);

/** True if its topics serve this one: the robot, or the scene of it that the key `scene` names. */
bool tfa_ros2_serves(const tfa_robot *robot);

/** True if both robots have the same node: their answers would be on the same topics. */
bool tfa_ros2_same_node(const config_robot_ros2 *a, const config_robot_ros2 *b);

#endif
