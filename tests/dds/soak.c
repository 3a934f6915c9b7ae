/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Soak: honest clients at full load over shared memory and DDS, compare every answer with the one
 * in process, while the daemon is reloaded, stopped, killed and attacked.
 *
 *   test_soak [SECONDS [MAX_STATE_US]]    20, 0: no limit, whatever the machine
 *
 * Fails, and says which: wrong, an answer or a status; too slow, no answer in WAIT_NS, to one over
 * DDS while the daemon is there; leak, memory or descriptors of the daemon that grow, or a report
 * of a sanitizer. Prints the counts.
 */
#include "attacks.h"
#include "dds_attacks.h"
#include "dds_client/dds_client.h"
#include "dds_test.h"
#include "models.h"
#include "support/sanitized.h"
#include "test.h"

#include <pthread.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <unistd.h>

#define STATES 32 /* that every client asks again and again */
#define MODELS 2  /* the daemon has one of them at a time */
#define CLIENTS 2 /* over shared memory */
#define SLOTS 16
#define JOINTS 7
#define LIFE_S 60        /* of a daemon, until it is killed */
#define GROWTH_KIB 32768 /* a life of 61 s grows by 16 MiB, one of 8 s by 13 */
#define DESCRIPTORS 32   /* of the honest clients, which may have come after the start of a life */
#define WARM_ANSWERS 10000 /* a daemon has what memory it needs */

static int max_state_us;

static const char *const gravities[MODELS] = {"    gravity: [0, 0, -9.80665]\n",
                                              "    gravity: [0, 0, -1.62]\n"};

/* What must come back, by model and state. */
static struct {
    uint64_t tag;
    double qdd[STATES][JOINTS];
} expected[MODELS];

typedef struct counts {
    _Atomic uint64_t answered, lost, timed_out, ended, reconnected;
} counts;

static counts shm, dds;
static _Atomic uint32_t absences; /* odd: the daemon is stopped, or killed and not back */
static _Atomic bool stop;
static _Atomic(const char *) fault; /* what went wrong first */
static harness daemon_harness;

static void report(const char *what)
{
    const char *none = NULL;
    atomic_compare_exchange_strong(&fault, &none, what);
    atomic_store(&stop, true);
}

/* ---- requests and answers ---- */

typedef struct numbers {
    double q[JOINTS], v[JOINTS], tau[JOINTS];
} numbers;

static numbers inputs[STATES];

static tfa_request request_of(uint32_t state)
{
    const numbers *n = &inputs[state % STATES];
    return (tfa_request){.op = TFA_OP_FORWARD_DYNAMICS,
                         .estimate = TFA_ESTIMATE_NEVER,
                         .refine = TFA_REFINE_DEFAULT,
                         .count = 1,
                         .q = n->q,
                         .v = n->v,
                         .tau = n->tau};
}

static void expect_answers(void)
{
    for (uint32_t s = 0; s < STATES; s++)
        (void)arm_request(0.1 * s - 1, inputs[s].q, inputs[s].v, inputs[s].tau);
    for (int m = 0; m < MODELS; m++) {
        const double gravity[3] = {0, 0, m ? -1.62 : -9.80665};
        const tfa_model_options options = {.gravity = gravity};
        SCOPED_MODEL *model = bundled_model("arm7.urdf", &options);
        SCOPED_WORKSPACE *w = workspace_for(model, NULL);
        expected[m].tag = tfa_model_tag(model);
        for (uint32_t s = 0; s < STATES; s++) {
            const tfa_request r = request_of(s);
            tfa_reply reply = {.qdd = expected[m].qdd[s]};
            assert_int_equal(tfa_compute(w, &r, &reply), TFA_OK);
        }
    }
}

static bool is_right(const tfa_reply *reply, uint32_t state)
{
    for (int m = 0; m < MODELS; m++)
        if (expected[m].tag == reply->model)
            return memcmp(reply->qdd, expected[m].qdd[state % STATES], sizeof expected[m].qdd[0]) ==
                   0;
    return false;
}

/* ---- over shared memory: full rings ---- */

static bool reconnect(tfa_client *client)
{
    bool connected = false;
    (void)WAIT_FOR(atomic_load(&stop) || (connected = tfa_client_reconnect(client) == TFA_OK));
    atomic_fetch_add(&shm.reconnected, connected);
    return connected;
}

