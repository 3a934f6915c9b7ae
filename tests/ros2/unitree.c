/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Robots that publish a LowState: motors in the order of the robot, orientation of the IMU, a CRC;
 * and publishers that do it wrong.
 */
#include "dds/dds_test.h"

#include "dds/ros2/unitree_crc.h"
#include "harness.h"
#include "models.h"
#include "ros2_daemon.h"

#include <idl/ros2.h>
#include <idl/ros2_service.h>
#include <idl/unitree.h>
#include <math.h>
#include <signal.h>
#include <string.h>

#define LEGS 12

/* Joints as the robot numbers its motors: FR, FL, RR, RL. The model begins with FL. */
static char *motor_joints[LEGS] = {
    "FR_hip_joint",   "FR_thigh_joint", "FR_calf_joint",  "FL_hip_joint",
    "FL_thigh_joint", "FL_calf_joint",  "RR_hip_joint",   "RR_thigh_joint",
    "RR_calf_joint",  "RL_hip_joint",   "RL_thigh_joint", "RL_calf_joint",
};

#define MOTORS                                                                                     \
    "FR_hip_joint, FR_thigh_joint, FR_calf_joint, FL_hip_joint, FL_thigh_joint, FL_calf_joint, "   \
    "RR_hip_joint, RR_thigh_joint, RR_calf_joint, RL_hip_joint, RL_thigh_joint, RL_calf_joint"

/* Nothing of the first two is ever too old; what the last one has heard is soon. */
static struct robot {
    dds_entity_t state, efforts, answers;
} go, hg, old;

/* A state as the robot has it: single precision, in the order of its motors. */
typedef struct motion {
    float q[LEGS], v[LEGS], quaternion[4], gyroscope[3];
    double tau[LEGS];
} motion;

static motion motion_of(uint64_t seed)
{
    motion m;
    float norm = 0;
    for (int k = 0; k < LEGS; k++) {
        m.q[k] = (float)test_random(&seed);
        m.v[k] = (float)test_random(&seed);
        m.tau[k] = 20 * test_random(&seed);
    }
    for (int k = 0; k < 4; k++) {
        m.quaternion[k] = (float)test_random(&seed);
        norm += m.quaternion[k] * m.quaternion[k];
    }
    for (int k = 0; k < 4; k++)
        m.quaternion[k] /= sqrtf(norm);
    for (int k = 0; k < 3; k++)
        m.gyroscope[k] = (float)test_random(&seed);
    return m;
}

/* LowState with the legs from motor `first` on */
#define STATE_OF(kind, first, count, m)                                                            \
    unitree_##kind##_msg_dds__LowState_ s;                                                         \
    memset(&s, 0, sizeof s);                                                                       \
    for (int k = 0; k < LEGS; k++) {                                                               \
        s.motor_state[first + k].q = (m)->q[k];                                                    \
        s.motor_state[first + k].dq = (m)->v[k];                                                   \
    }                                                                                              \
    memcpy(s.imu_state.quaternion, (m)->quaternion, sizeof(m)->quaternion);                        \
    memcpy(s.imu_state.gyroscope, (m)->gyroscope, sizeof(m)->gyroscope);                           \
    s.tick = count;                                                                                \
    s.crc = tfa_unitree_##kind##_crc(&s);                                                          \
    return s

static unitree_go_msg_dds__LowState_ go_state_at(const motion *m, uint32_t tick)
{
    STATE_OF(go, 0, tick, m);
}

static unitree_go_msg_dds__LowState_ go_state(const motion *m)
{
    return go_state_at(m, 12345);
}

static unitree_hg_msg_dds__LowState_ hg_state(const motion *m)
{
    STATE_OF(hg, 15, 54321, m);
}

