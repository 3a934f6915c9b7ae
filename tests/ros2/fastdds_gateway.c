/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A node of Fast DDS, which is what rmw_fastrtps is made of, and the real daemon: states, efforts
 * and a description one way, answers and diagnostics the other, to the bit.
 */
#include "fastdds_node.h"

#include "dds/dds_test.h"
#include "harness.h"
#include "models.h"
#include "ros2_arm.h"
#include "test.h"

#include <signal.h>
#include <string.h>

static harness running;
static fastdds_node *node;
static tfa_model *model;
static tfa_workspace *workspace;
static fastdds_writer *states, *efforts, *commands, *trajectories, *descriptions, *late_description;
static fastdds_reader *accelerations, *diagnostics, *lambda_inv, *jacobian, *bias, *gravity;

/* ---- commands ---- */

typedef enum command { EFFORT_COMMANDS, JOINT_EFFORTS, TRAJECTORY, COMMANDS } command;

static void publish_state(const arm_motion *m, int32_t sec)
{
    const sensor_msgs_msg_dds__JointState_ state = arm_state(m, sec);
    fastdds_publish(node, states, &state);
}

static void publish_command(const arm_motion *m, int32_t sec, command kind)
{
    double *tau = (double *)(uintptr_t)m->tau;
    trajectory_msgs_msg_dds__JointTrajectoryPoint_ point = {.effort = PEER_SEQUENCE(JOINTS, tau)};
    const std_msgs_msg_dds__Float64MultiArray_ array = {.data = PEER_SEQUENCE(JOINTS, tau)};
    const sensor_msgs_msg_dds__JointState_ named = arm_efforts(arm_joints, tau, JOINTS, -sec);
    const trajectory_msgs_msg_dds__JointTrajectory_ trajectory = {
        .header = {{-sec, 11}, "plan"},
        .joint_names = PEER_SEQUENCE(JOINTS, arm_joints),
        .points = PEER_SEQUENCE(1, &point)};
    if (kind == EFFORT_COMMANDS)
        fastdds_publish(node, commands, &array);
    else if (kind == JOINT_EFFORTS)
        fastdds_publish(node, efforts, &named);
    else
        fastdds_publish(node, trajectories, &trajectory);
}

/* Stamp and frame of the command, or of the state where the command has none. */
static void assert_header(const std_msgs_msg_dds__Header_ *h, int32_t sec, command kind)
{
    static const char *const frames[COMMANDS] = {"base", "command", "plan"};
    assert_int_equal(h->stamp.sec, kind == EFFORT_COMMANDS ? sec : -sec);
    assert_int_equal(h->stamp.nanosec, 7 + 2 * kind);
    assert_string_equal(h->frame_id, frames[kind]);
}

/* Publishes. @return whether the answer comes soon; an earlier one may still be under way */
static bool is_answered(const arm_motion *m, int32_t sec, command kind, const double qdd[JOINTS])
{
    trajectory_msgs_msg_dds__JointTrajectory_ got;
    bool found;
    publish_state(m, sec);
    publish_command(m, sec, kind);
    if (!fastdds_receive(node, accelerations, &got, 200))
        return false;
    found = arm_is_answer(&got, m, qdd);
    if (found)
        assert_header(&got.header, sec, kind);
    dds_sample_free(&got, &trajectory_msgs_msg_dds__JointTrajectory__desc, DDS_FREE_CONTENTS);
    return found;
}

/* Publishes until the answer of the library comes: what is sent before a match is lost. */
static void assert_answer(const arm_motion *m, int32_t sec, command kind)
{
    double qdd[JOINTS];
    arm_expect(workspace, m, qdd);
    assert_true(WAIT_FOR(is_answered(m, sec, kind, qdd)));
}

TEST(commands_are_answered_to_the_bit)
{
    for (int32_t k = 1; k <= 60; k++) {
        const arm_motion m = arm_motion_of((uint64_t)k);
        assert_answer(&m, k, (command)(k % COMMANDS));
    }
}

/* ---- states ---- */

