/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Hot standby, measured: how long nobody answers when the daemon that leads is killed, stopped or
 * ended, and whether a leader is replaced for nothing while a standby is stopped and in SECONDS of
 * full load; and how long a foreign program waits in dds_write for a killed daemon if its writer
 * keeps all. Prints figures for a machine that has nothing else to do; they are no verdict.
 *
 *   bench_standby [TRIALS [SECONDS [LEASE_MS]]]    10 of each kind, 60, 500
 *
 * Good is a median of at most the lease and 5 ms, 5 ms when the leader ends, and nobody replaced
 * for nothing, that is while all processors run.
 */
#include "dds/standby_pair.h"
#include "dds/topics/dds_convert.h"
#include "dds/topics/dds_topics.h"
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

/* Both daemons read what it writes; neither serves the robot. */
static dds_entity_t make_foreign_writer(dds_entity_t participant, bool keep_all)
{
    dds_publication_matched_status_t matched = {0};
    dds_qos_t *qos = dds_create_qos();
    dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_SECS(60));
    dds_qset_history(qos, keep_all ? DDS_HISTORY_KEEP_ALL : DDS_HISTORY_KEEP_LAST, 256);
    const dds_entity_t writer = dds_create_writer(
        participant, tfa_dds_create_topic(participant, TFA_DDS_REQUEST), qos, NULL);
    dds_delete_qos(qos);
    assert_true(WAIT_FOR(dds_get_publication_matched_status(writer, &matched) == 0 &&
                         matched.current_count == 2));
    return writer;
}

static void measure_foreign_writer(bool keep_all)
{
    double numbers[1000] = {0};
    totalforce_dds_Request request = {.q = {1000, 1000, numbers, false}};
    const dds_entity_t participant = dds_create_participant(pair.domain, NULL, NULL);
    const dds_entity_t writer = make_foreign_writer(participant, keep_all);
    harness *const killed = pair.leader;
    uint64_t longest = 0;
    assert_true(tfa_dds_set_robot(request.robot, "nobody"));
    pair_kill_leader();
    for (const uint64_t end = now_ns() + 12 * (uint64_t)DDS_SECS(1); now_ns() < end;) {
        const uint64_t start = now_ns();
        assert_int_equal(dds_write(writer, &request), DDS_RETCODE_OK);
        const uint64_t ns = now_ns() - start;
        longest = ns > longest ? ns : longest;
        sleep_ms(1);
    }
    print_message("a foreign writer that keeps %s waited for the killed leader for %.1f ms\n",
                  keep_all ? "all" : "the last 256", 1e-6 * (double)longest);
    assert_int_equal(dds_delete(participant), DDS_RETCODE_OK);
    harness_start(killed, "arm");
    pair_settle();
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
    measure_foreign_writer(true);
    measure_foreign_writer(false);
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