static void expect(const motion *m, double qdd[LEGS])
{
    double q[LEGS], v[LEGS], tau[LEGS];
    const float *o = m->quaternion, *w = m->gyroscope;
    const double pose[7] = {0, 0, 0, (double)o[1], (double)o[2], (double)o[3], (double)o[0]};
    const double twist[6] = {0, 0, 0, (double)w[0], (double)w[1], (double)w[2]};
    const tfa_request request = {.op = TFA_OP_FORWARD_DYNAMICS,
                                 .refine = TFA_REFINE_DEFAULT,
                                 .count = 1,
                                 .q = q,
                                 .v = v,
                                 .tau = tau,
                                 .base_pose = pose,
                                 .base_twist = twist};
    double base[6];
    tfa_reply reply = {.qdd = qdd, .base_acceleration = base};
    for (int k = 0; k < LEGS; k++) {
        const int32_t joint = tfa_model_find_joint(model, motor_joints[k]);
        assert_true(joint >= 0);
        q[joint] = (double)m->q[k];
        v[joint] = (double)m->v[k];
        tau[joint] = m->tau[k];
    }
    assert_int_equal(tfa_compute(workspace, &request, &reply), TFA_OK);
}

static void publish_efforts(const struct robot *r, const motion *m)
{
    const sensor_msgs_msg_dds__JointState_ sample = {
        .header = {{3, 4}, "policy"},
        .name = PEER_SEQUENCE(LEGS, motor_joints),
        .effort = PEER_SEQUENCE(LEGS, (double *)(uintptr_t)m->tau)};
    assert_int_equal(dds_write(r->efforts, &sample), DDS_RETCODE_OK);
}

/* Publishes the motion with an effort that no message of before had. @return whether the answer
 * comes soon; no answer to a command of before is then left */
static bool is_answered(const struct robot *r, const void *low_state, motion m)
{
    static trajectory_msgs_msg_dds__JointTrajectory_ sample;
    static double effort = 1;
    double qdd[LEGS];
    m.tau[0] = effort += 0.001;
    expect(&m, qdd);
    assert_int_equal(dds_write(r->state, low_state), DDS_RETCODE_OK);
    publish_efforts(r, &m);
    while (ros2_peer_take(r->answers, &sample, 200)) {
        assert_int_equal(sample.header.stamp.sec, 3);
        assert_int_equal(sample.joint_names._length, LEGS);
        if (memcmp(sample.points._buffer[0].accelerations._buffer, qdd, sizeof qdd) == 0)
            return true;
    }
    return false;
}

/* Publishes until the answer comes: what is sent before the other side has matched is lost. */
static void assert_answer(const struct robot *r, const void *low_state, const motion *m)
{
    assert_true(WAIT_FOR(is_answered(r, low_state, *m)));
}

TEST(motors_become_joints_and_the_imu_the_base)
{
    for (uint64_t seed = 1; seed <= 5; seed++) {
        const motion m = motion_of(seed), n = motion_of(100 + seed);
        const unitree_go_msg_dds__LowState_ dog = go_state(&m);
        const unitree_hg_msg_dds__LowState_ man = hg_state(&n);
        assert_answer(&go, &dog, &m);
        assert_answer(&hg, &man, &n);
    }
}

/* A bit that flipped anywhere, the CRC's own included. */
TEST(a_wrong_crc_is_refused)
{
    const motion m = motion_of(20);
    unitree_go_msg_dds__LowState_ dog = go_state(&m);
    unitree_hg_msg_dds__LowState_ man = hg_state(&m);
    dog.motor_state[19].q_raw = 1e-3f;
    man.crc ^= 1;
    assert_int_equal(dds_write(go.state, &dog), DDS_RETCODE_OK);
    assert_int_equal(dds_write(hg.state, &man), DDS_RETCODE_OK);
    assert_true(arm_await_diagnostic(&node, "dog/totalforce: /lowstate", "crc 0x") > 0);
    assert_true(arm_await_diagnostic(&node, "man/totalforce: /man/lowstate", "crc 0x") >= 0);
}

TEST(a_motor_that_is_not_finite_is_refused_by_its_joint)
{
    const motion m = motion_of(21);
    unitree_go_msg_dds__LowState_ dog = go_state(&m);
    dog.motor_state[3].dq = NAN;
    dog.crc = tfa_unitree_go_crc(&dog);
    assert_int_equal(dds_write(go.state, &dog), DDS_RETCODE_OK);
    assert_true(arm_await_diagnostic(&node, "dog/totalforce: /lowstate",
                                     "joint 'FL_hip_joint': velocity is not finite") > 0);
}

