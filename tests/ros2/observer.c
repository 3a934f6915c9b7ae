/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * External torques on topics of ROS 2. By the stamps, which the test chooses, they follow what was
 * added to the efforts that hold a robot; what starts the observer anew gives 0 and is told.
 */
#include "dds/dds_test.h"

#include "dds/ros2/unitree_crc.h"
#include "models.h"
#include "ros2_daemon.h"

#include <idl/unitree.h>
#include <math.h>
#include <string.h>
#include <totalforce/observer.h>

#define GAIN 20.0
#define MAX_GAP 0.5
#define MS INT64_C(1000000)
#define LEGS 12

typedef sensor_msgs_msg_dds__JointState_ joint_state;

typedef struct robot {
    const char *name, *frame; /* of its states; NULL: they are a LowState, whose stamp is a tick */
    char **joint;
    uint32_t joints;
    int64_t stamp; /* ns, of the last state */
    dds_entity_t states, torques, wrench;
} robot;

static robot arm = {.name = "arm", .frame = "base", .joint = arm_joints, .joints = JOINTS},
             bare = {.name = "bare", .frame = "base", .joint = arm_joints, .joints = JOINTS},
             unitree = {.name = "unitree", .joint = arm_joints, .joints = JOINTS},
             dog = {.name = "dog", .frame = "base", .joints = LEGS};

/* ---- samples ---- */

static joint_state state_of(const robot *r, const double *q, const double *v, const double *tau)
{
    return (joint_state){.header.frame_id = (char *)(uintptr_t)r->frame,
                         .name = PEER_SEQUENCE(r->joints, r->joint),
                         .position = PEER_SEQUENCE(r->joints, (double *)(uintptr_t)q),
                         .velocity = PEER_SEQUENCE(r->joints, (double *)(uintptr_t)v),
                         .effort = PEER_SEQUENCE(r->joints, (double *)(uintptr_t)tau)};
}

/* Torques of a LowState are those that its motors report. */
static void publish_motors(const robot *r, const joint_state *state)
{
    unitree_hg_msg_dds__LowState_ s = {.tick = (uint32_t)(r->stamp / MS)};
    for (uint32_t j = 0; j < r->joints; j++) {
        s.motor_state[j].q = (float)state->position._buffer[j];
        s.motor_state[j].tau_est = (float)state->effort._buffer[j];
    }
    s.crc = tfa_unitree_hg_crc(&s);
    assert_int_equal(dds_write(r->states, &s), DDS_RETCODE_OK);
}

static void publish(robot *r, joint_state state, int64_t step)
{
    r->stamp += step;
    state.header.stamp.sec = (int32_t)(r->stamp / 1000000000);
    state.header.stamp.nanosec = (uint32_t)(r->stamp % 1000000000);
    if (r->frame)
        assert_int_equal(dds_write(r->states, &state), DDS_RETCODE_OK);
    else
        publish_motors(r, &state);
}

static bool is_last(const robot *r, const std_msgs_msg_dds__Header_ *h)
{
    return h->stamp.sec == r->stamp / 1000000000 && h->stamp.nanosec == r->stamp % 1000000000;
}

/* The next torques: those of the last state. */
static const double *take_torques(const robot *r)
{
    static joint_state got;
    assert_true(ros2_peer_take(r->torques, &got, WAIT_MS));
    assert_true(is_last(r, &got.header));
    assert_string_equal(got.header.frame_id, r->frame ? r->frame : "");
    assert_int_equal(got.position._length + got.velocity._length, 0);
    assert_int_equal(got.name._length, r->joints);
    assert_int_equal(got.effort._length, r->joints);
    for (uint32_t j = 0; j < r->joints; j++)
        assert_string_equal(got.name._buffer[j], r->joint[j]);
    return got.effort._buffer;
}

static bool is_settled(robot *r, const joint_state *state)
{
    static joint_state got;
    publish(r, *state, MS);
    while (ros2_peer_take(r->torques, &got, 200))
        if (is_last(r, &got.header))
            return true;
    return false;
}

