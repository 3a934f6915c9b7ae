/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A node of Fast DDS, which is what rmw_fastrtps is made of, and the real daemon: states, efforts
 * and a description one way, answers and diagnostics the other, to the bit.
 */
#include "fastdds_node.h"

#include "harness.h"
#include "models.h"
#include "ros2_arm.h"
#include "test.h"

#include <signal.h>
#include <string.h>

#define PATIENCE_MS 20000

static harness running;
static fastdds_node *node;
static tfa_model *model;
static tfa_workspace *workspace;
static fastdds_writer *states, *efforts, *commands, *descriptions;
static fastdds_reader *accelerations, *diagnostics, *lambda_inv;

static void publish_motion(const arm_motion *m, bool by_name)
{
    const sensor_msgs_msg_dds__JointState_ state = {
        .header = {{1, 7}, "base"},
        .name = PEER_SEQUENCE(JOINTS, arm_joints),
        .position = PEER_SEQUENCE(JOINTS, (double *)(uintptr_t)m->q),
        .velocity = PEER_SEQUENCE(JOINTS, (double *)(uintptr_t)m->v)};
    const sensor_msgs_msg_dds__JointState_ named = {
        .header = {{2, 9}, "command"},
        .name = PEER_SEQUENCE(JOINTS, arm_joints),
        .effort = PEER_SEQUENCE(JOINTS, (double *)(uintptr_t)m->tau)};
    const std_msgs_msg_dds__Float64MultiArray_ array = {
        .data = PEER_SEQUENCE(JOINTS, (double *)(uintptr_t)m->tau)};

    fastdds_publish(node, states, &state);
    if (by_name)
        fastdds_publish(node, efforts, &named);
    else
        fastdds_publish(node, commands, &array);
}

/* Publishes until the answer of the library comes: what is sent before a match is lost. */
static void assert_answer(const arm_motion *m, bool by_name)
{
    const tfa_request request = {.op = TFA_OP_FORWARD_DYNAMICS,
                                 .refine = TFA_REFINE_DEFAULT,
                                 .count = 1,
                                 .q = m->q,
                                 .v = m->v,
                                 .tau = m->tau};
    double qdd[JOINTS];
    tfa_reply reply = {.qdd = qdd};
    bool found = false;

    assert_int_equal(tfa_compute(workspace, &request, &reply), TFA_OK);
    for (int k = 0; k < 100 && !found; k++) {
        trajectory_msgs_msg_dds__JointTrajectory_ got;
        publish_motion(m, by_name);
        if (!fastdds_receive(node, accelerations, &got, 200))
            continue;
        const trajectory_msgs_msg_dds__JointTrajectoryPoint_ *p = &got.points._buffer[0];
        found = p->accelerations._length == JOINTS &&
                memcmp(p->accelerations._buffer, qdd, sizeof qdd) == 0;
        if (found) {
            assert_int_equal(got.header.stamp.sec, by_name ? 2 : 1);
            assert_string_equal(got.header.frame_id, by_name ? "command" : "base");
            assert_string_equal(got.joint_names._buffer[6], "joint_7");
        }
        dds_sample_free(&got, &trajectory_msgs_msg_dds__JointTrajectory__desc, DDS_FREE_CONTENTS);
    }
    assert_true(found);
}

TEST(commands_are_answered_to_the_bit)
{
    for (uint64_t seed = 1; seed <= 20; seed++) {
        const arm_motion m = arm_motion_of(seed);
        assert_answer(&m, seed % 2 == 0);
    }
}

TEST(operational_space_is_read)
{
    static double expected[12 * 12], jacobian[12 * JOINTS];
    const arm_motion m = arm_motion_of(50);
    const tfa_request request = {.op = TFA_OP_OPERATIONAL_INERTIA,
                                 .refine = TFA_REFINE_DEFAULT,
                                 .flags = TFA_WANT_JACOBIAN,
                                 .count = 1,
                                 .tip_count = 2,
                                 .tips = {(uint32_t)tfa_model_find_frame(model, "tool0"),
                                          (uint32_t)tfa_model_find_frame(model, "link_4")},
                                 .q = m.q};
    tfa_reply reply = {.lambda_inv = expected, .jacobian = jacobian};
    bool found = false;

    assert_int_equal(tfa_compute(workspace, &request, &reply), TFA_OK);
    for (int k = 0; k < 100 && !found; k++) {
        std_msgs_msg_dds__Float64MultiArray_ got;
        publish_motion(&m, true);
        if (!fastdds_receive(node, lambda_inv, &got, 200))
            continue;
        found = got.data._length == 144 && got.layout.dim._length == 3 &&
                memcmp(got.data._buffer, expected, sizeof expected) == 0;
        dds_sample_free(&got, &std_msgs_msg_dds__Float64MultiArray__desc, DDS_FREE_CONTENTS);
    }
    assert_true(found);
}

