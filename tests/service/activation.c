/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Socket activation: a service manager made the sockets, and starts the daemon when somebody comes.
 */
#include "harness.h"
#include "test.h"

#include <fcntl.h>
#include <poll.h>
#include <pthread.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#define SOCKETS_MAX 4
#define FIRST_FD 3 /* of the sockets in the daemon, by the protocol of systemd */

static harness h;
static int sockets[SOCKETS_MAX], socket_count;
static const char *wrong_number; /* LISTEN_FDS; NULL: the true one */

static void add_socket(const char *name)
{
    sockets[socket_count++] = socket_at(h.runtime_dir, name, SOCK_SEQPACKET, true);
}

static harness *make_directory(void)
{
    socket_count = 0;
    h = harness_make(ARM, "");
    assert_int_equal(mkdir(h.runtime_dir, 0755), 0);
    return &h;
}

static void remove_directory(harness **unused)
{
    (void)unused;
    for (int i = 0; i < socket_count; i++)
        close(sockets[i]);
    harness_remove(&h);
}
#define SCOPED_DIRECTORY SCOPED(remove_directory) harness

/* As systemd does: the sockets from descriptor 3 on, their number and the process in the
 * environment. */
static void activate(void)
{
    char number[16], log[96];
    snprintf(log, sizeof log, "%s/log", h.directory);
    h.pid = fork();
    assert_true(h.pid >= 0);
    if (h.pid != 0)
        return;
    (void)prctl(PR_SET_PDEATHSIG, SIGKILL);
    (void)dup2(open(log, O_WRONLY | O_CREAT | O_APPEND, 0600), STDERR_FILENO);
    int copies[SOCKETS_MAX];
    for (int i = 0; i < socket_count; i++)
        copies[i] = fcntl(sockets[i], F_DUPFD, 100);
    for (int i = 0; i < socket_count; i++)
        (void)dup2(copies[i], FIRST_FD + i);
    for (int i = 0; i < socket_count; i++)
        close(copies[i]);
    snprintf(number, sizeof number, "%d", (int)getpid());
    setenv("LISTEN_PID", number, 1);
    snprintf(number, sizeof number, "%d", socket_count);
    setenv("LISTEN_FDS", wrong_number ? wrong_number : number, 1);
    execl(TFA_BINARY_DIR "/bin/totalforced", "totalforced", h.config, (char *)NULL);
    _exit(127);
}

static bool is_socket(const char *name)
{
    char path[160];
    struct stat info;
    snprintf(path, sizeof path, "%s/%s", h.runtime_dir, name);
    return stat(path, &info) == 0 && S_ISSOCK(info.st_mode);
}

static void *connect_and_ask(void *status)
{
    double qdd[7];
    tfa_client_options options = harness_options(&h, "arm");
    tfa_client *client;
    options.wait = TFA_WAIT_BLOCK;
    *(int *)status = tfa_client_connect(&options, &client);
    if (*(int *)status != TFA_OK)
        return NULL;
    *(int *)status = ask_arm(client, 0.1, qdd, WAIT_NS);
    tfa_client_close(client);
    return NULL;
}

/* A client that came before the daemon is served, and so is one that comes while it restarts. */
TEST(clients_wait_for_the_daemon)
{
    SCOPED_DIRECTORY *unit = make_directory();
    add_socket("arm.sock");
    add_socket(".control.sock");
    for (int i = 0; i < 3; i++) {
        pthread_t thread;
        int status = TFA_E_TIMEOUT;
        assert_int_equal(pthread_create(&thread, NULL, connect_and_ask, &status), 0);
        struct pollfd listener = {.fd = sockets[0], .events = POLLIN};
        assert_int_equal(poll(&listener, 1, WAIT_MS), 1); /* it has come */
        activate();
        pthread_join(thread, NULL);
        assert_int_equal(status, TFA_OK);
        char text[4096];
        assert_int_equal(tfa_daemon_command(h.runtime_dir, "status", WAIT_MS, text, sizeof text),
                         TFA_OK);
        assert_int_equal(harness_stop(&h, i == 1 ? SIGKILL : SIGTERM), i == 1 ? SIGKILL : 0);
        assert_true(is_socket("arm.sock") && is_socket(".control.sock"));
    }
    assert_true(harness_logged(&h, "the service manager passed 2 sockets"));
}