static void assert_share(const double *got, double share, const double *of, uint32_t count)
{
    for (uint32_t k = 0; k < count; k++)
        if (!(fabs(got[k] - share * of[k]) < 1e-9))
            fail_msg("number %u: %.17g, expected %.17g", k, got[k], share * of[k]);
}

/* What has followed for so many seconds; INFINITY: all of it */
static double share_after(double seconds)
{
    return 1 - exp(-GAIN * seconds);
}

static void assert_torques(robot *r, const joint_state *state, int64_t step, double seconds,
                           const double *external)
{
    publish(r, *state, step);
    assert_share(take_torques(r), share_after(seconds), external, r->joints);
}

static void assert_wrench(const robot *r, const char *frame, double seconds, const double *wrench)
{
    static geometry_msgs_msg_dds__WrenchStamped_ got;
    double numbers[6];
    do
        assert_true(ros2_peer_take(r->wrench, &got, WAIT_MS));
    while (!is_last(r, &got.header));
    assert_string_equal(got.header.frame_id, frame);
    memcpy(numbers, &got.wrench, sizeof numbers);
    assert_share(numbers, share_after(seconds), wrench, 6);
}

/* ---- the arm at rest, and torques that push it ---- */

/* In single precision, too */
static const double at[JOINTS] = {0.25, 0.75, -0.5, 1.125, 0.5, -0.875, 0.1875}, rest[LEGS],
                    pushes[JOINTS] = {3, -5, 0.5, 7, -0.25, 0, 1.5};
static double holds[JOINTS]; /* against the pushes, too */

static void find_gravity(tfa_workspace *space, const double *q, const double *pose, double *gravity)
{
    const tfa_request request = {.op = TFA_OP_BIAS, .count = 1, .q = q, .base_pose = pose};
    tfa_reply reply = {.gravity_force = gravity};
    assert_int_equal(tfa_compute(space, &request, &reply), TFA_OK);
}

static void hold(const double *external)
{
    find_gravity(workspace, at, NULL, holds);
    for (int j = 0; j < JOINTS; j++)
        holds[j] -= external[j];
}

static void assert_after(int64_t step, double seconds, const double *external)
{
    const joint_state held = state_of(&arm, at, rest, holds);
    assert_torques(&arm, &held, step, seconds, external);
}

/* Torques are 0, then follow the push. */
static void assert_restarted_by(int64_t step, const double *external)
{
    hold(external);
    assert_after(step, 0, external);
    assert_after(10 * MS, 0.01, external);
}

static bool restart_is_logged(const char *text)
{
    char line[160];
    snprintf(line, sizeof line, "robot 'arm': the observer restarted: %s", text);
    return harness_logged(&running, line);
}

/* ---- tests ---- */

/* Stamps of an epoch far from the first one: no digit of a step is lost. A gap beyond the largest
 * and a step back restart; each is logged before the next, for a line tells the last one. */
TEST(torques_follow_a_constant_push_by_the_stamps)
{
    static const struct {
        int64_t step;
        const char *says; /* of a restart */
    } rows[] = {{MS, NULL},
                {MS / 4, NULL},
                {4 * MS, NULL},
                {MS + 1, NULL},
                {30 * MS, NULL},
                {1, NULL},
                {7 * MS, NULL},
                {99 * MS, NULL},
                {400 * MS, NULL},
                {2 * MS, NULL},
                {600 * MS, "gap, 0.6 s after the state before"},
                {10 * MS, NULL},
                {-1500 * MS, "time, -1.5 s after the state before"},
                {499 * MS, NULL},
                {INT64_C(86400000) * MS, "gap, 86400 s after the state before"},
                {10 * MS, NULL},
                {0, "time; restart"},
                {10 * MS, NULL}};
    int64_t time = 0;
    arm.stamp = INT64_C(1700000000123456789);
    hold(pushes);
    assert_after(0, 0, pushes);
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
        time = rows[k].says ? 0 : time + rows[k].step;
        assert_after(rows[k].step, 1e-9 * (double)time, pushes);
        assert_true(!rows[k].says || restart_is_logged(rows[k].says));
    }
    assert_int_equal(
        arm_await_diagnostic(&node, "arm/totalforce: answers", "the observer restarted: time"), 1);
    assert_true(arm_await_diagnostic(&node, "arm/totalforce: answers", ", last: time") >= 0);
}

