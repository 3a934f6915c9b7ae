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

static int bind_at(const char *directory, const char *name, int type)
{
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    const int fd = socket(AF_UNIX, type | SOCK_CLOEXEC, 0);
    snprintf(address.sun_path, sizeof address.sun_path, "%s/%s", directory, name);
    assert_int_equal(bind(fd, (const struct sockaddr *)&address, sizeof address), 0);
    return fd;
}

static int listen_at(const char *directory, const char *name, int type)
{
    const int fd = bind_at(directory, name, type);
    assert_int_equal(listen(fd, 16), 0);
    return fd;
}

static void add_socket(const char *name)
{
    sockets[socket_count++] = listen_at(h.runtime_dir, name, SOCK_SEQPACKET);
}

static int make_directory(void **state)
{
    (void)state;
    socket_count = 0;
    wrong_number = NULL;
    harness_make(&h, ARM, "");
    assert_int_equal(mkdir(h.runtime_dir, 0755), 0);
    return 0;
}

static int remove_directory(void **state)
{
    (void)state;
    for (int i = 0; i < socket_count; i++)
        close(sockets[i]);
    harness_remove(&h);
    return 0;
}

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
static void clients_wait_for_the_daemon(void **state)
{
    (void)state;
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
static void the_rest_is_made(void **state)
{
    (void)state;
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
    tfa_client *client;
    options.runtime_dir = directory;
    options.wait = TFA_WAIT_BLOCK;
    assert_int_equal(tfa_client_connect(&options, &client), TFA_OK);
    return client;
}

/* The directory is taken away: the daemon keeps the sockets that it was given, says that their
 * paths are gone, and makes the others again. */
static void passed_sockets_are_kept(void **state)
{
    char away[96];
    double qdd[7];
    (void)state;
    snprintf(away, sizeof away, "%s/away", h.directory);
    add_socket("arm.sock");
    activate();
    tfa_client_close(connect_at(h.runtime_dir));
    assert_int_equal(rename(h.runtime_dir, away), 0);
    assert_true(harness_logged(&h, "arm.sock', which the service manager passed, is gone"));
    assert_true(WAIT_FOR(is_socket(".control.sock")));
    assert_false(is_socket("arm.sock"));
    tfa_client *client = connect_at(away);
    assert_int_equal(ask_arm(client, 0.1, qdd, WAIT_NS), TFA_OK);
    tfa_client_close(client);
    assert_int_equal(harness_stop(&h, SIGTERM), 0);
}

static void assert_refused(const char *text)
{
    activate();
    const int status = harness_stop(&h, 0); /* it ends by itself */
    assert_true(WIFEXITED(status));
    assert_int_equal(WEXITSTATUS(status), 2);
    assert_true(harness_logged(&h, text));
}

static void other_robots_are_named(void **state)
{
    (void)state;
    add_socket("arn.sock");
    assert_refused("(arn.sock), which the service manager passed: the configuration has no such");
    assert_true(is_socket("arn.sock"));
}

static void other_kinds_are_named(void **state)
{
    (void)state;
    sockets[socket_count++] = listen_at(h.runtime_dir, "arm.sock", SOCK_STREAM);
    assert_refused("is a stream (SOCK_STREAM); the unit needs ListenSequentialPacket=");
}

static void sockets_that_do_not_listen_are_named(void **state)
{
    (void)state;
    sockets[socket_count++] = bind_at(h.runtime_dir, "arm.sock", SOCK_SEQPACKET);
    assert_refused("does not listen; the unit needs Accept=no");
}

static void other_places_are_named(void **state)
{
    (void)state;
    sockets[socket_count++] = listen_at(h.directory, "arm.sock", SOCK_SEQPACKET);
    assert_refused("lies elsewhere; correct the unit, or runtime_dir");
}

static void files_are_named(void **state)
{
    (void)state;
    sockets[socket_count++] = open("/dev/null", O_RDONLY | O_CLOEXEC);
    assert_refused("not a Unix socket");
}

static void wrong_numbers_are_named(void **state)
{
    (void)state;
    add_socket("arm.sock");
    wrong_number = "two";
    assert_refused("LISTEN_FDS 'two', LISTEN_PID '");
    assert_true(is_socket("arm.sock"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(clients_wait_for_the_daemon, make_directory,
                                        remove_directory),
        cmocka_unit_test_setup_teardown(the_rest_is_made, make_directory, remove_directory),
        cmocka_unit_test_setup_teardown(passed_sockets_are_kept, make_directory, remove_directory),
        cmocka_unit_test_setup_teardown(other_robots_are_named, make_directory, remove_directory),
        cmocka_unit_test_setup_teardown(other_kinds_are_named, make_directory, remove_directory),
        cmocka_unit_test_setup_teardown(other_places_are_named, make_directory, remove_directory),
        cmocka_unit_test_setup_teardown(files_are_named, make_directory, remove_directory),
        cmocka_unit_test_setup_teardown(sockets_that_do_not_listen_are_named, make_directory,
                                        remove_directory),
        cmocka_unit_test_setup_teardown(wrong_numbers_are_named, make_directory, remove_directory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
