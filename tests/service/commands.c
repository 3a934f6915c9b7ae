/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Commands of operators to a real daemon, and others at the same socket.
 */
#include "harness.h"
#include "ipc/control_socket.h"
#include "test.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#define PLACES 8 /* connections at once (docs/security.md) */

static char text[TFA_CONTROL_TEXT_MAX];

static int command(const harness *h, const char *word)
{
    return tfa_daemon_command(h->runtime_dir, word, WAIT_MS, text, sizeof text);
}

TEST(status_counts_requests)
{
    double qdd[7];
    SCOPED_HARNESS h = harness_serve(ARM, "");
    SCOPED_CLIENT *client = harness_connect(&h, "arm", TFA_WAIT_BLOCK);
    for (int i = 0; i < 3; i++)
        assert_int_equal(ask_arm(client, i, qdd, WAIT_NS), TFA_OK);
    assert_int_equal(command(&h, "status"), TFA_OK);
    assert_non_null(strstr(text, "\"name\": \"arm\""));
    assert_non_null(strstr(text, "\"requests\": 3, \"rejected\": 0, \"late\": 0"));
}

/* The base's count as well, as tfa_client_info, `totalforce list` and the JSON lines say. */
TEST(status_counts_the_freedoms_of_a_floating_base)
{
    SCOPED_HARNESS h = harness_serve(ARM "    base: floating\n", "");
    assert_int_equal(command(&h, "status"), TFA_OK);
    assert_non_null(strstr(text, "\"joints\": 7, \"freedoms\": 13, \"floating\": true"));
}

TEST(reload_answers_when_it_is_done)
{
    SCOPED_HARNESS h = harness_serve(ARM, "");
    harness_configure(&h, ARM "    gravity: [0, 0, -2]\n", "");
    assert_int_equal(command(&h, "reload"), TFA_OK);
    assert_non_null(strstr(text, "ok: 1 of 1 models exchanged"));
    assert_int_equal(command(&h, "dance"), TFA_E_REFUSED);
}

/* File, line and key; the line of a robot's list is 3. */
TEST(a_refused_reload_gives_the_reason)
{
    static const struct {
        const char *robots, *more, *text[2];
    } cases[] = {
        {ARM "    gravitas: 1\n    gravity: [0]\n",
         "",
         {"/c.yaml:5:5: robots[0]: there is no key 'gravitas'", "/c.yaml:6:14: robots[0].gravity"}},
        {ARM, "workers: 2\n", {"/c.yaml:2:10: workers is another: that needs a restart"}},
        {ARM, "allow_users: [zzyzx]\n", {"/c.yaml:2:15: allow_users[0]: 'zzyzx' does not exist"}},
        {ARM "    armature: [{joint: joint_8, value: 1}]\n", "", {"no joint 'joint_8'"}},
    };
    SCOPED_HARNESS h = harness_serve(ARM, "");
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        harness_configure(&h, cases[i].robots, cases[i].more);
        assert_int_equal(command(&h, "reload"), TFA_E_REFUSED);
        assert_non_null(strstr(text, "error: refused, everything stays as it was:\n"));
        for (int k = 0; k < 2 && cases[i].text[k]; k++)
            if (!strstr(text, cases[i].text[k]))
                fail_msg("no '%s' in '%s'", cases[i].text[k], text);
    }
}

TEST(stop_stops)
{
    SCOPED_HARNESS h = harness_serve(ARM, "");
    assert_int_equal(command(&h, "stop"), TFA_OK);
    assert_int_equal(child_end(h.pid), 0);
    h.pid = 0;
    assert_int_equal(command(&h, "status"), TFA_E_DISCONNECTED);
}

