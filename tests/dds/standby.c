/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Hot standby: two totalforced serve one robot over DDS, and the one that leads is killed, stopped
 * or ended while a client calls and another one streams torques. Every call is answered, once, with
 * the right bits, and the stream goes on.
 *
 *   test_standby [TRIALS [SECONDS [LEASE_MS]]]    2 of each kind, 2, 500
 *
 * Prints how long nobody answered, and whether a leader was replaced for nothing in SECONDS of full
 * load. On a machine that has nothing else to do that is asserted: with 10 trials and more the
 * median is at most the lease and 5 ms, 5 ms when the leader ends; in 60 seconds and more nobody is
 * replaced for nothing, that is while all processors run.
 */
#include "dds_client/dds_client.h"
#include "dds_test.h"
#include "harness.h"
#include "models.h"
#include "stalls.h"
#include "test.h"
#include "wire_observer.h"

#include <pthread.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <time.h>

#define JOINTS 7
#define TRIALS_MAX 1000
#define PATIENCE_NS UINT64_C(10000000000)
#define STRICT_TRIALS 10
#define STRICT_SECONDS 60
#define MARGIN_MS 5
/* On a busy machine a gap is still a matter of leases. */
#define LEASES_MAX 15

static int trials = 2, quiet_seconds = 2, lease_ms = 500;

/* ---- a client that calls without a pause ---- */

static struct {
    double q[JOINTS], v[JOINTS], tau[JOINTS], qdd[JOINTS];
    _Atomic bool stop;
    _Atomic uint64_t answered, wrong, failed;
    _Atomic uint64_t longest_ns; /* between two answers; whoever reads it sets it to 0 */
} caller;

static void expect_answer(void)
{
    tfa_model *model = bundled_model("arm7.urdf", NULL);
    tfa_workspace *w = workspace_for(model, NULL);
    tfa_request request = arm_request(0.3, caller.q, caller.v, caller.tau);
    tfa_reply reply = {.qdd = caller.qdd};

    assert_int_equal(tfa_compute(w, &request, &reply), TFA_OK);
    tfa_workspace_free(w);
    tfa_model_free(model);
}

static void *call_on_and_on(void *client)
{
    double q[JOINTS], v[JOINTS], tau[JOINTS], qdd[JOINTS];
    const tfa_request request = arm_request(0.3, q, v, tau);
    uint64_t last = now_ns();

    while (!atomic_load(&caller.stop)) {
        tfa_reply reply = {.qdd = qdd};
        memset(qdd, 0, sizeof qdd);
        const int status = tfa_dds_client_call(client, &request, &reply, PATIENCE_NS, NULL);
        const uint64_t now = now_ns();
        if (status != TFA_OK) {
            if (atomic_fetch_add(&caller.failed, 1) < 10)
                print_error("a call: %s\n", tfa_status_text(status));
            sleep_ms(1);
        }
        if (status == TFA_OK && memcmp(qdd, caller.qdd, sizeof qdd) != 0)
            atomic_fetch_add(&caller.wrong, 1);
        if (now - last > atomic_load(&caller.longest_ns))
            atomic_store(&caller.longest_ns, now - last);
        last = now;
        atomic_fetch_add(&caller.answered, 1);
    }
    return NULL;
}

static void await_answers(uint64_t more)
{
    const uint64_t from = atomic_load(&caller.answered), end = now_ns() + WAIT_NS;

    while (atomic_load(&caller.answered) < from + more) {
        assert_true(now_ns() < end);
        sleep_ms(1);
    }
}

/* ---- two daemons ---- */

typedef struct node {
    harness h;
    unsigned led, stood_by; /* lines in its log: leads; standby */
} node;

static node nodes[2];
static node *leader, *standby;
static tfa_dds_client *client;
static pthread_t thread;

static void await_role(node *n, const char *line, unsigned *count)
{
    ++*count;
    assert_true(harness_logged_times(&n->h, line, *count));
}

static void become_standby(node *n)
{
    await_role(n, "standby, the leader", &n->stood_by);
}

static void become_leader(node *n)
{
    await_role(n, "leads, epoch", &n->led);
}

static void swap(void)
{
    node *n = leader;

    leader = standby;
    standby = n;
    become_leader(leader);
}

static int start_all(void **state)
{
    char more[128];
    tfa_dds_client_options options = {.robot = "arm", .connect_timeout_ms = 20000};

    (void)state;
    options.domain = test_domain();
    expect_answer();
    snprintf(more, sizeof more, "dds:\n  enabled: true\n  domain: %u\n  lease_ms: %d\n",
             options.domain, lease_ms);
    leader = &nodes[0];
    standby = &nodes[1];
    harness_serve(&leader->h, ARM, more);
    become_leader(leader);
    harness_serve(&standby->h, ARM, more);
    become_standby(standby);
    assert_int_equal(tfa_dds_client_connect(&options, &client), TFA_OK);
    assert_int_equal(pthread_create(&thread, NULL, call_on_and_on, client), 0);
    wire_observer_start(options.domain, "arm");
    await_answers(100);
    return 0;
}

