/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Two daemons for one robot on topics of ROS 2: each command has one answer, the standby writes
 * nothing, and it answers when the leader has died or ends.
 */
#include "dds/dds_test.h"

#include "dds/herald.h"
#include "models.h"
#include "ros2_arm.h"

#include <signal.h>
#include <string.h>

static harness first, second;
static arm_node node;

/* The participant that wrote a sample. */
static dds_guid_t writer_of(dds_entity_t reader, dds_instance_handle_t handle)
{
    dds_builtintopic_endpoint_t *e = dds_get_matched_publication_data(reader, handle);
    dds_guid_t guid = {{0}};
    if (e != NULL) {
        guid = e->participant_key;
        dds_builtintopic_free_endpoint(e);
    }
    return guid;
}

/* Takes a sample that has come. */
static bool take_sample(dds_entity_t reader, void *sample, dds_guid_t *from)
{
    dds_sample_info_t info;
    while (dds_take(reader, &sample, &info, 1, 1) == 1)
        if (info.valid_data) {
            *from = writer_of(reader, info.publication_handle);
            return true;
        }
    return false;
}

/* The last command's, and that of the last before there was a leader to speak of: a daemon that is
 * stopped between its look at the clock and its write answers such a one when it goes on. */
static int32_t stamp = 1000, settled;

/* Publishes a command. @return its stamp, which no other has */
static int32_t publish(void)
{
    const arm_motion m = arm_motion_of((uint64_t)++stamp);
    sensor_msgs_msg_dds__JointState_ state = arm_state(&m, stamp);
    state.effort = arm_efforts(arm_joints, m.tau, JOINTS, stamp).effort;
    assert_int_equal(dds_write(node.joint_states, &state), DDS_RETCODE_OK);
    arm_publish_named_efforts(&node, arm_joints, m.tau, JOINTS, stamp);
    return stamp;
}

/* The next answer to a command since then. @return its stamp */
static int32_t await_answer(dds_guid_t *from)
{
    static trajectory_msgs_msg_dds__JointTrajectory_ answer;
    do
        assert_true(WAIT_FOR(take_sample(node.accelerations, &answer, from)));
    while (answer.header.stamp.sec <= settled);
    return answer.header.stamp.sec;
}

#define EFFORTS "/arm/joint_efforts"

/* Whether the daemon, and it may be the standby, has read a command of now */
static bool reads_commands(const harness *h)
{
    const uint64_t before = arm_received(h, "arm", EFFORTS);
    (void)publish();
    sleep_ms(20); /* between two commands */
    return arm_received(h, "arm", EFFORTS) > before;
}

#define COMMANDS 30

/* Answers of before are taken: all are of this participant. */
static void take_answers(const dds_guid_t *expected)
{
    const int32_t last = publish();
    dds_guid_t from;
    int32_t answered;
    do {
        answered = await_answer(&from);
        assert_memory_equal(&from, expected, sizeof from);
    } while (answered != last);
}

/* Publishes a command. @return whether its answer comes soon; `from` gets its participant */
static bool is_answered(dds_guid_t *from)
{
    static trajectory_msgs_msg_dds__JointTrajectory_ answer;
    const int32_t command = publish();
    const uint64_t end = now_ns() + 200000000;
    bool last = false;
    do
        while (take_sample(node.accelerations, &answer, from))
            if (answer.header.stamp.sec == command)
                return true;
    while (wait_again(end, &last));
    return false;
}

/* The one that answers */
static dds_guid_t find_leader(void)
{
    dds_guid_t from;
    settled = stamp;
    assert_true(WAIT_FOR(is_answered(&from)));
    return from;
}

/* There is one answer to each command, all of the leader; the standby has read commands, and its
 * answers would have come, for it answers before it counts. */
static void assert_one_answers(const dds_guid_t *leader, const harness *standby)
{
    dds_guid_t from;
    take_answers(leader);
    for (int k = 0; k < COMMANDS; k++) {
        const int32_t command = publish();
        assert_int_equal(await_answer(&from), command);
        assert_memory_equal(&from, leader, sizeof from);
    }
    if (standby != NULL)
        assert_true(WAIT_FOR(reads_commands(standby)));
    take_answers(leader);
}

/* ---- two daemons ---- */

