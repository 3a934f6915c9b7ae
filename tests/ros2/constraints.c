/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Constraints of a scene on topics of ROS 2: the active ones by name, accelerations and forces as
 * the library has them. What is unknown, old or too long is refused by name.
 */
#include "dds/dds_test.h"

#include "models.h"
#include "ros2_daemon.h"

#include <string.h>

enum { CONSTRAINTS = 2, TIP = 1, ELBOW = 2, NEITHER = 0 };

/* Two robots of one kind: nothing of the arm becomes too old; of the old one only `elbow` is active
 * without a message. */
typedef struct robot {
    const char *name;
    dds_entity_t joint_states, efforts, active, description, accelerations, wrenches;
} robot;

static robot arm = {.name = "arm"}, old = {.name = "old"};

typedef struct answer {
    double qdd[JOINTS], wrench[CONSTRAINTS][6];
} answer;

static answer expect(const arm_motion *m, uint32_t active)
{
    tfa_request request = request_fd(m->q, m->v, m->tau);
    answer a = {0};
    tfa_reply reply = {.qdd = a.qdd, .constraint_wrenches = a.wrench[0]};
    request.constraints = active;
    if (active)
        request.op = TFA_OP_CONSTRAINED_DYNAMICS;
    assert_int_equal(tfa_compute(workspace, &request, &reply), TFA_OK);
    return a;
}

static void publish_active(const robot *r, const char *names)
{
    const std_msgs_msg_dds__String_ sample = {(char *)(uintptr_t)names};
    assert_int_equal(dds_write(r->active, &sample), DDS_RETCODE_OK);
}

static void publish_motion(const robot *r, const arm_motion *m, int32_t sec)
{
    const sensor_msgs_msg_dds__JointState_ state = arm_state(m, sec),
                                           efforts = arm_efforts(arm_joints, m->tau, JOINTS, sec);
    assert_int_equal(dds_write(r->joint_states, &state), DDS_RETCODE_OK);
    assert_int_equal(dds_write(r->efforts, &efforts), DDS_RETCODE_OK);
}

/* Takes the forces of the command with this stamp: those of the active constraints, by name. */
static void assert_wrenches(const robot *r, const answer *a, uint32_t active, int32_t sec)
{
    static const char *const names[CONSTRAINTS] = {"tip", "elbow"};
    static sensor_msgs_msg_dds__MultiDOFJointState_ got;
    uint32_t count = 0;
    do
        assert_true(ros2_peer_take(r->wrenches, &got, WAIT_MS));
    while (got.header.stamp.sec != sec);
    assert_string_equal(got.header.frame_id, "command");
    assert_int_equal(got.transforms._length + got.twist._length, 0);
    for (uint32_t k = 0; k < CONSTRAINTS; k++) {
        if (!(active >> k & 1))
            continue;
        assert_true(count < got.joint_names._length && count < got.wrench._length);
        assert_string_equal(got.joint_names._buffer[count], names[k]);
        assert_memory_equal(&got.wrench._buffer[count], a->wrench[count], sizeof a->wrench[count]);
        count++;
    }
    assert_int_equal(got.joint_names._length, count);
    assert_int_equal(got.wrench._length, count);
}

/* Publishes the names, unless they are NULL, and a motion that no other is like. @return whether
 * its answer under these constraints comes soon */
static bool is_answered(const robot *r, const char *names, uint32_t active)
{
    static trajectory_msgs_msg_dds__JointTrajectory_ got;
    static int32_t sec = 1;
    const arm_motion m = arm_motion_of((uint64_t)++sec);
    const answer a = expect(&m, active);
    if (names)
        publish_active(r, names);
    publish_motion(r, &m, sec);
    while (ros2_peer_take(r->accelerations, &got, 200))
        if (got.header.stamp.sec == sec && arm_is_answer(&got, &m, a.qdd)) {
            assert_wrenches(r, &a, active, sec);
            return true;
        }
    return false;
}

/* Before any name came */
TEST(without_a_message_the_configured_ones_are_active)
{
    assert_true(WAIT_FOR(is_answered(&arm, NULL, TIP | ELBOW)));
    assert_true(WAIT_FOR(is_answered(&old, NULL, ELBOW)));
}

TEST(a_message_names_the_active_ones)
{
    static const struct {
        const char *names;
        uint32_t active;
    } rows[] = {{"tip", TIP},           {"elbow", ELBOW},         {"elbow tip", TIP | ELBOW},
                {" \n tip\ttip ", TIP}, {"", NEITHER},            {"tip\nelbow\n", TIP | ELBOW},
                {"  ", NEITHER},        {"elbow\r\n", ELBOW}};
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++)
        assert_true(WAIT_FOR(is_answered(&arm, rows[i].names, rows[i].active)));
}

TEST(an_unknown_name_changes_nothing)
{
    assert_true(WAIT_FOR(is_answered(&arm, "tip", TIP)));
    publish_active(&arm, "elbow ti");
    assert_true(arm_await_diagnostic(&node, "/arm/contacts", "no constraint 'ti'") > 0);
    publish_active(&arm, "tipp");
    assert_true(arm_await_diagnostic(&node, "/arm/contacts", "no constraint 'tipp'") > 0);
    assert_true(WAIT_FOR(is_answered(&arm, NULL, TIP)));
}

