/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Clients that speak the protocol themselves, and badly. A witness must not notice.
 *
 *   test_hostile [SECONDS]    again and again for so long; once
 */
#include "attacks.h"
#include "fuzz/random.h"
#include "raw_client.h"
#include "test.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

static struct random_source bits = {1};

/* ---- memory ---- */

TEST(truncates_its_requests)
{
    SCOPED_SCENE s = open_scene("");
    for (int i = 0; i < 20; i++) {
        SCOPED_RAW_CLIENT v = connect_client(&s.h, i & 1 ? TFA_WAIT_SPIN : TFA_WAIT_BLOCK);
        /* to nothing, or to one page, so that the worker falls over a later slot */
        assert_int_equal(ftruncate(v.fds[TFA_WELCOME_REQUESTS], i & 2 ? 4096 : 0), 0);
        if (i & 2) {
            const tfa_wire_request line = {.count = 1};
            memcpy(tfa_ring_next_request(&v.ring), &line, sizeof line);
            (void)tfa_ring_send(&v.ring); /* the first slot is there; the next is not */
            (void)ftruncate(v.fds[TFA_WELCOME_REQUESTS], 0);
        }
        wake(&v);
        assert_hung_up(v.socket);
        assert_unharmed(&s);
    }
    assert_true(harness_logged(&s.h, "its memory"));
}

TEST(replies_are_out_of_reach)
{
    static const char *const backends[] = {"backend: shm\n", "backend: memfd\n"};
    for (int i = 0; i < 2; i++) {
        SCOPED_SCENE s = open_scene(backends[i]);
        SCOPED_RAW_CLIENT v = connect_client(&s.h, TFA_WAIT_BLOCK);
        static const int readonly[] = {TFA_WELCOME_REPLIES, TFA_WELCOME_NAMES};
        for (int k = 0; k < 2; k++) {
            const int fd = v.fds[readonly[k]];
            assert_int_not_equal(ftruncate(fd, 0), 0);
            assert_int_equal(write(fd, "x", 1), -1);
            assert_ptr_equal(mmap(NULL, 64, PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0), MAP_FAILED);
        }
        if (i == 1) {
            assert_int_not_equal(ftruncate(v.fds[TFA_WELCOME_REQUESTS], 0), 0);
            assert_int_equal(errno, EPERM); /* sealed */
        }
    }
}

/* ---- slots ---- */

/* Random bytes under a good sequence number: every one is answered, most with a refusal. */
TEST(writes_garbage)
{
    SCOPED_SCENE s = open_scene("");
    SCOPED_RAW_CLIENT v = connect_client(&s.h, TFA_WAIT_HYBRID);
    const uint32_t dof = v.welcome.shape.q_count + v.welcome.shape.v_count;
    for (int i = 0; i < 5000; i++) {
        uint64_t *slot = tfa_ring_next_request(&v.ring);
        for (size_t k = 1; k < v.ring.layout.request_stride / 8; k++)
            slot[k] = random_next(&bits);
        tfa_wire_request *line = (tfa_wire_request *)(void *)slot;
        if (i & 1)
            line->dof = dof;
        if (i & 2)
            line->op %= TFA_OP_LAST + 1, line->method %= 7, line->rows %= 3, line->rank_loss %= 4;
        if (i & 4)
            line->count %= 3, line->tip_count %= 10, line->wrench_count &= 7;
        if (i & 8)
            line->payload_count %= 6, line->locked_count %= 9, line->constraints &= 7;
        if (i & 16)
            line->flags &= TFA_WANT_ALL;
        const uint64_t id = line->id;
        if (tfa_ring_send(&v.ring))
            wake(&v);
        assert_int_equal(await_reply(&v)->id, id);
        tfa_ring_release(&v.ring);
        if (i % 500 == 0)
            assert_unharmed(&s);
    }
}

/* What the counts and blocks of a request whose other bytes are 0 deserve. A block without a count
 * is nothing; a count without its block lacks it. */
static int32_t expected_status(const tfa_wire_request *line, uint32_t joints, tfa_field *field)
{
    const struct {
        uint32_t count, limit, block;
        tfa_field field;
    } lists[] = {
        {line->payload_count, TFA_MAX_PAYLOADS, TFA_WIRE_PAYLOADS, TFA_FIELD_PAYLOADS},
        {line->locked_count, joints, TFA_WIRE_LOCKED, TFA_FIELD_LOCKED},
    };
    for (size_t k = 0; k < sizeof lists / sizeof *lists; k++) {
        *field = lists[k].field;
        if (lists[k].count > lists[k].limit)
            return TFA_E_SIZE;
        if (lists[k].count && !(line->present >> lists[k].block & 1))
            return TFA_E_ARGUMENT;
    }
    *field = TFA_FIELD_NONE;
    return TFA_OK;
}

