/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Endpoints as rmw_cyclonedds makes them: names, QoS, user data, XCDR1. What a node of ROS 2 beside
 * the daemon would be.
 */
#ifndef TESTS_ROS2_PEER_H
#define TESTS_ROS2_PEER_H

#include <dds/dds.h>
#include <stdbool.h>

/** QoS of an endpoint. */
typedef enum ros2_peer_qos {
    PEER_DEFAULT,         /**< reliable, volatile, keep last 10 */
    PEER_SENSOR,          /**< best effort, volatile, keep last 5 */
    PEER_TRANSIENT_LOCAL, /**< reliable, transient local, keep last 1 */
    PEER_ALL,             /**< reliable, volatile, keep all: for what a slow test must not lose */
} ros2_peer_qos;

/** The lease of participants in domains that this process or a child joins from now on: "600 s".
 * A domain of the test must be known (test_domain). */
void ros2_peer_set_lease(const char *duration);
/** A participant. */
dds_entity_t ros2_peer_open(uint32_t domain);
/** Endpoints of a topic, "rt/arm/joint_states". */
dds_entity_t ros2_peer_writer(dds_entity_t participant, const dds_topic_descriptor_t *type,
                              const char *topic, ros2_peer_qos qos);
dds_entity_t ros2_peer_reader(dds_entity_t participant, const dds_topic_descriptor_t *type,
                              const char *topic, ros2_peer_qos qos);
/** Waits until the endpoint has a partner. */
void ros2_peer_await_reader(dds_entity_t writer);
void ros2_peer_await_writer(dds_entity_t reader);
/** Takes a sample; waits for one. WAIT_MS where one must come; less in a loop that publishes again,
 * for what is sent before the other side has matched is lost. 0: one that has come */
bool ros2_peer_take(dds_entity_t reader, void *sample, int timeout_ms);

/** A sequence of texts or numbers as a member of a sample. */
#define PEER_SEQUENCE(count, buffer)                                                               \
    {                                                                                              \
        (count), (count), (buffer), false                                                          \
    }

#endif
