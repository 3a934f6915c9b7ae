/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A client with huge batches beside one with small requests, in the real daemon, without and with a
 * pool: the small ones are answered between the parts of the batches, and all answers have the bits
 * of tfa_compute.
 */
#include "harness.h"
#include "models.h"
#include "test.h"

#include <pthread.h>
#include <signal.h>
#include <stdatomic.h>

#define STATES 1024
#define BATCHES TEST_ROUNDS(24)
#define SMALL_MAX 400000

#define HUMANOID                                                                                   \
    "  - name: humanoid\n    urdf: @/config/robots/humanoid.urdf\n    max_batch: 1024\n"           \
    "    estimate: never\n"

/* States of the humanoid, and what must come back. */
typedef struct batch {
    uint32_t joints;
    double *q, *v, *tau, *expected, *qdd;
} batch;

static tfa_request request_of(const batch *b)
{
    return (tfa_request){.op = TFA_OP_FORWARD_DYNAMICS,
                         .refine = TFA_REFINE_DEFAULT,
                         .count = STATES,
                         .q = b->q,
                         .v = b->v,
                         .tau = b->tau};
}

static void make_batch(batch *b)
{
    SCOPED_MODEL *model = bundled_model("humanoid.urdf", NULL);
    SCOPED_WORKSPACE *w = workspace_for(model, NULL);
    b->joints = tfa_model_v_count(model);
    const size_t n = (size_t)STATES * b->joints;
    b->q = calloc(5 * n, sizeof *b->q);
    assert_non_null(b->q);
    b->v = b->q + n;
    b->tau = b->v + n;
    b->expected = b->tau + n;
    b->qdd = b->expected + n;
    for (size_t i = 0; i < 3 * n; i++)
        b->q[i] = 0.01 * (double)(i * 37 % 151) - 0.7;
    const tfa_request r = request_of(b);
    tfa_reply reply = {.qdd = b->expected};
    assert_int_equal(tfa_compute(w, &r, &reply), TFA_OK);
}

/* A client that asks small requests, one after the other. */
typedef struct small_client {
    tfa_client *client;
    pthread_t thread;
    _Atomic bool stop;
    uint32_t count;
    const char *error;
    tfa_exchange *times;
} small_client;

static void *ask_small(void *argument)
{
    small_client *m = argument;
    static const double numbers[7] = {0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7};
    double first[7], qdd[7];
    const tfa_request r = {.op = TFA_OP_FORWARD_DYNAMICS,
                           .estimate = TFA_ESTIMATE_NEVER,
                           .count = 1,
                           .q = numbers,
                           .v = numbers,
                           .tau = numbers};
    while (!atomic_load(&m->stop) && m->count < SMALL_MAX && !m->error) {
        tfa_reply reply = {.qdd = m->count ? qdd : first};
        if (tfa_client_call(m->client, &r, &reply, WAIT_NS, &m->times[m->count]) != TFA_OK)
            m->error = "a small request was not answered";
        else if (m->count++ && memcmp(qdd, first, sizeof qdd) != 0)
            m->error = "a small request has other bits";
    }
    return NULL;
}

static tfa_client *connect_batches(const harness *h)
{
    tfa_client_options options = harness_options(h, "humanoid");
    options.max_batch = STATES;
    options.slots = 2;
    return harness_connect_with(&options);
}

static void ask_batches(tfa_client *client, batch *b, tfa_exchange times[BATCHES])
{
    const tfa_request r = request_of(b);
    const size_t size = sizeof *b->qdd * STATES * b->joints;
    for (int k = 0; k < BATCHES; k++) {
        tfa_reply reply = {.qdd = b->qdd};
        memset(b->qdd, 0xff, size);
        assert_int_equal(tfa_client_call(client, &r, &reply, WAIT_NS, &times[k]), TFA_OK);
        assert_memory_equal(b->qdd, b->expected, size);
    }
}

/* Small requests that came during a batch: those that were answered before its end, and those that
 * had to wait for it. With one small request at a time these are at most one for each batch, in its
 * last part. @return how many were answered before */
