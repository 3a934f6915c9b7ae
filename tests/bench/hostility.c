/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * What a client that asks little feels of each kind of attack: its times beside hostile sessions
 * and, just before, without them. Prints a table; "queue" is the time from the client's store to
 * the worker's start, which the scheduler answers for.
 *
 *   bench_hostility [SAMPLES [THREADS [PRIORITY [URDF]]]]
 *
 * SAMPLES of each run, 3000; THREADS on one futex word, 500; PRIORITY of the worker (SCHED_FIFO),
 * 0: none; the robot that every kind of request is about, the bundled humanoid, floating.
 *
 * An attack may double the queue's median, or add as much as a few turns, and add max_state_us, 500
 * by default, to its 99th percentile; a row that shows more says so. That every request is
 * answered rightly meanwhile is a law: tests/service/hostile.c.
 */
#include "service/attacks.h"
#include "test.h"
#include "timing.h"

#include <signal.h>
#include <stdlib.h>
#include <unistd.h>

#define PERIOD_NS 200000 /* of the polite client */
#define TURN_NS 20000    /* the daemon's defaults */
#define MOST_US 500

static int samples = 3000, priority;
static const char *large = "@/config/robots/humanoid.urdf";

/* ---- the polite client ---- */

typedef struct figures {
    double queue[3], trip[3]; /* us: p50, p90, p99 */
} figures;

static void percentiles(double *us, int count, double p[3])
{
    qsort(us, (size_t)count, sizeof *us, by_value);
    p[0] = us[count / 2];
    p[1] = us[count * 9 / 10];
    p[2] = us[count * 99 / 100];
}

static figures ask_politely(tfa_client *client)
{
    double q[7], v[7], tau[7], qdd[7];
    const tfa_request r = arm_request(1, q, v, tau);
    double *queue = calloc((size_t)samples, sizeof *queue);
    double *trip = calloc((size_t)samples, sizeof *trip);
    figures f;
    assert_true(queue && trip);
    for (int i = 0; i < samples; i++) {
        const uint64_t begin = now_ns();
        tfa_reply reply = {.qdd = qdd};
        tfa_exchange x;
        assert_int_equal(tfa_client_call(client, &r, &reply, WAIT_NS, &x), TFA_OK);
        queue[i] = (double)(x.t_start - x.t_sent) * 1e-3;
        trip[i] = (double)(x.t_reply - x.t_sent) * 1e-3;
        const uint64_t spent = now_ns() - begin;
        if (spent < PERIOD_NS)
            usleep((useconds_t)((PERIOD_NS - spent) / 1000));
    }
    percentiles(queue, samples, f.queue);
    percentiles(trip, samples, f.trip);
    free(queue);
    free(trip);
    return f;
}

static const char *verdict(const figures *alone, const figures *beside)
{
    return beside->queue[0] > 2 * alone->queue[0] + 3e-3 * TURN_NS ? "  p50: more than withstood"
           : beside->queue[2] > alone->queue[2] + MOST_US          ? "  p99: more than withstood"
                                                                   : "";
}

static void print_row(const attack *a, const figures *alone, const figures *beside)
{
    print_message("%-32s %3d | %7.1f %7.1f | %7.1f %7.1f || %7.1f %7.1f | %7.1f %7.1f%s\n", a->name,
                  a->sessions, alone->queue[0], alone->queue[2], beside->queue[0], beside->queue[2],
                  alone->trip[0], alone->trip[2], beside->trip[0], beside->trip[2],
                  verdict(alone, beside));
}

static figures ask_beside(harness *h, tfa_client *polite, const attack *a)
{
    const pid_t child = attack_start(a, h);
    assert_true(WAIT_FOR(attack_steps() >= a->steps));
    const figures f = ask_politely(polite);
    attack_stop(child);
    return f;
}

static void compare(harness *h, tfa_client *polite, const attack *a)
{
    const attack loops = {"loops", a->sessions, attack_loop, (unsigned)a->sessions, true};
    const figures alone = a->busy ? ask_beside(h, polite, &loops) : ask_politely(polite);
    const figures beside = ask_beside(h, polite, a);
    print_row(a, &alone, &beside);
}

TEST(beside_attacks)
{
    char robots[400], more[300];
    snprintf(robots, sizeof robots, ARM "  - name: large\n    urdf: %s\n    base: floating\n",
             large);
    snprintf(more, sizeof more,
             "limits: {clients: 100, clients_per_user: 100, memory_mib: 2048, "
             "memory_mib_per_user: 2048}\nmax_state_us: 500\nlog: error\n"
             "realtime: {priority: %d}\n",
             priority);
    SCOPED_HARNESS h = harness_serve(robots, more);
    attack_robot = "large";
    SCOPED_CLIENT *polite = harness_connect(&h, "arm", TFA_WAIT_HYBRID);
    print_message("us, p50 and p99               sessions |      queue alone |    queue beside ||"
                  "  round trip alone |  round trip beside\n");
    for (size_t i = 0; i < attack_count; i++)
        compare(&h, polite, &attacks[i]);
}

int main(int argc, char **argv)
{
    signal(SIGPIPE, SIG_IGN);
    if (argc > 1)
        samples = atoi(argv[1]) > 100 ? atoi(argv[1]) : 100;
    if (argc > 2)
        attack_parked = atoi(argv[2]);
    if (argc > 3)
        priority = atoi(argv[3]);
    if (argc > 4)
        large = argv[4];
    return test_run(NULL, NULL);
}
