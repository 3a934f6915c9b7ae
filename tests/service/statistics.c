/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Statistics of a daemon: what clients received is what was counted, whoever comes, leaves, is
 * killed or breaks the protocol; snapshots under load are of one moment; readers cannot write.
 */
#include <totalforce/statistics.h>

#include "harness.h"
#include "models.h"
#include "raw_client.h"
#include "test.h"

#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <signal.h>
#include <stdatomic.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <totalforce/dynamics.h>
#include <unistd.h>

#define TWO_ROBOTS ARM "  - name: other\n    urdf: @/config/robots/arm7.urdf\n"

typedef struct reader {
    tfa_statistics *statistics;
    tfa_snapshot *now;
} reader;

static reader open_reader(const harness *h)
{
    reader r;
    assert_int_equal(tfa_statistics_open(h->runtime_dir, WAIT_MS, &r.statistics), TFA_OK);
    assert_int_equal(tfa_snapshot_create(r.statistics, &r.now), TFA_OK);
    return r;
}

static void close_reader(reader *r)
{
    tfa_snapshot_free(r->now);
    tfa_statistics_close(r->statistics);
}
#define SCOPED_READER SCOPED(close_reader) reader

/* ---- laws ---- */

static uint64_t sum(const uint64_t *values, int count)
{
    uint64_t all = 0;
    for (int i = 0; i < count; i++)
        all += values[i];
    return all;
}

static void check_times(const tfa_histogram *h)
{
    assert_int_equal(h->count, sum(h->buckets, (int)h->bucket_count));
    assert_true(h->count == 0 || h->lowest <= h->highest);
    assert_true(tfa_histogram_quantile(h, 1.0) <= h->highest);
}

/* Holds in every snapshot. */
static void check_tally(const tfa_tally *t)
{
    assert_int_equal(t->requests, sum(t->statuses, TFA_STATISTICS_STATUSES));
    assert_int_equal(t->requests - t->rejected, sum(t->methods, TFA_STATISTICS_METHODS));
    assert_int_equal(t->estimates, sum(t->estimate_decades, TFA_STATISTICS_DECADES));
    assert_true(t->queue.count >= t->requests && t->compute.count >= t->requests);
    check_times(&t->queue);
    check_times(&t->compute);
    check_times(&t->total);
}

/* While nobody asks */
static void check_rest(const tfa_tally *t)
{
    check_tally(t);
    assert_int_equal(t->queue.count, t->requests);
    assert_int_equal(t->compute.count, t->requests);
    assert_true(t->total.count <= t->requests);
}

static void check_sums(const tfa_snapshot *s)
{
    for (uint32_t i = 0; i < s->robot_count; i++) {
        const tfa_robot_statistics *r = &s->robots[i];
        uint64_t requests = r->departed.requests, rejected = r->departed.rejected,
                 states = r->departed.states;
        for (uint32_t k = 0; k < s->client_count; k++) {
            const tfa_client_statistics *c = &s->clients[k];
            if (c->served.robot != i || c->served.kind == TFA_CLIENT_SELF)
                continue;
            requests += c->tally.requests;
            rejected += c->tally.rejected;
            states += c->tally.states;
        }
        assert_int_equal(r->total.requests, requests);
        assert_int_equal(r->total.rejected, rejected);
        assert_int_equal(r->total.states, states);
    }
}

/* A writer that has no processor keeps readers busy. */
static void read_all(reader *r)
{
    int status;
    (void)WAIT_FOR((status = tfa_statistics_read(r->statistics, r->now)) != TFA_E_BUSY);
    assert_int_equal(status, TFA_OK);
    check_sums(r->now);
    for (uint32_t i = 0; i < r->now->robot_count; i++) {
        check_tally(&r->now->robots[i].departed);
        check_tally(&r->now->robots[i].total);
    }
    for (uint32_t i = 0; i < r->now->client_count; i++)
        check_tally(&r->now->clients[i].tally);
}

