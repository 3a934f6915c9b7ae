/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * See standby_pair.h.
 */
#include "standby_pair.h"

#include "dds_client/dds_client.h"
#include "dds_test.h"
#include "herald.h"
#include "models.h"
#include "test.h"

#include <pthread.h>
#include <signal.h>

#define JOINTS 7
#define FAILURES_SHOWN 10

standby_pair pair;

static struct {
    double q[JOINTS], v[JOINTS], tau[JOINTS], qdd[JOINTS]; /* what is asked, and its answer */
    tfa_dds_client *client;
    pthread_t thread, loads[2];
    int load_count;
    _Atomic uint64_t load_answered;
    _Atomic bool stop;
} self;

/* ---- clients ---- */

static void expect_answer(void)
{
    SCOPED_MODEL *model = bundled_model("arm7.urdf", NULL);
    SCOPED_WORKSPACE *w = workspace_for(model, NULL);
    const tfa_request request = arm_request(0.3, self.q, self.v, self.tau);
    tfa_reply reply = {.qdd = self.qdd};
    assert_int_equal(tfa_compute(w, &request, &reply), TFA_OK);
}

/* The stream fills the slots of a worker that gets no processor: the call is refused, and there is
 * another one. */
static void count_call(int status, const double qdd[JOINTS])
{
    if (status == TFA_E_AGAIN)
        return;
    if (status != TFA_OK && atomic_fetch_add(&pair.failed, 1) < FAILURES_SHOWN)
        print_error("a call: %s\n", tfa_status_text(status));
    if (status == TFA_OK && memcmp(qdd, self.qdd, sizeof self.qdd) != 0)
        atomic_fetch_add(&pair.wrong, 1);
    if (status == TFA_OK)
        atomic_fetch_add(&pair.answered, 1);
}

static void *call_on_and_on(void *unused)
{
    double q[JOINTS], v[JOINTS], tau[JOINTS], qdd[JOINTS];
    const tfa_request request = arm_request(0.3, q, v, tau);
    uint64_t last = now_ns();
    (void)unused;
    while (!atomic_load(&self.stop)) {
        tfa_reply reply = {.qdd = qdd};
        memset(qdd, 0, sizeof qdd);
        const int status = tfa_dds_client_call(self.client, &request, &reply, WAIT_NS, NULL);
        const uint64_t now = now_ns();
        count_call(status, qdd);
        if (now - last > atomic_load(&pair.longest_ns))
            atomic_store(&pair.longest_ns, now - last);
        last = now;
    }
    return NULL;
}

void pair_await_answers(uint64_t more)
{
    const uint64_t enough = atomic_load(&pair.answered) + more;
    assert_true(WAIT_FOR(atomic_load(&pair.answered) >= enough));
}

void pair_await_stream(uint64_t more)
{
    const uint64_t enough = wire_observer_count().accelerations + more;
    assert_true(WAIT_FOR(wire_observer_count().accelerations >= enough));
}

static void *load(void *h)
{
    SCOPED_CLIENT *shm = harness_connect(h, "arm", TFA_WAIT_HYBRID);
    double qdd[JOINTS];
    while (!atomic_load(&self.stop))
        if (ask_arm(shm, 0.1, qdd, WAIT_NS) == TFA_OK)
            atomic_fetch_add(&self.load_answered, 1);
    return NULL;
}

void pair_load(void)
{
    for (self.load_count = 0; self.load_count < 2; self.load_count++)
        assert_int_equal(
            pthread_create(&self.loads[self.load_count], NULL, load, &pair.nodes[self.load_count]),
            0);
}

uint64_t pair_load_answered(void)
{
    return atomic_load(&self.load_answered);
}

/* ---- who leads ---- */

bool pair_leadership(const harness *h, char *out, size_t size)
{
    static char text[65536];
    if (tfa_daemon_command(h->runtime_dir, "status", WAIT_MS, text, sizeof text) != TFA_OK)
        return false;
    const char *at = strstr(text, "leadership");
    snprintf(out, size, "%.*s", at != NULL ? (int)strcspn(at, "}") : 0, at != NULL ? at : "");
    return at != NULL;
}

/* The role, if it knows the other one. */
static bool get_role(const harness *h, char role[16], unsigned long long *epoch)
{
    char text[256];
    unsigned peers = 0;
    return pair_leadership(h, text, sizeof text) &&
           sscanf(text, "leadership\": {\"role\": \"%15[a-z]\", \"epoch\": %llu, \"peers\": %u",
                  role, epoch, &peers) == 3 &&
           peers == 1;
}

static bool is_settled(void)
{
    char roles[2][16];
    unsigned long long epochs[2];
    if (!get_role(&pair.nodes[0], roles[0], &epochs[0]) ||
        !get_role(&pair.nodes[1], roles[1], &epochs[1]) || epochs[0] != epochs[1])
        return false;
    const int leader = strcmp(roles[1], "leading") == 0;
    pair.leader = &pair.nodes[leader];
    pair.standby = &pair.nodes[1 - leader];
    pair.epoch = epochs[0];
    return strcmp(roles[leader], "leading") == 0 && strcmp(roles[1 - leader], "standby") == 0;
}

void pair_settle(void)
{
    assert_true(WAIT_FOR(is_settled()));
}

unsigned pair_leaderships(void)
{
    return harness_log_lines(&pair.nodes[0], "leads, epoch") +
           harness_log_lines(&pair.nodes[1], "leads, epoch");
}

/* ---- begin and end ---- */

void pair_start(int lease_ms)
{
    const uint32_t domain = pair.domain = test_domain();
    const char *more = dds_yaml(domain, lease_ms);
    expect_answer();
    pair.nodes[0] = harness_serve(ARM, more);
    dds_herald(domain, "arm");
    pair.nodes[1] = harness_serve(ARM, more);
    pair_settle();
    self.client = dds_connect(domain, "arm");
    assert_int_equal(pthread_create(&self.thread, NULL, call_on_and_on, NULL), 0);
    wire_observer_start(domain, "arm");
    pair_await_answers(100);
}

void pair_stop(void)
{
    atomic_store(&self.stop, true);
    pthread_join(self.thread, NULL);
    for (int i = 0; i < self.load_count; i++)
        pthread_join(self.loads[i], NULL);
    tfa_dds_client_close(self.client);
    wire_observer_stop();
    for (int i = 0; i < 2; i++)
        harness_remove(&pair.nodes[i]);
}

/* ---- what happens to the leader ---- */

void pair_kill_leader(void)
{
    (void)harness_stop(pair.leader, SIGKILL);
}

void pair_end_leader(void)
{
    assert_int_equal(harness_stop(pair.leader, SIGTERM), 0);
}

void pair_pause_leader(void)
{
    harness_pause(pair.leader);
}

uint64_t pair_fail_over(void (*strike)(void))
{
    const unsigned led = pair_leaderships();
    pair_settle();
    const uint64_t epoch = pair.epoch;
    harness *const old = pair.leader;
    pair_await_answers(200);
    atomic_store(&pair.longest_ns, 0);
    strike();
    pair_await_answers(200);
    const uint64_t silence = atomic_load(&pair.longest_ns);
    assert_true(WAIT_FOR(pair_leaderships() > led));
    pair_await_stream(20);
    if (old->pid > 0)
        assert_int_equal(kill(old->pid, SIGCONT), 0);
    else
        harness_start(old, "arm");
    pair_settle();
    assert_true(pair.epoch > epoch);
    return silence;
}