static void exchange_line(raw_client *v, const tfa_wire_request *line)
{
    unsigned char *slot = tfa_ring_next_request(&v->ring);
    memset(slot + 8, 0, v->ring.layout.request_stride - 8);
    memcpy(slot + 8, (const unsigned char *)line + 8, sizeof *line - 8);
    if (tfa_ring_send(&v->ring))
        wake(v);
    tfa_field field;
    const tfa_wire_reply *reply = await_reply(v);
    const int32_t status = expected_status(line, v->welcome.shape.v_count, &field);
    if (reply->status != status || reply->field != (uint32_t)field || reply->id != line->id)
        fail_msg("payloads %u, locked %u, blocks %x: %s about %s, not %s about %s",
                 line->payload_count, line->locked_count, (unsigned)line->present,
                 tfa_status_name(reply->status), tfa_field_name((tfa_field)reply->field),
                 tfa_status_name(status), tfa_field_name(field));
    tfa_ring_release(&v->ring);
}

/* Counts without blocks, blocks without counts, counts beyond everything: each refused by name. */
TEST(counts_without_measure)
{
    SCOPED_SCENE s = open_scene("");
    SCOPED_RAW_CLIENT v = connect_client(&s.h, TFA_WAIT_HYBRID);
    const tfa_wire_shape *shape = &v.welcome.shape;
    const uint32_t joints[] = {0, 1, shape->v_count, shape->v_count + 1, UINT32_MAX};
    static const uint8_t payloads[] = {0, 1, TFA_MAX_PAYLOADS + 1, 255};
    for (uint32_t i = 0; i < 4 * 5 * 4; i++) {
        tfa_wire_request line = {.id = i,
                                 .count = 1,
                                 .dof = shape->q_count + shape->v_count,
                                 .op = TFA_OP_FORWARD_DYNAMICS,
                                 .want = 1u << TFA_WIRE_OUT_QDD,
                                 .present = 1u << TFA_WIRE_Q};
        line.payload_count = payloads[i % 4];
        line.locked_count = joints[i / 4 % 5];
        line.present |= i / 20 & 1 ? 1u << TFA_WIRE_PAYLOADS : 0;
        line.present |= i / 20 & 2 ? 1u << TFA_WIRE_LOCKED : 0;
        exchange_line(&v, &line);
        if (i % 20 == 0)
            assert_unharmed(&s);
    }
}

TEST(sequence_outside_the_window)
{
    static const uint64_t numbers[] = {2, 9, 1000, UINT64_MAX, UINT64_MAX - 8};
    SCOPED_SCENE s = open_scene("");
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++) {
        raw_client v = connect_client(&s.h, TFA_WAIT_BLOCK);
        tfa_wire_request *line = tfa_ring_next_request(&v.ring);
        atomic_store(&line->seq, numbers[i]);
        wake(&v);
        assert_hung_up(v.socket);
        disconnect_client(&v);
        assert_unharmed(&s);
    }
}

/* Fills the ring again and again and never reads a reply; says it sleeps, too. */
TEST(fills_the_ring)
{
    SCOPED_SCENE s = open_scene("");
    SCOPED_RAW_CLIENT v = connect_client(&s.h, TFA_WAIT_HYBRID);
    const pid_t child = fork();
    if (child == 0) {
        (void)prctl(PR_SET_PDEATHSIG, SIGKILL);
        const tfa_wire_request line = {.count = 1, .op = TFA_OP_MASS_MATRIX};
        atomic_store(&tfa_ring_client_flags_of(&v.ring)->asleep, 1);
        for (;;) {
            unsigned char *slot = tfa_ring_next_request(&v.ring);
            memcpy(slot + 8, (const unsigned char *)&line + 8, sizeof line - 8);
            (void)tfa_ring_send(&v.ring);
            wake(&v);
            for (int t = 0; t < 100 && !tfa_ring_reply_ready(&v.ring); t++)
                tfa_ring_cpu_relax(); /* now and then it even overtakes the worker */
            v.ring.received++;
        }
    }
    for (int i = 0; i < 200; i++)
        assert_unharmed(&s);
    kill(child, SIGKILL);
}

/* ---- stopped in the middle ---- */