TEST(moving_joints_are_observed_as_the_library_does)
{
    const tfa_observer_options options = {.gain = GAIN, .max_gap = MAX_GAP};
    tfa_observer *observer;
    tfa_request request;
    tfa_reply reply;
    assert_int_equal(tfa_observer_create(0, JOINTS, &options, &observer), TFA_OK);
    arm.stamp += 1000 * MS;
    for (int k = 0; k < 30; k++) {
        const arm_motion m = arm_motion_of(100 + (uint64_t)k);
        const joint_state moving = state_of(&arm, m.q, m.v, m.tau);
        tfa_observer_request(observer, &request, &reply);
        request.q = m.q;
        request.v = m.v;
        assert_int_equal(tfa_compute(workspace, &request, &reply), TFA_OK);
        assert_int_equal(tfa_observer_update(observer, 5e-3 * k, m.tau, NULL, &reply),
                         k ? TFA_OBSERVER_UPDATED : TFA_OBSERVER_STARTED);
        assert_torques(&arm, &moving, 5 * MS, INFINITY, tfa_observer_torques(observer));
    }
    tfa_observer_free(observer);
}

TEST(the_wrench_at_the_tip_is_the_one_that_pushes)
{
    static const double wrench[6] = {10, -4, 25, 0.5, 2, -1}; /* axes of tool0 */
    double jacobian[6 * JOINTS], lambda_inv[36], external[JOINTS] = {0};
    const tfa_request request = {.op = TFA_OP_OPERATIONAL_INERTIA,
                                 .flags = TFA_WANT_JACOBIAN,
                                 .frame = TFA_FRAME_LOCAL,
                                 .count = 1,
                                 .tip_count = 1,
                                 .tips = {(uint32_t)tfa_model_find_frame(model, "tool0")},
                                 .q = at};
    tfa_reply reply = {.jacobian = jacobian, .lambda_inv = lambda_inv};
    assert_int_equal(tfa_compute(workspace, &request, &reply), TFA_OK);
    for (int j = 0; j < JOINTS; j++)
        for (int e = 0; e < 6; e++)
            external[j] += jacobian[e * JOINTS + j] * wrench[e];
    assert_restarted_by(1000 * MS, external);
    assert_wrench(&arm, "tool0", 0.01, wrench);
    for (int k = 0; k < 20; k++)
        assert_after(100 * MS, 0.11 + 0.1 * k, external);
    assert_wrench(&arm, "tool0", INFINITY, wrench);
    assert_after(501 * MS, 0, external);
    assert_wrench(&arm, "tool0", 0, wrench);
}

TEST(a_state_without_an_answer_restarts)
{
    static const double fast[JOINTS] = {1e200, 1e200, 1e200, 1e200};
    const joint_state invalid = state_of(&arm, at, fast, holds);
    assert_restarted_by(1000 * MS, pushes);
    assert_torques(&arm, &invalid, MS, 0, pushes);
    assert_wrench(&arm, "tool0", 0, pushes);
    assert_restarted_by(MS, pushes);
    assert_true(restart_is_logged("invalid, 0.001 s"));
}

/* A sample has a new number of every joint; one that is not finite is none. */
TEST(joints_without_a_number_wait)
{
    double effort[JOINTS];
    assert_restarted_by(1000 * MS, pushes);
    for (int j = 0; j < JOINTS; j++) {
        memcpy(effort, holds, sizeof effort);
        effort[j] = j % 2 ? NAN : INFINITY;
        publish(&arm, state_of(&arm, at, rest, effort), MS);
        assert_after(9 * MS, 0.01 * (j + 2), pushes);
    }
}

