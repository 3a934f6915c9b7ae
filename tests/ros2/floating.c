/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A floating base from odometry, and wrenches on a link: what is there is used as the library uses
 * it, what is missing, old or wrong is refused by name.
 */
#include "dds/dds_test.h"

#include "models.h"
#include "ros2_arm.h"

#include <math.h>
#include <signal.h>
#include <string.h>

#define LEGS 12

static harness running;
static arm_node node;
static dds_entity_t odometry, wrench;
static tfa_model *model;
static tfa_workspace *workspace;

typedef struct motion {
    double q[LEGS], v[LEGS], tau[LEGS], pose[7], twist[6], wrench[6];
} motion;

static motion motion_of(uint64_t seed)
{
    motion m;
    double norm = 0;

    for (size_t k = 0; k < sizeof m / sizeof(double); k++)
        ((double *)(void *)&m)[k] = test_random(&seed);
    for (int k = 3; k < 7; k++)
        norm += m.pose[k] * m.pose[k];
    for (int k = 3; k < 7; k++)
        m.pose[k] /= sqrt(norm);
    return m;
}

static void publish_odometry(const motion *m, const char *child)
{
    const double *p = m->pose, *t = m->twist;
    nav_msgs_msg_dds__Odometry_ sample = {.header = {{1, 1}, "odom"},
                                          .child_frame_id = (char *)(uintptr_t)child};

    sample.pose.pose = (geometry_msgs_msg_dds__Pose_){{p[0], p[1], p[2]}, {p[3], p[4], p[5], p[6]}};
    sample.twist.twist = (geometry_msgs_msg_dds__Twist_){{t[0], t[1], t[2]}, {t[3], t[4], t[5]}};
    assert_int_equal(dds_write(odometry, &sample), DDS_RETCODE_OK);
}

static void publish_wrench(const motion *m, const char *frame)
{
    const double *w = m->wrench;
    const geometry_msgs_msg_dds__WrenchStamped_ sample = {
        .header = {{1, 1}, (char *)(uintptr_t)frame},
        .wrench = {{w[0], w[1], w[2]}, {w[3], w[4], w[5]}}};

    assert_int_equal(dds_write(wrench, &sample), DDS_RETCODE_OK);
}

static char *joint_names[LEGS];

static void publish_joints(const motion *m)
{
    const sensor_msgs_msg_dds__JointState_ state = {
        .header = {{1, 1}, ""},
        .name = PEER_SEQUENCE(LEGS, joint_names),
        .position = PEER_SEQUENCE(LEGS, (double *)(uintptr_t)m->q),
        .velocity = PEER_SEQUENCE(LEGS, (double *)(uintptr_t)m->v)};
    const sensor_msgs_msg_dds__JointState_ efforts = {
        .header = {{5, 6}, "policy"},
        .name = PEER_SEQUENCE(LEGS, joint_names),
        .effort = PEER_SEQUENCE(LEGS, (double *)(uintptr_t)m->tau)};

    assert_int_equal(dds_write(node.joint_states, &state), DDS_RETCODE_OK);
    assert_int_equal(dds_write(node.joint_efforts, &efforts), DDS_RETCODE_OK);
}

static bool is_answer(const trajectory_msgs_msg_dds__JointTrajectory_ *got, const motion *m)
{
    const uint32_t foot = (uint32_t)tfa_model_find_frame(model, "FL_foot");
    const tfa_request request = {.op = TFA_OP_FORWARD_DYNAMICS,
                                 .refine = TFA_REFINE_DEFAULT,
                                 .frame = TFA_FRAME_LOCAL,
                                 .count = 1,
                                 .q = m->q,
                                 .v = m->v,
                                 .tau = m->tau,
                                 .base_pose = m->pose,
                                 .base_twist = m->twist,
                                 .wrench_count = 1,
                                 .wrench_frames = {foot},
                                 .wrenches = m->wrench};
    double qdd[LEGS], base[6];
    tfa_reply reply = {.qdd = qdd, .base_acceleration = base};

    assert_int_equal(tfa_compute(workspace, &request, &reply), TFA_OK);
    return got->points._buffer[0].accelerations._length == LEGS &&
           memcmp(got->points._buffer[0].accelerations._buffer, qdd, sizeof qdd) == 0;
}

/* Publishes until the answer comes: what is sent before a match is lost. */
static void assert_answer(const motion *m, const char *child, const char *frame)
{
    static trajectory_msgs_msg_dds__JointTrajectory_ got;
    bool found = false;

    for (int k = 0; k < 100 && !found; k++) {
        publish_odometry(m, child);
        publish_wrench(m, frame);
        dds_sleepfor(DDS_MSECS(1));
        publish_joints(m);
        found = ros2_peer_take(node.accelerations, &got, 200) && is_answer(&got, m);
    }
    assert_true(found);
}

static void assert_silent(void)
{
    static trajectory_msgs_msg_dds__JointTrajectory_ got;
    assert_false(ros2_peer_take(node.accelerations, &got, 100));
}

