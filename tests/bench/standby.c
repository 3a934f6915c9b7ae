/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Hot standby, measured: how long nobody answers when the daemon that leads is killed, stopped or
 * ended, and whether a leader is replaced for nothing while a standby is stopped and in SECONDS of
 * full load. Prints figures for a machine that has nothing else to do; they are no verdict.
 *
 *   bench_standby [TRIALS [SECONDS [LEASE_MS]]]    10 of each kind, 60, 500
 *
 * Good is a median of at most the lease and 5 ms, 5 ms when the leader ends, and nobody replaced
 * for nothing, that is while all processors run.
 */
#include "dds/standby_pair.h"
#include "stalls.h"
#include "test.h"

#include <signal.h>

#define TRIALS_MAX 1000

static int trials = 10, quiet_seconds = 60, lease_ms = 500;

static int by_size(const void *a, const void *b)
{
    const uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
    return x < y ? -1 : x > y;
}

static void measure(const char *kind, void (*strike)(void))
{
    static uint64_t gaps[TRIALS_MAX];
    for (int i = 0; i < trials; i++)
        gaps[i] = pair_fail_over(strike);
    qsort(gaps, (size_t)trials, sizeof *gaps, by_size);
    print_message("%s, %d trials: nobody answered for %.1f ms (median), %.1f ms (most); lease %d "
                  "ms\n",
                  kind, trials, 1e-6 * (double)gaps[trials / 2], 1e-6 * (double)gaps[trials - 1],
                  lease_ms);
}

/* A call under way when the leader changes is sent again, and both leaders may answer it. */
static void report_wire(void)
{
    const wire_counts w = wire_observer_count();
    print_message("on the wire: %llu replies to %llu calls (%llu failed, %llu wrong), %llu "
                  "accelerations to %llu torques; %llu repeated and %llu outdated in %llu "
                  "takeovers\n",
                  (unsigned long long)w.replies, (unsigned long long)atomic_load(&pair.answered),
                  (unsigned long long)atomic_load(&pair.failed),
                  (unsigned long long)atomic_load(&pair.wrong), (unsigned long long)w.accelerations,
                  (unsigned long long)w.published, (unsigned long long)w.repeated,
                  (unsigned long long)w.outdated, (unsigned long long)w.takeovers);
}

static void stop_standby(void)
{
    const unsigned before = pair_leaderships();
    for (int i = 0; i < trials; i++) {
        pair_settle();
        harness_pause(pair.standby);
        sleep_ms(3 * (unsigned)lease_ms);
        assert_int_equal(kill(pair.standby->pid, SIGCONT), 0);
        sleep_ms(3 * (unsigned)lease_ms);
    }
    print_message("standby stopped and continued, %d trials: replaced the leader %u times\n",
                  trials, pair_leaderships() - before);
}

static void show_leadership(void)
{
    char text[256];
    for (int i = 0; i < 2; i++)
        if (pair_leadership(&pair.nodes[i], text, sizeof text))
            print_message("daemon %d: %s\n", i, text);
}

/* A leader without a processor is replaced, rightly: that is counted apart. */
static void load_fully(void)
{
    const uint64_t lease_ns = (uint64_t)lease_ms * 1000000u;
    const uint64_t from = atomic_load(&pair.answered);
    const uint64_t end = now_ns() + (uint64_t)quiet_seconds * 1000000000u;
    unsigned seen = pair_leaderships(), stalled = 0, replaced = 0;
    stalls_start(lease_ns / 2);
    pair_load();
    while (now_ns() < end) {
        sleep_ms(10);
        const unsigned more = pair_leaderships() - seen;
        seen += more;
        *(now_ns() - stalls_last() < 2 * lease_ns ? &stalled : &replaced) += more;
    }
    print_message("full load for %d s: %llu calls, replaced for nothing %u times, while a "
                  "processor stood still %u times (it did %u times, for %.1f ms at most)\n",
                  quiet_seconds, (unsigned long long)(atomic_load(&pair.answered) - from), replaced,
                  stalled, stalls_count(), 1e-6 * (double)stalls_longest_ns());
    stalls_stop();
    show_leadership();
}

TEST(standby)
{
    pair_start(lease_ms);
    measure("SIGKILL", pair_kill_leader);
    measure("SIGSTOP", pair_pause_leader);
    measure("SIGTERM", pair_end_leader);
    report_wire();
    stop_standby();
    load_fully();
    report_wire();
    pair_stop();
}

int main(int argc, char **argv)
{
    if (argc > 1 && atoi(argv[1]) > 0 && atoi(argv[1]) <= TRIALS_MAX)
        trials = atoi(argv[1]);
    if (argc > 2 && atoi(argv[2]) > 0)
        quiet_seconds = atoi(argv[2]);
    if (argc > 3 && atoi(argv[3]) > 0)
        lease_ms = atoi(argv[3]);
    return test_run(NULL, NULL);
}
