/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A floating base from odometry, and wrenches on a link: what is there is used as the library uses
 * it, what is missing, old or wrong is refused by name.
 */
#include "dds/dds_test.h"

#include "models.h"
#include "ros2_daemon.h"

#include <math.h>
#include <signal.h>
#include <string.h>

#define LEGS 12

/* Two robots of one kind: no message of the dog becomes too old, those of the old one soon do. */
typedef struct robot {
    const char *name;
    dds_entity_t joint_states, efforts, odometry, wrench[2], accelerations; /* FL_foot, RR_foot */
} robot;

static robot dog = {.name = "dog"}, old = {.name = "old"};

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

static void publish_odometry(const robot *r, const motion *m, const char *child)
{
    const double *p = m->pose, *t = m->twist;
    nav_msgs_msg_dds__Odometry_ sample = {.header = {{1, 1}, "odom"},
                                          .child_frame_id = (char *)(uintptr_t)child};
    sample.pose.pose = (geometry_msgs_msg_dds__Pose_){{p[0], p[1], p[2]}, {p[3], p[4], p[5], p[6]}};
    sample.twist.twist = (geometry_msgs_msg_dds__Twist_){{t[0], t[1], t[2]}, {t[3], t[4], t[5]}};
    assert_int_equal(dds_write(r->odometry, &sample), DDS_RETCODE_OK);
}

static void publish_wrench(const robot *r, int k, const double w[6], const char *frame)
{
    const geometry_msgs_msg_dds__WrenchStamped_ sample = {
        .header = {{1, 1}, (char *)(uintptr_t)frame},
        .wrench = {{w[0], w[1], w[2]}, {w[3], w[4], w[5]}}};
    assert_int_equal(dds_write(r->wrench[k], &sample), DDS_RETCODE_OK);
}

static void publish_wrenches(const robot *r, const motion *m, const char *frame)
{
    publish_wrench(r, 1, m->wrench[1], "");
    publish_wrench(r, 0, m->wrench[0], frame);
}

static char *joint_names[LEGS];

static void publish_joints(const robot *r, const motion *m)
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
    assert_int_equal(dds_write(r->joint_states, &state), DDS_RETCODE_OK);
    assert_int_equal(dds_write(r->efforts, &efforts), DDS_RETCODE_OK);
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

static void publish_all(const robot *r, const motion *m, const char *child, const char *frame)
{
    publish_odometry(r, m, child);
    publish_wrenches(r, m, frame);
    publish_joints(r, m);
}

/* Publishes the motion with an effort that no message of before had. @return whether the answer
 * comes soon; no answer to a command of before is then left */
static bool is_answered(const robot *r, motion m, const char *child, const char *frame)
{
    static trajectory_msgs_msg_dds__JointTrajectory_ got;
    static double effort = 1;
    m.tau[0] = effort += 0.001;
    publish_all(r, &m, child, frame);
    while (ros2_peer_take(r->accelerations, &got, 200))
        if (is_answer(&got, &m))
            return true;
    return false;
}

/* Publishes until the answer comes: what is sent before a match is lost. */
static void assert_answer(const robot *r, const motion *m, const char *child, const char *frame)
{
    assert_true(WAIT_FOR(is_answered(r, *m, child, frame)));
}

/* It would be here: the diagnostics that tell the refusal are written after the answers. */
static void assert_silent(const robot *r)
{
    static trajectory_msgs_msg_dds__JointTrajectory_ got;
    assert_false(ros2_peer_take(r->accelerations, &got, 0));
}

/* @return level of the answers' status with this text, -1: it does not come soon */
static int find_answers(const robot *r, const char *text)
{
    char what[64];
    snprintf(what, sizeof what, "%s/totalforce: answers", r->name);
    return arm_find_diagnostic(&node, what, text);
}

/* Before anything came. */
TEST(a_base_that_never_came_is_named)
{
    const motion m = motion_of(1);
    int level = -1;
    assert_true(
        WAIT_FOR((publish_joints(&dog, &m),
                  level = find_answers(&dog, "floating base: pose and twist were never received"),
                  level >= 0)));
    assert_int_equal(level, 2);
    assert_true(WAIT_FOR((publish_odometry(&dog, &m, ""), publish_joints(&dog, &m),
                          find_answers(&dog, "link 'FL_foot': wrench was never received") >= 0)));
}

TEST(base_and_wrench_are_used_as_the_library_does)
{
    const char *root = tfa_model_frame(model, 0).name;
    for (uint64_t seed = 10; seed < 30; seed++) {
        const motion m = motion_of(seed);
        assert_answer(&dog, &m, seed % 2 ? "" : root, seed % 3 ? "FL_foot" : "");
    }
}