/* The daemon makes the sockets that it was not given, and removes those alone. */
TEST(the_rest_is_made)
{
    SCOPED_DIRECTORY *unit = make_directory();
    add_socket("arm.sock");
    activate();
    tfa_client *client = harness_connect(&h, "arm", TFA_WAIT_BLOCK);
    tfa_client_close(client);
    assert_true(is_socket(".control.sock"));
    assert_int_equal(harness_stop(&h, SIGTERM), 0);
    assert_true(is_socket("arm.sock"));
    assert_false(is_socket(".control.sock"));
}

static tfa_client *connect_at(const char *directory)
{
    tfa_client_options options = harness_options(&h, "arm");
    options.runtime_dir = directory;
    options.wait = TFA_WAIT_BLOCK;
    return harness_connect_with(&options);
}

/* The directory is taken away: the daemon keeps the sockets that it was given, says that their
 * paths are gone, and makes the others again. */
TEST(passed_sockets_are_kept)
{
    SCOPED_DIRECTORY *unit = make_directory();
    char away[96];
    double qdd[7];
    snprintf(away, sizeof away, "%s/away", h.directory);
    add_socket("arm.sock");
    activate();
    tfa_client_close(connect_at(h.runtime_dir));
    assert_int_equal(rename(h.runtime_dir, away), 0);
    assert_true(harness_logged(&h, "arm.sock', which the service manager passed, is gone"));
    assert_true(WAIT_FOR(is_socket(".control.sock")));
    assert_false(is_socket("arm.sock"));
    SCOPED_CLIENT *client = connect_at(away);
    assert_int_equal(ask_arm(client, 0.1, qdd, WAIT_NS), TFA_OK);
    assert_int_equal(harness_stop(&h, SIGTERM), 0);
}

enum { FILE_DESCRIPTOR = -1 };

/* Each ends the daemon at once, by name, and leaves the sockets where they are. */
TEST(other_sockets_are_refused)
{
    static const struct {
        const char *name;
        int type; /* of the socket */
        bool elsewhere, silent;
        const char *number, *text;
    } cases[] = {
        {"arn.sock", SOCK_SEQPACKET,
         .text = "(arn.sock), which the service manager passed: the "
                 "configuration has no such"},
        {"arm.sock", SOCK_STREAM,
         .text = "is a stream (SOCK_STREAM); the unit needs ListenSequentialPacket="},
        {"arm.sock", SOCK_SEQPACKET, .elsewhere = true,
         .text = "lies elsewhere; correct the unit, or runtime_dir"},
        {"/dev/null", FILE_DESCRIPTOR, .text = "not a Unix socket"},
        {"arm.sock", SOCK_SEQPACKET, .silent = true,
         .text = "does not listen; the unit needs Accept=no"},
        {"arm.sock", SOCK_SEQPACKET, .number = "two", .text = "LISTEN_FDS 'two', LISTEN_PID '"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        SCOPED_DIRECTORY *unit = make_directory();
        const bool file = cases[i].type == FILE_DESCRIPTOR;
        sockets[socket_count++] = file ? open(cases[i].name, O_RDONLY | O_CLOEXEC)
                                       : socket_at(cases[i].elsewhere ? h.directory : h.runtime_dir,
                                                   cases[i].name, cases[i].type, !cases[i].silent);
        wrong_number = cases[i].number;
        activate();
        const int status = harness_stop(&h, 0); /* it ends by itself */
        assert_true(WIFEXITED(status));
        assert_int_equal(WEXITSTATUS(status), 2);
        assert_true(harness_logged(&h, cases[i].text));
        assert_true(file || cases[i].elsewhere || is_socket(cases[i].name));
    }
}
