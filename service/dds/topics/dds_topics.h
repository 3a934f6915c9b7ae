/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The six topics with their QoS in one table, so that daemon and clients cannot disagree.
 */
#ifndef TFA_SERVICE_DDS_TOPICS_H
#define TFA_SERVICE_DDS_TOPICS_H

#include <dds/dds.h>

#include <idl/totalforce.h>

typedef enum tfa_dds_topic {
    TFA_DDS_ROBOT_INFO,
    TFA_DDS_REQUEST,
    TFA_DDS_REPLY,
    TFA_DDS_TORQUES,
    TFA_DDS_ACCELERATIONS,
    TFA_DDS_LEADER,
    TFA_DDS_TOPIC_COUNT
} tfa_dds_topic;

/* Creates the topic entity of a participant. @return the entity, or a negative Cyclone code. */
dds_entity_t tfa_dds_create_topic(dds_entity_t participant, tfa_dds_topic topic);

/* Creates a writer (a reader) with the QoS of the table. `entity` is the topic's; the listener may
 * be NULL and is copied. @return the entity, or a negative Cyclone code. */
dds_entity_t tfa_dds_create_writer(dds_entity_t participant, dds_entity_t entity,
                                   tfa_dds_topic topic, const dds_listener_t *listener);
dds_entity_t tfa_dds_create_reader(dds_entity_t participant, dds_entity_t entity,
                                   tfa_dds_topic topic, const dds_listener_t *listener);

/* The same for the topic LEADER: who does not write for `lease` is not alive. */
dds_entity_t tfa_dds_create_leader_writer(dds_entity_t participant, dds_entity_t entity,
                                          dds_duration_t lease);

#endif
