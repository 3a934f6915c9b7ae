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
#include <sys/wait.h>
#include <unistd.h>

#define ATTACK_MS 600    /* each */
#define GROWN_KIB 100000 /* 16 MiB were seen */
#define MEDIAN_RATIO 60  /* a busy machine; 12 was the largest on an idle one */
#define LOG_LINES 1000   /* 192 were seen; a line for each bad description would be more */
#define COMMANDS 2000
#define CALLS_MAX 100000

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

typedef struct latency {
    double median_us, p99_us;
} latency;

static int by_value(const void *a, const void *b)
{
    const uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
    return (x > y) - (x < y);
}

/* Calls over shared memory for a while, each right. */
static latency call_for(tfa_client *client, unsigned ms)
{
    static uint64_t ns[CALLS_MAX];
    const uint64_t end = now_ns() + 1000000u * (uint64_t)ms;
    size_t count = 0;

    while (now_ns() < end && count < CALLS_MAX) {
        double qdd[JOINTS];
        const uint64_t start = now_ns();
        assert_int_equal(ask_arm(client, 0.1, qdd, WAIT_NS), TFA_OK);
        ns[count++] = now_ns() - start;
        assert_memory_equal(qdd, right_answer, sizeof qdd);
        dds_sleepfor(DDS_USECS(500));
    }
    qsort(ns, count, sizeof *ns, by_value);
    return (latency){1e-3 * (double)ns[count / 2], 1e-3 * (double)ns[count * 99 / 100]};
}

static arm_node other;

/* The other robot of the daemon. */
static void assert_other_is_answered(void)
{
    static trajectory_msgs_msg_dds__JointTrajectory_ m;
    const arm_motion motion = arm_motion_of(3);
    bool answered = false;

    for (int k = 0; k < 100 && !answered; k++) {
        arm_publish_state(&other, &motion, 1);
        arm_publish_named_efforts(&other, arm_joints, motion.tau, JOINTS, 1);
        answered = ros2_peer_take(other.accelerations, &m, 100);
    }
    assert_true(answered);
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

static void check_attack(tfa_client *client, const flood *how, const latency *quiet)
{
    static flooder f;
    const long before = harness_resident_kib(&running);

    flooder_start(&f, how, node.domain);
    const latency l = call_for(client, ATTACK_MS);
    assert_other_is_answered();
    const uint64_t written = flooder_stop(&f);
    const long grown = harness_resident_kib(&running) - before;
    print_message("%-24s %7llu messages, grown %6ld KiB, median %.2f, p99 %.2f of the quiet ones\n",
                  how->name, (unsigned long long)written, grown, l.median_us / quiet->median_us,
                  l.p99_us / quiet->p99_us);
    assert_true(written > 10);
    assert_true(l.median_us < MEDIAN_RATIO * quiet->median_us);
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
    harness_serve(&running,
                  arm_yaml("  - name: other\n    urdf: @/config/robots/arm7.urdf\n"
                           "    ros2: {enabled: yes, namespace: /other, joint_efforts: efforts, "
                           "robot_description: robot_description}\n"),
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
    assert_int_equal(harness_stop(&running, SIGTERM), 0);
    harness_remove(&running);
}

static void check_attacks(void)
{
    tfa_client *client = harness_connect(&running, "arm", TFA_WAIT_BLOCK);

    assert_int_equal(ask_arm(client, 0.1, right_answer, WAIT_NS), TFA_OK);
    const latency quiet = call_for(client, ATTACK_MS);
    print_message("quiet: median %.1f us, p99 %.1f us\n", quiet.median_us, quiet.p99_us);
    for (size_t k = 0; k < flood_count; k++)
        check_attack(client, &floods[k], &quiet);
    tfa_client_close(client);
    const unsigned lines = harness_log_lines(&running, "");
    print_message("%u lines in the log\n", lines);
    assert_true(lines < LOG_LINES);
}

/* A process that subscribes to every answer, reliably, and stops. @return its id */
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
        const dds_entity_t p = ros2_peer_open(arm_domain());
        for (size_t k = 0; k < sizeof answers / sizeof *answers; k++)
            ros2_peer_await_writer(
                ros2_peer_reader(p, answers[k].type, answers[k].topic, PEER_DEFAULT));
        dds_sleepfor(DDS_MSECS(300)); /* until the daemon has matched, too */
        raise(SIGSTOP);
        _exit(0);
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
        assert_true(ros2_peer_take(node.accelerations, &m, 10000));
        assert_int_equal(m.header.stamp.sec, k);
    }
    assert_bounded(harness_resident_kib(&running) - before);
    assert_other_is_answered();
    assert_int_equal(kill(child, SIGKILL), 0);
    assert_int_equal(waitpid(child, NULL, 0), child);
    stop();
}

TEST(clients_and_other_robots_are_served_under_attack)
{
    serve("");
    check_attacks();
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
    serve("realtime: {priority: 20}\n");
    (void)set_priority(20);
    check_attacks();
    (void)set_priority(0);
    stop();
}

#define PUBLISHERS 200

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
        dds_sleepfor(DDS_MSECS(500));
        assert_other_is_answered();
        assert_int_equal(dds_delete(p), DDS_RETCODE_OK);
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
