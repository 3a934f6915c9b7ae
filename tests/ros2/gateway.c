/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The daemon on topics of ROS 2: answers are those of the library in this process, to the bit, and
 * every input that is refused is named in the diagnostics.
 */
#include "dds/dds_test.h"

#include "models.h"
#include "ros2_daemon.h"

#include <idl/ros2_typed.h>
#include <math.h>
#include <signal.h>
#include <string.h>

enum { LEVEL_OK, LEVEL_WARN, LEVEL_ERROR, LEVEL_STALE };

/* ---- answers ---- */

/* Whether this is the answer to the motion, with this stamp and frame */
static bool is_answer(const trajectory_msgs_msg_dds__JointTrajectory_ *got, const arm_motion *m,
                      int32_t sec, uint32_t nanosec, const char *frame)
{
    double qdd[JOINTS];
    arm_expect(workspace, m, qdd);
    return got->header.stamp.sec == sec && got->header.stamp.nanosec == nanosec &&
           strcmp(got->header.frame_id, frame) == 0 && arm_is_answer(got, m, qdd);
}

/* The next answer is to this motion, and echoes stamp and frame. */
static void assert_accelerations(const arm_motion *m, int32_t sec, uint32_t nanosec,
                                 const char *frame)
{
    static trajectory_msgs_msg_dds__JointTrajectory_ sample;
    assert_true(ros2_peer_take(node.accelerations, &sample, WAIT_MS));
    assert_true(is_answer(&sample, m, sec, nanosec, frame));
}

TEST(accelerations_are_those_of_the_library)
{
    for (int32_t k = 0; k < 200; k++) {
        const arm_motion m = arm_motion_of(1000 + (uint64_t)k);
        arm_publish_state(&node, &m, k);
        arm_publish_efforts(&node, m.tau, JOINTS);
        assert_accelerations(&m, k, 7, "base");
    }
}

/* Names decide, not their order; the command's stamp is echoed. */
TEST(named_efforts_in_any_order)
{
    for (int32_t k = 0; k < 50; k++) {
        const arm_motion m = arm_motion_of(2000 + (uint64_t)k);
        char *name[JOINTS];
        double tau[JOINTS];
        for (int j = 0; j < JOINTS; j++) {
            const int other = (j * 3 + (int)k) % JOINTS;
            name[j] = arm_joints[other];
            tau[j] = m.tau[other];
        }
        arm_publish_state(&node, &m, k);
        arm_publish_named_efforts(&node, name, tau, JOINTS, 100 + k);
        assert_accelerations(&m, 100 + k, 9, "command");
    }
}

/* Does an answer to the motion with this stamp come soon? What was sent before the other side has
 * matched is lost, and sent again. */
static bool comes(const arm_motion *m, int32_t sec, uint32_t nanosec, const char *frame)
{
    static trajectory_msgs_msg_dds__JointTrajectory_ got;
    while (ros2_peer_take(node.accelerations, &got, 200))
        if (is_answer(&got, m, sec, nanosec, frame))
            return true;
    return false;
}

static bool answers_both(dds_entity_t second, const sensor_msgs_msg_dds__JointState_ *few,
                         const arm_motion *other, const arm_motion *m)
{
    arm_publish_state(&node, other, 4);
    assert_int_equal(dds_write(second, few), DDS_RETCODE_OK);
    arm_publish_efforts(&node, m->tau, JOINTS);
    return comes(m, 5, 6, "few");
}

