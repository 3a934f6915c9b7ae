/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Publishers that flood the topics of a robot, with messages of any length and content: the daemon
 * answers its clients of shared memory and its other robots all the while, its memory is bounded,
 * and the robot is answered again when they have gone.
 */
#include "dds/dds_test.h"

#include "models.h"
#include "ros2_arm.h"

#include <idl/ros2_service.h>
#include <math.h>
#include <pthread.h>
#include <signal.h>
#include <stdatomic.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#define ATTACK_MS 600    /* each */
#define PERIOD_US 100    /* 10 kHz */
#define GROWN_KIB 100000 /* 16 MiB were seen */
#define MEDIAN_RATIO 60  /* a busy machine; 12 was the largest on an idle one */
#define LOG_LINES 1000   /* 192 were seen; a line for each bad description would be more */
#define MANY_NAMES 5000
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

/* ---- attackers ---- */

typedef struct attack {
    const char *name;
    const dds_topic_descriptor_t *type;
    const char *topic;
    ros2_peer_qos qos;
    void (*write)(dds_entity_t writer, uint64_t *seed);
    unsigned period_us;
} attack;

static void write_state(dds_entity_t writer, char **name, uint32_t names, double *number,
                        uint32_t numbers)
{
    const sensor_msgs_msg_dds__JointState_ m = {.header = {{1, 2}, "x"},
                                                .name = PEER_SEQUENCE(names, name),
                                                .position = PEER_SEQUENCE(numbers, number),
                                                .velocity = PEER_SEQUENCE(numbers, number),
                                                .effort = PEER_SEQUENCE(numbers, number)};
    (void)dds_write(writer, &m);
}

static void flood_states(dds_entity_t writer, uint64_t *seed)
{
    double q[JOINTS];
    for (int j = 0; j < JOINTS; j++)
        q[j] = test_random(seed);
    write_state(writer, arm_joints, JOINTS, q, JOINTS);
}

static void flood_nan(dds_entity_t writer, uint64_t *seed)
{
    double q[JOINTS] = {NAN, INFINITY, -INFINITY, 1e308, 1e308, 1e308, NAN};
    (void)seed;
    write_state(writer, arm_joints, JOINTS, q, JOINTS);
}

/* Thousands of names, none of the robot's; or a few that are very long; or empty ones. */
static void flood_names(dds_entity_t writer, uint64_t *seed)
{
    static char *name[MANY_NAMES], text[MANY_NAMES][12], longest[1000000];
    static double number[MANY_NAMES];
    char *few[] = {longest, longest + 950000, "", ""};
    if (name[0] == NULL)
        memset(longest, 'x', sizeof longest - 1);
    for (int k = 0; k < MANY_NAMES && name[MANY_NAMES - 1] == NULL; k++) {
        snprintf(text[k], sizeof text[k], "joint%d", k);
        name[k] = text[k];
    }
    if (test_random(seed) < 0)
        write_state(writer, name, MANY_NAMES, number, MANY_NAMES);
    else
        write_state(writer, few, 4, number, 4);
}

static void flood_efforts(dds_entity_t writer, uint64_t *seed)
{
    double tau[JOINTS];
    for (int j = 0; j < JOINTS; j++)
        tau[j] = test_random(seed);
    const std_msgs_msg_dds__Float64MultiArray_ m = {.data = PEER_SEQUENCE(JOINTS, tau)};
    (void)dds_write(writer, &m);
}

/* 80 kB, 0.8 MB, or 8 MB: more than the domain takes. */
static void flood_arrays(dds_entity_t writer, uint64_t *seed)
{
    static double numbers[1000000];
    const uint32_t sizes[] = {10000, 100000, 1000000};
    const uint32_t size = sizes[(uint32_t)(1.4 * (test_random(seed) + 1))];
    const std_msgs_msg_dds__Float64MultiArray_ m = {.data = PEER_SEQUENCE(size, numbers)};
    (void)dds_write(writer, &m);
}

/* Bytes that pass for a JointState by their type's name. */
static void flood_bytes(dds_entity_t writer, uint64_t *seed)
{
    test_msg_dds__Bytes_ m;
    for (size_t k = 0; k < sizeof m.data; k++)
        m.data[k] = k % 4 ? 0 : (uint8_t)(64 * (test_random(seed) + 1));
    (void)dds_write(writer, &m);
}

