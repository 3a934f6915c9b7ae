/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Publishers that flood the topics of a robot, with messages of any length and content: the daemon
 * answers its clients of shared memory and its other robots all the while, its memory is bounded,
 * and the robot is answered again when they have gone. A subscriber that stands still holds up
 * nobody.
 */
#include "dds/dds_test.h"

#include "floods.h"
#include "ros2_arm.h"

#include <signal.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#define CALLS 200        /* beside each attack, which lasts so long at least */
#define ATTACK_US 300000 /* in its periods: messages that are sent without one being late */
#define GROWN_KIB 100000 /* 16 MiB were seen; queues and histories are bounded by numbers */
#define COMMANDS 1000
/* The log's limit, of each kind of line (platform/log.c), and two lines that count the others */
#define WINDOW_NS (UINT64_C(1) << 33)
#define WINDOW_LINES 22

static harness running;
static arm_node node;
static double right_answer[JOINTS];

/* Of this thread; 0: the ordinary scheduler. @return it is permitted */
static bool set_priority(int priority)
{
    const struct sched_param q = {.sched_priority = priority};
    return pthread_setschedparam(pthread_self(), priority ? SCHED_FIFO : SCHED_OTHER, &q) == 0;
}

/* ---- a client and another robot ---- */

/* A call over shared memory is answered, and right. */
static void call(tfa_client *client)
{
    double qdd[JOINTS];
    assert_int_equal(ask_arm(client, 0.1, qdd, WAIT_NS), TFA_OK);
    assert_memory_equal(qdd, right_answer, sizeof qdd);
}

static arm_node other;

static bool is_other_answered(void)
{
    static trajectory_msgs_msg_dds__JointTrajectory_ m;
    const arm_motion motion = arm_motion_of(3);
    arm_publish_state(&other, &motion, 1);
    arm_publish_named_efforts(&other, arm_joints, motion.tau, JOINTS, 1);
    return ros2_peer_take(other.accelerations, &m, 100);
}

/* The other robot of the daemon. */
static void assert_other_is_answered(void)
{
    assert_true(WAIT_FOR(is_other_answered()));
}

/* Memory is measured where nothing else is kept, as freed blocks are by a sanitizer. */
static void assert_bounded(long grown)
{
#ifdef TFA_INSTRUMENTED
    (void)grown;
#else
    assert_true(grown < GROWN_KIB);
#endif
}

static void check_attack(tfa_client *client, const flood *how)
{
    static flooder f;
    const long before = harness_resident_kib(&running);
    int calls = 0;
    flooder_start(&f, how, node.domain);
    assert_true(WAIT_FOR(
        (call(client), ++calls >= CALLS && atomic_load(&f.written) * how->period_us > ATTACK_US)));
    assert_other_is_answered();
    const uint64_t written = flooder_stop(&f);
    const long grown = harness_resident_kib(&running) - before;
    print_message("%-24s %7llu messages, %5d calls, grown %6ld KiB\n", how->name,
                  (unsigned long long)written, calls, grown);
    assert_bounded(grown);
    arm_assert_answered(&node);
}

static void open_other(void)
{
    const dds_entity_t p = other.participant = ros2_peer_open(node.domain);
    const dds_topic_descriptor_t *state = &sensor_msgs_msg_dds__JointState__desc;
    other.joint_states = ros2_peer_writer(p, state, "rt/other/joint_states", PEER_DEFAULT);
    other.joint_efforts = ros2_peer_writer(p, state, "rt/other/efforts", PEER_DEFAULT);
    other.accelerations = ros2_peer_reader(p, &trajectory_msgs_msg_dds__JointTrajectory__desc,
                                           "rt/other/totalforce/accelerations", PEER_DEFAULT);
}

static void start(const char *more)
{
    running = harness_serve(
        arm_yaml("  - name: other\n    urdf: @/config/robots/arm7.urdf\n"
                 "    ros2: {enabled: yes, namespace: /other, joint_efforts: efforts, "
                 "robot_description: robot_description, state_age_ms: 3600000, "
                 "command_age_ms: 3600000}\n"),
        arm_settings(more));
}

static void open_nodes(void)
{
    arm_node_open(&node);
    (void)ros2_peer_reader(node.participant, &sensor_msgs_msg_dds__JointState__desc, "rt/elsewhere",
                           PEER_SENSOR);
    open_other();
}

static void serve(const char *more)
{
    start(more);
    open_nodes();
}

static void stop(void)
{
    arm_node_close(&other);
    arm_node_close(&node);
    harness_remove(&running);
}

/* @param begin  ns, before the start of the daemon */
static void check_attacks(uint64_t begin)
{
    static const char line[] = "a robot_description of";
    tfa_client *client = harness_connect(&running, "arm", TFA_WAIT_BLOCK);
    assert_int_equal(ask_arm(client, 0.1, right_answer, WAIT_NS), TFA_OK);
    for (size_t k = 0; k < flood_count; k++)
        check_attack(client, &floods[k]);
    tfa_client_close(client);
    const unsigned lines = harness_log_lines(&running, line);
    const uint64_t windows = (now_ns() - begin) / WINDOW_NS + 2; /* the first and the last, too */
    print_message("%u lines in the log, %u about descriptions\n", harness_log_lines(&running, ""),
                  lines);
    assert_in_range(lines, 1, WINDOW_LINES * windows);
}