static bool receive_array(fastdds_reader *r, const double *expected, uint32_t count, int32_t sec)
{
    const dds_topic_descriptor_t *type = &std_msgs_msg_dds__Float64MultiArray__desc;
    std_msgs_msg_dds__Float64MultiArray_ got;
    char label[64];
    if (!fastdds_receive(node, r, &got, 200))
        return false;
    snprintf(label, sizeof label, "stamp %d.000000007 frame base", (int)sec);
    assert_int_equal(got.data._length, count);
    const bool found = memcmp(got.data._buffer, expected, count * sizeof *expected) == 0;
    if (found)
        assert_string_equal(got.layout.dim._buffer[0].label, label);
    dds_sample_free(&got, type, DDS_FREE_CONTENTS);
    return found;
}

static bool receive_gravity(const double *expected, int32_t sec)
{
    sensor_msgs_msg_dds__JointState_ got;
    if (!fastdds_receive(node, gravity, &got, 200))
        return false;
    assert_int_equal(got.effort._length, JOINTS);
    const bool found = memcmp(got.effort._buffer, expected, JOINTS * sizeof *expected) == 0;
    if (found)
        assert_true(got.header.stamp.sec == sec && got.header.stamp.nanosec == 7);
    dds_sample_free(&got, &sensor_msgs_msg_dds__JointState__desc, DDS_FREE_CONTENTS);
    return found;
}

static arm_operational expected;

/* Publishes the state. @return a bit for each of those `left` whose answer has not come */
static unsigned receive_states(const arm_motion *m, unsigned left)
{
    publish_state(m, 500);
    left &= ~(left & 1 && receive_array(lambda_inv, expected.lambda_inv, 12 * 12, 500) ? 1u : 0u);
    left &= ~(left & 2 && receive_array(jacobian, expected.jacobian, 12 * JOINTS, 500) ? 2u : 0u);
    left &= ~(left & 4 && receive_array(bias, expected.bias, 12, 500) ? 4u : 0u);
    return left & ~(left & 8 && receive_gravity(expected.gravity, 500) ? 8u : 0u);
}

TEST(states_are_answered_to_the_bit)
{
    const arm_motion m = arm_motion_of(500);
    unsigned left = 1 | 2 | 4 | 8;
    arm_expect_operational(workspace, model, &m, &expected);
    assert_true(WAIT_FOR((left = receive_states(&m, left)) == 0));
}

/* ---- the graph ---- */

#define TYPE(package, name) package "::msg::dds_::" name "_"
#define JOINT_STATE TYPE("sensor_msgs", "JointState")
#define ARRAY TYPE("std_msgs", "Float64MultiArray")
#define JOINT_TRAJECTORY TYPE("trajectory_msgs", "JointTrajectory")

/* Endpoints of the arm's node in the order of its list: its own words, not the daemon's tables. */
static const struct {
    const char *topic, *type, *hash;
    bool is_writer, reliable, transient_local;
} endpoints[] = {
#define HASH_JOINT_STATE "a13ee3a330e346c9d87b5aa18d24e11690752bd33a0350f11c5882bc9179260e"
#define HASH_ARRAY "1025ddc6b9552d191f89ef1a8d2f60f3d373e28b283d8891ddcc974e8c55397f"
#define HASH_TRAJECTORY "179b33eba59d676f6d967ac71fe35e7ca2f64b2f3928f4a018cec115e213796e"
    {"rt/arm/robot_description", TYPE("std_msgs", "String"),
     "df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18", false, true, true},
    {"rt/arm/joint_states", JOINT_STATE, HASH_JOINT_STATE, false, false, false},
    {"rt/arm/effort_controller/commands", ARRAY, HASH_ARRAY, false, false, false},
    {"rt/arm/joint_efforts", JOINT_STATE, HASH_JOINT_STATE, false, false, false},
    {"rt/arm/trajectory", JOINT_TRAJECTORY, HASH_TRAJECTORY, false, false, false},
    {"rt/arm/totalforce/accelerations", JOINT_TRAJECTORY, HASH_TRAJECTORY, true, true, false},
    {"rt/arm/totalforce/gravity_torques", JOINT_STATE, HASH_JOINT_STATE, true, true, false},
    {"rt/arm/totalforce/lambda_inv", ARRAY, HASH_ARRAY, true, true, false},
    {"rt/arm/totalforce/jacobian", ARRAY, HASH_ARRAY, true, true, false},
    {"rt/arm/totalforce/bias_acceleration", ARRAY, HASH_ARRAY, true, true, false},
    {"rt/diagnostics", TYPE("diagnostic_msgs", "DiagnosticArray"),
     "5a8a36efb05fb25070fa0fb3810290c0e6cd4862b54a8fb975a1ee8dc55a333e", true, true, false},
};