TEST(a_text_that_is_too_long_is_dropped)
{
    static char text[32 * 257 + 2];
    assert_true(WAIT_FOR(is_answered(&arm, "tip", TIP)));
    memset(text, ' ', sizeof text - 1);
    publish_active(&arm, text);
    assert_true(arm_await_diagnostic(&node, "/arm/contacts", "too long") > 0);
    assert_true(WAIT_FOR(is_answered(&arm, NULL, TIP)));
    assert_true(WAIT_FOR(is_answered(&arm, text + 1, NEITHER)));
}

TEST(an_old_message_is_refused)
{
    const arm_motion m = arm_motion_of(1);
    static trajectory_msgs_msg_dds__JointTrajectory_ got;
    assert_true(WAIT_FOR(is_answered(&old, "tip", TIP)));
    assert_int_equal(arm_await_diagnostic(&node, "/old/contacts", "ms old, the limit is 500 ms"),
                     3);
    assert_true(WAIT_FOR((publish_motion(&old, &m, 1),
                          arm_find_diagnostic(&node, "old/totalforce: answers",
                                              "active constraints: the last message is too old") >
                              0)));
    assert_false(ros2_peer_take(old.accelerations, &got, 0));
    assert_true(WAIT_FOR(is_answered(&old, "elbow", ELBOW)));
}

/* ---- the model ---- */

/* The arm with its constraints, as this test computes it. */
static void compile(const char *urdf)
{
    static const tfa_constraint constraints[CONSTRAINTS] = {
        {.name = "tip", .link = {NULL, "tool0"}, .rows = TFA_CONSTRAINT_POINT},
        {.name = "elbow", .link = {NULL, "link_4"}, .pose = {{0}, {0.25}}, .rows = 0x05}};
    const tfa_scene scene = {.constraints = constraints, .constraint_count = CONSTRAINTS};
    const tfa_model_options held = {.scene = &scene};
    tfa_report report = {0};
    tfa_description *d;
    assert_int_equal(tfa_urdf_parse(urdf, strlen(urdf), NULL, &d, &report), TFA_OK);
    tfa_report_free(&report);
    tfa_workspace_free(workspace);
    tfa_model_free(model);
    model = compiled(d, &held);
    workspace = workspace_for(model, NULL);
    tfa_description_free(d);
}

static void publish_description(const robot *r, const char *urdf)
{
    const std_msgs_msg_dds__String_ sample = {(char *)(uintptr_t)urdf};
    assert_int_equal(dds_write(r->description, &sample), DDS_RETCODE_OK);
}

/* The last test of the arm: its model is another afterwards. */
TEST(another_model_keeps_the_active_ones)
{
    char *const heavy = arm_urdf(true);
    assert_true(WAIT_FOR(is_answered(&arm, "elbow", ELBOW)));
    publish_description(&arm, "<robot");
    assert_int_equal(
        arm_await_diagnostic(&node, "arm/totalforce: model", "robot_description refused"), 2);
    assert_true(WAIT_FOR(is_answered(&arm, NULL, ELBOW)));
    compile(heavy);
    publish_description(&arm, heavy);
    assert_true(WAIT_FOR(is_answered(&arm, NULL, ELBOW)));
    assert_true(arm_received(&running, "arm.held", "/arm/contacts") > 0);
    free(heavy);
}

/* ---- the daemon ---- */

static void open_robot(robot *r)
{
    const dds_topic_descriptor_t *state = &sensor_msgs_msg_dds__JointState__desc,
                                 *text = &std_msgs_msg_dds__String__desc;
    r->joint_states = open_writer(state, PEER_DEFAULT, "rt/%s/joint_states", r->name);
    r->efforts = open_writer(state, PEER_DEFAULT, "rt/%s/efforts", r->name);
    r->active = open_writer(text, PEER_TRANSIENT_LOCAL, "rt/%s/contacts", r->name);
    r->description = open_writer(text, PEER_TRANSIENT_LOCAL, "rt/%s/robot_description", r->name);
    r->accelerations = open_reader(&trajectory_msgs_msg_dds__JointTrajectory__desc,
                                   "rt/%s/totalforce/accelerations", r->name);
    r->wrenches = open_reader(&sensor_msgs_msg_dds__MultiDOFJointState__desc,
                              "rt/%s/totalforce/constraint_wrenches", r->name);
}

#define ROBOT(name, more)                                                                          \
    "  - name: " name "\n    urdf: @/config/robots/arm7.urdf\n"                                    \
    "    scenes:\n      - name: held\n        constraints:\n"                                      \
    "          - {name: tip, second: {link: tool0}, hold: point}\n"                                \
    "          - {name: elbow, second: {link: link_4, xyz: [0.25, 0, 0]}, hold: [x, z]}\n"         \
    "    ros2:\n      enabled: yes\n      namespace: /" name "\n      scene: held\n"               \
    "      op: constrained_dynamics\n      active_constraints: contacts\n"                         \
    "      joint_efforts: efforts\n      robot_description: robot_description\n"                   \
    "      command_age_ms: 3600000\n" more

static int serve(void **state)
{
    char *const urdf = arm_urdf(false);
    (void)state;
    compile(urdf);
    free(urdf);
    running = harness_serve(ROBOT("arm", "      state_age_ms: 3600000\n")
                                ROBOT("old", "      state_age_ms: 500\n"
                                             "      constraints: [elbow]\n"),
                            arm_settings(""));
    arm_node_watch(&node);
    open_robot(&arm);
    open_robot(&old);
    return 0;
}

int main(void)
{
    return test_run(serve, stop);
}
