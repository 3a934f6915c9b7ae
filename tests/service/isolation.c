/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A client that takes more than its share, or reaches for memory that it may only read. The daemon
 * and its other clients go on.
 */
#include "raw_client.h"

#include "test.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

static const char *const backends[] = {"backend: shm\n", "backend: memfd\n"};

/* Six connections that say nothing; the honest client is the fourth of its user. The daemon answers
 * in the order of connections: when the later ones are answered the first three were accepted.
 * @return false: the first three were turned out for their silence before the later ones came, or a
 * former client was still there */
static bool three_of_six_are_refused(const harness *h)
{
    tfa_welcome w;
    int fds[6];
    bool refused = true;
    for (int i = 0; i < 6; i++)
        fds[i] = connect_raw(h);
    for (int i = 3; i < 6; i++)
        refused = receive_status(fds[i], &w) == TFA_E_REFUSED && refused &&
                  strstr(w.text, "clients_per_user") != NULL;
    for (int i = 0; i < 3; i++)
        refused = recv(fds[i], &w, sizeof w, MSG_DONTWAIT) <= 0 && refused;
    for (int i = 0; i < 6; i++)
        close(fds[i]);
    return refused;
}

/* Connections that have said nothing use up the quota of their user, and are named as the cause. */
TEST(silent_connections_count)
{
    SCOPED_SCENE s = open_scene("limits: {clients: 20, clients_per_user: 4}\n");
    assert_true(WAIT_FOR(three_of_six_are_refused(&s.h)));
    assert_true(harness_logged(&s.h, "clients_per_user"));
}

/* Memory is counted by user. */
TEST(memory_of_a_user_is_limited)
{
    tfa_client *client;
    SCOPED_SCENE s = open_scene("limits: {memory_mib: 64, memory_mib_per_user: 2}\n");
    tfa_client_options options = harness_options(&s.h, "arm");
    options.slots = 64;
    options.max_batch = 64;
    assert_int_equal(tfa_client_connect(&options, &client), TFA_E_REFUSED);
    assert_true(harness_logged(&s.h, "memory_mib_per_user"));
}

/* A request segment that grows, by its size or by pages behind its end, ends its client, and the
 * daemon lets go of the memory. */
TEST(grown_segments)
{
    SCOPED_SCENE s = open_scene("");
    for (int i = 0; i < 2; i++) {
        SCOPED_RAW_CLIENT v = connect_client(&s.h, TFA_WAIT_BLOCK);
        const int fd = v.fds[TFA_WELCOME_REQUESTS];
        const off_t size = (off_t)v.ring.layout.request_bytes;
        if (i == 0)
            assert_int_equal(ftruncate(fd, size + (8 << 20)), 0);
        else
            assert_int_equal(fallocate(fd, FALLOC_FL_KEEP_SIZE, size, 8 << 20), 0);
        assert_hung_up(v.socket);
        assert_unharmed(&s);
    }
    assert_true(harness_logged(&s.h, "changed the size of its memory"));
}

/* A client of the daemon's own user opens what it may only read a second time, for writing: with
 * seals it cannot spoil anything; without them only its own connection. */
