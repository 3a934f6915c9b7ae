/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * See ros2_arm.h.
 */
#include "ros2_arm.h"

#include "dds/dds_test.h"
#include "models.h"

#include <string.h>

char *arm_joints[JOINTS] = {"joint_1", "joint_2", "joint_3", "joint_4",
                            "joint_5", "joint_6", "joint_7"};

uint32_t arm_domain(void)
{
    return test_domain();
}

const char *arm_yaml(const char *more)
{
    static char text[1024];
    snprintf(text, sizeof text,
             ARM "    ros2:\n      enabled: yes\n      namespace: /arm\n"
                 "      effort_commands: effort_controller/commands\n"
                 "      joint_efforts: joint_efforts\n      trajectory: trajectory\n"
                 "      robot_description: robot_description\n      tips: [tool0, link_4]\n"
                 "      state_age_ms: 3600000\n      command_age_ms: 3600000\n%s",
             more);
    return text;
}

const char *arm_settings(const char *more)
{
    static char text[512];
    snprintf(text, sizeof text,
             "ros2: {enabled: yes, domain: %u, discovery_range: system_default}\n%s", arm_domain(),
             more);
    return text;
}

#define COMMAND_KINDS 3

/* Publishes a motion, another for each seed. @return whether it is answered soon: those before are
 * then, too, for a topic's commands are answered in their order */
static bool is_answered(const arm_node *n, int kind, uint64_t seed)
{
    static trajectory_msgs_msg_dds__JointTrajectory_ answer;
    const arm_motion m = arm_motion_of(seed);
    arm_publish_state(n, &m, kind);
    if (kind == 0)
        arm_publish_efforts(n, m.tau, JOINTS);
    else if (kind == 1)
        arm_publish_named_efforts(n, arm_joints, m.tau, JOINTS, kind);
    else
        arm_publish_trajectory(n, m.tau, kind);
    while (ros2_peer_take(n->accelerations, &answer, 200))
        if (answer.points._buffer[0].effort._buffer[0] == m.tau[0])
            return true;
    return false;
}

void arm_settle(const arm_node *n)
{
    static uint64_t seed = 1000000;
    for (int kind = 0; kind < COMMAND_KINDS; kind++)
        assert_true(WAIT_FOR(is_answered(n, kind, seed++)));
}

void arm_node_watch(arm_node *n)
{
    n->domain = arm_domain();
    n->participant = ros2_peer_open(n->domain);
    n->diagnostics =
        ros2_peer_reader(n->participant, &diagnostic_msgs_msg_dds__DiagnosticArray__desc,
                         "rt/diagnostics", PEER_ALL);
    ros2_peer_await_writer(n->diagnostics);
}

void arm_node_open(arm_node *n)
{
    arm_node_watch(n);
    const dds_entity_t p = n->participant;
    const dds_topic_descriptor_t *state = &sensor_msgs_msg_dds__JointState__desc;
    n->joint_states = ros2_peer_writer(p, state, "rt/arm/joint_states", PEER_DEFAULT);
    n->effort_commands = ros2_peer_writer(p, &std_msgs_msg_dds__Float64MultiArray__desc,
                                          "rt/arm/effort_controller/commands", PEER_DEFAULT);
    n->joint_efforts = ros2_peer_writer(p, state, "rt/arm/joint_efforts", PEER_SENSOR);
    n->trajectory = ros2_peer_writer(p, &trajectory_msgs_msg_dds__JointTrajectory__desc,
                                     "rt/arm/trajectory", PEER_DEFAULT);
    n->description = ros2_peer_writer(p, &std_msgs_msg_dds__String__desc,
                                      "rt/arm/robot_description", PEER_TRANSIENT_LOCAL);
    n->accelerations = ros2_peer_reader(p, &trajectory_msgs_msg_dds__JointTrajectory__desc,
                                        "rt/arm/totalforce/accelerations", PEER_DEFAULT);
    ros2_peer_await_reader(n->joint_states);
    ros2_peer_await_reader(n->effort_commands);
    ros2_peer_await_reader(n->joint_efforts);
    ros2_peer_await_reader(n->trajectory);
    ros2_peer_await_reader(n->description);
    ros2_peer_await_writer(n->accelerations);
    arm_settle(n);
}

void arm_node_close(arm_node *n)
{
    assert_int_equal(dds_delete(n->participant), DDS_RETCODE_OK);
}

arm_motion arm_motion_of(uint64_t seed)
{
    arm_motion m;
    for (int j = 0; j < JOINTS; j++) {
        m.q[j] = test_random(&seed);
        m.v[j] = test_random(&seed);
        m.tau[j] = 10 * test_random(&seed);
    }
    return m;
}

void arm_expect(tfa_workspace *workspace, const arm_motion *m, double qdd[JOINTS])
{
    const tfa_request request = request_fd(m->q, m->v, m->tau);
    tfa_reply reply = {.qdd = qdd};
    assert_int_equal(tfa_compute(workspace, &request, &reply), TFA_OK);
}