/* Of two states the second one, with a text in the diagnostics */
static bool is_refused(const unitree_go_msg_dds__LowState_ *first,
                       const unitree_go_msg_dds__LowState_ *second, const char *text)
{
    assert_int_equal(dds_write(go.state, first), DDS_RETCODE_OK);
    assert_int_equal(dds_write(go.state, second), DDS_RETCODE_OK);
    return arm_find_diagnostic(&node, "dog/totalforce: /lowstate", text) > 0;
}

/* A state is replayed while the robot publishes: nothing is answered from it, and it is named. The
 * count wraps after 49 days: the states after that are taken at once. */
TEST(a_replayed_state_is_refused)
{
    const motion before = motion_of(30), now = motion_of(31), later = motion_of(32);
    const unitree_go_msg_dds__LowState_ replayed = go_state_at(&before, UINT32_MAX - 10),
                                        last = go_state_at(&now, UINT32_MAX),
                                        wrapped = go_state_at(&later, 5);
    assert_answer(&go, &last, &now); /* after a rest */
    assert_true(WAIT_FOR(is_refused(&last, &replayed, "5 after tick 4294967295")));
    assert_answer(&go, &wrapped, &later);
    assert_true(WAIT_FOR(is_refused(&wrapped, &replayed, "tick 4294967285 after tick 5")));
    assert_answer(&go, &wrapped, &later);
}

/* After the last message the state ages, and nothing is answered. */
TEST(a_robot_that_falls_silent_is_stale)
{
    const motion m = motion_of(22);
    const unitree_go_msg_dds__LowState_ dog = go_state(&m);
    static trajectory_msgs_msg_dds__JointTrajectory_ sample;
    assert_answer(&old, &dog, &m);
    assert_int_equal(
        arm_await_diagnostic(&node, "old/totalforce: /old/lowstate", "the limit is 500 ms"), 3);
    publish_efforts(&old, &m);
    assert_true(arm_await_diagnostic(&node, "old/totalforce: answers", "is too old") > 0);
    assert_false(ros2_peer_take(old.answers, &sample, 0));
}

/* Fewer motors than the type has: the message is shorter, Cyclone does not deliver it. */
TEST(a_publisher_with_other_motors_is_seen_as_silent)
{
    dds_topic_descriptor_t type = test_msg_dds__Bytes__desc;
    const test_msg_dds__Bytes_ bytes = {{0}};
    type.m_typename = unitree_hg_msg_dds__LowState__desc.m_typename;
    const dds_entity_t writer =
        ros2_peer_writer(node.participant, &type, "rt/mute/lowstate", PEER_SENSOR);
    ros2_peer_await_reader(writer);
    for (int i = 0; i < 5; i++)
        assert_int_equal(dds_write(writer, &bytes), DDS_RETCODE_OK);
    assert_int_equal(arm_await_diagnostic(&node, "mute/totalforce: /mute/lowstate",
                                          "no message that can be read"),
                     3);
    assert_int_equal(dds_delete(writer), DDS_RETCODE_OK);
    assert_int_equal(arm_await_diagnostic(&node, "mute/totalforce: /mute/lowstate", "no publisher"),
                     3);
}

/* The robot's command topic belongs to its controllers. */
TEST(nothing_is_written_to_the_robot)
{
    static void *found[256];
    static dds_sample_info_t info[256];
    const dds_entity_t reader =
        dds_create_reader(node.participant, DDS_BUILTIN_TOPIC_DCPSPUBLICATION, NULL, NULL);
    const int count = dds_read(reader, found, info, 256, 256);
    assert_true(count > 3);
    for (int k = 0; k < count; k++) {
        const dds_builtintopic_endpoint_t *e = found[k];
        assert_null(strstr(e->topic_name, "lowcmd"));
    }
    (void)dds_return_loan(reader, found, count);
}

/* As nodes of Humble read the graph: gids of 24 bytes, the last eight of a GUID zero. Samples of
 * another length are not delivered. */