TEST(publishers_with_some_joints_each_complete_a_sample)
{
    const robot hand = {.frame = "base", .joint = arm_joints + 4, .joints = JOINTS - 4},
                upper = {.frame = "base", .joint = arm_joints, .joints = 4};
    assert_restarted_by(1000 * MS, pushes);
    const joint_state last = state_of(&hand, at + 4, rest + 4, holds + 4);
    for (int k = 1; k < 4; k++) {
        publish(&arm, state_of(&upper, at, rest, holds), 0);
        assert_torques(&arm, &last, 10 * MS, 0.01 * (k + 1), pushes);
    }
}

/* @return whether the torques follow the push by the time of receipt: all by one share */
static bool follow_receipt(void)
{
    publish(&arm, state_of(&arm, at, rest, holds), 0);
    const double *r = take_torques(&arm), share = r[0] / pushes[0];
    assert_share(r, share, pushes, JOINTS);
    return share > 0 && share < 1;
}

TEST(states_without_a_stamp_have_the_time_of_receipt)
{
    const int64_t stamp = arm.stamp;
    hold(pushes);
    arm.stamp = 0;
    assert_true(WAIT_FOR(follow_receipt()));
    arm.stamp = stamp;
}

/* Efforts come later than positions: told once, and then it runs. */
TEST(states_without_efforts_are_told_once)
{
    static const char missing[] = "joint 'joint_1': no effort was received";
    joint_state silent = state_of(&bare, at, rest, holds), sample = silent;
    char says[128];
    silent.effort._length = 0;
    snprintf(says, sizeof says, "robot 'bare': the observer does not run: %s", missing);
    assert_true(WAIT_FOR((publish(&bare, silent, MS), harness_log_lines(&running, says) > 0)));
    for (int k = 0; k < 3; k++) /* a second each */
        assert_true(WAIT_FOR((publish(&bare, silent, MS),
                              arm_find_diagnostic(&node, "/bare/joint_states", missing) == 2)));
    assert_false(ros2_peer_take(bare.torques, &(joint_state){0}, 0));
    assert_true(WAIT_FOR(is_settled(&bare, &sample)));
    assert_true(
        harness_logged(&running, "robot 'bare': the observer restarted: first sample; restart 1"));
    assert_int_equal(harness_log_lines(&running, says), 1);
}

TEST(motors_report_torques)
{
    double external[JOINTS];
    const joint_state pushed = state_of(&unitree, at, rest, pushes);
    find_gravity(workspace, at, NULL, external);
    for (int j = 0; j < JOINTS; j++)
        external[j] -= pushes[j];
    assert_true(WAIT_FOR(is_settled(&unitree, &pushed)));
    assert_torques(&unitree, &pushed, 10000 * MS, 0, external);
    assert_torques(&unitree, &pushed, 100 * MS, 0.1, external);
}

/* At rest and without a foot on the ground something holds its weight. */
TEST(a_floating_base_has_a_wrench)
{
    static const double q[LEGS] = {0.1, 0.8, -1.5, -0.1, 0.8, -1.5,
                                   0.1, 0.8, -1.5, -0.1, 0.8, -1.5},
                        pose[7] = {0, 0, 0, 0.6, 0, 0, 0.8};
    const tfa_model_options floating = {.base = TFA_BASE_FLOATING};
    SCOPED_MODEL *legs = bundled_model("quadruped.urdf", &floating);
    SCOPED_WORKSPACE *space = workspace_for(legs, NULL);
    const nav_msgs_msg_dds__Odometry_ odometry = {.header = {{1, 1}, "odom"},
                                                  .child_frame_id = "",
                                                  .pose.pose.orientation = {0.6, 0, 0, 0.8}};
    const dds_entity_t writer =
        open_writer(&nav_msgs_msg_dds__Odometry__desc, PEER_DEFAULT, "rt/dog/odom");
    double gravity[6 + LEGS], tau[LEGS], external[LEGS];
    char *names[LEGS];
    find_gravity(space, q, pose, gravity);
    for (uint32_t j = 0; j < LEGS; j++) {
        names[j] = (char *)(uintptr_t)tfa_model_joint(legs, j).name;
        external[j] = 0.5 * j - 2;
        tau[j] = gravity[6 + j] - external[j];
    }
    dog.joint = names;
    const joint_state held = state_of(&dog, q, rest, tau);
    assert_true(WAIT_FOR(
        (assert_int_equal(dds_write(writer, &odometry), DDS_RETCODE_OK), is_settled(&dog, &held))));
    assert_torques(&dog, &held, 10000 * MS, 0, external);
    assert_torques(&dog, &held, 100 * MS, 0.1, external);
    assert_wrench(&dog, tfa_model_frame(legs, 0).name, 0.1, gravity);
}