TEST(other_frames_and_numbers_are_refused)
{
    motion m = motion_of(40);
    publish_odometry(&dog, &m, "base_footprint");
    assert_true(arm_await_diagnostic(&node, "/dog/odom", "child_frame_id 'base_footprint'") > 0);
    publish_wrench(&dog, 0, m.wrench[0], "FR_foot");
    assert_true(arm_await_diagnostic(&node, "/dog/ft", "frame_id 'FR_foot' where 'FL_foot'") > 0);
    m.wrench[0][2] = NAN;
    publish_wrench(&dog, 0, m.wrench[0], "");
    assert_true(arm_await_diagnostic(&node, "/dog/ft", "a number is not finite") > 0);
    m.twist[4] = INFINITY;
    publish_odometry(&dog, &m, "");
    assert_true(arm_await_diagnostic(&node, "/dog/odom", "a number is not finite") > 0);
}

/* The base and the wrench of before stay in force. */
TEST(what_is_refused_changes_nothing)
{
    static trajectory_msgs_msg_dds__JointTrajectory_ got;
    motion good = motion_of(43), bad = motion_of(44);
    assert_answer(&dog, &good, "", "");
    publish_odometry(&dog, &bad, "base_footprint");
    publish_wrench(&dog, 0, bad.wrench[0], "FR_foot");
    for (int k = 0; k < 6; k++) {
        motion one = bad;
        one.wrench[0][k] = k % 2 ? NAN : -INFINITY;
        publish_wrench(&dog, 0, one.wrench[0], "");
    }
    for (int k = 0; k < 13; k++) {
        motion one = bad;
        *(k < 7 ? &one.pose[k] : &one.twist[k - 7]) = k % 2 ? NAN : INFINITY;
        publish_odometry(&dog, &one, "");
        good.tau[0] = k;
        publish_joints(&dog, &good);
        assert_true(ros2_peer_take(dog.accelerations, &got, WAIT_MS));
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

static double lambda_inv[36], jacobian[6 * (6 + LEGS)], bias[6], torques[6 + LEGS];

static bool take_torques(dds_entity_t reader)
{
    static sensor_msgs_msg_dds__JointState_ got;
    return ros2_peer_take(reader, &got, 200) && got.effort._length == LEGS &&
           memcmp(got.effort._buffer, torques + 6, LEGS * sizeof *torques) == 0;
}

/* Publishes the state. @return a bit for each of those `left` whose answer has not come */
static unsigned take_states(const dds_entity_t readers[4], const motion *m, unsigned left)
{
    publish_odometry(&dog, m, "");
    publish_joints(&dog, m);
    left &= ~(left & 1 && take_array(readers[0], lambda_inv, 36) ? 1u : 0u);
    left &= ~(left & 2 && take_array(readers[1], jacobian, 6 * (6 + LEGS)) ? 2u : 0u);
    left &= ~(left & 4 && take_array(readers[2], bias, 6) ? 4u : 0u);
    return left & ~(left & 8 && take_torques(readers[3]) ? 8u : 0u);
}

/* What holds the dog still in this state */
static void expect_torques(const motion *m)
{
    const tfa_request at_rest = {
        .op = TFA_OP_BIAS, .count = 1, .q = m->q, .base_pose = m->pose, .base_twist = m->twist};
    tfa_reply reply = {.gravity_force = torques};
    assert_int_equal(tfa_compute(workspace, &at_rest, &reply), TFA_OK);
}

/* Of the state that came last: pose and twist, too. */
TEST(states_are_answered_as_the_library_does)
{
    const dds_topic_descriptor_t *array = &std_msgs_msg_dds__Float64MultiArray__desc;
    const dds_entity_t readers[] = {
        open_reader(array, "rt/dog/totalforce/lambda_inv"),
        open_reader(array, "rt/dog/totalforce/jacobian"),
        open_reader(array, "rt/dog/totalforce/bias_acceleration"),
        open_reader(&sensor_msgs_msg_dds__JointState__desc, "rt/dog/totalforce/gravity_torques")};
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
    tfa_reply reply = {.lambda_inv = lambda_inv, .jacobian = jacobian, .bias_acceleration = bias};
    unsigned left = 1 | 2 | 4 | 8;
    assert_int_equal(tfa_compute(workspace, &request, &reply), TFA_OK);
    expect_torques(&m);
    assert_true(WAIT_FOR((left = take_states(readers, &m, left)) == 0));
    for (size_t k = 0; k < sizeof readers / sizeof *readers; k++)
        assert_int_equal(dds_delete(readers[k]), DDS_RETCODE_OK);
}

/* Publishes a state that no other is like. @return its answer has come: no earlier one is left */
static bool is_settled(dds_entity_t reader, uint64_t seed)
{
    const motion m = motion_of(seed);
    expect_torques(&m);
    publish_odometry(&dog, &m, "");
    publish_joints(&dog, &m);
    for (int k = 0; k < 100; k++)
        if (take_torques(reader))
            return true;
    return false;
}

/* An answer bears the stamp of a joint state, so there is one for each: the odometry that came
 * meanwhile is used with the next. */
TEST(odometry_alone_is_not_answered)
{
    const dds_entity_t reader =
        open_reader(&sensor_msgs_msg_dds__JointState__desc, "rt/dog/totalforce/gravity_torques");
    static sensor_msgs_msg_dds__JointState_ got;
    motion next = motion_of(91);
    uint64_t seed = 50;
    assert_true(WAIT_FOR(is_settled(reader, seed++)));
    const uint64_t before = arm_received(&running, "dog", "/dog/odom");
    publish_odometry(&dog, &next, "");
    assert_true(WAIT_FOR(arm_received(&running, "dog", "/dog/odom") > before));
    publish_joints(&dog, &next);
    expect_torques(&next);
    assert_true(WAIT_FOR(ros2_peer_take(reader, &got, 200)));
    assert_int_equal(got.effort._length, LEGS);
    assert_memory_equal(got.effort._buffer, torques + 6, LEGS * sizeof *torques);
    assert_int_equal(dds_delete(reader), DDS_RETCODE_OK);
}

/* A quaternion that is none is the library's refusal. */
TEST(what_the_library_refuses_is_told)
{
    motion m = motion_of(41);
    assert_answer(&dog, &m, "", "");
    m.pose[3] = m.pose[4] = m.pose[5] = m.pose[6] = 2;
    publish_all(&dog, &m, "", "");
    assert_true(arm_await_diagnostic(&node, "dog/totalforce: answers", "base_pose") > 0);
    assert_silent(&dog);
}

TEST(old_ones_are_refused)
{
    static const char limit[] = "ms old, the limit is 500 ms";
    const motion m = motion_of(42);
    assert_answer(&old, &m, "", "");
    assert_int_equal(arm_await_diagnostic(&node, "/old/odom", limit), 3);
    assert_true(WAIT_FOR((publish_joints(&old, &m),
                          find_answers(&old, "floating base: pose and twist are too old") > 0)));
    assert_silent(&old);
    assert_int_equal(arm_await_diagnostic(&node, "/old/ft", limit), 3);
    assert_true(WAIT_FOR((publish_odometry(&old, &m, ""), publish_joints(&old, &m),
                          find_answers(&old, "link 'FL_foot': wrench is too old") > 0)));
    assert_silent(&old);
}

static void open_robot(robot *r)
{
    const dds_topic_descriptor_t *state = &sensor_msgs_msg_dds__JointState__desc,
                                 *force = &geometry_msgs_msg_dds__WrenchStamped__desc;
    r->joint_states = open_writer(state, PEER_DEFAULT, "rt/%s/joint_states", r->name);
    r->efforts = open_writer(state, PEER_DEFAULT, "rt/%s/efforts", r->name);
    r->odometry =
        open_writer(&nav_msgs_msg_dds__Odometry__desc, PEER_DEFAULT, "rt/%s/odom", r->name);
    r->wrench[0] = open_writer(force, PEER_SENSOR, "rt/%s/ft", r->name);
    r->wrench[1] = open_writer(force, PEER_SENSOR, "rt/%s/rear/ft", r->name);
    r->accelerations = open_reader(&trajectory_msgs_msg_dds__JointTrajectory__desc,
                                   "rt/%s/totalforce/accelerations", r->name);
}

#define ROBOT(name, age)                                                                           \
    "  - name: " name "\n    urdf: @/config/robots/quadruped.urdf\n    base: floating\n"           \
    "    ros2:\n      enabled: yes\n      namespace: /" name "\n      odometry: odom\n"            \
    "      joint_efforts: efforts\n      wrenches: [{topic: ft, link: FL_foot}, "                  \
    "{topic: rear/ft, link: RR_foot}]\n      tips: [RR_foot]\n"                                    \
    "      state_age_ms: " age "\n      command_age_ms: 3600000\n"

static int serve(void **state)
{
    const tfa_model_options floating = {.base = TFA_BASE_FLOATING};
    (void)state;
    load_robot("quadruped.urdf", &floating);
    for (uint32_t j = 0; j < LEGS; j++)
        joint_names[j] = (char *)(uintptr_t)tfa_model_joint(model, j).name;
    running = harness_make(ROBOT("dog", "3600000") ROBOT("old", "500"), arm_settings(""));
    harness_start(&running, "dog");
    arm_node_watch(&node);
    open_robot(&dog);
    open_robot(&old);
    return 0;
}

int main(void)
{
    return test_run(serve, stop);
}