static bool is_listed(const fastdds_gids *gids, const uint8_t gid[16])
{
    for (uint32_t k = 0; k < gids->count; k++)
        if (memcmp(gids->gid[k], gid, sizeof gids->gid[k]) == 0)
            return true;
    return false;
}

/* On the wire as `ros2 topic info -v` shows it, and listed by this identity. */
static void assert_endpoint(size_t i, const fastdds_listed *listed)
{
    fastdds_endpoint e;
    char user_data[128];
    if (!fastdds_await_endpoint(fastdds_node_peer(node), endpoints[i].topic, endpoints[i].is_writer,
                                &e, WAIT_MS))
        fail_msg("%s is not there", endpoints[i].topic);
    snprintf(user_data, sizeof user_data, "typehash=RIHS01_%s;", endpoints[i].hash);
    assert_string_equal(e.type, endpoints[i].type);
    assert_string_equal(e.user_data, user_data);
    assert_int_equal(e.reliable, endpoints[i].reliable);
    assert_int_equal(e.transient_local, endpoints[i].transient_local);
    assert_memory_equal(e.gid, listed->participant, 12); /* its prefix */
    if (!is_listed(endpoints[i].is_writer ? &listed->writers : &listed->readers, e.gid))
        fail_msg("%s is not listed by the node", endpoints[i].topic);
}

TEST(the_daemon_is_a_node)
{
    fastdds_listed listed;
    fastdds_endpoint graph;
    char user_data[128];
    assert_true(fastdds_await_node(node, "/arm", "totalforce", &listed, WAIT_MS));
    assert_int_equal(listed.readers.count, 5); /* states, three kinds of commands, description */
    assert_int_equal(listed.writers.count, 6); /* five answers, diagnostics */
    for (size_t i = 0; i < sizeof endpoints / sizeof *endpoints; i++)
        assert_endpoint(i, &listed);
    assert_true(
        fastdds_participant_user_data(fastdds_node_peer(node), listed.participant, user_data));
    assert_string_equal(user_data, "enclave=/;");
    assert_true(fastdds_await_endpoint(fastdds_node_peer(node), "ros_discovery_info", true, &graph,
                                       WAIT_MS));
    assert_memory_equal(graph.user_data, "typehash=RIHS01_", 16);
    assert_true(graph.reliable && graph.transient_local);
    assert_false(is_listed(&listed.writers, graph.gid)); /* of rmw, of no node */
    /* its own: a while, for nothing tells that none will come; a slow machine passes */
    assert_false(fastdds_await_node(node, "/arm", "controller", NULL, 200));
}

/* ---- descriptions ---- */

/* Publishes the URDF. @param hash  receives its model's */
static void publish_description(fastdds_writer *writer, const char *name, char hash[17])
{
    SCOPED_MODEL *described = bundled_model(name, NULL);
    SCOPED_TEXT *text = bundled_text(name);
    snprintf(hash, 17, "%s", tfa_model_hash_text(described));
    const std_msgs_msg_dds__String_ description = {text};
    fastdds_publish(node, writer, &description);
}

static bool comes_diagnostic(const char *what, const char *value)
{
    diagnostic_msgs_msg_dds__DiagnosticArray_ got;
    if (!fastdds_receive(node, diagnostics, &got, 2000))
        return false;
    const bool found = arm_level_in(&got, what, value) >= 0;
    dds_sample_free(&got, &diagnostic_msgs_msg_dds__DiagnosticArray__desc, DDS_FREE_CONTENTS);
    return found;
}

