/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Robot descriptions over a topic while the robot is asked: every answer is that of one of the
 * models, none is lost, and a bad description leaves the model as it was.
 */
#include "dds/dds_test.h"

#include "models.h"
#include "ros2_arm.h"

#include <pthread.h>
#include <signal.h>
#include <stdatomic.h>
#include <string.h>
#include <sys/wait.h>

#define SWAPS 100
#define UNDER_WAY 8 /* commands without an answer at once */
#define MODEL_STATUS "arm/totalforce: model"
#define MANY_JOINTS 64
#define LEVEL_OK 0
#define LEVEL_ERROR 2

/* The bundled arm, and the same with another mass. */
typedef struct variant {
    char *text;
    tfa_model *model;
    tfa_workspace *workspace;
} variant;

static variant variants[2];
static harness running;
static arm_node node;

/* The text with `from`, which is there, in place of `to`. */
static char *replace(const char *text, const char *from, const char *to)
{
    const char *at = strstr(text, from);
    char *result;
    assert_non_null(at);
    assert_true(asprintf(&result, "%.*s%s%s", (int)(at - text), text, to, at + strlen(from)) > 0);
    return result;
}

static void make_variants(void)
{
    for (int k = 0; k < 2; k++) {
        variants[k].text = arm_urdf(k);
        variants[k].model = arm_model(variants[k].text);
        variants[k].workspace = workspace_for(variants[k].model, NULL);
    }
}

static void free_variants(void)
{
    for (int k = 0; k < 2; k++) {
        tfa_workspace_free(variants[k].workspace);
        tfa_model_free(variants[k].model);
        free(variants[k].text);
    }
}

static void publish_description(dds_entity_t writer, char *text)
{
    const std_msgs_msg_dds__String_ sample = {text};
    assert_int_equal(dds_write(writer, &sample), DDS_RETCODE_OK);
}

/* ---- load ---- */

typedef struct load {
    pthread_t thread;
    _Atomic bool stop;
    _Atomic int model; /* that answered last */
    uint32_t sent, answered;
    _Atomic(const char *) error;
} load;

/* The variant whose answer this is, from the state in the message; -1: neither. */
static int variant_of(const trajectory_msgs_msg_dds__JointTrajectory_ *m)
{
    const trajectory_msgs_msg_dds__JointTrajectoryPoint_ *p = &m->points._buffer[0];
    const tfa_request request =
        request_fd(p->positions._buffer, p->velocities._buffer, p->effort._buffer);
    double qdd[JOINTS];
    tfa_reply reply = {.qdd = qdd};
    if (m->points._length != 1 || p->accelerations._length != JOINTS)
        return -1;
    for (int k = 0; k < 2; k++)
        if (tfa_compute(variants[k].workspace, &request, &reply) == TFA_OK &&
            memcmp(qdd, p->accelerations._buffer, sizeof qdd) == 0)
            return k;
    return -1;
}

static void publish_motion(load *l)
{
    const arm_motion m = arm_motion_of(9000 + l->sent % 100);
    arm_publish_state(&node, &m, (int32_t)l->sent);
    arm_publish_named_efforts(&node, arm_joints, m.tau, JOINTS, (int32_t)l->sent);
    l->sent++;
}

/* Answers come in the order of the commands: the stamp tells if one is missing. */
static void take_answers(load *l)
{
    static trajectory_msgs_msg_dds__JointTrajectory_ m;
    void *sample = &m;
    dds_sample_info_t info;
    while (dds_take(node.accelerations, &sample, &info, 1, 1) == 1) {
        if (!info.valid_data)
            continue;
        const int model = variant_of(&m);
        if (model < 0)
            l->error = "an answer is that of neither model";
        if (m.header.stamp.sec != (int32_t)l->answered)
            l->error = "a command was not answered";
        l->answered++;
        atomic_store(&l->model, model);
    }
}

/* About 1 kHz, paced by the answers: a reader that is best effort may drop what waits too long. */
static void *run_load(void *arg)
{
    load *l = arg;
    uint64_t last = now_ns();
    while ((!atomic_load(&l->stop) || l->answered < l->sent) && l->error == NULL) {
        const uint32_t before = l->answered;
        if (!atomic_load(&l->stop) && l->sent - l->answered < UNDER_WAY)
            publish_motion(l);
        dds_sleepfor(DDS_USECS(900));
        take_answers(l);
        last = l->answered != before ? now_ns() : last;
        if (now_ns() - last > WAIT_NS)
            l->error = "answers stay away";
    }
    return NULL;
}

/* The model of the next answers */
static void await_model(load *l, int model)
{
    const char *error = NULL;
    atomic_store(&l->model, -1);
    assert_true(
        WAIT_FOR(atomic_load(&l->model) == model || (error = atomic_load(&l->error)) != NULL));
    if (error != NULL)
        fail_msg("%s", error);
}

/* ---- the laws ---- */

