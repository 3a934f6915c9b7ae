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
static dds_entity_t odometry, wrench[2]; /* of FL_foot and RR_foot */
static tfa_model *model;
static tfa_workspace *workspace;

typedef struct motion {
    double q[LEGS], v[LEGS], tau[LEGS], pose[7], twist[6], wrench[2][6];
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

static void publish_wrench(int k, const double w[6], const char *frame)
{
    const geometry_msgs_msg_dds__WrenchStamped_ sample = {
        .header = {{1, 1}, (char *)(uintptr_t)frame},
        .wrench = {{w[0], w[1], w[2]}, {w[3], w[4], w[5]}}};

    assert_int_equal(dds_write(wrench[k], &sample), DDS_RETCODE_OK);
}

static void publish_wrenches(const motion *m, const char *frame)
{
    publish_wrench(1, m->wrench[1], "");
    publish_wrench(0, m->wrench[0], frame);
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

static uint32_t frame_of(const char *link)
{
    const int32_t frame = tfa_model_find_frame(model, link);
    assert_true(frame >= 0);
    return (uint32_t)frame;
}

static bool is_answer(const trajectory_msgs_msg_dds__JointTrajectory_ *got, const motion *m)
{
    const tfa_request request = {.op = TFA_OP_FORWARD_DYNAMICS,
                                 .refine = TFA_REFINE_DEFAULT,
                                 .frame = TFA_FRAME_LOCAL,
                                 .count = 1,
                                 .q = m->q,
                                 .v = m->v,
                                 .tau = m->tau,
                                 .base_pose = m->pose,
                                 .base_twist = m->twist,
                                 .wrench_count = 2,
                                 .wrench_frames = {frame_of("FL_foot"), frame_of("RR_foot")},
                                 .wrenches = m->wrench[0]};
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
        publish_wrenches(m, frame);
        dds_sleepfor(DDS_MSECS(1));
        publish_joints(m);
        found = ros2_peer_take(node.accelerations, &got, 200) && is_answer(&got, m);
    }
    assert_true(found);
}

/* Answers that nobody waited for. */
static void drop_answers(void)
{
    static trajectory_msgs_msg_dds__JointTrajectory_ got;
    while (ros2_peer_take(node.accelerations, &got, 100))
        continue;
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
    publish_wrench(0, m.wrench[0], "FR_foot");
    assert_true(arm_await_diagnostic(&node, "/dog/ft", "frame_id 'FR_foot' where 'FL_foot'") > 0);
    m.wrench[0][2] = NAN;
    publish_wrench(0, m.wrench[0], "");
    assert_true(arm_await_diagnostic(&node, "/dog/ft", "a number is not finite") > 0);
    m.twist[4] = INFINITY;
    publish_odometry(&m, "");
    assert_true(arm_await_diagnostic(&node, "/dog/odom", "a number is not finite") > 0);
}

/* The base and the wrench of before stay in force. */
TEST(what_is_refused_changes_nothing)
{
    static trajectory_msgs_msg_dds__JointTrajectory_ got;
    const motion good = motion_of(43);
    motion bad = motion_of(44);

    assert_answer(&good, "", "");
    publish_odometry(&bad, "base_footprint");
    publish_wrench(0, bad.wrench[0], "FR_foot");
    for (int k = 0; k < 6; k++) {
        motion one = bad;
        one.wrench[0][k] = k % 2 ? NAN : -INFINITY;
        publish_wrench(0, one.wrench[0], "");
    }
    for (int k = 0; k < 13; k++) {
        motion one = bad;
        *(k < 7 ? &one.pose[k] : &one.twist[k - 7]) = k % 2 ? NAN : INFINITY;
        publish_odometry(&one, "");
        dds_sleepfor(DDS_MSECS(1));
        publish_joints(&good);
        assert_true(ros2_peer_take(node.accelerations, &got, 10000));
        assert_true(is_answer(&got, &good));
    }
}

/* ---- states ---- */

static bool take_array(dds_entity_t reader, const double *expected, uint32_t count)
{
    static std_msgs_msg_dds__Float64MultiArray_ got;

    if (!ros2_peer_take(reader, &got, 200))
        return false;
    assert_int_equal(got.data._length, count);
    if (got.layout.dim._length == 3 && got.layout.dim._buffer[2].size == 6 + LEGS) {
        assert_non_null(strstr(got.layout.dim._buffer[2].label, "columns base.x base.y"));
        assert_non_null(strstr(got.layout.dim._buffer[2].label, joint_names[LEGS - 1]));
    }
    return memcmp(got.data._buffer, expected, count * sizeof *expected) == 0;
}

/* Of the state that came last: pose and twist, too. */
TEST(states_are_answered_as_the_library_does)
{
    static double lambda_inv[36], jacobian[6 * (6 + LEGS)], bias[6], torques[6 + LEGS];
    static sensor_msgs_msg_dds__JointState_ held;
    const dds_topic_descriptor_t *array = &std_msgs_msg_dds__Float64MultiArray__desc;
    const dds_entity_t p = node.participant;
    const dds_entity_t readers[] = {
        ros2_peer_reader(p, array, "rt/dog/totalforce/lambda_inv", PEER_DEFAULT),
        ros2_peer_reader(p, array, "rt/dog/totalforce/jacobian", PEER_DEFAULT),
        ros2_peer_reader(p, array, "rt/dog/totalforce/bias_acceleration", PEER_DEFAULT),
        ros2_peer_reader(p, &sensor_msgs_msg_dds__JointState__desc,
                         "rt/dog/totalforce/gravity_torques", PEER_DEFAULT)};
    const motion m = motion_of(45);
    const tfa_request request = {.op = TFA_OP_OPERATIONAL_INERTIA,
                                 .refine = TFA_REFINE_DEFAULT,
                                 .flags = TFA_WANT_JACOBIAN | TFA_WANT_BIAS_ACCELERATION,
                                 .count = 1,
                                 .tip_count = 1,
                                 .tips = {frame_of("RR_foot")},
                                 .q = m.q,
                                 .v = m.v,
                                 .base_pose = m.pose,
                                 .base_twist = m.twist};
    const tfa_request at_rest = {
        .op = TFA_OP_BIAS, .count = 1, .q = m.q, .base_pose = m.pose, .base_twist = m.twist};
    tfa_reply reply = {.lambda_inv = lambda_inv, .jacobian = jacobian, .bias_acceleration = bias};
    tfa_reply holding = {.gravity_force = torques};
    unsigned left = 1 | 2 | 4 | 8;

    assert_int_equal(tfa_compute(workspace, &request, &reply), TFA_OK);
    assert_int_equal(tfa_compute(workspace, &at_rest, &holding), TFA_OK);
    for (int k = 0; k < 100 && left != 0; k++) {
        publish_odometry(&m, "");
        publish_joints(&m);
        left &= ~(left & 1 && take_array(readers[0], lambda_inv, 36) ? 1u : 0u);
        left &= ~(left & 2 && take_array(readers[1], jacobian, 6 * (6 + LEGS)) ? 2u : 0u);
        left &= ~(left & 4 && take_array(readers[2], bias, 6) ? 4u : 0u);
        if (left & 8 && ros2_peer_take(readers[3], &held, 200) && held.effort._length == LEGS &&
            memcmp(held.effort._buffer, torques + 6, LEGS * sizeof *torques) == 0)
            left &= ~8u;
    }
    assert_int_equal(left, 0);
    for (size_t k = 0; k < sizeof readers / sizeof *readers; k++)
        assert_int_equal(dds_delete(readers[k]), DDS_RETCODE_OK);
    drop_answers();
}

/* A quaternion that is none is the library's refusal. */
TEST(what_the_library_refuses_is_told)
{
    motion m = motion_of(41);

    m.pose[3] = m.pose[4] = m.pose[5] = m.pose[6] = 2;
    publish_odometry(&m, "");
    publish_wrenches(&m, "");
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
    wrench[0] =
        ros2_peer_writer(p, &geometry_msgs_msg_dds__WrenchStamped__desc, "rt/dog/ft", PEER_SENSOR);
    wrench[1] = ros2_peer_writer(p, &geometry_msgs_msg_dds__WrenchStamped__desc, "rt/dog/rear/ft",
                                 PEER_SENSOR);
    node.accelerations = ros2_peer_reader(p, &trajectory_msgs_msg_dds__JointTrajectory__desc,
                                          "rt/dog/totalforce/accelerations", PEER_DEFAULT);
    node.diagnostics = ros2_peer_reader(p, &diagnostic_msgs_msg_dds__DiagnosticArray__desc,
                                        "rt/diagnostics", PEER_DEFAULT);
    ros2_peer_await_writer(node.diagnostics);
    ros2_peer_await_reader(odometry);
    ros2_peer_await_reader(wrench[0]);
    ros2_peer_await_reader(wrench[1]);
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
                 "      joint_efforts: efforts\n      wrenches: [{topic: ft, link: FL_foot}, "
                 "{topic: rear/ft, link: RR_foot}]\n      tips: [RR_foot]\n"
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