bool arm_is_answer(const trajectory_msgs_msg_dds__JointTrajectory_ *got, const arm_motion *m,
                   const double qdd[JOINTS])
{
    const trajectory_msgs_msg_dds__JointTrajectoryPoint_ *p = got->points._buffer;
    const size_t size = JOINTS * sizeof *qdd;
    bool same = got->points._length == 1 && got->joint_names._length == JOINTS &&
                p->positions._length == JOINTS && p->velocities._length == JOINTS &&
                p->accelerations._length == JOINTS && p->effort._length == JOINTS;
    for (int j = 0; same && j < JOINTS; j++)
        same = strcmp(got->joint_names._buffer[j], arm_joints[j]) == 0;
    return same && memcmp(p->positions._buffer, m->q, size) == 0 &&
           memcmp(p->velocities._buffer, m->v, size) == 0 &&
           memcmp(p->effort._buffer, m->tau, size) == 0 &&
           memcmp(p->accelerations._buffer, qdd, size) == 0;
}

void arm_expect_operational(tfa_workspace *workspace, const tfa_model *model, const arm_motion *m,
                            arm_operational *out)
{
    const tfa_request request = {.op = TFA_OP_OPERATIONAL_INERTIA,
                                 .refine = TFA_REFINE_DEFAULT,
                                 .flags = TFA_WANT_JACOBIAN | TFA_WANT_BIAS_ACCELERATION,
                                 .count = 1,
                                 .tip_count = 2,
                                 .tips = {(uint32_t)tfa_model_find_frame(model, "tool0"),
                                          (uint32_t)tfa_model_find_frame(model, "link_4")},
                                 .q = m->q,
                                 .v = m->v};
    const tfa_request at_rest = {.op = TFA_OP_BIAS, .count = 1, .q = m->q};
    tfa_reply reply = {
        .lambda_inv = out->lambda_inv, .jacobian = out->jacobian, .bias_acceleration = out->bias};
    tfa_reply holding = {.gravity_force = out->gravity};
    assert_int_equal(tfa_compute(workspace, &request, &reply), TFA_OK);
    assert_int_equal(tfa_compute(workspace, &at_rest, &holding), TFA_OK);
}

char *arm_urdf(bool heavy)
{
    static const char light_mass[] = "<mass value=\"2.8\"/>",
                      heavy_mass[] = "<mass value=\"5.6\"/>";
    char *const text = bundled_text("arm7.urdf"), *const at = strstr(text, light_mass);
    assert_non_null(at);
    if (heavy)
        memcpy(at, heavy_mass, sizeof heavy_mass - 1);
    return text;
}

tfa_model *arm_model(const char *urdf)
{
    tfa_description *d;
    tfa_report report = {0};
    assert_int_equal(tfa_urdf_parse(urdf, strlen(urdf), NULL, &d, &report), TFA_OK);
    tfa_model *model = compiled(d, NULL);
    tfa_description_free(d);
    tfa_report_free(&report);
    return model;
}

sensor_msgs_msg_dds__JointState_ arm_state(const arm_motion *m, int32_t sec)
{
    return (sensor_msgs_msg_dds__JointState_){
        .header = {{sec, 7}, "base"},
        .name = PEER_SEQUENCE(JOINTS, arm_joints),
        .position = PEER_SEQUENCE(JOINTS, (double *)(uintptr_t)m->q),
        .velocity = PEER_SEQUENCE(JOINTS, (double *)(uintptr_t)m->v),
    };
}

sensor_msgs_msg_dds__JointState_ arm_efforts(char **name, const double *tau, uint32_t count,
                                             int32_t sec)
{
    return (sensor_msgs_msg_dds__JointState_){
        .header = {{sec, 9}, "command"},
        .name = PEER_SEQUENCE(count, name),
        .effort = PEER_SEQUENCE(count, (double *)(uintptr_t)tau),
    };
}

void arm_publish_state(const arm_node *n, const arm_motion *m, int32_t sec)
{
    const sensor_msgs_msg_dds__JointState_ sample = arm_state(m, sec);
    assert_int_equal(dds_write(n->joint_states, &sample), DDS_RETCODE_OK);
}

void arm_publish_efforts(const arm_node *n, const double *tau, uint32_t count)
{
    const std_msgs_msg_dds__Float64MultiArray_ sample = {
        .data = PEER_SEQUENCE(count, (double *)(uintptr_t)tau)};
    assert_int_equal(dds_write(n->effort_commands, &sample), DDS_RETCODE_OK);
}

void arm_publish_named_efforts(const arm_node *n, char **name, const double *tau, uint32_t count,
                               int32_t sec)
{
    const sensor_msgs_msg_dds__JointState_ sample = arm_efforts(name, tau, count, sec);
    assert_int_equal(dds_write(n->joint_efforts, &sample), DDS_RETCODE_OK);
}

void arm_publish_trajectory(const arm_node *n, const double *tau, int32_t sec)
{
    trajectory_msgs_msg_dds__JointTrajectoryPoint_ points[2] = {
        {.effort = PEER_SEQUENCE(JOINTS, (double *)(uintptr_t)tau)}, {.effort = {0}}};
    const trajectory_msgs_msg_dds__JointTrajectory_ sample = {.header = {{sec, 78}, "plan"},
                                                              .joint_names =
                                                                  PEER_SEQUENCE(JOINTS, arm_joints),
                                                              .points = PEER_SEQUENCE(2, points)};
    assert_int_equal(dds_write(n->trajectory, &sample), DDS_RETCODE_OK);
}