/* The operator was told that it timed out: it must not happen later. */
TEST(a_command_that_timed_out_is_dropped)
{
    static const char *const words[] = {"reload", "stop"};
    SCOPED_HARNESS h = harness_serve(ARM, "");
    harness_configure(&h, ARM "    gravity: [0, 0, -2]\n", "");
    for (int i = 0; i < 2; i++) {
        harness_pause(&h);
        assert_int_equal(tfa_daemon_command(h.runtime_dir, words[i], 100, text, sizeof text),
                         TFA_E_TIMEOUT);
        assert_int_equal(kill(h.pid, SIGCONT), 0);
        assert_int_equal(command(&h, "status"), TFA_OK);
    }
    /* after a reload that was not dropped there would be nothing to exchange */
    assert_int_equal(command(&h, "reload"), TFA_OK);
    assert_non_null(strstr(text, "ok: 1 of 1 models exchanged"));
}

/* A peer that has no more to say than its command still waits for the answer. */
TEST(a_half_closed_peer_is_answered)
{
    static const char *const words[] = {"status", "reload", "stop"};
    static const char *const answers[] = {"{", "ok: 0 of 1 models exchanged", "ok: stopping"};
    SCOPED_HARNESS h = harness_serve(ARM, "");
    for (int i = 0; i < 3; i++) {
        harness_pause(&h);
        const int fd = harness_dial(&h, TFA_CONTROL_SOCKET);
        assert_true(send(fd, words[i], strlen(words[i]), MSG_NOSIGNAL) > 0);
        assert_int_equal(shutdown(fd, SHUT_WR), 0);
        assert_int_equal(kill(h.pid, SIGCONT), 0);
        assert_true(recv(fd, text, sizeof text, 0) > 0);
        assert_memory_equal(text, answers[i], strlen(answers[i]));
        close(fd);
    }
    assert_int_equal(child_end(h.pid), 0);
    h.pid = 0;
}

/* Others of the sockets' group may look, and no more. */
TEST(only_its_user_commands)
{
    if (geteuid() != 0)
        skip();
    SCOPED_HARNESS h = harness_serve(ARM, "group: nogroup\n");
    assert_int_equal(chmod(h.directory, 0711), 0);
    const pid_t child = fork();
    if (child == 0) {
        if (!become_user(USER_NOBODY))
            _exit(1);
        _exit(command(&h, "status") != TFA_OK || command(&h, "describe arm") != TFA_OK ||
              command(&h, "stop") != TFA_E_REFUSED || command(&h, "reload") != TFA_E_REFUSED ||
              command(&h, "record arm 1") != TFA_E_REFUSED);
    }
    assert_int_equal(child_end(child), 0);
}

/* A robot has one description, however often it is asked for, and another after a reload. */
TEST(descriptions_are_shared)
{
    SCOPED_HARNESS h = harness_serve(ARM, "");
    assert_int_equal(command(&h, "describe nobody"), TFA_E_REFUSED);
    assert_string_equal(text, "error: no robot 'nobody' is served here");
    assert_int_equal(command(&h, "describe arm"), TFA_OK);
    const int descriptors = harness_descriptors(&h);
    for (int i = 0; i < 2; i++) {
        for (int k = 0; k < 50; k++)
            assert_int_equal(command(&h, "describe arm"), TFA_OK);
        assert_int_equal(command(&h, "status"), TFA_OK); /* the last connection was closed */
        harness_assert_descriptors(&h, descriptors);
        assert_int_equal(command(&h, "reload"), TFA_OK);
    }
}

/* Silent peers, garbage, peers that never read: the socket is there for others again. */
TEST(others_at_the_socket)
{
    int fds[20];
    unsigned char garbage[4096];
    SCOPED_HARNESS h = harness_serve(ARM, "");
    for (size_t i = 0; i < sizeof garbage; i++)
        garbage[i] = (unsigned char)(i * 37);
    for (int i = 0; i < 200; i++) {
        const int fd = harness_dial(&h, TFA_CONTROL_SOCKET);
        (void)!send(fd, garbage, 1 + (size_t)i * 20 % sizeof garbage, MSG_NOSIGNAL);
        close(fd);
    }
    for (int i = 0; i < 20; i++) {
        fds[i] = harness_dial(&h, TFA_CONTROL_SOCKET);
        if (i % 2)
            (void)!send(fds[i], "status", 6, MSG_NOSIGNAL); /* and does not read */
    }
    assert_true(WAIT_FOR(command(&h, "status") == TFA_OK));
    for (int i = 0; i < 20; i++)
        close(fds[i]);
}