static int stop_all(void **state)
{
    (void)state;
    atomic_store(&caller.stop, true);
    pthread_join(thread, NULL);
    tfa_dds_client_close(client);
    wire_observer_stop();
    for (int i = 0; i < 2; i++)
        harness_remove(&nodes[i].h);
    return 0;
}

/* Requests that a standby hears and does not answer are none of its own. */
static void ignored_requests_are_counted_apart(void **state)
{
    (void)state;
    await_answers(100);
    assert_int_equal(kill(standby->h.pid, SIGUSR1), 0);
    assert_true(harness_logged(&standby->h, "refused 0, requests 0, rejected 0"));
    assert_int_equal(harness_log_lines(&standby->h, ", standby 0"), 0);
    assert_true(harness_logged(&standby->h, ", standby "));
}

/* ---- what happens to the leader ---- */

static void kill_leader(void)
{
    (void)harness_stop(&leader->h, SIGKILL);
}

static void end_leader(void)
{
    const int status = harness_stop(&leader->h, SIGTERM);
    assert_int_equal(status, 0);
}

static void stop_leader(void)
{
    harness_pause(&leader->h);
}

static int by_size(const void *a, const void *b)
{
    const uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;

    return x < y ? -1 : x > y;
}

/* Gaps in ns, of all trials; the limit is for their median. */
static void report(const char *kind, uint64_t *gaps, int limit_ms)
{
    qsort(gaps, (size_t)trials, sizeof *gaps, by_size);
    const double median = 1e-6 * (double)gaps[trials / 2];
    const double worst = 1e-6 * (double)gaps[trials - 1];
    print_message("%s, %d trials: nobody answered for %.1f ms (median), %.1f ms (most); lease %d "
                  "ms\n",
                  kind, trials, median, worst, lease_ms);
    assert_true(worst < LEASES_MAX * lease_ms);
    if (trials >= STRICT_TRIALS)
        assert_true(median <= limit_ms);
}

/* A call under way when the leader changes is sent again, and both leaders may answer it; a reply
 * of the older epoch is dropped by the client. No other call is answered twice. */
static void assert_answered_once(void)
{
    const wire_counts wire = wire_observer_count();

    print_message(
        "on the wire: %llu replies to %llu calls, %llu accelerations to %llu torques; %llu "
        "repeated and %llu outdated in %llu takeovers\n",
        (unsigned long long)wire.replies, (unsigned long long)atomic_load(&caller.answered),
        (unsigned long long)wire.accelerations, (unsigned long long)wire.published,
        (unsigned long long)wire.repeated, (unsigned long long)wire.outdated,
        (unsigned long long)wire.takeovers);
    assert_int_equal(atomic_load(&caller.wrong), 0);
    if (stalls_count() > 0)
        return; /* two may have led until the machine let one hear the other */
    assert_true(wire.repeated <= wire.takeovers);
    assert_int_equal(atomic_load(&caller.failed), 0);
}

/* Whoever leads now answers the stream, too. */
static void await_stream(uint64_t more)
{
    const uint64_t from = wire_observer_count().accelerations, end = now_ns() + WAIT_NS;

    while (wire_observer_count().accelerations < from + more) {
        assert_true(now_ns() < end);
        sleep_ms(1);
    }
}

/* The standby answers; the old leader comes back and stands by. */
static void fail_over(const char *kind, void (*strike)(void), bool stopped, int limit_ms)
{
    static uint64_t gaps[TRIALS_MAX];

    for (int i = 0; i < trials; i++) {
        await_answers(200);
        atomic_store(&caller.longest_ns, 0);
        strike();
        await_answers(200);
        gaps[i] = atomic_load(&caller.longest_ns);
        swap();
        await_stream(20);
        if (stopped)
            assert_int_equal(kill(standby->h.pid, SIGCONT), 0);
        else
            harness_start(&standby->h, "arm");
        become_standby(standby);
        await_answers(200);
    }
    report(kind, gaps, limit_ms);
    assert_answered_once();
}

static void a_killed_leader_is_replaced(void **state)
{
    (void)state;
    fail_over("SIGKILL", kill_leader, false, lease_ms + MARGIN_MS);
}

static void a_stopped_leader_is_replaced(void **state)
{
    (void)state;
    fail_over("SIGSTOP", stop_leader, true, lease_ms + MARGIN_MS);
}

static void a_leader_that_ends_is_replaced_at_once(void **state)
{
    (void)state;
    fail_over("SIGTERM", end_leader, false, MARGIN_MS);
}

