/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Hot standby: two totalforced serve one robot over DDS, and the one that leads is killed, stopped
 * or ended while a client calls and another one streams torques. Every call is answered, with the
 * right bits, by leaders whose epochs grow, and the stream goes on. That nobody is replaced for
 * nothing holds in simulated time (election), how long nobody answers is measured (bench_standby).
 *
 *   test_standby [TRIALS [LEASE_MS]]    1 of each kind, 6000
 */
#include "standby_pair.h"
#include "test.h"

#include <signal.h>
#include <totalforce/statistics.h>

#define LOAD_CALLS 2000

static int trials = 1, lease_ms = 6000; /* a client waits five times as long */

static int start_all(void **state)
{
    (void)state;
    pair_start(lease_ms);
    return 0;
}

static int stop_all(void **state)
{
    (void)state;
    pair_stop();
    return 0;
}

static uint64_t count_ignored(const harness *h)
{
    tfa_statistics *statistics;
    tfa_snapshot *s;
    assert_int_equal(tfa_statistics_open(h->runtime_dir, WAIT_MS, &statistics), TFA_OK);
    assert_int_equal(tfa_snapshot_create(statistics, &s), TFA_OK);
    assert_int_equal(tfa_statistics_read(statistics, s), TFA_OK);
    const uint64_t ignored = s->dds.standby;
    tfa_snapshot_free(s);
    tfa_statistics_close(statistics);
    return ignored;
}

/* Requests that a standby hears and does not answer are none of its own. */
TEST(ignored_requests_are_counted_apart)
{
    const harness *standby = pair.standby;
    assert_true(WAIT_FOR(count_ignored(standby) > 100));
    assert_int_equal(kill(standby->pid, SIGUSR1), 0);
    assert_true(harness_logged(standby, "requests "));
    if (harness_log_lines(standby, "leads, epoch") > 0)
        return; /* it has answered some */
    assert_true(harness_logged(standby, "refused 0, requests 0, rejected 0"));
    assert_int_equal(harness_log_lines(standby, ", standby 0"), 0);
    assert_true(harness_logged(standby, ", standby "));
}

/* The client drops answers of older epochs. A daemon answers what it hears once: torques are sent
 * once, a call again to each leader. */
static void assert_answered_once(void)
{
    const wire_counts wire = wire_observer_count();
    assert_int_equal(atomic_load(&pair.wrong), 0);
    assert_int_equal(atomic_load(&pair.failed), 0);
    assert_int_equal(wire.twice_streamed, 0);
    assert_true(wire.twice_called <= pair_leaderships());
}

/* The standby answers; the old leader comes back, and one of the two stands by. */
static void fail_over(void (*strike)(void))
{
    for (int i = 0; i < trials; i++)
        (void)pair_fail_over(strike);
    assert_answered_once();
}

TEST(a_leader_that_ends_is_replaced)
{
    fail_over(pair_end_leader);
}

TEST(a_killed_leader_is_replaced)
{
    fail_over(pair_kill_leader);
}

TEST(a_stopped_leader_is_replaced)
{
    fail_over(pair_pause_leader);
}

/* Requests that are answered meanwhile. */
static bool standby_ignores(void)
{
    pair_settle();
    const harness *standby = pair.standby;
    const uint64_t ignored = count_ignored(standby);
    pair_await_answers(100);
    return count_ignored(standby) > ignored;
}

/* A standby that stands still for longer than a lease goes on: one of the two leads, the other
 * one hears requests and ignores them. */
TEST(a_stopped_standby_goes_on)
{
    for (int i = 0; i < trials; i++) {
        harness_pause(pair.standby);
        sleep_ms((unsigned)lease_ms + 100); /* its own clock shows that the leader was silent */
        pair_await_answers(200);
        assert_int_equal(kill(pair.standby->pid, SIGCONT), 0);
        assert_true(WAIT_FOR(standby_ignores()));
    }
    assert_answered_once();
}

TEST(full_load_is_answered)
{
    pair_load();
    for (uint64_t thousands = 1; thousands <= 20; thousands++) /* each has its minute */
        assert_true(WAIT_FOR(pair_load_answered() > 1000 * thousands));
    pair_await_answers(LOAD_CALLS);
    pair_settle();
    assert_answered_once();
}

int main(int argc, char **argv)
{
    if (argc > 1 && atoi(argv[1]) > 0)
        trials = atoi(argv[1]);
    if (argc > 2 && atoi(argv[2]) > 0)
        lease_ms = atoi(argv[2]);
    return test_run(start_all, stop_all);
}