/* A leader that is silent for its lease is replaced, rightly, and so is one that gets no processor.
 * The first daemon, whose end a test waits for, has a short lease; while it leads beside another
 * nothing is said about who answers. One that takes over has a long lease: it leads for good. */
#define SHORT_LEASE 3000
#define LONG_LEASE 15000 /* five times: more counts for nothing */

#define OBSERVER "      observer: {gain: 0.001}\n" /* no gap for stamps a second apart */

static const char *settings_of(uint32_t domain, unsigned lease_ms)
{
    char more[128];
    snprintf(more, sizeof more, "dds: {enabled: yes, domain: %u, lease_ms: %u}\n", domain,
             lease_ms);
    return arm_settings(more);
}

static uint32_t known_daemons(void)
{
    dds_subscription_matched_status_t status = {0};
    assert_int_equal(dds_get_subscription_matched_status(node.accelerations, &status),
                     DDS_RETCODE_OK);
    return status.total_count;
}

/* A daemon beside the leader: it has matched, too. */
static void join(harness *h)
{
    const uint32_t daemons = known_daemons();
    harness_start(h, "arm");
    assert_true(harness_logged(h, "standby, the leader has"));
    assert_true(WAIT_FOR(known_daemons() > daemons));
    assert_true(WAIT_FOR(reads_commands(h)));
}

/* Two daemons and a node. @param domain  of the daemons' own topics
 * @return the participant of the first, which answers while it is alone */
static dds_guid_t open_all(uint32_t domain)
{
    first = harness_make(arm_yaml(OBSERVER), settings_of(domain, SHORT_LEASE));
    second = harness_make(arm_yaml(OBSERVER), settings_of(domain, LONG_LEASE));
    ros2_peer_set_lease("600 s");
    harness_start(&first, "arm");
    dds_herald(domain, "arm");
    assert_true(harness_logged(&first, "leads, epoch"));
    arm_node_open(&node);
    const dds_guid_t alone = find_leader();
    join(&second);
    return alone;
}

/* With the daemon that is left. */
static void close_all(harness *last)
{
    arm_node_close(&node);
    harness_remove(last);
}

/* What comes while commands are published is of this participant. */
static void assert_writer(dds_entity_t reader, const dds_topic_descriptor_t *type, unsigned least,
                          const dds_guid_t *expected)
{
    void *sample = calloc(1, type->m_size);
    dds_guid_t from;
    assert_non_null(sample);
    while (take_sample(reader, sample, &from))
        ; /* of a leader before */
    for (unsigned count = 0; count < least; count++) {
        assert_true(WAIT_FOR(((void)publish(), take_sample(reader, sample, &from))));
        assert_memory_equal(&from, expected, sizeof from);
    }
    dds_sample_free(sample, type, DDS_FREE_ALL);
}

/* Diagnostics are those of the leader alone. */
static void assert_reports(const dds_guid_t *leader)
{
    assert_writer(node.diagnostics, &diagnostic_msgs_msg_dds__DiagnosticArray__desc, 2, leader);
}

/* The second daemon leads, for the first was stopped or killed. @return its participant */
static dds_guid_t await_second(const dds_guid_t *before)
{
    assert_true(harness_logged(&second, "leads, epoch"));
    const dds_guid_t leader = find_leader();
    assert_memory_not_equal(&leader, before, sizeof leader);
    assert_true(harness_logged(&second, "the observer restarted: takeover"));
    return leader;
}

/* The first goes on beside the second, and leads when that one ends. */
static void check_standby(uint32_t domain)
{
    const dds_guid_t before = open_all(domain);
    harness_pause(&first);
    const dds_guid_t leader = await_second(&before);
    assert_int_equal(kill(first.pid, SIGCONT), 0);
    assert_one_answers(&leader, &first);
    assert_reports(&leader);
    const unsigned lines = harness_log_lines(&first, "leads, epoch");
    assert_int_equal(harness_stop(&second, SIGTERM), 0);
    assert_true(harness_logged_times(&first, "leads, epoch", lines + 1));
    const dds_guid_t next = find_leader();
    assert_memory_equal(&next, &before, sizeof next);
    assert_one_answers(&next, NULL);
    harness_remove(&second);
    close_all(&first);
}

