/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Floods on topics of ROS 2: the times of a client of shared memory beside each, as multiples of
 * those without one, and what the daemon has grown. Under the ordinary scheduler, then with the
 * priorities of the documentation, where they are permitted.
 */
#include "dds/dds_test.h"

#include "floods.h"
#include "ros2_arm.h"

#include <signal.h>
#include <stdlib.h>

#define ATTACK_NS 600000000u /* each */
#define CALLS_MAX 100000

static harness running;
static arm_node node;

typedef struct latency {
    double median_us, p99_us;
} latency;

static int by_value(const void *a, const void *b)
{
    const uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
    return (x > y) - (x < y);
}

static latency measure(tfa_client *client)
{
    static uint64_t ns[CALLS_MAX];
    const uint64_t end = now_ns() + ATTACK_NS;
    size_t count = 0;
    do {
        double qdd[JOINTS];
        const uint64_t start = now_ns();
        assert_int_equal(ask_arm(client, 0.1, qdd, WAIT_NS), TFA_OK);
        ns[count++] = now_ns() - start;
        dds_sleepfor(DDS_USECS(500));
    } while (now_ns() < end && count < CALLS_MAX);
    qsort(ns, count, sizeof *ns, by_value);
    return (latency){1e-3 * (double)ns[count / 2], 1e-3 * (double)ns[count * 99 / 100]};
}

/* Of this thread; 0: the ordinary scheduler. @return it is permitted */
static bool set_priority(int priority)
{
    const struct sched_param q = {.sched_priority = priority};
    return pthread_setschedparam(pthread_self(), priority ? SCHED_FIFO : SCHED_OTHER, &q) == 0;
}

static void measure_flood(tfa_client *client, const flood *how, const latency *quiet)
{
    static flooder f;
    const long before = harness_resident_kib(&running);
    flooder_start(&f, how, node.domain);
    const latency l = measure(client);
    const uint64_t written = flooder_stop(&f);
    printf("%-24s %7llu messages, grown %6ld KiB, median %.2f, p99 %.2f of the quiet ones\n",
           how->name, (unsigned long long)written, harness_resident_kib(&running) - before,
           l.median_us / quiet->median_us, l.p99_us / quiet->p99_us);
}

static void measure_all(const char *more, int priority)
{
    running =
        harness_serve(arm_yaml("  - name: other\n    urdf: @/config/robots/arm7.urdf\n    ros2: "
                               "{enabled: yes, namespace: /other, robot_description: "
                               "robot_description}\n"),
                      arm_settings(more));
    arm_node_open(&node);
    (void)ros2_peer_reader(node.participant, &sensor_msgs_msg_dds__JointState__desc, "rt/elsewhere",
                           PEER_SENSOR);
    SCOPED_CLIENT *client = harness_connect(&running, "arm", TFA_WAIT_BLOCK);
    (void)set_priority(priority);
    const latency quiet = measure(client);
    printf("quiet: median %.1f us, p99 %.1f us\n", quiet.median_us, quiet.p99_us);
    for (size_t k = 0; k < flood_count; k++)
        measure_flood(client, &floods[k], &quiet);
    (void)set_priority(0);
    printf("%u lines in the log\n", harness_log_lines(&running, ""));
    arm_node_close(&node);
    harness_remove(&running);
}

TEST(ordinary_priority)
{
    measure_all("", 0);
}

TEST(real_time_priority)
{
    if (!set_priority(20)) {
        printf("left out: no permission for SCHED_FIFO\n");
        return;
    }
    (void)set_priority(0);
    measure_all("realtime: {priority: 20}\n", 20);
}

int main(void)
{
    return test_run(NULL, NULL);
}