/* Several publishers with some of the joints each; others' joints are skipped. */
TEST(partial_states_are_merged)
{
    const arm_motion m = arm_motion_of(7);
    const dds_entity_t second =
        ros2_peer_writer(node.participant, &sensor_msgs_msg_dds__JointState__desc,
                         "rt/arm/joint_states", PEER_SENSOR);
    char *name[] = {"gripper", "joint_7", "joint_5"};
    double q[] = {0.5, m.q[6], m.q[4]}, v[] = {0, m.v[6], m.v[4]};
    const sensor_msgs_msg_dds__JointState_ few = {.header = {{5, 6}, "few"},
                                                  .name = PEER_SEQUENCE(3, name),
                                                  .position = PEER_SEQUENCE(3, q),
                                                  .velocity = PEER_SEQUENCE(3, v)};
    arm_motion other = m;
    other.q[6] = other.q[4] = 0.1;
    assert_true(WAIT_FOR(answers_both(second, &few, &other, &m)));
    arm_settle(&node);
    assert_true(arm_await_diagnostic(&node, "joint_states", "last: gripper") >= 0);
    assert_int_equal(dds_delete(second), DDS_RETCODE_OK);
}

static bool answers_typed(dds_entity_t writer, const typed_JointState_ *sample, const arm_motion *m)
{
    assert_int_equal(dds_write(writer, sample), DDS_RETCODE_OK);
    arm_publish_efforts(&node, m->tau, JOINTS);
    return comes(m, 21, 22, "typed");
}

/* ROS 2 announces XTypes information since Kilted (Fast DDS) and Lyrical (Cyclone), none before:
 * the type's name decides. */
TEST(publishers_with_type_information_match)
{
    const arm_motion m = arm_motion_of(13);
    dds_topic_descriptor_t type = typed_JointState__desc;
    const typed_JointState_ sample = {
        .header = {{21, 22}, "typed"},
        .name = PEER_SEQUENCE(JOINTS, arm_joints),
        .position = PEER_SEQUENCE(JOINTS, (double *)(uintptr_t)m.q),
        .velocity = PEER_SEQUENCE(JOINTS, (double *)(uintptr_t)m.v),
    };
    assert_true(type.type_information.sz > 0);
    type.m_typename = sensor_msgs_msg_dds__JointState__desc.m_typename;
    const dds_entity_t writer =
        ros2_peer_writer(node.participant, &type, "rt/arm/joint_states", PEER_DEFAULT);
    assert_true(WAIT_FOR(answers_typed(writer, &sample, &m)));
    arm_settle(&node);
    assert_int_equal(dds_delete(writer), DDS_RETCODE_OK);
}

TEST(efforts_of_a_trajectory)
{
    const arm_motion m = arm_motion_of(11);
    arm_publish_state(&node, &m, 1);
    arm_publish_trajectory(&node, m.tau, 77);
    assert_accelerations(&m, 77, 78, "plan");
}

/* ---- operational space and gravity ---- */

static void assert_array(const std_msgs_msg_dds__Float64MultiArray_ *a, const double *expected,
                         uint32_t rows, uint32_t columns, const char *stamp)
{
    assert_int_equal(a->data._length, rows * columns);
    assert_memory_equal(a->data._buffer, expected, rows * columns * sizeof *expected);
    assert_int_equal(a->layout.data_offset, 0);
    assert_string_equal(a->layout.dim._buffer[0].label, stamp);
    assert_int_equal(a->layout.dim._buffer[0].size, 1);
    assert_int_equal(a->layout.dim._buffer[0].stride, rows * columns);
    assert_non_null(strstr(a->layout.dim._buffer[1].label, "rows tool0.x tool0.y tool0.z"));
    assert_int_equal(a->layout.dim._buffer[1].size, rows);
    assert_int_equal(a->layout.dim._buffer[1].stride, rows * columns);
    if (columns > 1) {
        assert_int_equal(a->layout.dim._buffer[2].size, columns);
        assert_int_equal(a->layout.dim._buffer[2].stride, columns);
    }
}

#define STAMP "stamp -3.000000007 frame base"

/* Takes samples until one is that of the state: a reader may begin with the state before. */
static bool takes_of_state(dds_entity_t reader, void *sample, bool is_array)
{
    const std_msgs_msg_dds__Float64MultiArray_ *array = sample;
    const sensor_msgs_msg_dds__JointState_ *torques = sample;
    while (ros2_peer_take(reader, sample, 100))
        if (is_array ? strcmp(array->layout.dim._buffer[0].label, STAMP) == 0
                     : torques->header.stamp.sec == -3)
            return true;
    return false;
}