TEST(the_graph_is_that_of_the_release)
{
    dds_topic_descriptor_t type = rmw_dds_common_msg_dds__HumbleParticipantEntitiesInfo__desc;
    static rmw_dds_common_msg_dds__HumbleParticipantEntitiesInfo_ info;
    void *sample = &info;
    dds_sample_info_t about;
    type.m_typename = rmw_dds_common_msg_dds__ParticipantEntitiesInfo__desc.m_typename;
    const dds_entity_t reader =
        ros2_peer_reader(node.participant, &type, "ros_discovery_info", PEER_TRANSIENT_LOCAL);
    assert_true(WAIT_FOR(dds_take(reader, &sample, &about, 1, 1) == 1 && about.valid_data));
    assert_int_equal(info.node_entities_info_seq._length, 4);
    const rmw_dds_common_msg_dds__HumbleNodeEntitiesInfo_ *dog =
        &info.node_entities_info_seq._buffer[0];
    static const uint8_t zeros[8];
    assert_string_equal(dog->node_namespace, "/dog");
    assert_string_equal(dog->node_name, "totalforce");
    assert_int_equal(dog->reader_gid_seq._length, 2); /* states, efforts */
    for (uint32_t k = 0; k < dog->writer_gid_seq._length; k++) {
        const uint8_t *gid = dog->writer_gid_seq._buffer[k].data;
        assert_memory_equal(gid, info.gid.data, 12); /* the participant's prefix */
        assert_memory_equal(gid + 16, zeros, sizeof zeros);
    }
    assert_int_equal(dds_delete(reader), DDS_RETCODE_OK);
}

#define ROBOT(name, type, age, more)                                                               \
    "  - name: " name "\n    urdf: @/config/robots/quadruped.urdf\n    base: floating\n"           \
    "    ros2:\n      enabled: yes\n      namespace: /" name "\n      joint_efforts: efforts\n"    \
    "      state_age_ms: " age "\n      command_age_ms: 3600000\n"                                 \
    "      unitree:\n        type: " type "\n" more

#define LONG_AGE "3600000"

static void open_node(void)
{
    const dds_topic_descriptor_t *efforts = &sensor_msgs_msg_dds__JointState__desc,
                                 *answers = &trajectory_msgs_msg_dds__JointTrajectory__desc;
    arm_node_watch(&node);
    go.state = open_writer(&unitree_go_msg_dds__LowState__desc, PEER_DEFAULT, "rt/lowstate");
    hg.state = open_writer(&unitree_hg_msg_dds__LowState__desc, PEER_SENSOR, "rt/man/lowstate");
    old.state = open_writer(&unitree_go_msg_dds__LowState__desc, PEER_DEFAULT, "rt/old/lowstate");
    go.efforts = open_writer(efforts, PEER_DEFAULT, "rt/dog/efforts");
    hg.efforts = open_writer(efforts, PEER_DEFAULT, "rt/man/efforts");
    old.efforts = open_writer(efforts, PEER_DEFAULT, "rt/old/efforts");
    go.answers = open_reader(answers, "rt/dog/totalforce/accelerations");
    hg.answers = open_reader(answers, "rt/man/totalforce/accelerations");
    old.answers = open_reader(answers, "rt/old/totalforce/accelerations");
}

static int serve(void **state)
{
    const tfa_model_options floating = {.base = TFA_BASE_FLOATING};
    char more[128];
    (void)state;
    load_robot("quadruped.urdf", &floating);
    snprintf(more, sizeof more,
             "ros2: {enabled: yes, domain: %u, release: humble, discovery_range: "
             "system_default}\n",
             arm_domain());
    running = harness_make(
        ROBOT("dog", "go", LONG_AGE, "        motors: [" MOTORS "]\n")
            ROBOT("man", "hg", LONG_AGE,
                  "        topic: /man/lowstate\n        motors: [-, -, -, -, -, -, -, -, "
                  "-, -, -, -, -, -, -, " MOTORS "]\n")
                ROBOT("mute", "hg", LONG_AGE,
                      "        topic: /mute/lowstate\n        motors: [" MOTORS "]\n")
                    ROBOT("old", "go", "500",
                          "        topic: /old/lowstate\n        motors: [" MOTORS "]\n"),
        more);
    harness_start(&running, "dog");
    open_node();
    return 0;
}

int main(void)
{
    return test_run(serve, stop);
}
