/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The runtime directory of a real daemon: it belongs to one daemon, nothing of others is touched,
 * nothing of its own stays.
 */
#include "harness.h"
#include "test.h"

#include <pwd.h>
#include <signal.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

static char *path_in(const harness *h, const char *name)
{
    static char path[160];
    snprintf(path, sizeof path, "%s/%s", h->runtime_dir, name);
    return path;
}

static bool exists(const harness *h, const char *name)
{
    return access(path_in(h, name), F_OK) == 0;
}

/* A socket of another program. @return its descriptor: closed, nobody listens there */
static int foreign_socket(const harness *h, const char *name)
{
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    snprintf(address.sun_path, sizeof address.sun_path, "%.60s/%.20s", h->runtime_dir, name);
    int fd = socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0);
    assert_int_equal(bind(fd, (struct sockaddr *)&address, sizeof address), 0);
    assert_int_equal(listen(fd, 1), 0);
    return fd;
}

static void assert_serves(const harness *h)
{
    double qdd[7];
    tfa_client *client = harness_connect(h, "arm", TFA_WAIT_BLOCK);
    assert_int_equal(ask_arm(client, 1, qdd, WAIT_NS), TFA_OK);
    tfa_client_close(client);
}

/* It fails, and says why. */
static void assert_refused(harness *h, const char *reason)
{
    const int status = harness_run(h);
    assert_true(WIFEXITED(status) && WEXITSTATUS(status) == 2);
    assert_true(harness_logged(h, reason));
}

TEST(sockets_of_others_stay)
{
    harness h;
    harness_make(&h, ARM, "");
    assert_int_equal(mkdir(h.runtime_dir, 0755), 0);
    const int fd = foreign_socket(&h, "listens.sock");
    close(foreign_socket(&h, "dead.sock"));
    harness_start(&h, "arm");
    assert_int_equal(harness_stop(&h, SIGTERM), 0);
    assert_true(exists(&h, "listens.sock"));
    assert_true(exists(&h, "dead.sock"));
    assert_false(exists(&h, "arm.sock"));
    assert_false(exists(&h, "totalforced.lock"));
    close(fd);
    harness_remove(&h);
}

TEST(a_name_that_another_program_has)
{
    harness h;
    harness_make(&h, ARM, "");
    assert_int_equal(mkdir(h.runtime_dir, 0755), 0);
    const int fd = foreign_socket(&h, "arm.sock");
    assert_refused(&h, "another program listens there");
    assert_true(exists(&h, "arm.sock"));
    close(fd);
    harness_remove(&h);
}

/* What a killed daemon left is removed, even of robots that are no longer configured. */
TEST(after_a_killed_daemon)
{
    harness h;
    harness_make(&h, ARM "  - name: other\n    urdf: @/config/robots/arm7.urdf\n", "");
    harness_start(&h, "other");
    (void)harness_stop(&h, SIGKILL);
    assert_true(exists(&h, "other.sock"));
    harness_configure(&h, ARM, "");
    harness_start(&h, "arm");
    assert_false(exists(&h, "other.sock"));
    assert_serves(&h);
    harness_remove(&h);
}

TEST(only_its_owner_may_write)
{
    static const mode_t modes[] = {0775, 0757, 0777};
    for (size_t i = 0; i < sizeof modes / sizeof *modes; i++) {
        harness h;
        harness_make(&h, ARM, "");
        assert_int_equal(mkdir(h.runtime_dir, 0755), 0);
        assert_int_equal(chmod(h.runtime_dir, modes[i]), 0);
        assert_refused(&h, "must belong to user");
        harness_remove(&h);
    }
}

TEST(a_link_is_no_directory)
{
    harness h;
    char target[96];
    harness_make(&h, ARM, "");
    snprintf(target, sizeof target, "%s/elsewhere", h.directory);
    assert_int_equal(mkdir(target, 0755), 0);
    assert_int_equal(symlink(target, h.runtime_dir), 0);
    assert_refused(&h, "is not a directory");
    harness_remove(&h);
}

/* A directory that was there keeps its owner; one of somebody else is refused. */
TEST(owners)
{
    static const char *const more[] = {"", "user: nobody\n"};
    const struct passwd *nobody = getpwnam("nobody");
    if (geteuid() != 0 || !nobody)
        skip();
    for (int i = 0; i < 2; i++) {
        harness h;
        struct stat info;
        const uid_t owner = i == 0 ? nobody->pw_uid : 0; /* the other one */
        harness_make(&h, ARM, more[i]);
        assert_int_equal(chmod(h.directory, 0755), 0);
        assert_int_equal(mkdir(h.runtime_dir, 0755), 0);
        assert_int_equal(chown(h.runtime_dir, owner, 0), 0);
        assert_refused(&h, "must belong to user");
        assert_int_equal(stat(h.runtime_dir, &info), 0);
        assert_int_equal(info.st_uid, owner);
        harness_remove(&h);
    }
}

/* It is removed under a daemon that runs: old clients go on, and new ones can come soon. */
TEST(removed_while_it_runs)
{
    harness h;
    double qdd[7];
    harness_serve(&h, ARM, "");
    tfa_client *client = harness_connect(&h, "arm", TFA_WAIT_BLOCK);
    assert_int_equal(unlink(path_in(&h, "arm.sock")), 0);
    assert_int_equal(unlink(path_in(&h, ".control.sock")), 0);
    assert_int_equal(unlink(path_in(&h, "totalforced.lock")), 0);
    assert_int_equal(rmdir(h.runtime_dir), 0);
    assert_int_equal(ask_arm(client, 1, qdd, WAIT_NS), TFA_OK);
    assert_true(harness_logged(&h, "was removed"));
    while (!exists(&h, "totalforced.lock") || !exists(&h, "arm.sock"))
        sleep_ms(10);
    sleep_ms(50);
    assert_serves(&h);
    assert_int_equal(ask_arm(client, 1, qdd, WAIT_NS), TFA_OK);
    tfa_client_close(client);
    assert_int_equal(harness_stop(&h, SIGTERM), 0);
    assert_int_equal(access(h.runtime_dir, F_OK), -1);
    harness_remove(&h);
}

/* Another daemon has a directory of that name by now: the sockets of that one stay. */
TEST(successor_keeps_its_sockets)
{
    harness first, second;
    char away[96];
    harness_serve(&first, ARM, "");
    second = first;
    assert_int_equal(kill(first.pid, SIGSTOP), 0);
    snprintf(away, sizeof away, "%s/away", first.directory);
    assert_int_equal(rename(first.runtime_dir, away), 0);
    harness_start(&second, "arm");
    assert_int_equal(kill(first.pid, SIGCONT), 0);
    sleep_ms(1200); /* it looks once a second */
    assert_int_equal(harness_stop(&first, SIGTERM), 0);
    assert_serves(&second);
    assert_int_equal(harness_stop(&second, SIGTERM), 0);
    harness_remove(&second);
}
