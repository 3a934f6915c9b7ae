/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A node of ROS 2 as rmw_fastrtps makes it: a Fast DDS participant whose publishers and
 * subscriptions have ROS names and samples of our C types, and which ros_discovery_info lists. The
 * functions fail the test where they say nothing else.
 *
 * A robot's node, once a daemon serves /arm:
 *
 *     fastdds_node *n = fastdds_node_open(test_domain(), "/arm", "controller");
 *     fastdds_writer *states = fastdds_publisher(
 *         n, &sensor_msgs_msg_dds__JointState__desc, "/arm/joint_states", &fastdds_default);
 *     fastdds_reader *answers = fastdds_subscription(
 *         n, &trajectory_msgs_msg_dds__JointTrajectory__desc, "/arm/totalforce/accelerations",
 *         &fastdds_default);
 *     fastdds_await_match_of_writer(states);
 *     do
 *         fastdds_publish(n, states, &sample);
 *     while (!fastdds_receive(n, answers, &answer, 100));
 */
#ifndef TESTS_ROS2_FASTDDS_NODE_H
#define TESTS_ROS2_FASTDDS_NODE_H

#include "fastdds_peer.h"

#include <dds/dds.h>
#include <idl/ros2.h>

typedef struct fastdds_node fastdds_node;

/** Identities of endpoints in ros_discovery_info. */
typedef struct fastdds_gids {
    uint32_t count;
    uint8_t gid[32][16];
} fastdds_gids;

/** A node in ros_discovery_info. */
typedef struct fastdds_listed {
    uint8_t participant[16];
    fastdds_gids readers, writers;
} fastdds_listed;

/** A participant with one node. */
fastdds_node *fastdds_node_open(uint32_t domain, const char *node_namespace, const char *name);
void fastdds_node_close(fastdds_node *n);
fastdds_peer *fastdds_node_peer(fastdds_node *n);

/** An endpoint of a ROS topic, "/arm/joint_states". The node announces it. */
fastdds_writer *fastdds_publisher(fastdds_node *n, const dds_topic_descriptor_t *type,
                                  const char *topic, const fastdds_qos *qos);
fastdds_reader *fastdds_subscription(fastdds_node *n, const dds_topic_descriptor_t *type,
                                     const char *topic, const fastdds_qos *qos);
/** Waits until the endpoint has a partner. This may know of the endpoint later, and miss what is
 * written until then: repeat a message until it is answered. */
void fastdds_await_match_of_writer(fastdds_writer *w);
void fastdds_await_match_of_reader(fastdds_reader *r);

/** Encodes the sample by Fast CDR and writes it. */
void fastdds_publish(fastdds_node *n, fastdds_writer *w, const void *sample);
/** Takes the next sample and decodes it by Fast CDR; dds_sample_free frees it. `sample` is
 * overwritten without being freed. @return false: none came in time */
bool fastdds_receive(fastdds_node *n, fastdds_reader *r, void *sample, int timeout_ms);

/** Waits until another participant lists the node in ros_discovery_info.
 * @param listed  receives its endpoints, or NULL */
bool fastdds_await_node(fastdds_node *n, const char *node_namespace, const char *name,
                        fastdds_listed *listed, int timeout_ms);

#endif
