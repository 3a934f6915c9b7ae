/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Answers on topics of ROS 2 are recorded as others are, without what the observer asks for itself;
 * and those of a robot whose URDF came over a topic.
 */
#include "dds/dds_test.h"

#include "recorder.h"
#include "ros2/ros2_arm.h"
#include "test.h"

#include <signal.h>

#define COMMANDS 200
/* With each state: gravity torques, and the tips' answers. */
#define ANSWERS_MIN (3 * COMMANDS - 10)

static harness h;
static arm_node node;
static dds_entity_t gravity, lambda;
static int32_t second; /* the stamp of each state is another */

/* Waits for the answers to the state with this stamp. */
static void await_answers(int32_t stamp)
{
    static sensor_msgs_msg_dds__JointState_ torques;
    static std_msgs_msg_dds__Float64MultiArray_ inertia;
    char label[32];
    snprintf(label, sizeof label, "stamp %d.", (int)stamp);
    do
        assert_true(ros2_peer_take(gravity, &torques, WAIT_MS));
    while (torques.header.stamp.sec != stamp);
    do
        assert_true(ros2_peer_take(lambda, &inertia, WAIT_MS));
    while (!strstr(inertia.layout.dim._buffer[0].label, label));
}

static void ask(void)
{
    static trajectory_msgs_msg_dds__JointTrajectory_ sample;
    for (int32_t k = 0; k < COMMANDS; k++) {
        const arm_motion m = arm_motion_of(1000 + (uint64_t)k);
        sensor_msgs_msg_dds__JointState_ state = arm_state(&m, ++second);
        state.effort = arm_efforts(arm_joints, m.tau, JOINTS, second).effort;
        assert_int_equal(dds_write(node.joint_states, &state), DDS_RETCODE_OK);
        await_answers(second);
        arm_publish_efforts(&node, m.tau, JOINTS);
        do
            assert_true(ros2_peer_take(node.accelerations, &sample, WAIT_MS));
        while (sample.header.stamp.sec != second);
    }
}

static void record_and_replay(const char *file)
{
    static recorder r;
    char more[160];
    arm_assert_answered(&node);
    recorder_begin(&h, &r, "arm", file, "", 0);
    ask();
    assert_int_equal(recorder_end(&r), 0);
    const long records = recorder_number(&r, ".rec: ");
    assert_true(records >= ANSWERS_MIN && records <= 3 * COMMANDS);
    assert_true(harness_logged(&h, "the observer restarted: "));
    assert_int_equal(recorder_replay(&h, &r, file, ""), 0);
    assert_int_equal(recorder_number(&r, "same bits "), records);
    snprintf(more, sizeof more, "--robot arm --runtime-dir %s", h.runtime_dir);
    assert_int_equal(recorder_replay(&h, &r, file, more), 0);
    assert_int_equal(recorder_number(&r, "same bits "), records);
}

/* The bundled arm with another mass. */
static void publish_description(void)
{
    SCOPED_TEXT *text = arm_urdf(true);
    const std_msgs_msg_dds__String_ sample = {text};
    assert_int_equal(dds_write(node.description, &sample), DDS_RETCODE_OK);
    assert_true(harness_logged(&h, "reload: done, 1 of 1"));
}

TEST(answers_on_topics)
{
    h = harness_serve(arm_yaml("      observer: {gain: 1, tip: tool0}\n"), arm_settings(""));
    arm_node_open(&node);
    gravity = ros2_peer_reader(node.participant, &sensor_msgs_msg_dds__JointState__desc,
                               "rt/arm/totalforce/gravity_torques", PEER_DEFAULT);
    lambda = ros2_peer_reader(node.participant, &std_msgs_msg_dds__Float64MultiArray__desc,
                              "rt/arm/totalforce/lambda_inv", PEER_DEFAULT);
    ros2_peer_await_writer(gravity);
    ros2_peer_await_writer(lambda);
    record_and_replay("file.rec");
    publish_description();
    record_and_replay("topic.rec");
    arm_node_close(&node);
    harness_remove(&h);
}
