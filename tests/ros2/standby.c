/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Two daemons for one robot on topics of ROS 2: each command has one answer, the standby writes
 * nothing, and it answers when the leader has died.
 */
#include "dds/dds_test.h"

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

/* Takes samples for a while. @return how many; `from` gets the participant, all of one */
static unsigned take_for(dds_entity_t reader, const dds_topic_descriptor_t *type, unsigned ms,
                         dds_guid_t *from)
{
    const uint64_t end = now_ns() + 1000000u * (uint64_t)ms;
    void *sample = calloc(1, type->m_size);
    unsigned count = 0;

    assert_non_null(sample);
    while (now_ns() < end) {
        dds_sample_info_t info;
        if (dds_take(reader, &sample, &info, 1, 1) != 1) {
            dds_sleepfor(DDS_MSECS(1));
            continue;
        }
        if (!info.valid_data)
            continue;
        const dds_guid_t writer = writer_of(reader, info.publication_handle);
        if (count++ > 0)
            assert_memory_equal(&writer, from, sizeof writer);
        *from = writer;
    }
    dds_sample_free(sample, type, DDS_FREE_ALL);
    return count;
}

static unsigned take_answers(unsigned ms, dds_guid_t *from)
{
    return take_for(node.accelerations, &trajectory_msgs_msg_dds__JointTrajectory__desc, ms, from);
}

/* Publishes a motion. @return answers that came, none after a while */
static unsigned answers_to(uint64_t seed, dds_guid_t *from)
{
    const arm_motion m = arm_motion_of(seed);
    unsigned answers = 0;

    arm_publish_state(&node, &m, (int32_t)seed);
    arm_publish_named_efforts(&node, arm_joints, m.tau, JOINTS, (int32_t)seed);
    for (int k = 0; k < 100 && answers == 0; k++)
        answers = take_answers(5, from);
    return answers;
}

#define COMMANDS 30

/* Waits until there is an answer; then there is one to each command, all of one participant. */
static dds_guid_t assert_one_answers(void)
{
    dds_guid_t from = {{0}}, next;
    unsigned answers = 0;

    for (uint64_t k = 0; k < 100 && answers == 0; k++)
        answers = answers_to(k, &from);
    assert_true(answers > 0);
    while (take_answers(300, &next) > 0)
        ;
    answers = 0;
    for (uint64_t k = 0; k < COMMANDS; k++) {
        answers += answers_to(k, &next);
        assert_memory_equal(&next, &from, sizeof from);
    }
    assert_int_equal(answers + take_answers(300, &next), COMMANDS);
    return from;
}

/* Two daemons and a node. @param domain  of the daemons' own topics */
static void open_all(uint32_t domain)
{
    char more[128];

    snprintf(more, sizeof more, "dds: {enabled: yes, domain: %u}\n", domain);
    const char *settings = arm_settings(more);
    const char *yaml = arm_yaml("      state_age_ms: 1000\n      command_age_ms: 1000\n");
    harness_serve(&first, yaml, settings);
    assert_true(harness_logged(&first, "leads, epoch"));
    harness_serve(&second, yaml, settings);
    assert_true(harness_logged(&second, "standby, the leader has"));
    arm_node_open(&node);
    dds_sleepfor(DDS_MSECS(1200)); /* the other daemon has matched, too */
}

static void close_all(void)
{
    arm_node_close(&node);
    assert_int_equal(harness_stop(&second, SIGTERM), 0);
    harness_remove(&second);
    harness_remove(&first);
}

static void check_takeover(uint32_t domain)
{
    const dds_topic_descriptor_t *diagnostics = &diagnostic_msgs_msg_dds__DiagnosticArray__desc;
    dds_guid_t from;

    open_all(domain);
    const dds_guid_t leader = assert_one_answers();
    (void)take_for(node.diagnostics, diagnostics, 10, &from);
    assert_in_range(take_for(node.diagnostics, diagnostics, 2500, &from), 1, 4);
    assert_memory_equal(&from, &leader, sizeof from);

    (void)harness_stop(&first, SIGKILL);
    assert_true(harness_logged(&second, "leads, epoch"));
    const dds_guid_t next = assert_one_answers();
    assert_memory_not_equal(&next, &leader, sizeof next);
    while (take_for(node.diagnostics, diagnostics, 100, &from) == 0)
        ;
    assert_memory_equal(&from, &next, sizeof from);
    close_all();
}

TEST(one_daemon_answers_and_another_takes_over)
{
    check_takeover(test_domain());
}

TEST(the_same_where_both_kinds_of_topics_share_a_domain)
{
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
    {&diagnostic_msgs_msg_dds__DiagnosticArray__desc, "rt/diagnostics", 2},
};

#define OUTPUTS (sizeof outputs / sizeof *outputs)