static void write_request(raw_client *v, uint64_t id)
{
    const tfa_wire_shape *shape = &v->welcome.shape;
    const tfa_wire_request line = {.id = id,
                                   .count = 1,
                                   .dof = shape->q_count + shape->v_count,
                                   .op = TFA_OP_FORWARD_DYNAMICS,
                                   .want = 1u << TFA_WIRE_OUT_QDD,
                                   .present = 1u << TFA_WIRE_Q};
    unsigned char *slot = tfa_ring_next_request(&v->ring);
    memset(slot + 8, 0, v->ring.layout.request_stride - 8);
    memcpy(slot + 8, (const unsigned char *)&line + 8, sizeof line - 8);
}

/* A process with the client's memory that publishes `published` requests, writes one more and stops
 * there; when it goes on it publishes that one, too, and ends. */
static pid_t stop_in_mid_request(raw_client v, uint64_t published)
{
    int status;
    const pid_t child = fork();
    if (child == 0) {
        (void)prctl(PR_SET_PDEATHSIG, SIGKILL);
        for (uint64_t id = 1; id <= published; id++) {
            write_request(&v, id);
            (void)tfa_ring_send(&v.ring);
        }
        wake(&v);
        if (published < v.ring.layout.slots)
            write_request(&v, published + 1);
        raise(SIGSTOP);
        if (published < v.ring.layout.slots)
            (void)tfa_ring_send(&v.ring);
        wake(&v);
        _exit(0);
    }
    assert_int_equal(waitpid(child, &status, WUNTRACED), child);
    assert_true(WIFSTOPPED(status));
    return child;
}

static void assert_replies(raw_client *v, uint64_t from, uint64_t to)
{
    for (uint64_t id = from; id <= to; id++) {
        const tfa_wire_reply *reply = await_reply(v);
        assert_int_equal(reply->id, id);
        assert_int_equal(reply->status, TFA_OK);
        tfa_ring_release(&v->ring);
    }
}

/* Between writing a slot and publishing it, with replies unread, with a full ring of them: what was
 * published is answered, what was not is answered when the client goes on. */
TEST(stopped_in_mid_request)
{
    static const tfa_wait waits[] = {TFA_WAIT_SPIN, TFA_WAIT_HYBRID, TFA_WAIT_BLOCK};
    static const uint64_t published[] = {0, 3, 8};
    SCOPED_SCENE s = open_scene("");
    for (int i = 0; i < 9; i++) {
        SCOPED_RAW_CLIENT v = connect_client(&s.h, waits[i / 3]);
        const uint64_t count = published[i % 3], slots = v.ring.layout.slots;
        const pid_t child = stop_in_mid_request(v, count);
        for (int k = 0; k < 20; k++)
            assert_unharmed(&s);
        assert_replies(&v, 1, count);
        assert_false(tfa_ring_reply_ready(&v.ring));
        assert_int_equal(kill(child, SIGCONT), 0);
        assert_int_equal(waitpid(child, NULL, 0), child);
        if (count < slots)
            assert_replies(&v, count + 1, count + 1);
    }
}

/* ---- many at once ---- */

#define CROWD                                                                                      \
    "limits: {clients: 100, clients_per_user: 100, memory_mib: 2048, memory_mib_per_user: 2048}\n" \
    "log: error\n"

/* Each attack of the list, until its sessions have done so much; bench_hostility measures what it
 * costs. */
TEST(beside_each_attack)
{
    SCOPED_SCENE s = open_scene(CROWD);
    for (size_t i = 0; i < attack_count; i++) {
        const pid_t child = attack_start(&attacks[i], &s.h);
        for (int k = 0; k < 20; k++)
            assert_unharmed(&s);
        assert_true(WAIT_FOR((assert_unharmed(&s), attack_steps() >= attacks[i].steps)));
        attack_stop(child);
    }
}

static uint64_t heartbeat(const harness *h)
{
    static char text[65536];
    unsigned long long beat = 0;
    assert_int_equal(tfa_daemon_command(h->runtime_dir, "status", WAIT_MS, text, sizeof text),
                     TFA_OK);
    const char *at = strstr(text, "\"heartbeat\": ");
    assert_non_null(at);
    assert_int_equal(sscanf(at, "\"heartbeat\": %llu", &beat), 1);
    return beat;
}

static void await_heartbeat(const harness *h)
{
    const uint64_t from = heartbeat(h);
    assert_true(WAIT_FOR(heartbeat(h) != from));
}

/* The heaviest attack is under way: the worker shows progress, and the daemon ends when it is told
 * to. */