TEST(reopened_for_writing)
{
    static const int readonly[] = {TFA_WELCOME_REPLIES, TFA_WELCOME_NAMES};
    for (int k = 0; k < 2; k++) {
        SCOPED_SCENE s = open_scene(backends[k]);
        for (int i = 0; i < 2; i++) {
            SCOPED_RAW_CLIENT v = connect_client(&s.h, TFA_WAIT_BLOCK);
            char path[64];
            snprintf(path, sizeof path, "/proc/self/fd/%d", v.fds[readonly[i]]);
            const int fd = open(path, O_RDWR);
            const bool sealed = k == 1 || readonly[i] == TFA_WELCOME_NAMES;
            assert_true(fd >= 0);
            assert_int_equal(ftruncate(fd, 0) == 0, !sealed);
            void *memory = mmap(NULL, 4096, PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
            assert_int_equal(memory == MAP_FAILED, sealed);
            if (memory != MAP_FAILED)
                munmap(memory, 4096);
            /* the worker answers into a segment that has no memory any more */
            const tfa_wire_request line = {.count = 1, .op = TFA_OP_MASS_MATRIX};
            memcpy(tfa_ring_next_request(&v.ring), &line, sizeof line);
            tfa_ring_client blind = v.ring;
            static const tfa_ring_worker_status awake;
            blind.worker_status = &awake;
            (void)tfa_ring_send(&blind);
            wake(&v);
            if (!sealed)
                assert_hung_up(v.socket);
            assert_unharmed(&s);
            close(fd);
        }
    }
}

/* @return status of a greeting */
static int greet(const harness *h)
{
    tfa_welcome w;
    const tfa_hello hello = good_hello(TFA_WAIT_BLOCK);
    const int fd = connect_raw(h);
    (void)!send(fd, &hello, sizeof hello, MSG_NOSIGNAL);
    return receive_status(fd, &w);
}

/* Connects so many times as user nobody of group nogroup. @return status of the last one */
static int as_nobody(scene *s, int connections)
{
    assert_int_equal(chmod(s->h.directory, 0711), 0);
    const pid_t child = fork();
    if (child == 0) {
        int last = TFA_OK;
        if (!become_user(USER_NOBODY))
            _exit(99);
        for (int i = 0; i < connections; i++)
            last = greet(&s->h);
        _exit(-last);
    }
    return -child_end(child);
}

/* A user whom the sockets' group lets in, but not the list of users or groups. */
TEST(allowed_users_and_groups)
{
    static const struct {
        const char *lists;
        int status;
    } cases[] = {
        {"", TFA_OK},
        {"allow_users: [daemon]\n", TFA_E_REFUSED},
        {"allow_users: [daemon, nobody]\n", TFA_OK},
        {"allow_groups: [daemon]\n", TFA_E_REFUSED},
        {"allow_users: [daemon]\nallow_groups: [nogroup]\n", TFA_OK},
    };
    if (geteuid() != 0)
        skip();
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        scene s;
        char more[128];
        snprintf(more, sizeof more, "group: nogroup\n%s", cases[i].lists);
        s = open_scene(more);
        assert_int_equal(as_nobody(&s, 1), cases[i].status);
        close_scene(&s);
    }
}

/* In a child as user nobody. @return whether the client is refused with these words, and without
 * `absent` */
static bool nobody_is_told(scene *s, const char *word, const char *other, const char *absent)
{
    assert_int_equal(chmod(s->h.directory, 0711), 0);
    const tfa_client_options options = harness_options(&s->h, "arm");
    const pid_t child = fork();
    if (child == 0) {
        char text[512];
        tfa_client *client;
        if (!become_user(USER_NOBODY))
            _exit(99);
        const int status = tfa_client_connect(&options, &client);
        (void)tfa_client_explain(&options, status, text, sizeof text);
        const bool told = status == TFA_E_REFUSED && strstr(text, "/arm.sock, of mode 0660") &&
                          strstr(text, word) && strstr(text, other) && !strstr(text, absent);
        if (!told)
            fprintf(stderr, "%s\n", text);
        _exit(told ? 0 : 1);
    }
    return child_end(child) == 0;
}

/* A user whom the mode of the socket keeps out is told the group and how to become a member; root's
 * is not one to join. */
TEST(refused_by_the_mode)
{
    if (geteuid() != 0)
        skip();
    SCOPED_SCENE of_daemon = open_scene("group: daemon\n");
    assert_true(nobody_is_told(&of_daemon, "group 'daemon'", "adduser $USER daemon", "quota"));
    SCOPED_SCENE of_root = open_scene("");
    assert_true(nobody_is_told(&of_root, "group 'root'", "'group' in the daemon's", "adduser"));
}

