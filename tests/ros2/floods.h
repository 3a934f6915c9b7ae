/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Publishers that flood the topics of the arm, a kind of message each, in threads of this process.
 */
#ifndef TESTS_ROS2_FLOODS_H
#define TESTS_ROS2_FLOODS_H

#include "ros2_peer.h"

#include <pthread.h>
#include <stdatomic.h>

/** One kind: `write` sends a message, another for each state of the seed. */
typedef struct flood {
    const char *name;
    const dds_topic_descriptor_t *type;
    const char *topic;
    ros2_peer_qos qos;
    void (*write)(dds_entity_t writer, uint64_t *seed);
    unsigned period_us;
} flood;

/** A publisher with a participant of its own. */
typedef struct flooder {
    const flood *how;
    uint32_t domain;
    pthread_t thread;
    _Atomic bool stop;
    _Atomic uint64_t written;
} flooder;

/** The first one goes to another topic: the cost of a publisher by itself, on the processors of
 *  all. */
extern const flood floods[];
extern const size_t flood_count;

/** Publishes as fast as the period allows, under the ordinary scheduler. */
void flooder_start(flooder *f, const flood *how, uint32_t domain);
/** @return messages that were written */
uint64_t flooder_stop(flooder *f);

/** A valid state of the arm. */
void flood_states(dds_entity_t writer, uint64_t *seed);

#endif