/* A state with a frame of 1 MB */
static void flood_frames(dds_entity_t writer, uint64_t *seed)
{
    static char text[1000000];
    double q[JOINTS] = {test_random(seed)};
    memset(text, 'x', sizeof text - 1);
    const sensor_msgs_msg_dds__JointState_ m = {.header = {{1, 2}, text},
                                                .name = PEER_SEQUENCE(JOINTS, arm_joints),
                                                .position = PEER_SEQUENCE(JOINTS, q)};
    (void)dds_write(writer, &m);
}

/* A trajectory of 1 MB, of points without anything or of one point */
static void flood_points(dds_entity_t writer, uint64_t *seed)
{
    static trajectory_msgs_msg_dds__JointTrajectoryPoint_ points[40000];
    static double numbers[120000];
    trajectory_msgs_msg_dds__JointTrajectoryPoint_ one = {.velocities =
                                                              PEER_SEQUENCE(120000, numbers)};
    trajectory_msgs_msg_dds__JointTrajectory_ m = {.header = {{1, 2}, ""},
                                                   .points = PEER_SEQUENCE(40000, points)};
    if (test_random(seed) < 0)
        m.points =
            (dds_sequence_trajectory_msgs_msg_dds__JointTrajectoryPoint_)PEER_SEQUENCE(1, &one);
    (void)dds_write(writer, &m);
}

/* A layout of 1 MB, of many dimensions or of one label */
static void flood_layouts(dds_entity_t writer, uint64_t *seed)
{
    static std_msgs_msg_dds__MultiArrayDimension_ dimensions[60000];
    static char text[1000000];
    double tau[JOINTS] = {0};
    const bool many = test_random(seed) < 0;
    const uint32_t count = many ? 60000 : 1;
    memset(text, 'x', sizeof text - 1);
    for (uint32_t k = 0; k < count; k++)
        dimensions[k].label = many ? "" : text;
    const std_msgs_msg_dds__Float64MultiArray_ m = {.layout = {PEER_SEQUENCE(count, dimensions), 0},
                                                    .data = PEER_SEQUENCE(JOINTS, tau)};
    (void)dds_write(writer, &m);
}

/* Each another one, all bad, of almost the length that is read. */
static void flood_descriptions(dds_entity_t writer, uint64_t *seed)
{
    static char text[1000000];
    memset(text, 'x', sizeof text - 1);
    snprintf(text, 64, "<robot name='%.17g'><link", test_random(seed));
    text[strlen(text)] = ' ';
    const std_msgs_msg_dds__String_ m = {text};
    (void)dds_write(writer, &m);
}

/* Short ones, each with many errors. */
static void flood_short_descriptions(dds_entity_t writer, uint64_t *seed)
{
    static char text[8192];
    size_t used = (size_t)snprintf(text, sizeof text, "<robot name='%.17g'>", test_random(seed));
    for (int k = 0; k < 100; k++)
        used += (size_t)snprintf(text + used, sizeof text - used, "<link name='l%d' mass='x'/>", k);
    snprintf(text + used, sizeof text - used, "<joint name='j'/></robot>");
    const std_msgs_msg_dds__String_ m = {text};
    (void)dds_write(writer, &m);
}

/* Each another one, all good: the model is exchanged as often as the daemon can. */
static void flood_good_descriptions(dds_entity_t writer, uint64_t *seed)
{
    static char file[65536], text[66000];
    static const char mass[] = "<mass value=\"2.8\"/>";
    if (file[0] == 0) {
        FILE *in = fopen(TFA_SOURCE_DIR "/config/robots/arm7.urdf", "r");
        assert_non_null(in);
        assert_true(fread(file, 1, sizeof file - 1, in) > 0);
        fclose(in);
    }
    const char *at = strstr(file, mass);
    assert_non_null(at);
    snprintf(text, sizeof text, "%.*s<mass value=\"%.17g\"/>%s", (int)(at - file), file,
             3 + test_random(seed), at + sizeof mass - 1);
    const std_msgs_msg_dds__String_ m = {text};
    (void)dds_write(writer, &m);
}

static dds_topic_descriptor_t bytes_as_state;