/* A reload that exchanges no model does not: the last test of the arm, whose model is another
 * then. */
TEST(another_model_restarts)
{
    SCOPED_TEXT *heavy = arm_urdf(true);
    const std_msgs_msg_dds__String_ description = {heavy};
    const dds_entity_t writer = open_writer(&std_msgs_msg_dds__String__desc, PEER_TRANSIENT_LOCAL,
                                            "rt/arm/robot_description");
    assert_restarted_by(1000 * MS, pushes);
    harness_reload(&running, NULL, NULL);
    assert_true(harness_logged(&running, "reload: done, 0 of 4"));
    assert_after(10 * MS, 0.02, pushes);
    tfa_workspace_free(workspace);
    tfa_model_free(model);
    model = arm_model(heavy);
    workspace = workspace_for(model, NULL);
    assert_int_equal(dds_write(writer, &description), DDS_RETCODE_OK);
    assert_true(harness_logged(&running, "reload: done, 1 of 4"));
    assert_restarted_by(10 * MS, pushes);
    assert_true(restart_is_logged("reload, 0.01 s after the state before"));
}

/* ---- the daemon ---- */

#define ROBOT(name, urdf, more)                                                                    \
    "  - name: " name "\n    urdf: @/config/robots/" urdf "\n    ros2:\n      enabled: yes\n"      \
    "      namespace: /" name "\n      state_age_ms: 3600000\n      observer: {gain: 20" more "\n"

static const char robots[] = ROBOT(
    "arm", "arm7.urdf", ", max_gap: 0.5, tip: tool0}\n      robot_description: robot_description")
    ROBOT("bare", "arm7.urdf", "}")
        ROBOT("dog", "quadruped.urdf", "}\n      odometry: odom\n    base: floating")
            ROBOT("unitree", "arm7.urdf",
                  "}\n      unitree: {type: hg, motors: [joint_1, joint_2, joint_3, "
                  "joint_4, joint_5, joint_6, joint_7]}");

static void open_robot(robot *r, const char *wrench)
{
    const dds_topic_descriptor_t *state = &sensor_msgs_msg_dds__JointState__desc;
    if (r->frame)
        r->states = open_writer(state, PEER_DEFAULT, "rt/%s/joint_states", r->name);
    else
        r->states = open_writer(&unitree_hg_msg_dds__LowState__desc, PEER_DEFAULT, "rt/lowstate");
    r->torques = open_reader(state, "rt/%s/totalforce/external_torques", r->name);
    if (wrench)
        r->wrench = open_reader(&geometry_msgs_msg_dds__WrenchStamped__desc, "rt/%s/totalforce/%s",
                                r->name, wrench);
}

static int serve(void **state)
{
    (void)state;
    load_robot("arm7.urdf", NULL);
    running = harness_serve(robots, arm_settings(""));
    arm_node_watch(&node);
    open_robot(&arm, "external_wrench");
    open_robot(&bare, NULL);
    open_robot(&unitree, NULL);
    open_robot(&dog, "external_base_wrench");
    const joint_state first = state_of(&arm, at, rest, pushes);
    assert_true(WAIT_FOR(is_settled(&arm, &first)));
    assert_true(restart_is_logged("first sample; restart"));
    return 0;
}

int main(void)
{
    return test_run(serve, stop);
}