/* What a daemon says about who leads. @return false: it does not answer */
static bool get_leadership(const node *n, char *out, size_t size)
{
    static char text[65536];

    if (tfa_daemon_command(n->h.runtime_dir, "status", 0, text, sizeof text) != TFA_OK)
        return false;
    const char *at = strstr(text, "leadership");
    snprintf(out, size, "%.*s", at != NULL ? (int)strcspn(at, "}") : 0, at != NULL ? at : "");
    return at != NULL;
}

/* On a busy machine the leader itself may stand still, and is replaced rightly. */
static bool has_stood_still(const node *n)
{
    char text[256];
    double pause_ms = 0;

    const char *at = get_leadership(n, text, sizeof text) ? strstr(text, "pause_ms") : NULL;
    return at == NULL || sscanf(at, "pause_ms\": %lf", &pause_ms) != 1 || pause_ms > lease_ms / 2;
}

/* A standby that stands still and goes on does not take over. */
static void a_stopped_standby_stays_one(void **state)
{
    (void)state;
    for (int i = 0; i < trials; i++) {
        harness_pause(&standby->h);
        sleep_ms(3 * (unsigned)lease_ms);
        assert_int_equal(kill(standby->h.pid, SIGCONT), 0);
        sleep_ms(3 * (unsigned)lease_ms);
    }
    const unsigned led = harness_log_lines(&standby->h, "leads, epoch");
    if (trials >= STRICT_TRIALS || !has_stood_still(leader))
        assert_int_equal(led, standby->led);
    standby->led = led;
    assert_int_equal(atomic_load(&caller.failed), 0);
}

/* Clients over shared memory load both processors, too. */
static void *load(void *h)
{
    tfa_client *shm = harness_connect(h, "arm", TFA_WAIT_HYBRID);
    double qdd[JOINTS];

    while (!atomic_load(&caller.stop))
        (void)ask_arm(shm, 0.1, qdd, PATIENCE_NS);
    tfa_client_close(shm);
    return NULL;
}

static void show_leadership(void)
{
    char text[256];

    for (int i = 0; i < 2; i++)
        if (get_leadership(&nodes[i], text, sizeof text))
            print_message("daemon %d: %s\n", i, text);
}

/* Takeovers, by the logs of both */
static unsigned count_takeovers(void)
{
    return harness_log_lines(&nodes[0].h, "leads, epoch") +
           harness_log_lines(&nodes[1].h, "leads, epoch");
}

/* A leader without a processor is replaced, rightly: that is counted apart. */
static void full_load_replaces_nobody(void **state)
{
    const uint64_t lease_ns = (uint64_t)lease_ms * 1000000u;
    const uint64_t from = atomic_load(&caller.answered);
    const uint64_t end = now_ns() + (uint64_t)quiet_seconds * 1000000000u;
    unsigned seen = count_takeovers(), stalled = 0, replaced = 0;
    pthread_t loads[2];

    (void)state;
    stalls_start(lease_ns / 2);
    for (int i = 0; i < 2; i++)
        assert_int_equal(pthread_create(&loads[i], NULL, load, &nodes[i].h), 0);
    while (now_ns() < end) {
        sleep_ms(10);
        const unsigned more = count_takeovers() - seen;
        seen += more;
        *(now_ns() - stalls_last() < 2 * lease_ns ? &stalled : &replaced) += more;
    }
    print_message("full load for %d s: %llu calls, replaced for nothing %u times, while a "
                  "processor stood still %u times (it did %u times, for %.1f ms at most)\n",
                  quiet_seconds, (unsigned long long)(atomic_load(&caller.answered) - from),
                  replaced, stalled, stalls_count(), 1e-6 * (double)stalls_longest_ns());
    stalls_stop();
    show_leadership();
    atomic_store(&caller.stop, true);
    for (int i = 0; i < 2; i++)
        pthread_join(loads[i], NULL);
    assert_answered_once();
    if (quiet_seconds >= STRICT_SECONDS)
        assert_int_equal(replaced, 0);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(ignored_requests_are_counted_apart), /* nobody was replaced yet: first */
        cmocka_unit_test(a_killed_leader_is_replaced),
        cmocka_unit_test(a_stopped_leader_is_replaced),
        cmocka_unit_test(a_leader_that_ends_is_replaced_at_once),
        cmocka_unit_test(a_stopped_standby_stays_one),
        cmocka_unit_test(full_load_replaces_nobody), /* ends the calls: last */
    };

    if (argc > 1 && atoi(argv[1]) > 0 && atoi(argv[1]) <= TRIALS_MAX)
        trials = atoi(argv[1]);
    if (argc > 2 && atoi(argv[2]) > 0)
        quiet_seconds = atoi(argv[2]);
    if (argc > 3 && atoi(argv[3]) > 0)
        lease_ms = atoi(argv[3]);
    return cmocka_run_group_tests(tests, start_all, stop_all);
}