/* Takes the oldest reply, which is that of request `state`. @return false: a fault */
static bool take_reply(tfa_client *client, uint32_t state, uint64_t id)
{
    double qdd[JOINTS];
    tfa_reply reply = {.qdd = qdd};
    tfa_exchange exchange;
    int status = tfa_client_receive(client, &reply, WAIT_NS, &exchange);
    if (status == TFA_E_DISCONNECTED && reconnect(client))
        status = tfa_client_receive(client, &reply, WAIT_NS, &exchange);
    if (status == TFA_OK && is_right(&reply, state) && exchange.id == id)
        atomic_fetch_add_explicit(&shm.answered, 1, memory_order_relaxed);
    else if (status == TFA_E_LOST && exchange.id == id)
        atomic_fetch_add(&shm.lost, 1);
    else if (!atomic_load(&stop))
        report(status == TFA_OK          ? "wrong: shared memory: an answer"
               : status == TFA_E_TIMEOUT ? "too slow: shared memory: a request without an answer"
                                         : "wrong: shared memory: the status of a request");
    return !atomic_load(&stop);
}

static void *ask_shm(void *unused)
{
    uint64_t ids[SLOTS];
    uint32_t sent = 0, received = 0;
    tfa_client_options options = harness_options(&daemon_harness, "arm");
    tfa_client *client;
    (void)unused;
    options.slots = SLOTS;
    if (tfa_client_connect(&options, &client) != TFA_OK) {
        report("too slow: shared memory: no connection");
        return NULL;
    }
    while (!atomic_load_explicit(&stop, memory_order_relaxed)) {
        int status = TFA_OK;
        while (sent - received < SLOTS && status == TFA_OK) {
            const tfa_request r = request_of(sent);
            status = tfa_client_send(client, &r, &ids[sent % SLOTS]);
            sent += status == TFA_OK;
        }
        if (sent == received && status == TFA_E_DISCONNECTED) {
            (void)reconnect(client);
            continue;
        }
        if (!take_reply(client, received, ids[received % SLOTS]))
            break;
        received++;
    }
    tfa_client_close(client);
    return NULL;
}

/* ---- over DDS: one call at a time ---- */

/* Calls end with a status: without a daemon, for example. They may time out only while it is
 * away. */
static void count_dds(int status, bool right, bool was_away)
{
    if (status == TFA_OK && right)
        atomic_fetch_add(&dds.answered, 1);
    else if (status == TFA_OK)
        report("wrong: dds: an answer");
    else if (status == TFA_E_TIMEOUT)
        atomic_fetch_add(&dds.timed_out, 1);
    else
        atomic_fetch_add(&dds.ended, 1);
    if (status == TFA_E_TIMEOUT && !was_away && !atomic_load(&stop))
        report("too slow: dds: a request without an answer");
}

static void *ask_dds(void *unused)
{
    const tfa_dds_client_options options = {
        .domain = test_domain(), .robot = "arm", .connect_timeout_ms = WAIT_MS};
    tfa_dds_client *client;
    (void)unused;
    if (tfa_dds_client_connect(&options, &client) != TFA_OK) {
        report("too slow: dds: no connection");
        return NULL;
    }
    for (uint32_t k = 0; !atomic_load(&stop); k++) {
        double qdd[JOINTS];
        const tfa_request r = request_of(k);
        tfa_reply reply = {.qdd = qdd};
        const uint32_t before = atomic_load(&absences);
        const int status = tfa_dds_client_call(client, &r, &reply, WAIT_NS, NULL);
        const bool was_away = before % 2 || atomic_load(&absences) != before;
        count_dds(status, status == TFA_OK && is_right(&reply, k), was_away);
        sleep_ms(status == TFA_E_DISCONNECTED ? 20 : 1);
    }
    tfa_dds_client_close(client);
    return NULL;
}

/* ---- chaos ---- */

typedef struct life {
    uint64_t start; /* CLOCK_MONOTONIC ns */
    long resident_kib;
    int descriptors;
} life;

static void reload(int model)
{
    char robots[256];
    snprintf(robots, sizeof robots, "%s%s", ARM, gravities[model]);
    char more[256];
    snprintf(more, sizeof more,
             "max_state_us: %d\nlog: error\ndds: {enabled: yes, domain: %u}\n"
             "limits: {clients: 100, clients_per_user: 100}\n",
             max_state_us, test_domain());
    harness_configure(&daemon_harness, robots, more);
    if (daemon_harness.pid > 0)
        (void)kill(daemon_harness.pid, SIGHUP);
}

/* So many clients have found it that its memory grows no more. */
static void await_answers(void)
{
    const uint64_t by_dds = atomic_load(&dds.answered) + 1;
    const uint64_t by_shm = atomic_load(&shm.answered) + WARM_ANSWERS;
    if (!WAIT_FOR(atomic_load(&stop) || atomic_load(&dds.answered) >= by_dds))
        report("too slow: dds: the daemon that is back does not answer");
    if (!WAIT_FOR(atomic_load(&stop) || atomic_load(&shm.answered) >= by_shm))
        report("too slow: shared memory: the daemon that is back does not answer");
}