TEST(progress_and_end_under_attack)
{
    static const char *const heavy[] = {"spectra of 8 tips", "batches of 64, 4 tips, spectra"};
    for (size_t i = 0; i < attack_count; i++) {
        if (strcmp(attacks[i].name, heavy[0]) != 0 && strcmp(attacks[i].name, heavy[1]) != 0)
            continue;
        SCOPED_HARNESS h = harness_serve(ARM, CROWD);
        const pid_t child = attack_start(&attacks[i], &h);
        assert_true(WAIT_FOR(attack_steps() >= attacks[i].steps));
        for (int k = 0; k < 5; k++)
            await_heartbeat(&h);
        assert_int_equal(harness_stop(&h, SIGTERM), 0);
        attack_stop(child);
    }
}

/* ---- the socket ---- */

TEST(garbage_handshake)
{
    SCOPED_SCENE s = open_scene("");
    for (int i = 0; i < 100; i++) {
        unsigned char bytes[512];
        tfa_welcome w;
        for (size_t k = 0; k < sizeof bytes; k++)
            bytes[k] = (unsigned char)random_next(&bits);
        tfa_hello hello = good_hello(TFA_WAIT_BLOCK);
        size_t size = sizeof hello;
        hello.max_tips = TFA_MAX_TIPS + 1;
        if (i % 4 == 0)
            size = 1 + random_below(&bits, sizeof bytes);
        else if (i % 4 == 1)
            memcpy(bytes, &hello, 8); /* right magic and version, then noise */
        else if (i % 4 == 2)
            memset(hello.robot, 'x', sizeof hello.robot), memcpy(bytes, &hello, sizeof hello);
        else
            memcpy(bytes, &hello, sizeof hello); /* good but for its tips */
        int fd = connect_raw(&s.h);
        assert_int_equal(send(fd, bytes, size, 0), size);
        assert_int_equal(recv(fd, &w, sizeof w, 0), sizeof w);
        assert_int_not_equal(w.status, TFA_OK);
        assert_true(w.text[0] != 0);
        assert_int_equal(recv(fd, &w, sizeof w, 0), 0); /* then it hangs up */
        close(fd);
    }
}

TEST(sends_after_the_handshake)
{
    SCOPED_SCENE s = open_scene("");
    SCOPED_RAW_CLIENT v = connect_client(&s.h, TFA_WAIT_BLOCK);
    const tfa_hello again = good_hello(TFA_WAIT_BLOCK);
    assert_int_equal(send(v.socket, &again, sizeof again, 0), sizeof again);
    assert_hung_up(v.socket);
}

/* Says nothing: turned out after a while. Takes the welcome and never reads it: no harm. */
TEST(clients_without_handshake)
{
    SCOPED_SCENE s = open_scene("");
    int silent[10], deaf[10];
    const tfa_hello hello = good_hello(TFA_WAIT_BLOCK);
    for (int i = 0; i < 10; i++) {
        silent[i] = connect_raw(&s.h);
        deaf[i] = connect_raw(&s.h);
        assert_int_equal(send(deaf[i], &hello, sizeof hello, 0), sizeof hello);
    }
    for (int i = 0; i < 10; i++)
        assert_hung_up(silent[i]);
    assert_unharmed(&s);
    for (int i = 0; i < 10; i++) {
        close(silent[i]);
        close(deaf[i]);
    }
}

/* @return false: some were turned out for their silence, before the last ones came */
static bool most_are_refused(const harness *h)
{
    tfa_welcome w;
    int fds[20];
    bool refused = true;
    for (int i = 0; i < 20; i++)
        fds[i] = connect_raw(h);
    for (int i = 5; i < 20; i++)
        refused = receive_status(fds[i], &w) == TFA_E_REFUSED && refused;
    for (int i = 0; i < 20; i++)
        close(fds[i]);
    return refused;
}

TEST(too_many_clients)
{
    SCOPED_SCENE s = open_scene("limits: {clients: 4}\n");
    assert_true(WAIT_FOR(most_are_refused(&s.h)));
}

int main(int argc, char **argv)
{
    const uint64_t seconds = argc > 1 && atoi(argv[1]) > 0 ? (uint64_t)atoi(argv[1]) : 0;
    const uint64_t end = now_ns() + seconds * 1000000000u;
    int failed;
    signal(SIGPIPE, SIG_IGN);
    do
        failed = test_run(NULL, NULL);
    while (failed == 0 && now_ns() < end);
    return failed;
}