/* A reply is there before it is counted: waits for the count, then checks that it stays so. */
static const tfa_robot_statistics *await_requests(reader *r, uint32_t robot, uint64_t requests)
{
    (void)WAIT_FOR((read_all(r), r->now->robots[robot].total.requests >= requests));
    const tfa_robot_statistics *found = &r->now->robots[robot];
    assert_int_equal(found->total.requests, requests);
    check_rest(&found->total);
    return found;
}

static void await_clients(reader *r, uint32_t robot, uint32_t clients)
{
    (void)WAIT_FOR((read_all(r), r->now->robots[robot].clients == clients));
    assert_int_equal(r->now->robots[robot].clients, clients);
}

/* ---- tests ---- */

TEST(what_was_received_was_counted)
{
    double q[14] = {0.1, 0.2}, v[14] = {0}, tau[14] = {0}, qdd[14];
    tfa_answer answers[2];
    SCOPED_HARNESS h = harness_serve(TWO_ROBOTS, "workers: 2\n");
    SCOPED_READER r = open_reader(&h);
    read_all(&r);
    assert_int_equal(r.now->process, h.pid);
    assert_int_equal(r.now->robot_count, 2);
    assert_int_equal(r.now->worker_count, 2);
    assert_int_equal(r.now->robots[0].total.requests, 0); /* self-tests do not count */
    const uint64_t connections = r.now->connections;
    assert_string_equal(r.now->robots[1].served.name, "other");
    assert_int_equal(r.now->robots[1].served.joints, 7);
    assert_int_equal(strlen(r.now->robots[1].served.model_hash), 64);
    assert_true(r.now->robots[1].served.kernel_isa[0] != 0);
    tfa_client_options options = harness_options(&h, "arm");
    tfa_client *a, *b = harness_connect(&h, "arm", TFA_WAIT_BLOCK),
                   *c = harness_connect(&h, "other", TFA_WAIT_BLOCK);
    options.max_batch = 2;
    assert_int_equal(tfa_client_connect(&options, &a), TFA_OK);
    tfa_request request = request_fd(q, v, tau);
    tfa_reply reply = {.qdd = qdd, .answers = answers};
    for (int i = 0; i < 10; i++)
        assert_int_equal(tfa_client_call(a, &request, &reply, WAIT_NS, NULL), TFA_OK);
    request.count = 2;
    request.method = TFA_METHOD_CRBA;
    request.estimate = TFA_ESTIMATE_ALWAYS;
    for (int i = 0; i < 5; i++)
        assert_int_equal(tfa_client_call(a, &request, &reply, WAIT_NS, NULL), TFA_OK);
    request.count = 1;
    request.estimate = TFA_ESTIMATE_DEFAULT;
    request.method = TFA_METHOD_TFA;
    request.refine = 2;
    assert_int_equal(tfa_client_call(b, &request, &reply, WAIT_NS, NULL), TFA_OK);
    q[1] = NAN;
    for (int i = 0; i < 3; i++)
        assert_int_equal(tfa_client_call(b, &request, &reply, WAIT_NS, NULL), TFA_E_VALUE);
    q[1] = 0.5;
    assert_int_equal(tfa_client_call(c, &request, &reply, WAIT_NS, NULL), TFA_OK);
    const tfa_robot_statistics *arm = await_requests(&r, 0, 19);
    assert_int_equal(arm->clients, 2);
    assert_int_equal(arm->total.rejected, 3);
    assert_int_equal(arm->total.statuses[-TFA_E_VALUE], 3);
    assert_int_equal(arm->total.states, 21);
    assert_int_equal(arm->total.methods[TFA_METHOD_ABA], 10);
    assert_int_equal(arm->total.methods[TFA_METHOD_CRBA], 5);
    assert_int_equal(arm->total.methods[TFA_METHOD_TFA], 1);
    assert_int_equal(arm->total.refined, 1);
    assert_true(arm->total.estimates >= 10);
    assert_true(arm->total.largest_estimate > 0 && arm->total.largest_estimate < 1e-8);
    assert_int_equal(arm->total.total.count, 19);
    assert_true(arm->total.busy_ns > 0 && arm->total.busy_ns <= (uint64_t)arm->total.compute.sum);
    assert_int_equal(await_requests(&r, 1, 1)->total.methods[TFA_METHOD_TFA], 1);
    assert_int_equal(r.now->connections, connections + 3);
    tfa_client_close(a); /* its counts stay */
    await_clients(&r, 0, 1);
    arm = await_requests(&r, 0, 19);
    assert_int_equal(arm->departed.requests, 15);
    assert_int_equal(arm->departed.states, 20);
    tfa_client_close(b);
    tfa_client_close(c);
    await_clients(&r, 0, 0);
    assert_int_equal(await_requests(&r, 0, 19)->departed.rejected, 3);
}