/* Lists do not open the sockets for users whom the group keeps out: --check says so. */
TEST(kept_out_in_spite_of_the_list)
{
    static const struct {
        const char *more, *warning; /* NULL: none */
    } cases[] = {
        {"allow_users: [root, nobody]\n", "allow_users[1]: user 'nobody' cannot open the sockets"},
        {"group: daemon\nallow_users: [nobody]\n", "adduser nobody daemon"},
        {"group: nogroup\nallow_users: [nobody]\n", NULL},
        {"user: nobody\nallow_users: [nobody]\n", NULL},
    };
    if (geteuid() != 0)
        skip();
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        SCOPED_HARNESS h = harness_make(ARM, cases[i].more);
        assert_int_equal(harness_check(&h), 0);
        if (cases[i].warning)
            assert_true(harness_logged(&h, cases[i].warning));
        else
            assert_int_equal(harness_log_lines(&h, "cannot open"), 0);
    }
}

/* A user with as many connections as it may have locks nobody else out. */
TEST(users_have_quotas_of_their_own)
{
    if (geteuid() != 0)
        skip();
    SCOPED_SCENE s = open_scene("group: nogroup\nlimits: {clients: 8, clients_per_user: 4}\n");
    assert_int_equal(as_nobody(&s, 5), TFA_E_REFUSED);
    SCOPED_CLIENT *client = harness_connect(&s.h, "arm", TFA_WAIT_BLOCK);
}

/* Without descriptors left the daemon turns clients away, says so, and serves the others. */
TEST(descriptors_run_out)
{
    struct rlimit before, few;
    tfa_client_options options;
    tfa_client *client;
    char text[256];
    SCOPED_SCENE s = open_scene("");
    options = harness_options(&s.h, "arm");
    assert_int_equal(prlimit(s.h.pid, RLIMIT_NOFILE, NULL, &before), 0);
    few = before;
    few.rlim_cur = (rlim_t)harness_descriptors(&s.h) / 2; /* the lower half stays open */
    assert_int_equal(prlimit(s.h.pid, RLIMIT_NOFILE, &few, NULL), 0);
    for (int i = 0; i < 3; i++) {
        assert_int_not_equal(tfa_client_connect(&options, &client), TFA_OK);
        assert_unharmed(&s);
        /* an operator, too, who otherwise would keep the control thread busy */
        assert_int_equal(tfa_daemon_command(s.h.runtime_dir, "status", WAIT_MS, text, sizeof text),
                         TFA_E_DISCONNECTED);
    }
    assert_int_equal(prlimit(s.h.pid, RLIMIT_NOFILE, &before, NULL), 0);
    assert_int_equal(tfa_client_connect(&options, &client), TFA_OK);
    tfa_client_close(client);
}

/* Kinds of requests that the configuration takes away, by field; everything else is answered. */
TEST(refused_kinds)
{
    static const struct {
        const char *word;
        tfa_request change;
        tfa_field field;
    } cases[] = {
        {"several-tips", {.tip_count = 2, .tips = {1, 2}}, TFA_FIELD_TIPS},
        {"spectrum", {.tip_count = 1, .tips = {9}, .flags = TFA_WANT_SPECTRUM}, TFA_FIELD_OP},
        {"lambda", {.tip_count = 1, .tips = {9}, .flags = TFA_WANT_P}, TFA_FIELD_OP},
        {"lambda", {.op = TFA_OP_TASK_TORQUES, .tip_count = 1, .tips = {9}}, TFA_FIELD_OP},
        {"mass-matrix", {.op = TFA_OP_MASS_MATRIX}, TFA_FIELD_OP},
        {"derivatives", {.op = TFA_OP_DERIVATIVES}, TFA_FIELD_OP},
        {"derivatives", {.op = TFA_OP_INVERSE_DYNAMICS_DERIVATIVES}, TFA_FIELD_OP},
        {"methods", {.method = TFA_METHOD_TFA}, TFA_FIELD_METHOD},
        {"estimates", {.estimate = TFA_ESTIMATE_ALWAYS}, TFA_FIELD_ESTIMATE},
        {"batches", {.count = 2}, TFA_FIELD_COUNT},
    };
    static const double zeros[14];
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char robots[256];
        double qdd[14];
        snprintf(robots, sizeof robots, ARM "    refuse: [%s]\n", cases[i].word);
        SCOPED_HARNESS h = harness_serve(robots, "");
        tfa_client_options options = harness_options(&h, "arm");
        options.max_batch = 2;
        SCOPED_CLIENT *client = harness_connect_with(&options);
        tfa_request r = cases[i].change;
        r.op = r.op ? r.op : TFA_OP_FORWARD_DYNAMICS;
        r.count = r.count ? r.count : 1;
        r.q = zeros;
        tfa_reply reply = {.qdd = qdd};
        assert_int_equal(tfa_client_call(client, &r, &reply, WAIT_NS, NULL), TFA_E_REFUSED);
        assert_int_equal(reply.field, cases[i].field);
        assert_int_equal(ask_arm(client, 1, qdd, WAIT_NS), TFA_OK);
    }
}