static void check_takeover(uint32_t domain)
{
    const dds_guid_t before = open_all(domain);
    (void)harness_stop(&first, SIGKILL);
    const dds_guid_t leader = await_second(&before);
    assert_one_answers(&leader, NULL);
    assert_reports(&leader);
    harness_remove(&first);
    close_all(&second);
}

TEST(one_daemon_answers_and_another_takes_over)
{
    check_standby(test_domain());
    check_takeover(test_domain());
}

TEST(the_same_where_both_kinds_of_topics_share_a_domain)
{
    check_standby(arm_domain());
    check_takeover(arm_domain());
}

/* ---- every topic, and descriptions ---- */

static const struct {
    const dds_topic_descriptor_t *type;
    const char *topic;
    unsigned least; /* samples that are looked at */
} outputs[] = {
    {&std_msgs_msg_dds__Float64MultiArray__desc, "rt/arm/totalforce/lambda_inv", 5},
    {&std_msgs_msg_dds__Float64MultiArray__desc, "rt/arm/totalforce/jacobian", 5},
    {&std_msgs_msg_dds__Float64MultiArray__desc, "rt/arm/totalforce/bias_acceleration", 5},
    {&sensor_msgs_msg_dds__JointState__desc, "rt/arm/totalforce/gravity_torques", 5},
    {&sensor_msgs_msg_dds__JointState__desc, "rt/arm/totalforce/external_torques", 5},
    {&diagnostic_msgs_msg_dds__DiagnosticArray__desc, "rt/diagnostics", 2},
};

#define OUTPUTS (sizeof outputs / sizeof *outputs)

/* What is written while states come is all of this participant. */
static void assert_only_one_writes(const dds_entity_t *readers, const dds_guid_t *expected)
{
    for (size_t k = 0; k < OUTPUTS; k++)
        assert_writer(readers[k], outputs[k].type, outputs[k].least, expected);
}

/* Publishes a command. @return whether the next answer has this acceleration */
static bool has_acceleration(const double qdd[JOINTS])
{
    static trajectory_msgs_msg_dds__JointTrajectory_ got;
    const arm_motion m = arm_motion_of(77);
    arm_publish_state(&node, &m, 1);
    arm_publish_named_efforts(&node, arm_joints, m.tau, JOINTS, 1);
    return ros2_peer_take(node.accelerations, &got, 50) &&
           memcmp(got.points._buffer[0].accelerations._buffer, qdd, JOINTS * sizeof *qdd) == 0;
}

/* Answers become those of this model. */
static void await_model(tfa_workspace *workspace)
{
    const arm_motion m = arm_motion_of(77);
    double qdd[JOINTS];
    arm_expect(workspace, &m, qdd);
    assert_true(WAIT_FOR(has_acceleration(qdd)));
}

/* A leader that was stopped is silent when it goes on; the description is that of both. */
TEST(a_stopped_leader_comes_back_and_is_silent)
{
    SCOPED_TEXT *text = arm_urdf(true);
    SCOPED_MODEL *model = arm_model(text);
    SCOPED_WORKSPACE *workspace = workspace_for(model, NULL);
    dds_entity_t readers[OUTPUTS];
    const std_msgs_msg_dds__String_ description = {text};
    const dds_guid_t before = open_all(test_domain());
    for (size_t k = 0; k < OUTPUTS; k++)
        readers[k] =
            ros2_peer_reader(node.participant, outputs[k].type, outputs[k].topic, PEER_DEFAULT);
    assert_int_equal(dds_write(node.description, &description), DDS_RETCODE_OK);
    await_model(workspace);
    assert_true(harness_logged(&first, "reload: done, 1 of 1"));
    assert_true(harness_logged(&second, "reload: done, 1 of 1"));
    harness_pause(&first);
    const dds_guid_t leader = await_second(&before);
    await_model(workspace);
    assert_one_answers(&leader, NULL);
    assert_int_equal(kill(first.pid, SIGCONT), 0);
    assert_one_answers(&leader, &first);
    assert_true(harness_logged(&first, "standby, the leader has"));
    assert_one_answers(&leader, &first);
    assert_only_one_writes(readers, &leader);
    await_model(workspace);
    harness_remove(&first);
    close_all(&second);
}

int main(void)
{
    return test_run(NULL, NULL);
}