/* The state that a live page draws: that of a request with an answer, published every 10 ms. */
TEST(last_state)
{
    double qdd[7], q[7], v[7], tau[7];
    SCOPED_HARNESS h = harness_serve(ARM, "");
    SCOPED_READER r = open_reader(&h);
    read_all(&r);
    assert_int_equal(r.now->robots[0].state.time, 0);
    SCOPED_CLIENT *client = harness_connect(&h, "arm", TFA_WAIT_BLOCK);
    for (int i = 1; i <= 3; i++) {
        assert_int_equal(ask_arm(client, i, qdd, WAIT_NS), TFA_OK);
        (void)arm_request(i, q, v, tau);
        (void)WAIT_FOR((read_all(&r), memcmp(r.now->robots[0].state.q, q, sizeof q) == 0));
        assert_int_equal(r.now->robots[0].state.q_count, 7);
        assert_memory_equal(r.now->robots[0].state.q, q, sizeof q);
        assert_int_equal(r.now->robots[0].state.floating, 0);
        sleep_ms(12); /* longer than the interval of publications: the next one is due */
    }
}

/* ---- under load ---- */

typedef struct asker {
    const harness *h;
    pthread_t thread;
    _Atomic bool *stop;
    _Atomic uint64_t *answered;
    bool reconnects;
} asker;

static void *ask(void *arg)
{
    asker *a = arg;
    tfa_client *client = NULL;
    double qdd[7];
    for (unsigned i = 0; !atomic_load(a->stop); i++) {
        const tfa_client_options options = harness_options(a->h, "arm");
        if (!client && tfa_client_connect(&options, &client) != TFA_OK)
            break;
        if (ask_arm(client, i % 7, qdd, WAIT_NS) != TFA_OK)
            break;
        atomic_fetch_add(a->answered, 1);
        if (a->reconnects && i % 50 == 49) {
            tfa_client_close(client);
            client = NULL;
        }
    }
    tfa_client_close(client);
    return NULL;
}

/* Clients come and go and ask: no snapshot loses one or counts one twice. */
TEST(snapshots_under_load)
{
    enum { ASKERS = 3, SNAPSHOTS = 200, DEPARTED = TEST_ROUNDS(4000) };
    _Atomic bool stop = false;
    _Atomic uint64_t answered = 0;
    asker askers[ASKERS];
    uint64_t before = 0;
    uint32_t snapshots = 0;
    SCOPED_HARNESS h = harness_serve(ARM, "workers: 2\n");
    SCOPED_READER r = open_reader(&h);
    for (int i = 0; i < ASKERS; i++) {
        askers[i] = (asker){&h, 0, &stop, &answered, i > 0};
        assert_int_equal(pthread_create(&askers[i].thread, NULL, ask, &askers[i]), 0);
    }
    read_all(&r);
    for (const uint64_t end = now_ns() + WAIT_NS;
         snapshots < SNAPSHOTS || r.now->robots[0].departed.requests < DEPARTED; snapshots++) {
        assert_true(now_ns() < end);
        read_all(&r);
        assert_true(r.now->robots[0].total.requests >= before);
        before = r.now->robots[0].total.requests;
    }
    atomic_store(&stop, true);
    for (int i = 0; i < ASKERS; i++)
        pthread_join(askers[i].thread, NULL);
    await_clients(&r, 0, 0);
    const tfa_robot_statistics *arm = await_requests(&r, 0, atomic_load(&answered));
    assert_int_equal(arm->departed.requests, atomic_load(&answered));
}