/* Publishes the state. @return whether each of four readers, the last of torques, has its sample */
static bool take_each(const arm_motion *m, const dds_entity_t reader[4], void *const sample[4],
                      bool got[4])
{
    bool all = true;
    arm_publish_state(&node, m, -3);
    for (int k = 0; k < 4; k++) {
        got[k] = got[k] || takes_of_state(reader[k], sample[k], k < 3);
        all = all && got[k];
    }
    return all;
}

TEST(operational_space_is_that_of_the_library)
{
    static arm_operational expected;
    static std_msgs_msg_dds__Float64MultiArray_ l, j, b;
    static sensor_msgs_msg_dds__JointState_ g;
    const dds_topic_descriptor_t *type = &std_msgs_msg_dds__Float64MultiArray__desc;
    const dds_entity_t p = node.participant;
    const dds_entity_t readers[4] = {
        ros2_peer_reader(p, type, "rt/arm/totalforce/lambda_inv", PEER_DEFAULT),
        ros2_peer_reader(p, type, "rt/arm/totalforce/jacobian", PEER_SENSOR),
        ros2_peer_reader(p, type, "rt/arm/totalforce/bias_acceleration", PEER_DEFAULT),
        ros2_peer_reader(p, &sensor_msgs_msg_dds__JointState__desc,
                         "rt/arm/totalforce/gravity_torques", PEER_DEFAULT)};
    void *const samples[4] = {&l, &j, &b, &g};
    bool got[4] = {false};
    const arm_motion m = arm_motion_of(21);
    arm_expect_operational(workspace, model, &m, &expected);
    assert_true(WAIT_FOR(take_each(&m, readers, samples, got)));
    assert_array(&l, expected.lambda_inv, 12, 12, STAMP);
    assert_array(&j, expected.jacobian, 12, JOINTS, STAMP);
    assert_array(&b, expected.bias, 12, 1, STAMP);
    assert_string_equal(j.layout.dim._buffer[2].label,
                        "columns joint_1 joint_2 joint_3 joint_4 joint_5 joint_6 joint_7");
    assert_int_equal(g.header.stamp.sec, -3);
    assert_string_equal(g.name._buffer[1], "joint_2");
    assert_memory_equal(g.effort._buffer, expected.gravity, sizeof expected.gravity);
}

/* ---- the service ---- */

/* Sends the call. @return whether the reply to it comes soon */
static bool replies_to(dds_entity_t requests, dds_entity_t replies,
                       const totalforce_msgs_srv_dds__ForwardDynamics_Request_ *request,
                       totalforce_msgs_srv_dds__ForwardDynamics_Response_ *reply)
{
    assert_int_equal(dds_write(requests, request), DDS_RETCODE_OK);
    while (ros2_peer_take(replies, reply, 500))
        if (reply->guid == request->guid && reply->seq == request->seq)
            return true;
    return false;
}

static totalforce_msgs_srv_dds__ForwardDynamics_Response_ *
call(dds_entity_t requests, dds_entity_t replies,
     const totalforce_msgs_srv_dds__ForwardDynamics_Request_ *request)
{
    static totalforce_msgs_srv_dds__ForwardDynamics_Response_ reply;
    if (!WAIT_FOR(replies_to(requests, replies, request, &reply)))
        fail_msg("call %d is not answered", (int)request->seq);
    return &reply;
}