/* Those of the leader before */
static void discard_samples(dds_entity_t reader, const dds_topic_descriptor_t *type)
{
    void *sample = calloc(1, type->m_size);
    dds_sample_info_t info;

    assert_non_null(sample);
    while (dds_take(reader, &sample, &info, 1, 1) == 1)
        ;
    dds_sample_free(sample, type, DDS_FREE_ALL);
}

/* What is written while states come is all of this participant. */
static void assert_only_one_writes(const dds_entity_t *readers, const dds_guid_t *expected)
{
    const arm_motion m = arm_motion_of(3);

    for (size_t k = 0; k < OUTPUTS; k++) {
        unsigned count = 0;
        discard_samples(readers[k], outputs[k].type);
        for (int i = 0; i < 500 && count < outputs[k].least; i++) {
            dds_guid_t from;
            arm_publish_state(&node, &m, i);
            const unsigned more = take_for(readers[k], outputs[k].type, 20, &from);
            if (more > 0)
                assert_memory_equal(&from, expected, sizeof from);
            count += more;
        }
        assert_true(count >= outputs[k].least);
    }
}

/* The arm with another mass, as a description. */
static char *heavy_arm(tfa_workspace **workspace, tfa_model **model)
{
    static const char light[] = "<mass value=\"2.8\"/>", heavy[] = "<mass value=\"5.6\"/>";
    FILE *file = fopen(TFA_SOURCE_DIR "/config/robots/arm7.urdf", "r");
    tfa_description *d;
    tfa_report report = {0};
    char *text = NULL;
    size_t size = 0;

    assert_non_null(file);
    assert_true(getdelim(&text, &size, 0, file) > 0);
    fclose(file);
    char *at = strstr(text, light);
    assert_non_null(at);
    memcpy(at, heavy, sizeof heavy - 1);
    assert_int_equal(tfa_urdf_parse(text, strlen(text), NULL, &d, &report), TFA_OK);
    *model = compiled(d, NULL);
    *workspace = workspace_for(*model, NULL);
    tfa_description_free(d);
    tfa_report_free(&report);
    return text;
}

/* Is the next answer of this model, soon? */
static void await_model(tfa_workspace *workspace)
{
    static trajectory_msgs_msg_dds__JointTrajectory_ got;
    const arm_motion m = arm_motion_of(77);
    const tfa_request request = {.op = TFA_OP_FORWARD_DYNAMICS,
                                 .refine = TFA_REFINE_DEFAULT,
                                 .count = 1,
                                 .q = m.q,
                                 .v = m.v,
                                 .tau = m.tau};
    double qdd[JOINTS];
    tfa_reply reply = {.qdd = qdd};
    bool same = false;

    assert_int_equal(tfa_compute(workspace, &request, &reply), TFA_OK);
    for (int k = 0; k < 200 && !same; k++) {
        arm_publish_state(&node, &m, 1);
        arm_publish_named_efforts(&node, arm_joints, m.tau, JOINTS, 1);
        same = ros2_peer_take(node.accelerations, &got, 50) &&
               memcmp(got.points._buffer[0].accelerations._buffer, qdd, sizeof qdd) == 0;
    }
    assert_true(same);
}

/* A leader that was stopped is silent when it goes on; the description is that of both. */
TEST(a_stopped_leader_comes_back_and_is_silent)
{
    tfa_workspace *workspace;
    tfa_model *model;
    char *text = heavy_arm(&workspace, &model);
    dds_entity_t readers[OUTPUTS];
    const std_msgs_msg_dds__String_ description = {text};

    open_all(test_domain());
    for (size_t k = 0; k < OUTPUTS; k++)
        readers[k] =
            ros2_peer_reader(node.participant, outputs[k].type, outputs[k].topic, PEER_DEFAULT);
    assert_int_equal(dds_write(node.description, &description), DDS_RETCODE_OK);
    await_model(workspace);
    assert_true(harness_logged(&second, "reload: done, 1 of 1"));
    const dds_guid_t leader = assert_one_answers();
    assert_only_one_writes(readers, &leader);

    harness_pause(&first);
    assert_true(harness_logged(&second, "leads, epoch"));
    await_model(workspace);
    const dds_guid_t next = assert_one_answers();
    assert_memory_not_equal(&next, &leader, sizeof next);
    assert_int_equal(kill(first.pid, SIGCONT), 0);
    assert_true(harness_logged(&first, "standby, the leader has"));
    const dds_guid_t last = assert_one_answers();
    assert_memory_equal(&last, &next, sizeof last);
    assert_only_one_writes(readers, &next);
    await_model(workspace);

    assert_int_equal(harness_stop(&first, SIGTERM), 0);
    close_all();
    tfa_workspace_free(workspace);
    tfa_model_free(model);
    free(text);
}

int main(void)
{
    return test_run(NULL, NULL);
}
