/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * See ros2_peer.h.
 */
#include "ros2_peer.h"

#include "dds/ros2/type_hash.h"
#include "support/wait.h"
#include "test.h"

static dds_qos_t *make_qos(const dds_topic_descriptor_t *type, ros2_peer_qos kind)
{
    const dds_data_representation_id_t xcdr1 = DDS_DATA_REPRESENTATION_XCDR1;
    const char *user_data = tfa_ros2_user_data(type->m_typename);
    dds_qos_t *qos = dds_create_qos();
    dds_qset_reliability(
        qos, kind == PEER_SENSOR ? DDS_RELIABILITY_BEST_EFFORT : DDS_RELIABILITY_RELIABLE,
        (dds_duration_t)WAIT_NS);
    dds_qset_durability(qos, kind == PEER_TRANSIENT_LOCAL ? DDS_DURABILITY_TRANSIENT_LOCAL
                                                          : DDS_DURABILITY_VOLATILE);
    dds_qset_history(qos, kind == PEER_ALL ? DDS_HISTORY_KEEP_ALL : DDS_HISTORY_KEEP_LAST,
                     kind == PEER_TRANSIENT_LOCAL ? 1
                     : kind == PEER_SENSOR        ? 5
                                                  : 10);
    dds_qset_writer_data_lifecycle(qos, false);
    dds_qset_data_representation(qos, 1, &xcdr1);
    if (user_data != NULL)
        dds_qset_userdata(qos, user_data, strlen(user_data));
    return qos;
}

void ros2_peer_set_lease(const char *duration)
{
    static char local[256];
    char uri[512];
    if (local[0] == 0)
        snprintf(local, sizeof local, "%s", getenv("CYCLONEDDS_URI"));
    snprintf(uri, sizeof uri,
             "%s,<CycloneDDS><Domain><Discovery><LeaseDuration>%s</LeaseDuration></Discovery>"
             "</Domain></CycloneDDS>",
             local, duration);
    setenv("CYCLONEDDS_URI", uri, 1);
}

dds_entity_t ros2_peer_open(uint32_t domain)
{
    static const char enclave[] = "enclave=/;";
    dds_qos_t *qos = dds_create_qos();
    dds_qset_userdata(qos, enclave, sizeof enclave - 1);
    const dds_entity_t participant = dds_create_participant(domain, qos, NULL);
    dds_delete_qos(qos);
    assert_true(participant > 0);
    return participant;
}

typedef dds_entity_t (*maker)(dds_entity_t participant, dds_entity_t topic, const dds_qos_t *qos,
                              const dds_listener_t *listener);

static dds_entity_t make_endpoint(maker make, dds_entity_t participant,
                                  const dds_topic_descriptor_t *type, const char *topic,
                                  ros2_peer_qos kind)
{
    const dds_entity_t entity = dds_create_topic(participant, type, topic, NULL, NULL);
    dds_qos_t *qos = make_qos(type, kind);
    const dds_entity_t endpoint = make(participant, entity, qos, NULL);
    dds_delete_qos(qos);
    assert_true(endpoint > 0);
    return endpoint;
}

dds_entity_t ros2_peer_writer(dds_entity_t participant, const dds_topic_descriptor_t *type,
                              const char *topic, ros2_peer_qos kind)
{
    return make_endpoint(dds_create_writer, participant, type, topic, kind);
}

dds_entity_t ros2_peer_reader(dds_entity_t participant, const dds_topic_descriptor_t *type,
                              const char *topic, ros2_peer_qos kind)
{
    return make_endpoint(dds_create_reader, participant, type, topic, kind);
}

static bool has_reader(dds_entity_t writer)
{
    dds_publication_matched_status_t status = {0};
    assert_int_equal(dds_get_publication_matched_status(writer, &status), DDS_RETCODE_OK);
    return status.current_count > 0;
}

static bool has_writer(dds_entity_t reader)
{
    dds_subscription_matched_status_t status = {0};
    assert_int_equal(dds_get_subscription_matched_status(reader, &status), DDS_RETCODE_OK);
    return status.current_count > 0;
}

void ros2_peer_await_reader(dds_entity_t writer)
{
    assert_true(WAIT_FOR(has_reader(writer)));
}

void ros2_peer_await_writer(dds_entity_t reader)
{
    assert_true(WAIT_FOR(has_writer(reader)));
}

bool ros2_peer_take(dds_entity_t reader, void *sample, int timeout_ms)
{
    const uint64_t end = now_ns() + 1000000u * (uint64_t)timeout_ms;
    dds_sample_info_t info;
    bool last = false;
    do
        while (dds_take(reader, &sample, &info, 1, 1) == 1)
            if (info.valid_data)
                return true;
    while (wait_again(end, &last));
    return false;
}