/* Connects so many times as user nobody and says nothing, until the parent has asked. */
static _Noreturn void stay_silent(const harness *h, int count, int ready, int done)
{
    char byte = 0;
    if (!become_user(USER_NOBODY))
        _exit(1);
    for (int i = 0; i < count; i++)
        if (harness_dial(h, TFA_CONTROL_SOCKET) < 0)
            _exit(2);
    _exit(write(ready, &byte, 1) != 1 || read(done, &byte, 1) != 0);
}

/* Silent connections of another user, as many as there are places and more: an operator finds one
 * at once, another user by the end of the oldest. Attempts are counted, not the time. */
TEST(silent_sockets_shut_nobody_out)
{
    int ready[2], done[2];
    char byte;
    if (geteuid() != 0)
        skip();
    SCOPED_HARNESS h = harness_serve(ARM, "group: nogroup\n");
    assert_int_equal(chmod(h.directory, 0711), 0);
    for (int count = 1; count <= 3 * PLACES; count += PLACES) {
        assert_int_equal(pipe2(ready, O_CLOEXEC), 0);
        assert_int_equal(pipe2(done, O_CLOEXEC), 0);
        const pid_t child = fork();
        if (child == 0) {
            close(done[1]);
            stay_silent(&h, count, ready[1], done[0]);
        }
        assert_int_equal(read(ready[0], &byte, 1), 1);
        for (int i = 0; i < 20; i++)
            assert_int_equal(command(&h, "status"), TFA_OK);
        close(done[1]);
        assert_int_equal(child_end(child), 0);
        close(ready[0]);
        close(ready[1]);
        close(done[0]);
    }
}

/* @return false: its time was over before the last one came */
static bool is_told(const harness *h)
{
    int fds[PLACES + 1];
    char answer[128];
    for (int i = 0; i <= PLACES; i++)
        fds[i] = harness_dial(h, TFA_CONTROL_SOCKET);
    const ssize_t size = recv(fds[0], answer, sizeof answer - 1, 0);
    answer[size > 0 ? size : 0] = 0;
    for (int i = 0; i <= PLACES; i++)
        close(fds[i]);
    return strstr(answer, "busy") != NULL;
}

TEST(the_oldest_silent_one_is_told)
{
    SCOPED_HARNESS h = harness_serve(ARM, "");
    assert_true(WAIT_FOR(is_told(&h)));
}

/* All places are an operator's and silent. @return user nobody is told that the daemon is busy;
 * false: a place was free again */
static bool is_nobody_busy(const harness *h)
{
    int fds[PLACES];
    char answer[128];
    for (int i = 0; i < PLACES; i++)
        fds[i] = harness_dial(h, TFA_CONTROL_SOCKET);
    const pid_t child = fork();
    if (child == 0) {
        if (!become_user(USER_NOBODY))
            _exit(99);
        _exit(command(h, "status") != TFA_E_REFUSED || strstr(text, "busy") == NULL);
    }
    const int end = child_end(child);
    assert_in_range(end, 0, 1);
    for (int i = 0; i < PLACES; i++) {
        const ssize_t size = recv(fds[i], answer, sizeof answer - 1, MSG_DONTWAIT);
        answer[size > 0 ? size : 0] = 0;
        assert_null(strstr(answer, "busy"));
        close(fds[i]);
    }
    return end == 0;
}

TEST(operators_make_no_room_for_others)
{
    if (geteuid() != 0)
        skip();
    SCOPED_HARNESS h = harness_serve(ARM, "group: nogroup\n");
    assert_int_equal(chmod(h.directory, 0711), 0);
    assert_true(WAIT_FOR(is_nobody_busy(&h)));
}

int main(void)
{
    signal(SIGPIPE, SIG_IGN);
    return test_run(NULL, NULL);
}