/* A process that subscribes to every answer, reliably, and stops; when it goes on, it ends.
 * @return its id */
static pid_t start_stopped_subscriber(void)
{
    static const struct {
        const dds_topic_descriptor_t *type;
        const char *topic;
    } answers[] = {
        {&trajectory_msgs_msg_dds__JointTrajectory__desc, "rt/arm/totalforce/accelerations"},
        {&std_msgs_msg_dds__Float64MultiArray__desc, "rt/arm/totalforce/lambda_inv"},
        {&std_msgs_msg_dds__Float64MultiArray__desc, "rt/arm/totalforce/jacobian"},
        {&std_msgs_msg_dds__Float64MultiArray__desc, "rt/arm/totalforce/bias_acceleration"},
        {&sensor_msgs_msg_dds__JointState__desc, "rt/arm/totalforce/gravity_torques"},
        {&diagnostic_msgs_msg_dds__DiagnosticArray__desc, "rt/diagnostics"},
    };
    int status;
    const pid_t child = fork();
    if (child == 0) {
        static diagnostic_msgs_msg_dds__DiagnosticArray_ sample;
        dds_entity_t reader = 0;
        (void)prctl(PR_SET_PDEATHSIG, SIGKILL);
        const dds_entity_t p = ros2_peer_open(arm_domain());
        for (size_t k = 0; k < sizeof answers / sizeof *answers; k++) {
            reader = ros2_peer_reader(p, answers[k].type, answers[k].topic, PEER_DEFAULT);
            ros2_peer_await_writer(reader);
        }
        /* of the reader that was announced last: the daemon has matched all of them */
        assert_true(ros2_peer_take(reader, &sample, WAIT_MS));
        raise(SIGSTOP);
        _exit(dds_delete(p) == DDS_RETCODE_OK ? 0 : 1); /* says good-bye */
    }
    assert_int_equal(waitpid(child, &status, WUNTRACED), child);
    assert_true(WIFSTOPPED(status));
    return child;
}

/* A subscriber of every answer that is reliable and reads and acknowledges nothing. Forks before
 * this process joins the domain: first. */
TEST(a_stopped_subscriber_holds_nobody_up)
{
    static trajectory_msgs_msg_dds__JointTrajectory_ m;
    start("");
    const pid_t child = start_stopped_subscriber();
    open_nodes();
    const long before = harness_resident_kib(&running);
    for (int32_t k = 0; k < COMMANDS; k++) {
        const arm_motion motion = arm_motion_of((uint64_t)k);
        arm_publish_state(&node, &motion, k);
        arm_publish_named_efforts(&node, arm_joints, motion.tau, JOINTS, k);
        assert_true(ros2_peer_take(node.accelerations, &m, WAIT_MS));
        assert_int_equal(m.header.stamp.sec, k);
    }
    assert_bounded(harness_resident_kib(&running) - before);
    assert_other_is_answered();
    assert_int_equal(kill(child, SIGCONT), 0);
    assert_int_equal(child_end(child), 0);
    stop();
}

TEST(clients_and_other_robots_are_served_under_attack)
{
    const uint64_t begin = now_ns();
    serve("");
    check_attacks(begin);
    stop();
}

/* The same for a worker and a client that have the priority that they should have. */
TEST(real_time_clients_are_served_under_attack)
{
    if (!set_priority(20)) {
        print_message("skipped: no permission for SCHED_FIFO\n");
        return;
    }
    (void)set_priority(0);
    const uint64_t begin = now_ns();
    serve("realtime: {priority: 20}\n");
    (void)set_priority(20);
    check_attacks(begin);
    (void)set_priority(0);
    stop();
}

#define PUBLISHERS 200

/* Of the arm's states, as the daemon knows them */
static uint32_t publishers(void)
{
    const tfa_ros2_statistics s = arm_statistics(&running, "arm");
    for (uint32_t k = 0; k < s.input_count; k++)
        if (strcmp(s.inputs[k].name, "/arm/joint_states") == 0)
            return s.inputs[k].publishers;
    return 0;
}

TEST(hundreds_of_publishers_come_and_go)
{
    serve("");
    const long before = harness_resident_kib(&running);
    for (int turn = 0; turn < 3; turn++) {
        const dds_entity_t p = ros2_peer_open(node.domain);
        for (int k = 0; k < PUBLISHERS; k++) {
            const dds_entity_t w = ros2_peer_writer(p, &sensor_msgs_msg_dds__JointState__desc,
                                                    "rt/arm/joint_states", PEER_SENSOR);
            uint64_t seed = (uint64_t)k;
            flood_states(w, &seed);
        }
        assert_true(WAIT_FOR(publishers() == PUBLISHERS + 1));
        assert_other_is_answered();
        assert_int_equal(dds_delete(p), DDS_RETCODE_OK);
        assert_true(WAIT_FOR(publishers() == 1)); /* of this node */
    }
    const long grown = harness_resident_kib(&running) - before;
    print_message("3 times %d publishers: grown %ld KiB\n", PUBLISHERS, grown);
    assert_bounded(grown);
    arm_assert_answered(&node);
    stop();
}

int main(void)
{
    return test_run(NULL, NULL);
}
