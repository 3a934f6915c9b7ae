/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The daemon and its standard streams: floods of messages, an error stream that nobody reads, no
 * streams at all.
 */
#include "raw_client.h"

#include "test.h"

#include <fcntl.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

/* On a busy machine those that have left may still count. */
static void connect_and_leave(const harness *h)
{
    tfa_client_options options = harness_options(h, "arm");
    tfa_client *client;
    assert_true(WAIT_FOR(tfa_client_connect(&options, &client) == TFA_OK));
    tfa_client_close(client);
}

/* Starts the daemon with the given standard error; -1: without any standard stream. */
static void launch_with(harness *h, int error)
{
    h->pid = fork();
    if (h->pid == 0) {
        (void)prctl(PR_SET_PDEATHSIG, SIGKILL);
        if (error >= 0)
            (void)dup2(error, STDERR_FILENO);
        for (int fd = 0; error < 0 && fd <= 2; fd++)
            close(fd);
        execl(TFA_BINARY_DIR "/bin/totalforced", "totalforced", h->config, (char *)NULL);
        _exit(127);
    }
    connect_and_leave(h);
}

#define BURST 20 /* lines in a window of 8.6 s: log.c */

/* Thousands of bad greetings are a few lines in the log, which says that there were more. */
TEST(floods_are_limited)
{
    const uint64_t start = now_ns();
    SCOPED_HARNESS h = harness_serve(ARM, "");
    for (int i = 0; i < 3000; i++) {
        tfa_welcome w;
        const int fd = connect_raw(&h);
        (void)!send(fd, "hello", 5, MSG_NOSIGNAL);
        (void)!recv(fd, &w, sizeof w, 0);
        close(fd);
    }
    const unsigned lines = harness_log_lines(&h, "refused");
    print_message("3000 refusals, %u lines\n", lines);
    assert_in_range(lines, 1, BURST * (((now_ns() - start) >> 33) + 2));
    assert_int_equal(harness_stop(&h, SIGTERM), 0);
    assert_true(harness_logged(&h, "more messages like 'client %d"));
}

/* Standard error is a pipe or a terminal that is full: the daemon serves, and stops. */
static void serve_into(int ends[2])
{
    SCOPED_HARNESS h = harness_make(ARM, "log: debug\n");
    assert_int_equal(fcntl(ends[1], F_SETFL, O_NONBLOCK), 0);
    while (write(ends[1], "full ", 5) > 0)
        ;
    assert_int_equal(fcntl(ends[1], F_SETFL, 0), 0);
    launch_with(&h, ends[1]);
    for (int i = 0; i < 50; i++)
        connect_and_leave(&h);
    close(ends[0]);
    close(ends[1]);
}

TEST(nobody_reads_the_pipe)
{
    int ends[2];
    assert_int_equal(pipe(ends), 0);
    serve_into(ends);
}

TEST(nobody_reads_the_terminal)
{
    int ends[2] = {posix_openpt(O_RDWR | O_NOCTTY), -1};
    assert_true(ends[0] >= 0 && grantpt(ends[0]) == 0 && unlockpt(ends[0]) == 0);
    ends[1] = open(ptsname(ends[0]), O_RDWR | O_NOCTTY);
    assert_true(ends[1] >= 0);
    serve_into(ends);
}

/* Messages end nowhere, not in the lock file or in a socket. */
TEST(without_streams)
{
    char path[128], text[256];
    SCOPED_HARNESS h = harness_make(ARM, "log: debug\n");
    launch_with(&h, -1);
    snprintf(path, sizeof path, "%s/totalforced.lock", h.runtime_dir);
    FILE *lock = fopen(path, "r");
    assert_non_null(lock);
    const size_t size = fread(text, 1, sizeof text - 1, lock);
    text[size] = 0;
    fclose(lock);
    assert_null(strstr(text, "totalforced:"));
    assert_non_null(strstr(text, "ready\narm\n"));
}

/* The remedy stands at the end of a message. */
TEST(long_messages_are_whole)
{
    char more[300];
    snprintf(more, sizeof more, "user: \"u%0250d\"\n", 1);
    SCOPED_HARNESS h = harness_make(ARM, more);
    harness_assert_refused(&h, "getent passwd lists them");
}

int main(void)
{
    signal(SIGPIPE, SIG_IGN);
    return test_run(NULL, NULL);
}