static bool await_diagnostic(const char *what, const char *value)
{
    return WAIT_FOR(comes_diagnostic(what, value));
}

static char late_hash[17]; /* of the model that was described before the daemon started */

TEST(a_daemon_that_joins_late_reads_the_description)
{
    assert_true(await_diagnostic("/late/totalforce: model", late_hash));
}

TEST(a_description_changes_the_model)
{
    char hash[17];
    publish_description(descriptions, "arm6.urdf", hash);
    assert_true(await_diagnostic("/bare/totalforce: model", hash));
}

/* ---- the end ---- */

static bool await_no_match(void)
{
    return WAIT_FOR(fastdds_reader_matches(accelerations).matched == 0);
}

/* By its good-bye: its lease is an hour. */
TEST(the_end_of_the_daemon_is_noticed)
{
    assert_int_equal(harness_stop(&running, SIGTERM), 0);
    assert_true(await_no_match());
}

/* By the lease; and another daemon is met as the first one was. One that gets no processor for its
 * lease is lost, too, and found again: the answer is awaited. */
TEST(a_daemon_that_is_killed_is_noticed)
{
    const arm_motion m = arm_motion_of(600);
    ros2_peer_set_lease("3 s");
    harness_start(&running, "arm");
    fastdds_await_match_of_reader(accelerations);
    assert_answer(&m, 600, JOINT_EFFORTS);
    (void)harness_stop(&running, SIGKILL);
    assert_true(await_no_match());
}

static void open_node(void)
{
    node = fastdds_node_open(arm_domain(), "/arm", "controller");
    ros2_peer_set_lease("3600 s");
    late_description = fastdds_publisher(node, &std_msgs_msg_dds__String__desc,
                                         "/late/robot_description", &fastdds_latched);
    publish_description(late_description, "arm6.urdf", late_hash);
}

static void open_endpoints(void)
{
    const dds_topic_descriptor_t *state = &sensor_msgs_msg_dds__JointState__desc;
    const dds_topic_descriptor_t *array = &std_msgs_msg_dds__Float64MultiArray__desc;
    states = fastdds_publisher(node, state, "/arm/joint_states", &fastdds_default);
    efforts = fastdds_publisher(node, state, "/arm/joint_efforts", &fastdds_sensor_data);
    commands = fastdds_publisher(node, array, "/arm/effort_controller/commands", &fastdds_default);
    descriptions = fastdds_publisher(node, &std_msgs_msg_dds__String__desc,
                                     "/bare/robot_description", &fastdds_latched);
    accelerations = fastdds_subscription(node, &trajectory_msgs_msg_dds__JointTrajectory__desc,
                                         "/arm/totalforce/accelerations", &fastdds_default);
    lambda_inv = fastdds_subscription(node, array, "/arm/totalforce/lambda_inv", &fastdds_default);
    jacobian = fastdds_subscription(node, array, "/arm/totalforce/jacobian", &fastdds_sensor_data);
    bias = fastdds_subscription(node, array, "/arm/totalforce/bias_acceleration", &fastdds_default);
    gravity =
        fastdds_subscription(node, state, "/arm/totalforce/gravity_torques", &fastdds_sensor_data);
    trajectories = fastdds_publisher(node, &trajectory_msgs_msg_dds__JointTrajectory__desc,
                                     "/arm/trajectory", &fastdds_default);
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
    open_node();
    running =
        harness_serve(arm_yaml("  - name: bare\n    urdf: @/config/robots/arm7.urdf\n"
                               "    ros2: {enabled: yes, namespace: /bare, robot_description: "
                               "robot_description}\n"
                               "  - name: late\n    urdf: @/config/robots/arm7.urdf\n"
                               "    ros2: {enabled: yes, namespace: /late, robot_description: "
                               "robot_description}\n"),
                      arm_settings(""));
    open_endpoints();
    return 0;
}

static int stop(void **state)
{
    (void)state;
    fastdds_node_close(node);
    if (running.pid > 0)
        harness_remove(&running);
    tfa_workspace_free(workspace);
    tfa_model_free(model);
    return 0;
}

int main(void)
{
    return test_run(serve, stop);
}
