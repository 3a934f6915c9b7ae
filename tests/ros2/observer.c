/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * External torques on topics of ROS 2. By the stamps, which the test chooses, they follow what was
 * added to the efforts that hold a robot; what starts the observer anew gives 0 and is told.
 */
#include "dds/dds_test.h"

#include "dds/ros2/unitree_crc.h"
#include "models.h"
#include "ros2_arm.h"

#include <idl/unitree.h>
#include <math.h>
#include <string.h>
#include <totalforce/observer.h>

#define GAIN 20.0
#define MAX_GAP 0.5
#define MS INT64_C(1000000)
#define LEGS 12

static harness running;
static arm_node node; /* its participant and diagnostics */
static tfa_model *model;
static tfa_workspace *workspace;
static dds_entity_t description;

typedef struct robot {
    const char *name;
    char **joint;
    uint32_t joints;
    int64_t stamp; /* ns, of the last state */
    dds_entity_t states, torques, wrench;
} robot;

static robot arm = {.name = "arm", .joint = arm_joints, .joints = JOINTS},
             bare = {.name = "bare", .joint = arm_joints, .joints = JOINTS};

/* ---- samples ---- */

typedef sensor_msgs_msg_dds__JointState_ joint_state;

static void publish(robot *r, joint_state sample, int64_t stamp)
{
    r->stamp = stamp;
    sample.header.stamp.sec = (int32_t)(stamp / 1000000000);
    sample.header.stamp.nanosec = (uint32_t)(stamp % 1000000000);
    sample.header.frame_id = (char *)(uintptr_t) "base";
    assert_int_equal(dds_write(r->states, &sample), DDS_RETCODE_OK);
}

static joint_state state_of(const robot *r, const double *q, const double *v, const double *tau)
{
    return (joint_state){.name = PEER_SEQUENCE(r->joints, r->joint),
                         .position = PEER_SEQUENCE(r->joints, (double *)(uintptr_t)q),
                         .velocity = PEER_SEQUENCE(r->joints, (double *)(uintptr_t)v),
                         .effort = PEER_SEQUENCE(r->joints, (double *)(uintptr_t)tau)};
}

static bool is_of(const std_msgs_msg_dds__Header_ *h, int64_t stamp)
{
    return h->stamp.sec == stamp / 1000000000 && h->stamp.nanosec == stamp % 1000000000;
}

/* The next torques: those of the last state. */
static const double *take_torques(const robot *r)
{
    static joint_state got;
    assert_true(ros2_peer_take(r->torques, &got, WAIT_MS));
    assert_true(is_of(&got.header, r->stamp));
    assert_string_equal(got.header.frame_id, "base");
    assert_int_equal(got.position._length + got.velocity._length, 0);
    assert_int_equal(got.name._length, r->joints);
    assert_int_equal(got.effort._length, r->joints);
    for (uint32_t j = 0; j < r->joints; j++)
        assert_string_equal(got.name._buffer[j], r->joint[j]);
    return got.effort._buffer;
}

static const double *take_wrench(const robot *r, const char *frame)
{
    static geometry_msgs_msg_dds__WrenchStamped_ got;
    static double wrench[6];
    do
        assert_true(ros2_peer_take(r->wrench, &got, WAIT_MS));
    while (!is_of(&got.header, r->stamp));
    assert_string_equal(got.header.frame_id, frame);
    memcpy(wrench, &got.wrench, sizeof wrench);
    return wrench;
}

static void assert_share(const double *got, double share, const double *of, uint32_t count)
{
    for (uint32_t k = 0; k < count; k++)
        if (!(fabs(got[k] - share * of[k]) < 1e-9))
            fail_msg("number %u: %.17g, expected %.17g", k, got[k], share * of[k]);
}

/* ---- the arm at rest, and torques that push it ---- */

static const double at[JOINTS] = {0.3, 0.7, -0.4, 1.1, 0.5, -0.8, 0.2}, rest[JOINTS] = {0},
                    pushes[JOINTS] = {3, -5, 0.5, 7, -0.25, 0, 1.5};
static double holds[JOINTS]; /* against the pushes, too */