/* State and efforts come with the call: no topic is read, and no call sees those of another. */
TEST(calls_are_answered_to_their_caller)
{
    const dds_entity_t requests =
        ros2_peer_writer(node.participant, &totalforce_msgs_srv_dds__ForwardDynamics_Request__desc,
                         "rq/arm/totalforce/forward_dynamicsRequest", PEER_DEFAULT);
    const dds_entity_t replies =
        ros2_peer_reader(node.participant, &totalforce_msgs_srv_dds__ForwardDynamics_Response__desc,
                         "rr/arm/totalforce/forward_dynamicsReply", PEER_DEFAULT);
    arm_motion m = arm_motion_of(41);
    double qdd[JOINTS];
    totalforce_msgs_srv_dds__ForwardDynamics_Request_ request = {
        .guid = 77,
        .state = {.name = PEER_SEQUENCE(JOINTS, arm_joints),
                  .position = PEER_SEQUENCE(JOINTS, m.q),
                  .velocity = PEER_SEQUENCE(JOINTS, m.v),
                  .effort = PEER_SEQUENCE(JOINTS, m.tau)}};
    for (request.seq = 1; request.seq <= 20; request.seq++) {
        m = arm_motion_of(500 + (uint64_t)request.seq);
        arm_expect(workspace, &m, qdd);
        const totalforce_msgs_srv_dds__ForwardDynamics_Response_ *r =
            call(requests, replies, &request);
        assert_true(r->success);
        assert_string_equal(r->message, "");
        assert_int_equal(r->acceleration._length, JOINTS);
        assert_memory_equal(r->acceleration._buffer, qdd, sizeof qdd);
        assert_string_equal(r->name._buffer[2], "joint_3");
    }
    request.seq++; /* replies to repeated calls may be left */
    request.state.name._length = request.state.position._length = 6;
    request.state.velocity._length = request.state.effort._length = 6;
    assert_false(call(requests, replies, &request)->success);
    assert_string_equal(call(requests, replies, &request)->message,
                        "joint 'joint_7': no position was received");
    request.seq++;
    request.state.effort._length = 2;
    assert_string_equal(call(requests, replies, &request)->message,
                        "effort: neither empty nor as long as the names");
}

/* ---- refusals ---- */

static void publish_joints(uint32_t names, uint32_t positions, uint32_t velocities,
                           const arm_motion *m)
{
    const sensor_msgs_msg_dds__JointState_ sample = {
        .header = {{1, 1}, ""},
        .name = PEER_SEQUENCE(names, arm_joints),
        .position = PEER_SEQUENCE(positions, (double *)(uintptr_t)m->q),
        .velocity = PEER_SEQUENCE(velocities, (double *)(uintptr_t)m->v)};
    assert_int_equal(dds_write(node.joint_states, &sample), DDS_RETCODE_OK);
}

TEST(states_that_are_refused_are_named)
{
    arm_motion m = arm_motion_of(31);
    publish_joints(JOINTS, 3, 0, &m);
    assert_true(arm_await_diagnostic(&node, "joint_states",
                                     "position: neither empty nor as long as the names") > 0);
    m.q[3] = NAN;
    publish_joints(JOINTS, JOINTS, JOINTS, &m);
    assert_true(
        arm_await_diagnostic(&node, "joint_states", "joint 'joint_4': position is not finite") > 0);
    m.q[3] = 0;
    m.v[5] = INFINITY;
    publish_joints(JOINTS, JOINTS, JOINTS, &m);
    assert_true(
        arm_await_diagnostic(&node, "joint_states", "joint 'joint_6': velocity is not finite") > 0);
}

/* It does not match, and the right one beside it goes on. */
TEST(a_publisher_of_another_type_is_named)
{
    const dds_entity_t p = ros2_peer_open(arm_domain());
    const dds_entity_t wrong =
        ros2_peer_writer(p, &std_msgs_msg_dds__String__desc, "rt/arm/joint_states", PEER_DEFAULT);
    assert_true(wrong > 0);
    assert_true(arm_await_diagnostic(&node, "joint_states",
                                     "a publisher has the type std_msgs::msg::dds_::String_") > 0);
    assert_int_equal(dds_delete(p), DDS_RETCODE_OK);
}

