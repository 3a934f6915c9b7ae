/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * ROS 2 type hashes (REP-2016) of the messages in ros2.idl and unitree.idl.
 */
#ifndef TFA_ROS2_TYPE_HASH_H
#define TFA_ROS2_TYPE_HASH_H

/**
 * Text for the USER_DATA QoS of an endpoint of that DDS type, e.g. "std_msgs::msg::dds_::String_":
 * "typehash=RIHS01_<64 hex digits>;". It serves `ros2 topic info -v` and keeps nodes from warning
 * about an endpoint without a hash; data flows without it.
 *
 * @return NULL: no message of that name is known. Otherwise constant; any thread.
 */
const char *tfa_ros2_user_data(const char *dds_type);

#endif