static void hold(const double *external)
{
    double gravity[JOINTS];
    const tfa_request request = {.op = TFA_OP_BIAS, .count = 1, .q = at};
    tfa_reply reply = {.gravity_force = gravity};
    assert_int_equal(tfa_compute(workspace, &request, &reply), TFA_OK);
    for (int j = 0; j < JOINTS; j++)
        holds[j] = gravity[j] - external[j];
}

static const double *torques_after(int64_t step)
{
    publish(&arm, state_of(&arm, at, rest, holds), arm.stamp + step);
    return take_torques(&arm);
}

/* Torques are 0, then follow the push. */
static void assert_restarted_by(int64_t step, const double *external)
{
    hold(external);
    assert_share(torques_after(step), 0, external, JOINTS);
    assert_share(torques_after(10 * MS), 1 - exp(-GAIN * 0.01), external, JOINTS);
}

static bool restart_is_logged(const char *text)
{
    char line[160];
    snprintf(line, sizeof line, "robot 'arm': the observer restarted: %s", text);
    return harness_logged(&running, line);
}

/* ---- tests ---- */

/* Stamps of an epoch far from the first one: no digit of a step is lost. */
TEST(torques_follow_a_constant_push_by_the_stamps)
{
    static const int64_t steps[] = {MS,     MS / 4,  4 * MS, MS + 1,   30 * MS, 1,
                                    7 * MS, 99 * MS, MS,     400 * MS, 2 * MS};
    int64_t time = 0;
    arm.stamp = INT64_C(1700000000123456789);
    hold(pushes);
    assert_share(torques_after(0), 0, pushes, JOINTS);
    for (size_t k = 0; k < sizeof steps / sizeof *steps; k++) {
        time += steps[k];
        assert_share(torques_after(steps[k]), 1 - exp(-GAIN * 1e-9 * (double)time), pushes, JOINTS);
    }
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
        publish(&arm, state_of(&arm, m.q, m.v, m.tau), arm.stamp + 5 * MS);
        tfa_observer_request(observer, &request, &reply);
        request.q = m.q;
        request.v = m.v;
        assert_int_equal(tfa_compute(workspace, &request, &reply), TFA_OK);
        assert_int_equal(tfa_observer_update(observer, 5e-3 * k, m.tau, NULL, &reply),
                         k ? TFA_OBSERVER_UPDATED : TFA_OBSERVER_STARTED);
        assert_share(take_torques(&arm), 1, tfa_observer_torques(observer), JOINTS);
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
    assert_share(take_wrench(&arm, "tool0"), 1 - exp(-GAIN * 0.01), wrench, 6);
    for (int k = 0; k < 20; k++)
        assert_share(torques_after(100 * MS), 1 - exp(-GAIN * (0.11 + 0.1 * k)), external, JOINTS);
    assert_share(take_wrench(&arm, "tool0"), 1, wrench, 6);
    assert_share(torques_after(501 * MS), 0, external, JOINTS);
    assert_share(take_wrench(&arm, "tool0"), 0, wrench, 6);
}

/* Each is logged before the next: a line tells the last one. */
TEST(gaps_and_jumps_back_restart)
{
    static const struct {
        int64_t step;
        const char *says;
    } rows[] = {{600 * MS, "gap, 0.6 s after the state before"},
                {-1500 * MS, "time, -1.5 s after the state before"},
                {INT64_C(86400000) * MS, "gap, 86400 s after the state before"},
                {0, "time; restart"}};
    assert_restarted_by(1000 * MS, pushes);
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
        assert_restarted_by(rows[k].step, pushes);
        assert_true(restart_is_logged(rows[k].says));
    }
    assert_int_equal(
        arm_await_diagnostic(&node, "arm/totalforce: answers", "the observer restarted: time"), 1);
    assert_true(arm_await_diagnostic(&node, "arm/totalforce: answers", ", last: time") >= 0);
}

TEST(the_largest_gap_is_none)
{
    assert_restarted_by(1000 * MS, pushes);
    assert_share(torques_after(499 * MS), 1 - exp(-GAIN * 0.509), pushes, JOINTS);
}