/* Publishes a command. @return whether the next answer is of this model */
static bool is_variant(int model)
{
    static trajectory_msgs_msg_dds__JointTrajectory_ m;
    const arm_motion motion = arm_motion_of(5);
    arm_publish_state(&node, &motion, 1);
    arm_publish_named_efforts(&node, arm_joints, motion.tau, JOINTS, 1);
    return ros2_peer_take(node.accelerations, &m, 20) && variant_of(&m) == model;
}

static void await_variant(int model)
{
    assert_true(WAIT_FOR(is_variant(model)));
}

/* First: the log holds only so many lines about descriptions in a while. */
TEST(a_reload_keeps_the_description_and_the_same_one_is_no_news)
{
    publish_description(node.description, variants[0].text);
    assert_true(harness_logged_times(&running, "reload: done", 1));
    publish_description(node.description, variants[1].text);
    assert_true(harness_logged_times(&running, "reload: done", 2));
    await_variant(1);
    assert_int_equal(harness_log_lines(&running, "a robot_description of"), 2);
    publish_description(node.description, variants[1].text);
    assert_true(WAIT_FOR(arm_received(&running, "arm", "/arm/robot_description") == 3));
    assert_int_equal(kill(running.pid, SIGHUP), 0);
    assert_true(harness_logged_times(&running, "reload: done", 3));
    await_variant(1);
    assert_int_equal(harness_log_lines(&running, "a robot_description of"), 2);
}

/* Descriptions that are refused, and what the diagnostics say. */
typedef struct bad_description {
    const char *from, *to; /* NULL: all of the text is `to` */
    const char *says;
} bad_description;

static const bad_description bad[] = {
    {"</robot>", "", "robot_description of 'arm':"},
    {"<link name=\"link_3\">", "<link name=\"link_3\"><", "robot_description of 'arm':99"},
    {"name=\"joint_4\" type=\"revolute\"", "name=\"joint_4\" type=\"spiral\"",
     "robot_description of 'arm':116"},
    {"<joint name=\"joint_6\"", "<joint name=\"elbow\"", "joint_6"},
    {"<mass value=\"4.1\"/>", "<mass value=\"nan\"/>", "robot_description of 'arm':27:"},
    {"<link name=\"tool0\"/>", "<link name=\"tool1\"/>", "tool0"},
    {NULL, "", "robot_description of 'arm'"},
};

static void refuse_description(const bad_description *b)
{
    char *text = b->from != NULL ? replace(variants[0].text, b->from, b->to) : strdup(b->to);
    publish_description(node.description, text);
    assert_int_equal(arm_await_diagnostic(&node, MODEL_STATUS, b->says), LEVEL_ERROR);
    free(text);
}

/* Good descriptions, and some that are reported and change nothing. */
TEST(models_are_exchanged_under_load)
{
    static load l;
    static arm_witness c; /* of shared memory: served meanwhile, by either model */
    unsigned refused = 0;
    publish_description(node.description, variants[0].text);
    await_variant(0);
    arm_settle(&node); /* the answers to count are those to the load */
    atomic_store(&l.model, -1);
    assert_int_equal(pthread_create(&l.thread, NULL, run_load, &l), 0);
    arm_witness_start(&c, &running, false);
    await_model(&l, 0);
    for (int i = 1; i <= SWAPS; i++) {
        publish_description(node.description, variants[i % 2].text);
        await_model(&l, i % 2);
        if (i % 10 == 5) {
            refuse_description(&bad[refused++ % (sizeof bad / sizeof *bad)]);
            await_model(&l, i % 2);
        }
    }
    atomic_store(&l.stop, true);
    pthread_join(l.thread, NULL);
    if (l.error != NULL)
        fail_msg("command %u: %s", l.answered, l.error);
    assert_int_equal(l.answered, l.sent);
    arm_witness_stop(&c);
    print_message("%u commands over ROS 2 and %u requests over shared memory answered\n", l.sent,
                  c.asked);
}

/* The other robot's topics, and the state that is published there. */
typedef struct other_node {
    dds_entity_t description, states, efforts, accelerations;
    tfa_model *model;
    uint32_t joints;
    char *name[MANY_JOINTS];
    double q[MANY_JOINTS], v[MANY_JOINTS], tau[MANY_JOINTS], qdd[MANY_JOINTS];
} other_node;

static void open_other(other_node *o)
{
    const dds_topic_descriptor_t *state = &sensor_msgs_msg_dds__JointState__desc;
    const dds_entity_t p = node.participant;
    o->description = ros2_peer_writer(p, &std_msgs_msg_dds__String__desc,
                                      "rt/other/robot_description", PEER_TRANSIENT_LOCAL);
    o->states = ros2_peer_writer(p, state, "rt/other/joint_states", PEER_DEFAULT);
    o->efforts = ros2_peer_writer(p, state, "rt/other/efforts", PEER_DEFAULT);
    o->accelerations = ros2_peer_reader(p, &trajectory_msgs_msg_dds__JointTrajectory__desc,
                                        "rt/other/totalforce/accelerations", PEER_DEFAULT);
}

