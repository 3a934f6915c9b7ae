/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Commands of operators to a real daemon, and others at the same socket.
 */
#include "harness.h"
#include "ipc/control_socket.h"
#include "test.h"

#include <signal.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

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
    harness_configure(&h, ARM "    gravitas: 1\n", "");
    assert_int_equal(command(&h, "reload"), TFA_E_REFUSED);
    assert_int_equal(command(&h, "dance"), TFA_E_REFUSED);
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
    enum { NOBODY = 65534 };
    if (geteuid() != 0)
        skip();
    SCOPED_HARNESS h = harness_serve(ARM, "group: nogroup\n");
    assert_int_equal(chmod(h.directory, 0711), 0);
    const pid_t child = fork();
    if (child == 0) {
        if (setgid(NOBODY) != 0 || setuid(NOBODY) != 0)
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

int main(void)
{
    signal(SIGPIPE, SIG_IGN);
    return test_run(NULL, NULL);
}