TEST(a_state_without_an_answer_restarts)
{
    double fast[JOINTS] = {1e200, 1e200, 1e200, 1e200};
    assert_restarted_by(1000 * MS, pushes);
    publish(&arm, state_of(&arm, at, fast, holds), arm.stamp + MS);
    assert_share(take_torques(&arm), 0, pushes, JOINTS);
    assert_share(take_wrench(&arm, "tool0"), 0, pushes, 6);
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
        publish(&arm, state_of(&arm, at, rest, effort), arm.stamp + MS);
        assert_share(torques_after(9 * MS), 1 - exp(-GAIN * 0.01 * (j + 2)), pushes, JOINTS);
    }
}

TEST(publishers_with_some_joints_each_complete_a_sample)
{
    joint_state some = state_of(&arm, at, rest, holds);
    assert_restarted_by(1000 * MS, pushes);
    for (int k = 1; k < 4; k++) {
        some.name._length = some.position._length = some.velocity._length = some.effort._length = 4;
        publish(&arm, some, arm.stamp);
        joint_state others = state_of(&arm, at, rest, holds);
        others.name._buffer += 4;
        others.position._buffer += 4;
        others.velocity._buffer += 4;
        others.effort._buffer += 4;
        others.name._length = others.position._length = others.velocity._length =
            others.effort._length = JOINTS - 4;
        publish(&arm, others, arm.stamp + 10 * MS);
        assert_share(take_torques(&arm), 1 - exp(-GAIN * 0.01 * (k + 1)), pushes, JOINTS);
    }
}