TEST(the_daemon_is_a_node)
{
    uint32_t readers = 0, writers = 0;

    assert_true(fastdds_await_node(node, "/arm", "totalforce", &readers, &writers, PATIENCE_MS));
    assert_int_equal(readers, 5); /* states, three kinds of commands, description */
    assert_int_equal(writers, 6); /* five answers, diagnostics */
}

static bool tells_robot(const diagnostic_msgs_msg_dds__DiagnosticArray_ *d, const char *what,
                        const char *value)
{
    for (uint32_t k = 0; k < d->status._length; k++) {
        const diagnostic_msgs_msg_dds__DiagnosticStatus_ *s = &d->status._buffer[k];
        if (strstr(s->name, what) == NULL)
            continue;
        for (uint32_t i = 0; i < s->values._length; i++)
            if (strstr(s->values._buffer[i].value, value) != NULL)
                return true;
    }
    return false;
}

/* A description is read, and diagnostics tell its model. */
TEST(a_description_changes_the_model)
{
    tfa_model *arm6 = bundled_model("arm6.urdf", NULL);
    char *text = NULL, hash[17];
    size_t size = 0;
    FILE *file = fopen(TFA_SOURCE_DIR "/config/robots/arm6.urdf", "r");
    bool found = false;

    assert_true(file != NULL && getdelim(&text, &size, 0, file) > 0);
    fclose(file);
    snprintf(hash, sizeof hash, "%s", tfa_model_hash_text(arm6));
    const std_msgs_msg_dds__String_ description = {text};
    fastdds_publish(node, descriptions, &description);
    for (int k = 0; k < 15 && !found; k++) {
        diagnostic_msgs_msg_dds__DiagnosticArray_ got;
        if (!fastdds_receive(node, diagnostics, &got, 2000))
            continue;
        found = tells_robot(&got, "/bare/totalforce: model", hash);
        dds_sample_free(&got, &diagnostic_msgs_msg_dds__DiagnosticArray__desc, DDS_FREE_CONTENTS);
    }
    assert_true(found);
    tfa_model_free(arm6);
    free(text);
}

/* By its good-bye: the lease of Cyclone's participants is 10 s. */
TEST(the_end_of_the_daemon_is_noticed)
{
    int matched = 1;

    assert_int_equal(harness_stop(&running, SIGTERM), 0);
    for (int k = 0; k < 80 && matched > 0; k++) {
        dds_sleepfor(DDS_MSECS(100));
        matched = fastdds_reader_matches(accelerations).matched;
    }
    assert_int_equal(matched, 0);
}

static void open_node(void)
{
    const dds_topic_descriptor_t *state = &sensor_msgs_msg_dds__JointState__desc;
    const dds_topic_descriptor_t *array = &std_msgs_msg_dds__Float64MultiArray__desc;

    node = fastdds_node_open(arm_domain(), "/arm", "controller");
    states = fastdds_publisher(node, state, "/arm/joint_states", &fastdds_default);
    efforts = fastdds_publisher(node, state, "/arm/joint_efforts", &fastdds_sensor_data);
    commands = fastdds_publisher(node, array, "/arm/effort_controller/commands", &fastdds_default);
    descriptions = fastdds_publisher(node, &std_msgs_msg_dds__String__desc,
                                     "/bare/robot_description", &fastdds_latched);
    accelerations = fastdds_subscription(node, &trajectory_msgs_msg_dds__JointTrajectory__desc,
                                         "/arm/totalforce/accelerations", &fastdds_default);
    lambda_inv = fastdds_subscription(node, array, "/arm/totalforce/lambda_inv", &fastdds_default);
    diagnostics = fastdds_subscription(node, &diagnostic_msgs_msg_dds__DiagnosticArray__desc,
                                       "/diagnostics", &fastdds_default);
    fastdds_await_match_of_writer(states);
    fastdds_await_match_of_writer(efforts);
    fastdds_await_match_of_writer(commands);
    fastdds_await_match_of_reader(accelerations);
}

static int serve(void **state)
{
    (void)state;
    model = bundled_model("arm7.urdf", NULL);
    workspace = workspace_for(model, NULL);
    harness_serve(&running,
                  arm_yaml("      state_age_ms: 10000\n      command_age_ms: 10000\n"
                           "  - name: bare\n    urdf: @/config/robots/arm7.urdf\n"
                           "    ros2: {enabled: yes, namespace: /bare, robot_description: "
                           "robot_description}\n"),
                  arm_settings(""));
    open_node();
    return 0;
}

static int stop(void **state)
{
    (void)state;
    fastdds_node_close(node);
    if (running.pid > 0)
        assert_int_equal(harness_stop(&running, SIGTERM), 0);
    harness_remove(&running);
    tfa_workspace_free(workspace);
    tfa_model_free(model);
    return 0;
}

int main(void)
{
    return test_run(serve, stop);
}