static void begin_life(life *l)
{
    harness_start(&daemon_harness, "arm");
    await_answers();
    atomic_fetch_add(&absences, 1);
    *l = (life){now_ns(), harness_resident_kib(&daemon_harness),
                harness_descriptors(&daemon_harness)};
}

static bool has_grown(const life *l, int *descriptors, long *kib)
{
    *descriptors = harness_descriptors(&daemon_harness) - l->descriptors;
    *kib = harness_resident_kib(&daemon_harness) - l->resident_kib;
    return *descriptors > DESCRIPTORS || *kib > GROWTH_KIB;
}

/* The daemon has not grown since its start. */
static void end_life(life *l)
{
    int descriptors;
    long kib;
    (void)WAIT_FOR(!has_grown(l, &descriptors, &kib)); /* sessions of dead attackers end */
    print_message("life of %.0f s: %+ld KiB, %+d descriptors\n",
                  (double)(now_ns() - l->start) * 1e-9, kib, descriptors);
#ifndef SANITIZED /* sanitizers keep memory that was freed */
    if (kib > GROWTH_KIB)
        report("leak: the daemon's memory grows");
#endif
    if (harness_log_lines(&daemon_harness, "Sanitizer") > 0)
        report("leak: a sanitizer found something in the daemon");
    if (descriptors > DESCRIPTORS)
        report("leak: the daemon's descriptors grow");
    atomic_fetch_add(&absences, 1);
    (void)harness_stop(&daemon_harness, SIGKILL);
}

static void pause_daemon(void)
{
    atomic_fetch_add(&absences, 1);
    harness_pause(&daemon_harness);
    sleep_ms(100);
    (void)kill(daemon_harness.pid, SIGCONT);
    atomic_fetch_add(&absences, 1);
}

/* Attackers at both doors, a reload, now and then a pause. Its sleeps make interleavings. */
static void cause_trouble(unsigned round)
{
    const pid_t local = attack_start(&attacks[round % attack_count], &daemon_harness);
    const pid_t remote = dds_attack_start(round % dds_attack_count, test_domain());
    sleep_ms(700);
    reload((int)(round % MODELS));
    sleep_ms(300);
    if (round % 4 == 1)
        pause_daemon();
    sleep_ms(200);
    attack_stop(local);
    attack_stop(remote);
}

static void cause_chaos(unsigned seconds)
{
    const uint64_t end = now_ns() + (uint64_t)seconds * 1000000000u;
    life l;
    await_answers();
    l.start = now_ns();
    l.resident_kib = harness_resident_kib(&daemon_harness);
    l.descriptors = harness_descriptors(&daemon_harness);
    for (unsigned round = 0; now_ns() < end && !atomic_load(&stop); round++) {
        cause_trouble(round);
        if (now_ns() - l.start > LIFE_S * 1000000000ull || round == 5) {
            end_life(&l);
            begin_life(&l);
        }
    }
    atomic_store(&stop, true); /* nobody waits for a daemon that does not come back */
    end_life(&l);
}

static unsigned seconds = 20;

TEST(everything_at_once)
{
    pthread_t threads[CLIENTS + 1];
    expect_answers();
    daemon_harness = harness_make(ARM, "");
    reload(0);
    harness_start(&daemon_harness, "arm");
    for (int i = 0; i < CLIENTS; i++)
        assert_int_equal(pthread_create(&threads[i], NULL, ask_shm, NULL), 0);
    assert_int_equal(pthread_create(&threads[CLIENTS], NULL, ask_dds, NULL), 0);
    cause_chaos(seconds);
    for (int i = 0; i <= CLIENTS; i++)
        pthread_join(threads[i], NULL);
    print_message("shared memory: %llu answered and right, %llu reported lost, %llu reconnections\n"
                  "dds: %llu answered and right, %llu ended with another status, %llu timed out "
                  "while the daemon was away\n",
                  (unsigned long long)shm.answered, (unsigned long long)shm.lost,
                  (unsigned long long)shm.reconnected, (unsigned long long)dds.answered,
                  (unsigned long long)dds.ended, (unsigned long long)dds.timed_out);
    const char *what = atomic_load(&fault);
    if (what)
        fail_msg("%s", what);
    assert_true(shm.answered > WARM_ANSWERS && dds.answered > 0);
    harness_remove(&daemon_harness);
}

int main(int argc, char **argv)
{
    dds_attack_main(argc, argv);
    signal(SIGPIPE, SIG_IGN);
    if (argc > 1)
        seconds = (unsigned)atoi(argv[1]) > 5 ? (unsigned)atoi(argv[1]) : 5;
    if (argc > 2)
        max_state_us = atoi(argv[2]);
    return test_run(NULL, NULL);
}