/* @return whether the torques follow the push by the time of receipt: all by one share */
static bool follow_receipt(void)
{
    const double *r = torques_after(0), share = r[0] / pushes[0];
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

static bool is_settled(robot *r, const joint_state *state)
{
    static joint_state got;
    publish(r, *state, r->stamp + MS);
    while (ros2_peer_take(r->torques, &got, 200))
        if (is_of(&got.header, r->stamp))
            return true;
    return false;
}

static void open_robot(robot *r, const char *wrench)
{
    char name[3][64];
    snprintf(name[0], sizeof name[0], "rt/%s/joint_states", r->name);
    snprintf(name[1], sizeof name[1], "rt/%s/totalforce/external_torques", r->name);
    snprintf(name[2], sizeof name[2], "rt/%s/totalforce/%s", r->name, wrench);
    const dds_topic_descriptor_t *state = &sensor_msgs_msg_dds__JointState__desc,
                                 *force = &geometry_msgs_msg_dds__WrenchStamped__desc;
    r->states = ros2_peer_writer(node.participant, state, name[0], PEER_DEFAULT);
    r->torques = ros2_peer_reader(node.participant, state, name[1], PEER_DEFAULT);
    r->wrench = ros2_peer_reader(node.participant, force, name[2], PEER_DEFAULT);
    ros2_peer_await_reader(r->states);
    ros2_peer_await_writer(r->torques);
}

/* Efforts come later than positions: told once, and then it runs. */
TEST(states_without_efforts_are_told_once)
{
    static const char says[] =
        "robot 'bare': the observer does not run: joint 'joint_1': no effort was received";
    joint_state silent = state_of(&bare, at, rest, holds), sample = silent;
    static joint_state got;
    silent.effort._length = 0;
    open_robot(&bare, "external_wrench");
    assert_true(
        WAIT_FOR((publish(&bare, silent, bare.stamp + MS), harness_log_lines(&running, says) > 0)));
    for (int k = 0; k < 3; k++) /* a second each */
        assert_true(
            WAIT_FOR((publish(&bare, silent, bare.stamp + MS),
                      arm_find_diagnostic(&node, "/bare/joint_states",
                                          "joint 'joint_1': no effort was received") == 2)));
    assert_false(ros2_peer_take(bare.torques, &got, 0));
    assert_true(WAIT_FOR(is_settled(&bare, &sample)));
    assert_true(
        harness_logged(&running, "robot 'bare': the observer restarted: first sample; restart 1"));
    assert_int_equal(harness_log_lines(&running, says), 1);
}

/* ---- motors of Unitree ---- */

static robot unitree = {.name = "unitree", .joint = arm_joints, .joints = JOINTS};

/* As single precision has them: q, and the torques that the motors report */
static void publish_motors(int64_t stamp, double *q, double *tau)
{
    unitree_hg_msg_dds__LowState_ s = {.tick = (uint32_t)(stamp / MS)};
    for (int j = 0; j < JOINTS; j++) {
        q[j] = (double)(s.motor_state[j].q = (float)at[j]);
        tau[j] = (double)(s.motor_state[j].tau_est = (float)pushes[j]);
    }
    s.crc = tfa_unitree_hg_crc(&s);
    unitree.stamp = stamp;
    assert_int_equal(dds_write(unitree.states, &s), DDS_RETCODE_OK);
}

static bool is_unitree_heard(double *q, double *tau)
{
    static joint_state got;
    publish_motors(unitree.stamp + MS, q, tau);
    while (ros2_peer_take(unitree.torques, &got, 200))
        if (is_of(&got.header, unitree.stamp))
            return strcmp(got.header.frame_id, "") == 0;
    return false;
}

TEST(motors_report_torques)
{
    double q[JOINTS], tau[JOINTS], external[JOINTS];
    static joint_state got;
    const tfa_request request = {.op = TFA_OP_BIAS, .count = 1, .q = q};
    tfa_reply reply = {.gravity_force = external};
    unitree.states = ros2_peer_writer(node.participant, &unitree_hg_msg_dds__LowState__desc,
                                      "rt/lowstate", PEER_DEFAULT);
    unitree.torques = ros2_peer_reader(node.participant, &sensor_msgs_msg_dds__JointState__desc,
                                       "rt/unitree/totalforce/external_torques", PEER_DEFAULT);
    assert_true(WAIT_FOR(is_unitree_heard(q, tau)));
    assert_int_equal(tfa_compute(workspace, &request, &reply), TFA_OK);
    for (int j = 0; j < JOINTS; j++)
        external[j] -= tau[j];
    for (int k = 0; k < 2; k++) {
        publish_motors(unitree.stamp + (k ? 100 : 10000) * MS, q, tau);
        assert_true(ros2_peer_take(unitree.torques, &got, WAIT_MS));
        assert_true(is_of(&got.header, unitree.stamp));
        assert_share(got.effort._buffer, k ? 1 - exp(-GAIN * 0.1) : 0, external, JOINTS);
    }
}

/* ---- a floating base ---- */

static robot dog = {.name = "dog", .joints = LEGS};

static bool dog_has_base(const dds_entity_t odometry, const joint_state *state)
{
    nav_msgs_msg_dds__Odometry_ sample = {.header = {{1, 1}, (char *)(uintptr_t) "odom"},
                                          .child_frame_id = (char *)(uintptr_t) ""};
    sample.pose.pose.orientation.x = 0.6;
    sample.pose.pose.orientation.w = 0.8;
    assert_int_equal(dds_write(odometry, &sample), DDS_RETCODE_OK);
    return is_settled(&dog, state);
}

/* At rest and without a foot on the ground something holds its weight. */
TEST(a_floating_base_has_a_wrench)
{
    static const double q[LEGS] = {0.1, 0.8, -1.5, -0.1, 0.8, -1.5,
                                   0.1, 0.8, -1.5, -0.1, 0.8, -1.5},
                        zero[LEGS] = {0}, pose[7] = {0, 0, 0, 0.6, 0, 0, 0.8};
    const tfa_model_options floating = {.base = TFA_BASE_FLOATING};
    SCOPED_MODEL *legs = bundled_model("quadruped.urdf", &floating);
    SCOPED_WORKSPACE *space = workspace_for(legs, NULL);
    const tfa_request request = {.op = TFA_OP_BIAS, .count = 1, .q = q, .base_pose = pose};
    double gravity[6 + LEGS], tau[LEGS], external[LEGS];
    tfa_reply reply = {.gravity_force = gravity};
    char *names[LEGS];
    assert_int_equal(tfa_compute(space, &request, &reply), TFA_OK);
    for (uint32_t j = 0; j < LEGS; j++) {
        names[j] = (char *)(uintptr_t)tfa_model_joint(legs, j).name;
        external[j] = 0.5 * j - 2;
        tau[j] = gravity[6 + j] - external[j];
    }
    dog.joint = names;
    const joint_state held = state_of(&dog, q, zero, tau);
    open_robot(&dog, "external_base_wrench");
    const dds_entity_t odometry = ros2_peer_writer(
        node.participant, &nav_msgs_msg_dds__Odometry__desc, "rt/dog/odom", PEER_DEFAULT);
    ros2_peer_await_reader(odometry);
    ros2_peer_await_writer(dog.wrench);
    assert_true(WAIT_FOR(dog_has_base(odometry, &held)));
    publish(&dog, held, dog.stamp + 10000 * MS);
    assert_share(take_torques(&dog), 0, external, LEGS);
    publish(&dog, held, dog.stamp + 100 * MS);
    assert_share(take_torques(&dog), 1 - exp(-GAIN * 0.1), external, LEGS);
    assert_share(take_wrench(&dog, tfa_model_frame(legs, 0).name), 1 - exp(-GAIN * 0.1), gravity,
                 6);
}

/* ---- reloads ---- */

static void publish_description(const char *urdf)
{
    const std_msgs_msg_dds__String_ sample = {(char *)(uintptr_t)urdf};
    assert_int_equal(dds_write(description, &sample), DDS_RETCODE_OK);
}

/* One that exchanges no model does not: the last test of the arm, whose model is another then. */
TEST(another_model_restarts)
{
    SCOPED_TEXT *heavy = arm_urdf(true);
    assert_restarted_by(1000 * MS, pushes);
    harness_reload(&running, NULL, NULL);
    assert_true(harness_logged(&running, "reload: done, 0 of 4"));
    assert_share(torques_after(10 * MS), 1 - exp(-GAIN * 0.02), pushes, JOINTS);
    tfa_workspace_free(workspace);
    tfa_model_free(model);
    model = arm_model(heavy);
    workspace = workspace_for(model, NULL);
    publish_description(heavy);
    assert_true(harness_logged(&running, "reload: done, 1 of 4"));
    assert_restarted_by(10 * MS, pushes);
    assert_true(restart_is_logged("reload, 0.01 s after the state before"));
}

/* ---- the daemon ---- */

#define ROBOT(name, urdf, more)                                                                    \
    "  - name: " name "\n    urdf: @/config/robots/" urdf "\n    ros2:\n      enabled: yes\n"      \
    "      namespace: /" name "\n      state_age_ms: 3600000\n" more

static int serve(void **state)
{
    (void)state;
    model = bundled_model("arm7.urdf", NULL);
    workspace = workspace_for(model, NULL);
    running = harness_serve(
        ROBOT("arm", "arm7.urdf",
              "      observer: {gain: 20, max_gap: 0.5, tip: tool0}\n"
              "      robot_description: robot_description\n")
            ROBOT("bare", "arm7.urdf", "      observer: {gain: 20}\n")
                ROBOT("dog", "quadruped.urdf",
                      "      observer: {gain: 20}\n      odometry: odom\n    base: floating\n")
                    ROBOT("unitree", "arm7.urdf",
                          "      observer: {gain: 20}\n      unitree: {type: hg, motors: [joint_1, "
                          "joint_2, joint_3, joint_4, joint_5, joint_6, joint_7]}\n"),
        arm_settings(""));
    node.participant = ros2_peer_open(arm_domain());
    node.diagnostics =
        ros2_peer_reader(node.participant, &diagnostic_msgs_msg_dds__DiagnosticArray__desc,
                         "rt/diagnostics", PEER_ALL);
    ros2_peer_await_writer(node.diagnostics);
    open_robot(&arm, "external_wrench");
    ros2_peer_await_writer(arm.wrench);
    description = ros2_peer_writer(node.participant, &std_msgs_msg_dds__String__desc,
                                   "rt/arm/robot_description", PEER_TRANSIENT_LOCAL);
    ros2_peer_await_reader(description);
    const joint_state first = state_of(&arm, at, rest, pushes);
    assert_true(WAIT_FOR(is_settled(&arm, &first)));
    assert_true(restart_is_logged("first sample; restart"));
    return 0;
}

static int stop(void **state)
{
    (void)state;
    arm_node_close(&node);
    harness_remove(&running);
    tfa_workspace_free(workspace);
    tfa_model_free(model);
    return 0;
}

int main(void)
{
    return test_run(serve, stop);
}