/* The first one is no attack: what the publisher costs by itself, on the processors of all. */
static const attack attacks[] = {
    {"elsewhere at 10 kHz", &sensor_msgs_msg_dds__JointState__desc, "rt/elsewhere", PEER_SENSOR,
     flood_states, PERIOD_US},
    {"states at 10 kHz", &sensor_msgs_msg_dds__JointState__desc, "rt/arm/joint_states", PEER_SENSOR,
     flood_states, PERIOD_US},
    {"efforts at 10 kHz", &std_msgs_msg_dds__Float64MultiArray__desc,
     "rt/arm/effort_controller/commands", PEER_DEFAULT, flood_efforts, PERIOD_US},
    {"NaN at 10 kHz", &sensor_msgs_msg_dds__JointState__desc, "rt/arm/joint_efforts", PEER_DEFAULT,
     flood_nan, PERIOD_US},
    {"5000 names, long names", &sensor_msgs_msg_dds__JointState__desc, "rt/arm/joint_states",
     PEER_SENSOR, flood_names, 1000},
    {"huge arrays", &std_msgs_msg_dds__Float64MultiArray__desc, "rt/arm/effort_controller/commands",
     PEER_SENSOR, flood_arrays, 10000},
    {"long frames", &sensor_msgs_msg_dds__JointState__desc, "rt/arm/joint_states", PEER_SENSOR,
     flood_frames, 10000},
    {"many points", &trajectory_msgs_msg_dds__JointTrajectory__desc, "rt/arm/trajectory",
     PEER_DEFAULT, flood_points, 10000},
    {"long layouts", &std_msgs_msg_dds__Float64MultiArray__desc,
     "rt/arm/effort_controller/commands", PEER_DEFAULT, flood_layouts, 10000},
    {"bytes", &bytes_as_state, "rt/arm/joint_states", PEER_SENSOR, flood_bytes, PERIOD_US},
    {"bad descriptions", &std_msgs_msg_dds__String__desc, "rt/arm/robot_description",
     PEER_TRANSIENT_LOCAL, flood_descriptions, 10000},
    {"short bad descriptions", &std_msgs_msg_dds__String__desc, "rt/arm/robot_description",
     PEER_TRANSIENT_LOCAL, flood_short_descriptions, 1000},
    {"good descriptions", &std_msgs_msg_dds__String__desc, "rt/other/robot_description",
     PEER_TRANSIENT_LOCAL, flood_good_descriptions, 1000},
};

#define ATTACKS (sizeof attacks / sizeof *attacks)

typedef struct attacker {
    const attack *how;
    pthread_t thread;
    _Atomic bool stop;
    uint64_t written;
} attacker;

static void *run_attacker(void *arg)
{
    attacker *a = arg;
    uint64_t seed = 1;
    const dds_entity_t p = ros2_peer_open(node.domain);
    const dds_entity_t writer = ros2_peer_writer(p, a->how->type, a->how->topic, a->how->qos);
    uint64_t next = now_ns();

    (void)set_priority(0); /* inherited */
    ros2_peer_await_reader(writer);
    while (!atomic_load(&a->stop)) {
        a->how->write(writer, &seed);
        a->written++;
        next += 1000u * a->how->period_us;
        const uint64_t now = now_ns();
        if (now < next)
            dds_sleepfor((dds_duration_t)(next - now));
        else
            next = now;
    }
    assert_int_equal(dds_delete(p), DDS_RETCODE_OK);
    return NULL;
}

/* ---- the victims ---- */

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

static void check_attack(tfa_client *client, const attack *how, const latency *quiet)
{
    static attacker a;
    const long before = harness_resident_kib(&running);

    a = (attacker){.how = how};
    assert_int_equal(pthread_create(&a.thread, NULL, run_attacker, &a), 0);
    const latency l = call_for(client, ATTACK_MS);
    assert_other_is_answered();
    atomic_store(&a.stop, true);
    pthread_join(a.thread, NULL);
    const long grown = harness_resident_kib(&running) - before;
    print_message("%-24s %7llu messages, grown %6ld KiB, median %.2f, p99 %.2f of the quiet ones\n",
                  how->name, (unsigned long long)a.written, grown, l.median_us / quiet->median_us,
                  l.p99_us / quiet->p99_us);
    assert_true(a.written > 10);
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
    memcpy(&bytes_as_state, &test_msg_dds__Bytes__desc, sizeof bytes_as_state);
    bytes_as_state.m_typename = sensor_msgs_msg_dds__JointState__desc.m_typename;
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
    for (size_t k = 0; k < ATTACKS; k++)
        check_attack(client, &attacks[k], &quiet);
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
