/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The six topics with their QoS in one table, so that daemon and clients cannot disagree.
 */
#include "dds/topics/dds_topics.h"

#include "dds/topics/dds_convert.h"

#include <stdbool.h>

#define KEEP_ALL 0
/* Advertisements that a reader keeps apart: a bound for liars. */
#define LEADER_INSTANCES_MAX 4096

/* One end of a topic. */
typedef struct endpoint {
    bool reliable;
    int32_t depth; /* keep-last so many of each robot, or KEEP_ALL */
} endpoint;

typedef struct topic_row {
    const char *name;
    const dds_topic_descriptor_t *type;
    bool transient_local;
    endpoint writer, reader;
} topic_row;

/* Writers keep the last samples of each robot: such a writer never waits in Cyclone (0.10 sets no
 * watermark for it). So the daemon may write from the receiving thread, which cannot wait for
 * acknowledgements that it would have to receive itself; a client that stops acknowledging loses
 * only its own replies; and a standby that hangs holds up no client. 256 are four clients
 * with all the requests under way that they may have. Torques are asked for best effort: that
 * matches publishers of either kind. */
static const topic_row topics[] = {
    [TFA_DDS_ROBOT_INFO] = {TFA_DDS_TOPIC_ROBOT_INFO, &totalforce_dds_RobotInfo_desc, true,
                            .writer = {true, 1}, .reader = {true, 1}},
    [TFA_DDS_REQUEST] = {TFA_DDS_TOPIC_REQUEST, &totalforce_dds_Request_desc, false,
                         .writer = {true, 256}, .reader = {true, KEEP_ALL}},
    [TFA_DDS_REPLY] = {TFA_DDS_TOPIC_REPLY, &totalforce_dds_Reply_desc, false,
                       .writer = {true, 256}, .reader = {true, 64}},
    [TFA_DDS_TORQUES] = {TFA_DDS_TOPIC_TORQUES, &totalforce_dds_JointTorques_desc, false,
                         .writer = {false, 1}, .reader = {false, 1}},
    [TFA_DDS_ACCELERATIONS] = {TFA_DDS_TOPIC_ACCELERATIONS, &totalforce_dds_JointAccelerations_desc,
                               false, .writer = {true, 4}, .reader = {true, 64}},
    [TFA_DDS_LEADER] = {TFA_DDS_TOPIC_LEADER, &totalforce_dds_Leader_desc, true,
                        .writer = {true, 1}, .reader = {false, 1}},
};

dds_entity_t tfa_dds_create_topic(dds_entity_t participant, tfa_dds_topic topic)
{
    return dds_create_topic(participant, topics[topic].type, topics[topic].name, NULL, NULL);
}

static dds_qos_t *make_qos(const topic_row *row, const endpoint *end)
{
    dds_qos_t *qos = dds_create_qos();

    if (qos == NULL)
        return NULL;
    dds_qset_reliability(qos,
                         end->reliable ? DDS_RELIABILITY_RELIABLE : DDS_RELIABILITY_BEST_EFFORT, 0);
    if (end->depth == KEEP_ALL)
        dds_qset_history(qos, DDS_HISTORY_KEEP_ALL, 0);
    else
        dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, end->depth);
    dds_qset_durability(qos, row->transient_local ? DDS_DURABILITY_TRANSIENT_LOCAL
                                                  : DDS_DURABILITY_VOLATILE);
    /* A daemon that dies leaves its instances without a writer; it does not dispose them. */
    dds_qset_writer_data_lifecycle(qos, false);
    return qos;
}

dds_entity_t tfa_dds_create_leader_writer(dds_entity_t participant, dds_entity_t entity,
                                          dds_duration_t lease)
{
    dds_qos_t *qos = make_qos(&topics[TFA_DDS_LEADER], &topics[TFA_DDS_LEADER].writer);

    if (qos == NULL)
        return DDS_RETCODE_OUT_OF_RESOURCES;
    dds_qset_liveliness(qos, DDS_LIVELINESS_MANUAL_BY_TOPIC, lease);
    const dds_entity_t writer = dds_create_writer(participant, entity, qos, NULL);
    dds_delete_qos(qos);
    return writer;
}

dds_entity_t tfa_dds_create_writer(dds_entity_t participant, dds_entity_t entity,
                                   tfa_dds_topic topic, const dds_listener_t *listener)
{
    dds_qos_t *qos = make_qos(&topics[topic], &topics[topic].writer);

    if (qos == NULL)
        return DDS_RETCODE_OUT_OF_RESOURCES;
    const dds_entity_t writer = dds_create_writer(participant, entity, qos, listener);
    dds_delete_qos(qos);
    return writer;
}

dds_entity_t tfa_dds_create_reader(dds_entity_t participant, dds_entity_t entity,
                                   tfa_dds_topic topic, const dds_listener_t *listener)
{
    dds_qos_t *qos = make_qos(&topics[topic], &topics[topic].reader);

    if (qos == NULL)
        return DDS_RETCODE_OUT_OF_RESOURCES;
    if (topic == TFA_DDS_LEADER) { /* a listener for itself would run in its own dds_write */
        dds_qset_ignorelocal(qos, DDS_IGNORELOCAL_PARTICIPANT);
        dds_qset_resource_limits(qos, DDS_LENGTH_UNLIMITED, LEADER_INSTANCES_MAX,
                                 DDS_LENGTH_UNLIMITED);
    }
    const dds_entity_t reader = dds_create_reader(participant, entity, qos, listener);
    dds_delete_qos(qos);
    return reader;
}