static tfa_request at_rest(const double *q, uint32_t tips)
{
    tfa_request r = {.op = TFA_OP_OPERATIONAL_INERTIA, .count = 1, .q = q, .tip_count = tips};
    for (uint32_t k = 0; k < tips; k++)
        r.tips[k] = k + 1;
    return r;
}

/* A client gets as many tips as it asks for and the robot has; its memory counts. */
TEST(tips_are_limited)
{
    static const double zeros[7];
    static double lambda_inv[18 * 18];
    harness h;
    char text[400];
    tfa_client *client;
    h = harness_serve(ARM "    max_tips: 2\n", "");
    tfa_client_options options = harness_options(&h, "arm");
    options.max_tips = TFA_MAX_TIPS + 1;
    assert_int_equal(tfa_client_connect(&options, &client), TFA_E_SIZE);
    options.max_tips = TFA_MAX_TIPS;
    assert_int_equal(tfa_client_connect(&options, &client), TFA_OK);
    assert_int_equal(tfa_client_get_info(client)->max_tips, 2);
    tfa_reply reply = {.lambda_inv = lambda_inv};
    tfa_request r = at_rest(zeros, 2);
    assert_int_equal(tfa_client_call(client, &r, &reply, WAIT_NS, NULL), TFA_OK);
    r = at_rest(zeros, 3);
    assert_int_equal(tfa_client_call(client, &r, &reply, WAIT_NS, NULL), TFA_E_SIZE);
    assert_int_equal(reply.field, TFA_FIELD_TIPS);
    tfa_client_close(client);
    harness_remove(&h);
    /* 0.7 MiB a connection, and the daemon may not have noticed yet that the last one is closed */
    h = harness_serve(ARM "    max_tips: 32\n", "limits: {memory_mib_per_user: 2}\n");
    options = harness_options(&h, "arm");
    /* one still leaves */
    assert_true(WAIT_FOR((sleep_ms(5), tfa_client_connect(&options, &client) == TFA_OK)));
    tfa_client_close(client);
    options.max_tips = TFA_MAX_TIPS;
    const int status = tfa_client_connect(&options, &client);
    assert_int_equal(status, TFA_E_REFUSED);
    (void)tfa_client_explain(&options, status, text, sizeof text);
    assert_non_null(strstr(text, "fewer tips"));
    harness_remove(&h);
}

/* Names that do not exist are errors with their place. */
TEST(unknown_names_are_refused)
{
    SCOPED_HARNESS h = harness_make(ARM, "allow_users: [nobody, nobodi]\n");
    harness_assert_refused(&h, "allow_users[1]: 'nobodi' does not exist");
}

int main(void)
{
    signal(SIGPIPE, SIG_IGN);
    return test_run(NULL, NULL);
}