static bool is_command_answered(const arm_node *n)
{
    static trajectory_msgs_msg_dds__JointTrajectory_ m;
    const arm_motion motion = arm_motion_of(4);
    arm_publish_state(n, &motion, 4711);
    arm_publish_named_efforts(n, arm_joints, motion.tau, JOINTS, 4712);
    while (ros2_peer_take(n->accelerations, &m, 100))
        if (m.header.stamp.sec == 4712)
            return true;
    return false;
}

void arm_assert_answered(const arm_node *n)
{
    assert_true(WAIT_FOR(is_command_answered(n)));
}

static void *run_witness(void *arg)
{
    arm_witness *w = arg;
    double qdd[JOINTS];
    for (; !atomic_load(&w->stop); w->asked++) {
        w->wrong += ask_arm(w->client, 0.1, qdd, WAIT_NS) != TFA_OK ||
                    (w->exact && memcmp(qdd, w->right, sizeof qdd) != 0);
        dds_sleepfor(DDS_USECS(500)); /* leaves the processor to the others; nothing waits for it */
    }
    return NULL;
}

void arm_witness_start(arm_witness *w, const harness *h, bool exact)
{
    *w = (arm_witness){.exact = exact};
    w->client = harness_connect(h, "arm", TFA_WAIT_BLOCK);
    assert_int_equal(ask_arm(w->client, 0.1, w->right, WAIT_NS), TFA_OK);
    assert_int_equal(pthread_create(&w->thread, NULL, run_witness, w), 0);
}

void arm_witness_stop(arm_witness *w)
{
    assert_true(WAIT_FOR(atomic_load(&w->asked) > 100));
    atomic_store(&w->stop, true);
    pthread_join(w->thread, NULL);
    tfa_client_close(w->client);
    assert_int_equal(w->wrong, 0);
}

static bool contains(const diagnostic_msgs_msg_dds__DiagnosticStatus_ *s, const char *text)
{
    if (strstr(s->message, text) != NULL)
        return true;
    for (uint32_t k = 0; k < s->values._length; k++)
        if (strstr(s->values._buffer[k].value, text) != NULL)
            return true;
    return false;
}

int arm_level_in(const diagnostic_msgs_msg_dds__DiagnosticArray_ *message, const char *what,
                 const char *text)
{
    for (uint32_t k = 0; k < message->status._length; k++) {
        const diagnostic_msgs_msg_dds__DiagnosticStatus_ *s = &message->status._buffer[k];
        if (strstr(s->name, what) != NULL && contains(s, text))
            return s->level;
    }
    return -1;
}

/* @return level of the status in the next message; -1: it is not there */
static int take_diagnostic(const arm_node *n, const char *what, const char *text)
{
    diagnostic_msgs_msg_dds__DiagnosticArray_ sample = {0};
    if (!ros2_peer_take(n->diagnostics, &sample, 0))
        return -1;
    const int level = arm_level_in(&sample, what, text);
    dds_sample_free(&sample, &diagnostic_msgs_msg_dds__DiagnosticArray__desc, DDS_FREE_CONTENTS);
    return level;
}

static int diagnostic_within(const arm_node *n, const char *what, const char *text, uint64_t ns)
{
    const uint64_t end = now_ns() + ns;
    bool last = false;
    int level;
    do
        level = take_diagnostic(n, what, text);
    while (level < 0 && wait_again(end, &last));
    return level;
}

int arm_await_diagnostic(const arm_node *n, const char *what, const char *text)
{
    return diagnostic_within(n, what, text, WAIT_NS);
}

int arm_find_diagnostic(const arm_node *n, const char *what, const char *text)
{
    return diagnostic_within(n, what, text, 1500000000); /* they come every second */
}

tfa_ros2_statistics arm_statistics(const harness *h, const char *robot)
{
    tfa_statistics *statistics;
    tfa_snapshot *now;
    tfa_ros2_statistics found = {0};
    assert_int_equal(tfa_statistics_open(h->runtime_dir, WAIT_MS, &statistics), TFA_OK);
    assert_int_equal(tfa_snapshot_create(statistics, &now), TFA_OK);
    assert_int_equal(tfa_statistics_read(statistics, now), TFA_OK);
    for (uint32_t k = 0; k < now->robot_count; k++)
        if (strcmp(now->robots[k].served.name, robot) == 0)
            found = now->robots[k].ros2;
    tfa_snapshot_free(now);
    tfa_statistics_close(statistics);
    return found;
}

uint64_t arm_received(const harness *h, const char *robot, const char *topic)
{
    const tfa_ros2_statistics s = arm_statistics(h, robot);
    for (uint32_t k = 0; k < s.input_count; k++)
        if (strcmp(s.inputs[k].name, topic) == 0)
            return s.inputs[k].received;
    return 0;
}
