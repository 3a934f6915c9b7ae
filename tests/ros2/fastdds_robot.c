/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A node over Fast DDS and a plain Cyclone participant in the place of the daemon: a state goes one
 * way, an answer the other, and each finds the other in ros_discovery_info.
 */
#include "fastdds_node.h"

#include "dds/dds_test.h"
#include "ros2_peer.h"

#define NAMESPACE "/arm"

typedef rmw_dds_common_msg_dds__ParticipantEntitiesInfo_ graph_info;
typedef rmw_dds_common_msg_dds__NodeEntitiesInfo_ node_info;

static dds_entity_t participant;
static fastdds_node *node;

static bool have_partners(dds_entity_t reader, dds_entity_t writer)
{
    dds_subscription_matched_status_t of_reader = {0};
    dds_publication_matched_status_t of_writer = {0};

    dds_get_subscription_matched_status(reader, &of_reader);
    dds_get_publication_matched_status(writer, &of_writer);
    return of_reader.current_count > 0 && of_writer.current_count > 0;
}

#define STATES NAMESPACE "/joint_states"
#define ANSWERS NAMESPACE "/totalforce/accelerations"

TEST(a_state_is_answered)
{
    const dds_topic_descriptor_t *const state_type = &sensor_msgs_msg_dds__JointState__desc;
    const dds_topic_descriptor_t *const answer_type =
        &trajectory_msgs_msg_dds__JointTrajectory__desc;
    const dds_entity_t states =
        ros2_peer_reader(participant, state_type, "rt" STATES, PEER_DEFAULT);
    const dds_entity_t answers =
        ros2_peer_writer(participant, answer_type, "rt" ANSWERS, PEER_DEFAULT);
    fastdds_writer *const w = fastdds_publisher(node, state_type, STATES, &fastdds_default);
    fastdds_reader *const r = fastdds_subscription(node, answer_type, ANSWERS, &fastdds_default);
    char *name[] = {"joint_1", "joint_2"};
    double q[] = {0.5, -1}, qdd[] = {3, 4};
    const sensor_msgs_msg_dds__JointState_ sent = {
        .header = {{12, 34}, "base"}, .name = {2, 2, name, false}, .position = {2, 2, q, false}};
    sensor_msgs_msg_dds__JointState_ got = {0};

    fastdds_await_match_of_writer(w);
    fastdds_await_match_of_reader(r);
    /* both sides must know of each other: what is written before is lost */
    assert_true(WAIT_FOR(have_partners(states, answers)));
    fastdds_publish(node, w, &sent);
    assert_true(ros2_peer_take(states, &got, WAIT_MS));
    assert_int_equal(got.name._length, 2);
    assert_string_equal(got.name._buffer[1], "joint_2");
    assert_int_equal(got.position._length, 2);
    assert_memory_equal(got.position._buffer, q, sizeof q);

    trajectory_msgs_msg_dds__JointTrajectoryPoint_ point = {.accelerations = {2, 2, qdd, false}};
    const trajectory_msgs_msg_dds__JointTrajectory_ answer = {
        .header = got.header, .joint_names = got.name, .points = {1, 1, &point, false}};
    trajectory_msgs_msg_dds__JointTrajectory_ received;
    assert_int_equal(dds_write(answers, &answer), DDS_RETCODE_OK);
    assert_true(fastdds_receive(node, r, &received, WAIT_MS));
    assert_int_equal(received.header.stamp.sec, 12);
    assert_int_equal(received.header.stamp.nanosec, 34);
    assert_string_equal(received.header.frame_id, "base");
    assert_int_equal(received.points._length, 1);
    assert_memory_equal(received.points._buffer[0].accelerations._buffer, qdd, sizeof qdd);
    dds_sample_free(&received, answer_type, DDS_FREE_CONTENTS);
    dds_sample_free(&got, state_type, DDS_FREE_CONTENTS);
}

/* Every sample from the one node is its whole list: the newest counts. */
TEST(the_node_lists_its_endpoints)
{
    const dds_topic_descriptor_t *const type =
        &rmw_dds_common_msg_dds__ParticipantEntitiesInfo__desc;
    fastdds_writer *const w = fastdds_publisher(node, &std_msgs_msg_dds__Float64MultiArray__desc,
                                                NAMESPACE "/efforts", &fastdds_default);
    const dds_entity_t graph =
        ros2_peer_reader(participant, type, "ros_discovery_info", PEER_TRANSIENT_LOCAL);
    graph_info sample = {0};
    uint8_t peer_gid[16], writer_gid[16];

    assert_true(ros2_peer_take(graph, &sample, WAIT_MS));
    fastdds_gid(fastdds_node_peer(node), peer_gid);
    assert_memory_equal(sample.gid.data, peer_gid, sizeof peer_gid);
    assert_int_equal(sample.node_entities_info_seq._length, 1);
    const node_info *const n = sample.node_entities_info_seq._buffer;
    assert_string_equal(n->node_namespace, NAMESPACE);
    assert_string_equal(n->node_name, "controller");
    assert_int_equal(n->reader_gid_seq._length, 1);
    assert_int_equal(n->writer_gid_seq._length, 2);
    fastdds_writer_gid(w, writer_gid);
    assert_memory_equal(n->writer_gid_seq._buffer[1].data, writer_gid, sizeof writer_gid);
    dds_sample_free(&sample, type, DDS_FREE_CONTENTS);
}

TEST(the_node_finds_another)
{
    const dds_entity_t graph =
        ros2_peer_writer(participant, &rmw_dds_common_msg_dds__ParticipantEntitiesInfo__desc,
                         "ros_discovery_info", PEER_TRANSIENT_LOCAL);
    rmw_dds_common_msg_dds__Gid_ writers[2] = {{{1}}, {{2}}};
    node_info info = {.node_namespace = NAMESPACE, .node_name = "totalforce"};
    const graph_info sample = {.gid = {{3}}, .node_entities_info_seq = {1, 1, &info, false}};
    fastdds_listed listed;

    info.writer_gid_seq._buffer = writers;
    info.writer_gid_seq._length = 2;
    assert_int_equal(dds_write(graph, &sample), DDS_RETCODE_OK);
    assert_true(fastdds_await_node(node, NAMESPACE, "totalforce", &listed, WAIT_MS));
    assert_memory_equal(listed.participant, sample.gid.data, sizeof listed.participant);
    assert_int_equal(listed.readers.count, 0);
    assert_int_equal(listed.writers.count, 2);
    assert_memory_equal(listed.writers.gid[1], writers[1].data, sizeof writers[1].data);
    /* its own: a while, for nothing tells that none will come; a slow machine passes */
    assert_false(fastdds_await_node(node, NAMESPACE, "controller", NULL, 200));
}

static int open_both(void **state)
{
    (void)state;
    participant = dds_create_participant(test_domain(), NULL, NULL);
    node = fastdds_node_open(test_domain(), NAMESPACE, "controller");
    return participant > 0 ? 0 : -1;
}

static int close_both(void **state)
{
    (void)state;
    fastdds_node_close(node);
    return dds_delete(participant) == DDS_RETCODE_OK ? 0 : -1;
}

int main(void)
{
    return test_run(open_both, close_both);
}