/* Of a robot whose publishers leave a joint out: the joint is named while it is missing. */
TEST(missing_joints_are_named)
{
    const arm_motion m = arm_motion_of(34);
    const dds_entity_t writer =
        ros2_peer_writer(node.participant, &sensor_msgs_msg_dds__JointState__desc,
                         "rt/lonely/joint_states", PEER_DEFAULT);
    const sensor_msgs_msg_dds__JointState_ six = {
        .name = PEER_SEQUENCE(6, arm_joints),
        .position = PEER_SEQUENCE(6, (double *)(uintptr_t)m.q),
        .velocity = PEER_SEQUENCE(6, (double *)(uintptr_t)m.v)};
    int level = -1;
    assert_true(WAIT_FOR((assert_int_equal(dds_write(writer, &six), DDS_RETCODE_OK),
                          level = arm_find_diagnostic(&node, "lonely/joint_states",
                                                      "joint 'joint_7': no position was received"),
                          level >= 0)));
    assert_int_equal(level, LEVEL_ERROR);
    assert_int_equal(dds_delete(writer), DDS_RETCODE_OK);
}

/* Of a robot with a limit of 100 ms: once the diagnostics say that its state is too old, it is. */
TEST(stale_states_are_refused)
{
    static trajectory_msgs_msg_dds__JointTrajectory_ sample;
    const dds_topic_descriptor_t *type = &sensor_msgs_msg_dds__JointState__desc;
    const dds_entity_t p = node.participant;
    const arm_node old = {
        .joint_states = ros2_peer_writer(p, type, "rt/old/joint_states", PEER_DEFAULT),
        .joint_efforts = ros2_peer_writer(p, type, "rt/old/efforts", PEER_DEFAULT),
        .accelerations = ros2_peer_reader(p, &trajectory_msgs_msg_dds__JointTrajectory__desc,
                                          "rt/old/totalforce/accelerations", PEER_DEFAULT)};
    const arm_motion m = arm_motion_of(32);
    const char *limit = "ms old, the limit is 100 ms";
    int level = -1;
    ros2_peer_await_writer(old.accelerations);
    assert_true(
        WAIT_FOR((arm_publish_state(&old, &m, 1),
                  level = arm_find_diagnostic(&node, "old/joint_states", limit), level >= 0)));
    assert_int_equal(level, LEVEL_STALE);
    assert_true(WAIT_FOR((arm_publish_named_efforts(&old, arm_joints, m.tau, JOINTS, 1),
                          arm_find_diagnostic(&node, "old/totalforce: answers",
                                              "joint 'joint_1': position is too old") > 0)));
    assert_false(ros2_peer_take(old.accelerations, &sample, 0));
    assert_int_equal(dds_delete(old.joint_states), DDS_RETCODE_OK);
    assert_int_equal(dds_delete(old.joint_efforts), DDS_RETCODE_OK);
    assert_int_equal(dds_delete(old.accelerations), DDS_RETCODE_OK);
}

TEST(commands_that_are_refused_are_named)
{
    arm_motion m = arm_motion_of(33);
    char *stranger[] = {"joint_1", "elbow"};
    arm_publish_state(&node, &m, 1);
    arm_publish_efforts(&node, m.tau, 3);
    assert_int_equal(arm_await_diagnostic(&node, "effort_controller/commands",
                                          "3 numbers, data_offset 0; 7 joints are commanded"),
                     LEVEL_WARN);
    arm_publish_named_efforts(&node, arm_joints, m.tau, 0, 1);
    assert_int_equal(arm_await_diagnostic(&node, "joint_efforts", "no efforts"), LEVEL_WARN);
    arm_publish_named_efforts(&node, stranger, m.tau, 2, 1);
    assert_true(arm_await_diagnostic(&node, "joint_efforts", "last: elbow") >= 0);
    m.tau[1] = NAN;
    arm_publish_efforts(&node, m.tau, JOINTS);
    assert_int_equal(arm_await_diagnostic(&node, "effort_controller/commands",
                                          "joint 'joint_2': effort is not finite"),
                     LEVEL_WARN);
}