/* Before anything came. */
TEST(a_base_that_never_came_is_named)
{
    const motion m = motion_of(1);
    int level = -1;

    for (int k = 0; k < 20 && level < 0; k++) {
        publish_joints(&m);
        level = arm_await_diagnostic(&node, "dog/totalforce: answers",
                                     "floating base: pose and twist were never received");
    }
    assert_int_equal(level, 2);
    publish_odometry(&m, "");
    dds_sleepfor(DDS_MSECS(1));
    publish_joints(&m);
    assert_true(arm_await_diagnostic(&node, "dog/totalforce: answers",
                                     "link 'FL_foot': wrench was never received") >= 0);
}

TEST(base_and_wrench_are_used_as_the_library_does)
{
    const char *root = tfa_model_frame(model, 0).name;

    for (uint64_t seed = 10; seed < 30; seed++) {
        const motion m = motion_of(seed);
        assert_answer(&m, seed % 2 ? "" : root, seed % 3 ? "FL_foot" : "");
    }
}

TEST(other_frames_and_numbers_are_refused)
{
    motion m = motion_of(40);

    publish_odometry(&m, "base_footprint");
    assert_true(arm_await_diagnostic(&node, "/dog/odom", "child_frame_id 'base_footprint'") > 0);
    publish_wrench(&m, "FR_foot");
    assert_true(arm_await_diagnostic(&node, "/dog/ft", "frame_id 'FR_foot' where 'FL_foot'") > 0);
    m.wrench[2] = NAN;
    publish_wrench(&m, "");
    assert_true(arm_await_diagnostic(&node, "/dog/ft", "a number is not finite") > 0);
    m.twist[4] = INFINITY;
    publish_odometry(&m, "");
    assert_true(arm_await_diagnostic(&node, "/dog/odom", "a number is not finite") > 0);
}

/* A quaternion that is none is the library's refusal. */
TEST(what_the_library_refuses_is_told)
{
    motion m = motion_of(41);

    m.pose[3] = m.pose[4] = m.pose[5] = m.pose[6] = 2;
    publish_odometry(&m, "");
    publish_wrench(&m, "");
    dds_sleepfor(DDS_MSECS(1));
    publish_joints(&m);
    assert_silent();
    assert_true(arm_await_diagnostic(&node, "dog/totalforce: answers", "base_pose") > 0);
}

TEST(old_ones_are_refused)
{
    const motion m = motion_of(42);

    assert_answer(&m, "", "");
    dds_sleepfor(DDS_MSECS(1100)); /* the limit is 1 s */
    publish_joints(&m);
    assert_silent();
    assert_true(arm_await_diagnostic(&node, "dog/totalforce: answers",
                                     "floating base: pose and twist are too old") > 0);
    publish_odometry(&m, "");
    dds_sleepfor(DDS_MSECS(1));
    publish_joints(&m);
    assert_silent();
    assert_true(arm_await_diagnostic(&node, "dog/totalforce: answers",
                                     "link 'FL_foot': wrench is too old") > 0);
    assert_int_equal(arm_await_diagnostic(&node, "/dog/ft", "ms old, the limit is 1000 ms"), 3);
}

static void open_node(void)
{
    const dds_entity_t p = node.participant = ros2_peer_open(arm_domain());
    const dds_topic_descriptor_t *state = &sensor_msgs_msg_dds__JointState__desc;

    node.joint_states = ros2_peer_writer(p, state, "rt/dog/joint_states", PEER_DEFAULT);
    node.joint_efforts = ros2_peer_writer(p, state, "rt/dog/efforts", PEER_DEFAULT);
    odometry = ros2_peer_writer(p, &nav_msgs_msg_dds__Odometry__desc, "rt/dog/odom", PEER_DEFAULT);
    wrench =
        ros2_peer_writer(p, &geometry_msgs_msg_dds__WrenchStamped__desc, "rt/dog/ft", PEER_SENSOR);
    node.accelerations = ros2_peer_reader(p, &trajectory_msgs_msg_dds__JointTrajectory__desc,
                                          "rt/dog/totalforce/accelerations", PEER_DEFAULT);
    node.diagnostics = ros2_peer_reader(p, &diagnostic_msgs_msg_dds__DiagnosticArray__desc,
                                        "rt/diagnostics", PEER_DEFAULT);
    ros2_peer_await_writer(node.diagnostics);
    ros2_peer_await_reader(odometry);
    ros2_peer_await_reader(wrench);
    ros2_peer_await_reader(node.joint_efforts);
}

static int serve(void **state)
{
    const tfa_model_options floating = {.base = TFA_BASE_FLOATING};

    (void)state;
    model = bundled_model("quadruped.urdf", &floating);
    workspace = workspace_for(model, NULL);
    for (uint32_t j = 0; j < LEGS; j++)
        joint_names[j] = (char *)(uintptr_t)tfa_model_joint(model, j).name;
    harness_make(&running,
                 "  - name: dog\n    urdf: @/config/robots/quadruped.urdf\n    base: floating\n"
                 "    ros2:\n      enabled: yes\n      namespace: /dog\n      odometry: odom\n"
                 "      joint_efforts: efforts\n      wrenches: [{topic: ft, link: FL_foot}]\n"
                 "      state_age_ms: 1000\n      command_age_ms: 1000\n",
                 arm_settings(""));
    harness_start(&running, "dog");
    open_node();
    return 0;
}

static int stop(void **state)
{
    (void)state;
    arm_node_close(&node);
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