/* A random state of the model, and its answer. */
static void move_other(other_node *o, const char *file)
{
    uint64_t seed = 17;
    const tfa_request request = request_fd(o->q, o->v, o->tau);
    tfa_reply reply = {.qdd = o->qdd};
    o->model = bundled_model(file, NULL);
    o->joints = tfa_model_joint_count(o->model);
    assert_true(o->joints <= MANY_JOINTS);
    SCOPED_WORKSPACE *workspace = workspace_for(o->model, NULL);
    for (uint32_t j = 0; j < o->joints; j++) {
        o->name[j] = (char *)(uintptr_t)tfa_model_joint(o->model, j).name;
        o->q[j] = 0.3 * test_random(&seed);
        o->v[j] = test_random(&seed);
        o->tau[j] = test_random(&seed);
    }
    assert_int_equal(tfa_compute(workspace, &request, &reply), TFA_OK);
}

static bool is_answer_of(const other_node *o, const trajectory_msgs_msg_dds__JointTrajectory_ *m)
{
    const dds_sequence_double *qdd = &m->points._buffer[0].accelerations;
    if (m->joint_names._length != o->joints || qdd->_length != o->joints)
        return false;
    for (uint32_t j = 0; j < o->joints; j++)
        if (strcmp(m->joint_names._buffer[j], o->name[j]) != 0)
            return false;
    return memcmp(qdd->_buffer, o->qdd, o->joints * sizeof *o->qdd) == 0;
}

static bool is_answered(const other_node *o, const sensor_msgs_msg_dds__JointState_ *state,
                        const sensor_msgs_msg_dds__JointState_ *efforts)
{
    static trajectory_msgs_msg_dds__JointTrajectory_ m;
    assert_int_equal(dds_write(o->states, state), DDS_RETCODE_OK);
    assert_int_equal(dds_write(o->efforts, efforts), DDS_RETCODE_OK);
    return ros2_peer_take(o->accelerations, &m, 20) && is_answer_of(o, &m);
}

/* Other joints, more and fewer: the answers bear their names. */
static void assert_other_joints(other_node *o, const char *file)
{
    move_other(o, file);
    SCOPED_TEXT *text = bundled_text(file);
    const sensor_msgs_msg_dds__JointState_ state = {.name = PEER_SEQUENCE(o->joints, o->name),
                                                    .position = PEER_SEQUENCE(o->joints, o->q),
                                                    .velocity = PEER_SEQUENCE(o->joints, o->v)};
    const sensor_msgs_msg_dds__JointState_ efforts = {.name = PEER_SEQUENCE(o->joints, o->name),
                                                      .effort = PEER_SEQUENCE(o->joints, o->tau)};
    publish_description(o->description, text);
    assert_true(WAIT_FOR(is_answered(o, &state, &efforts)));
    assert_int_equal(arm_await_diagnostic(&node, "other/totalforce: model",
                                          strndupa(tfa_model_hash_text(o->model), 16)),
                     LEVEL_OK);
    SCOPED_CLIENT *client = harness_connect(&running, "other", TFA_WAIT_BLOCK);
    assert_int_equal(tfa_client_get_info(client)->v_count, o->joints);
    tfa_model_free(o->model);
}

TEST(a_description_with_other_joints_changes_them)
{
    static other_node o;
    tfa_client *client = harness_connect(&running, "other", TFA_WAIT_BLOCK);
    double qdd[JOINTS];
    assert_int_equal(tfa_client_get_info(client)->v_count, 7);
    open_other(&o);
    assert_other_joints(&o, "snake64.urdf");
    assert_int_equal(ask_arm(client, 0.1, qdd, WAIT_NS), TFA_E_DISCONNECTED);
    tfa_client_close(client);
    assert_other_joints(&o, "arm6.urdf"); /* after a rest */
}

/* robot_state_publisher may have started first. */
TEST(a_description_from_before_the_start_is_read)
{
    publish_description(node.description, variants[1].text);
    assert_int_equal(harness_stop(&running, SIGTERM), 0);
    harness_start(&running, "arm");
    await_variant(1);
}

static int serve(void **state)
{
    (void)state;
    make_variants();
    running = harness_serve(
        arm_yaml("      joints: [joint_1, joint_2, joint_3, joint_4, joint_5, joint_6, joint_7]\n"
                 "  - name: other\n    urdf: @/config/robots/arm7.urdf\n    ros2: {enabled: "
                 "yes, namespace: /other, joint_efforts: efforts, robot_description: "
                 "robot_description, state_age_ms: 3600000, command_age_ms: 3600000}\n"),
        arm_settings(""));
    arm_node_open(&node);
    return 0;
}

static int stop(void **state)
{
    (void)state;
    arm_node_close(&node);
    harness_remove(&running);
    free_variants();
    return 0;
}

int main(void)
{
    return test_run(serve, stop);
}