/* ---- clients that do not behave, and models that change ---- */

TEST(a_killed_client_keeps_its_counts)
{
    int pipes[2];
    uint64_t answered = 0;
    SCOPED_HARNESS h = harness_serve(ARM, "");
    SCOPED_READER r = open_reader(&h);
    assert_int_equal(pipe(pipes), 0);
    const pid_t child = fork();
    if (child == 0) {
        (void)prctl(PR_SET_PDEATHSIG, SIGKILL);
        tfa_client *client = harness_connect(&h, "arm", TFA_WAIT_BLOCK);
        double qdd[7];
        for (uint64_t i = 1; ask_arm(client, (double)(i % 7), qdd, WAIT_NS) == TFA_OK; i++)
            if (i == 100 && write(pipes[1], &i, sizeof i) > 0)
                pause();
        _exit(1);
    }
    assert_int_equal(read(pipes[0], &answered, sizeof answered), sizeof answered);
    const tfa_robot_statistics *arm = await_requests(&r, 0, answered);
    assert_int_equal(arm->clients, 1);
    bool found = false;
    for (uint32_t i = 0; i < r.now->client_count; i++)
        found = found || (r.now->clients[i].served.process == child &&
                          r.now->clients[i].served.kind == TFA_CLIENT_SHM);
    assert_true(found);
    assert_int_equal(kill(child, SIGKILL), 0);
    assert_int_equal(waitpid(child, NULL, 0), child);
    await_clients(&r, 0, 0);
    assert_int_equal(await_requests(&r, 0, answered)->departed.requests, answered);
}

/* Garbage under good sequence numbers is answered, mostly refused; then the sequence is broken. */
TEST(a_hostile_client_is_counted)
{
    enum { SLOTS = 200 };
    uint64_t seed = 7;
    SCOPED_SCENE s = open_scene("");
    SCOPED_READER r = open_reader(&s.h);
    read_all(&r);
    const uint64_t before = r.now->robots[0].total.requests;
    raw_client v = connect_client(&s.h, TFA_WAIT_HYBRID);
    for (int i = 0; i < SLOTS; i++) {
        uint64_t *slot = tfa_ring_next_request(&v.ring);
        for (size_t k = 1; k < v.ring.layout.request_stride / 8; k++)
            slot[k] = seed = seed * 6364136223846793005u + 1442695040888963407u;
        (void)tfa_ring_send(&v.ring);
        wake(&v);
        (void)await_reply(&v);
        tfa_ring_release(&v.ring);
    }
    const tfa_robot_statistics *arm = await_requests(&r, 0, before + SLOTS);
    assert_true(arm->total.rejected > 0);
    disconnect_client(&v);
    await_clients(&r, 0, 1); /* the honest one */
    (void)await_requests(&r, 0, before + SLOTS);
}

TEST(a_reload_keeps_counts)
{
    double qdd[7];
    char hash[72], text[256];
    SCOPED_HARNESS h = harness_serve(TWO_ROBOTS, "");
    SCOPED_READER r = open_reader(&h);
    SCOPED_CLIENT *client = harness_connect(&h, "arm", TFA_WAIT_BLOCK);
    for (int i = 0; i < 20; i++)
        assert_int_equal(ask_arm(client, i, qdd, WAIT_NS), TFA_OK);
    (void)await_requests(&r, 0, 20);
    memcpy(hash, r.now->robots[0].served.model_hash, sizeof hash);
    harness_configure(&h, TWO_ROBOTS "    gravity: [0.5, 0, -1.62]\n", "");
    assert_int_equal(tfa_daemon_command(h.runtime_dir, "reload", WAIT_MS, text, sizeof text),
                     TFA_OK);
    for (int i = 0; i < 20; i++)
        assert_int_equal(ask_arm(client, i, qdd, WAIT_NS), TFA_OK);
    const tfa_robot_statistics *arm = await_requests(&r, 0, 40);
    assert_int_equal(arm->clients, 1);
    assert_string_equal(arm->served.model_hash, hash);
    assert_string_not_equal(r.now->robots[1].served.model_hash, hash);
    assert_int_equal(r.now->reloads, 1);
}