static uint32_t check_order(const small_client *m, const tfa_exchange *batches)
{
    uint32_t between = 0, late = 0;
    for (int k = 0; k < BATCHES; k++)
        for (uint32_t i = 0; i < m->count; i++) {
            const tfa_exchange *s = &m->times[i], *l = &batches[k];
            const bool came = s->t_sent > l->t_start && s->t_sent < l->t_done;
            between += came && s->t_done < l->t_done;
            late += came && s->t_start >= l->t_done;
        }
    print_message("%u small requests, %u during %d batches, %u at their ends\n", m->count, between,
                  BATCHES, late);
    assert_true(late <= BATCHES);
    return between;
}

/* All batches, and small requests meanwhile. @return how many were answered during a batch */
static uint32_t ask_both(tfa_client *client, batch *b, small_client *m, bool same_worker)
{
    tfa_exchange times[BATCHES];
    m->count = 0;
    atomic_store(&m->stop, false);
    assert_int_equal(pthread_create(&m->thread, NULL, ask_small, m), 0);
    ask_batches(client, b, times);
    atomic_store(&m->stop, true);
    pthread_join(m->thread, NULL);
    if (m->error)
        fail_msg("%s", m->error);
    return same_worker ? check_order(m, times) : 0;
}

static void small_beside_batches(const char *more, bool same_worker, const char *logged)
{
    batch b;
    small_client m = {0};
    make_batch(&b);
    m.times = calloc(SMALL_MAX, sizeof *m.times);
    assert_non_null(m.times);
    SCOPED_HARNESS h = harness_make(ARM HUMANOID, more);
    harness_start(&h, "humanoid");
    if (logged)
        assert_true(harness_logged(&h, logged));
    m.client = harness_connect(&h, "arm", TFA_WAIT_HYBRID);
    SCOPED_CLIENT *client = connect_batches(&h);
    uint32_t between = 0;
    /* again where the small client got no processor during the batches */
    assert_true(WAIT_FOR(
        (between += ask_both(client, &b, &m, same_worker), !same_worker || between >= BATCHES)));
    tfa_client_close(m.client);
    free(m.times);
    free(b.q);
}

TEST(alone)
{
    small_beside_batches("", true, NULL);
}

TEST(on_the_pool)
{
    small_beside_batches("pool:\n  threads: 2\n", true, "pool: 2 threads");
}

/* More threads than processors, at a priority that may not be had. */
TEST(oversubscribed)
{
    small_beside_batches(
        "workers: 2\npool:\n  threads: 5\n  from: 100\n  priority: 1\n  affinity: [0]\n"
        "  spin_ns: 1000\n",
        false, "pool: 5 threads");
}

/* Two clients with batches, two workers, one pool: whoever finds it busy computes alone. Meanwhile
 * the models are exchanged. */
typedef struct batch_client {
    tfa_client *client;
    pthread_t thread;
    batch b;
    tfa_exchange times[BATCHES];
} batch_client;

static void *ask_large(void *argument)
{
    batch_client *g = argument;
    ask_batches(g->client, &g->b, g->times);
    return NULL;
}

TEST(one_pool_for_two_workers)
{
    static batch_client clients[2];
    const char *more = "workers: 2\npool:\n  threads: 2\n";
    SCOPED_HARNESS h = harness_make(HUMANOID, more);
    harness_start(&h, "humanoid");
    for (int k = 0; k < 2; k++) {
        make_batch(&clients[k].b);
        clients[k].client = connect_batches(&h);
    }
    for (int k = 0; k < 2; k++)
        assert_int_equal(pthread_create(&clients[k].thread, NULL, ask_large, &clients[k]), 0);
    for (unsigned i = 1; i <= 4; i++) { /* another policy: other solvers, other pools */
        harness_reload(&h, i % 2 ? HUMANOID "    estimate_every: 7\n" : HUMANOID, more);
        assert_true(harness_logged_times(&h, "reload: done, 1 of 1", i));
    }
    for (int k = 0; k < 2; k++) {
        pthread_join(clients[k].thread, NULL);
        tfa_client_close(clients[k].client);
        free(clients[k].b.q);
    }
}