/* An answer would be of the efforts before, with the stamp of this command. */
TEST(commands_that_are_not_taken_are_not_answered)
{
    const arm_motion m = arm_motion_of(35);
    char *strangers[JOINTS] = {"a1", "a2", "a3", "a4", "a5", "a6", "a7"};
    double tau[JOINTS];
    arm_settle(&node);
    arm_publish_state(&node, &m, 1);
    arm_publish_efforts(&node, m.tau, JOINTS);
    assert_accelerations(&m, 1, 7, "base");
    arm_publish_named_efforts(&node, strangers, m.tau, JOINTS, 2);
    for (int j = 0; j < JOINTS; j++) {
        memcpy(tau, m.tau, sizeof tau);
        tau[j] = j % 2 ? NAN : INFINITY;
        arm_publish_efforts(&node, tau, JOINTS);
        arm_publish_named_efforts(&node, arm_joints, tau, JOINTS, 3 + j);
    }
    strangers[3] = arm_joints[3]; /* of both robots: the next answer is to this one */
    tau[0] = tau[3] = m.tau[3];
    arm_publish_named_efforts(&node, strangers, tau, 4, 20);
    assert_accelerations(&m, 20, 9, "command");
    arm_publish_efforts(&node, m.tau, JOINTS); /* and to this one on the other topic */
    assert_accelerations(&m, 1, 7, "base");
}

/* ---- endpoints ---- */

TEST(a_publisher_of_another_qos_or_type_is_named)
{
    const dds_entity_t wrong_type = ros2_peer_writer(
        node.participant, &std_msgs_msg_dds__String__desc, "rt/lonely/joint_states", PEER_DEFAULT);
    const dds_entity_t is_volatile =
        ros2_peer_writer(node.participant, &std_msgs_msg_dds__String__desc,
                         "rt/arm/robot_description", PEER_DEFAULT);
    assert_int_equal(
        arm_await_diagnostic(&node, "lonely/joint_states", "type std_msgs::msg::dds_::String_"),
        LEVEL_WARN);
    assert_true(
        arm_await_diagnostic(&node, "arm/robot_description", "last by its QoS: durability") >= 0);
    assert_int_equal(dds_delete(wrong_type), DDS_RETCODE_OK);
    assert_int_equal(dds_delete(is_volatile), DDS_RETCODE_OK);
    assert_int_equal(arm_await_diagnostic(&node, "lonely/joint_states", "no publisher"),
                     LEVEL_STALE);
}

/* Robots may be in domains of their own. */
TEST(a_robot_in_another_domain_is_found_there)
{
    const dds_entity_t p = ros2_peer_open(test_domain());
    arm_node far = {.diagnostics =
                        ros2_peer_reader(p, &diagnostic_msgs_msg_dds__DiagnosticArray__desc,
                                         "rt/diagnostics", PEER_ALL)};
    assert_int_not_equal(test_domain(), arm_domain());
    ros2_peer_await_writer(far.diagnostics);
    assert_int_equal(arm_await_diagnostic(&far, "far/joint_states", "no publisher"), LEVEL_STALE);
    assert_int_equal(arm_await_diagnostic(&node, "lonely/joint_states", "no publisher"),
                     LEVEL_STALE);
    assert_int_equal(dds_delete(p), DDS_RETCODE_OK);
}

static int serve(void **state)
{
    char yaml[2048];
    (void)state;
    load_robot("arm7.urdf", NULL);
    snprintf(
        yaml, sizeof yaml,
        "%s  - name: lonely\n    urdf: @/config/robots/arm7.urdf\n"
        "    ros2: {enabled: yes, namespace: /lonely, state_age_ms: 3600000}\n"
        "  - name: old\n    urdf: @/config/robots/arm7.urdf\n"
        "    ros2: {enabled: yes, namespace: /old, joint_efforts: efforts, state_age_ms: 100}\n"
        "  - name: far\n    urdf: @/config/robots/arm7.urdf\n"
        "    ros2: {enabled: yes, namespace: /far, domain: %u}\n",
        arm_yaml("      services: yes\n"), test_domain());
    running = harness_serve(yaml, arm_settings(""));
    arm_node_open(&node);
    return 0;
}

int main(void)
{
    return test_run(serve, stop);
}