/* ---- the descriptor ---- */

static int ask_descriptor(const harness *h)
{
    union {
        char bytes[CMSG_SPACE(sizeof(int))];
        struct cmsghdr align;
    } control;
    char text[16];
    struct iovec part = {.iov_base = text, .iov_len = sizeof text};
    struct msghdr message = {.msg_iov = &part,
                             .msg_iovlen = 1,
                             .msg_control = control.bytes,
                             .msg_controllen = sizeof control.bytes};
    const int fd = harness_dial(h, ".control.sock");
    int found = -1;
    assert_int_equal(send(fd, "statistics", 10, 0), 10);
    assert_int_equal(recvmsg(fd, &message, 0), 2);
    assert_memory_equal(text, "ok", 2);
    assert_non_null(CMSG_FIRSTHDR(&message));
    memcpy(&found, CMSG_DATA(CMSG_FIRSTHDR(&message)), sizeof found);
    close(fd);
    return found;
}

TEST(a_reader_cannot_write)
{
    char path[64];
    SCOPED_HARNESS h = harness_serve(ARM, "");
    const int fd = ask_descriptor(&h);
    snprintf(path, sizeof path, "/proc/self/fd/%d", fd);
    for (int i = 0; i < 2; i++) {
        const int way = i ? fd : open(path, O_RDWR); /* the same user may reopen it */
        assert_true(way >= 0);
        assert_int_not_equal(ftruncate(way, 0), 0);
        assert_int_not_equal(ftruncate(way, 1 << 30), 0);
        assert_int_equal(write(way, "x", 1), -1);
        assert_ptr_equal(mmap(NULL, 64, PROT_READ | PROT_WRITE, MAP_SHARED, way, 0), MAP_FAILED);
        close(way);
    }
}

/* After the end of the daemon its last figures stay, and say so. */
TEST(end_of_the_daemon)
{
    double qdd[7];
    tfa_statistics *none;
    SCOPED_HARNESS h = harness_serve(ARM, "");
    SCOPED_READER r = open_reader(&h);
    tfa_client *client = harness_connect(&h, "arm", TFA_WAIT_BLOCK);
    assert_int_equal(ask_arm(client, 1, qdd, WAIT_NS), TFA_OK);
    (void)await_requests(&r, 0, 1);
    assert_int_equal(r.now->stopped, 0);
    tfa_client_close(client);
    (void)harness_stop(&h, SIGTERM);
    assert_int_equal(await_requests(&r, 0, 1)->departed.requests, 1);
    assert_int_equal(r.now->stopped, 1);
    assert_int_equal(tfa_statistics_open(h.runtime_dir, 0, &none), TFA_E_DISCONNECTED);
    assert_null(none);
}

/* Files that are no statistics, or other ones, are refused. */
TEST(other_files_are_refused)
{
    tfa_statistics *none;
    uint64_t words[512] = {0};
    const int fd = memfd_create("test", 0);
    assert_true(fd >= 0);
    assert_int_equal(tfa_statistics_map(fd, &none), TFA_E_PROTOCOL);
    assert_int_equal(write(fd, words, sizeof words), sizeof words);
    assert_int_equal(tfa_statistics_map(fd, &none), TFA_E_PROTOCOL);
    assert_null(none);
    close(fd);
    assert_int_equal(tfa_statistics_map(-1, &none), TFA_E_SYSTEM);
}
