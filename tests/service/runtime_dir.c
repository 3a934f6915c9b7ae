/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The runtime directory of a real daemon: it belongs to one daemon, nothing of others is touched,
 * nothing of its own stays.
 */
#include "harness.h"
#include "test.h"

#include <fcntl.h>
#include <pthread.h>
#include <pwd.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdio.h>
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
    return socket_at(h->runtime_dir, name, SOCK_SEQPACKET, true);
}

static void assert_serves(const harness *h)
{
    double qdd[7];
    SCOPED_CLIENT *client = harness_connect(h, "arm", TFA_WAIT_BLOCK);
    assert_int_equal(ask_arm(client, 1, qdd, WAIT_NS), TFA_OK);
}

TEST(sockets_of_others_stay)
{
    SCOPED_HARNESS h = harness_make(ARM, "");
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
}

TEST(a_name_that_another_program_has)
{
    SCOPED_HARNESS h = harness_make(ARM, "");
    assert_int_equal(mkdir(h.runtime_dir, 0755), 0);
    const int fd = foreign_socket(&h, "arm.sock");
    harness_assert_refused(&h, "another program listens there");
    assert_true(exists(&h, "arm.sock"));
    close(fd);
}

/* A second daemon is refused, and leaves the first one all its sockets. */
TEST(a_second_daemon_touches_nothing)
{
    harness h, second;
    char text[4096];
    h = harness_serve(ARM, "");
    second = h;
    harness_assert_refused(&second, "another totalforced");
    assert_true(exists(&h, ".control.sock"));
    assert_int_equal(tfa_daemon_command(h.runtime_dir, "status", WAIT_MS, text, sizeof text),
                     TFA_OK);
    assert_serves(&h);
    harness_remove(&h);
}

/* What a killed daemon left is removed, even of robots that are no longer configured. */
TEST(after_a_killed_daemon)
{
    SCOPED_HARNESS h =
        harness_make(ARM "  - name: other\n    urdf: @/config/robots/arm7.urdf\n", "");
    harness_start(&h, "other");
    (void)harness_stop(&h, SIGKILL);
    assert_true(exists(&h, "other.sock"));
    harness_configure(&h, ARM, "");
    harness_start(&h, "arm");
    assert_false(exists(&h, "other.sock"));
    assert_serves(&h);
}

TEST(only_its_owner_may_write)
{
    static const mode_t modes[] = {0775, 0757, 0777};
    for (size_t i = 0; i < sizeof modes / sizeof *modes; i++) {
        SCOPED_HARNESS h = harness_make(ARM, "");
        assert_int_equal(mkdir(h.runtime_dir, 0755), 0);
        assert_int_equal(chmod(h.runtime_dir, modes[i]), 0);
        harness_assert_refused(&h, "must belong to user");
    }
}

TEST(a_link_is_no_directory)
{
    char target[96];
    SCOPED_HARNESS h = harness_make(ARM, "");
    snprintf(target, sizeof target, "%s/elsewhere", h.directory);
    assert_int_equal(mkdir(target, 0755), 0);
    assert_int_equal(symlink(target, h.runtime_dir), 0);
    harness_assert_refused(&h, "is not a directory");
}

/* A check refuses what a start refuses, with key, value and remedy, and leaves nothing behind. */
TEST(a_check_tries_it)
{
    static const struct {
        const char *path, *text;
        mode_t mode; /* of the parent, 0: there is none */
        bool root;   /* others cannot mount, and root writes everywhere */
    } cases[] = {
        {"parent/run", "chmod +t that folder, or choose another runtime_dir", 0777, false},
        {"parent/run", "make that folder, or choose another runtime_dir", 0, false},
        {"parent/run", "check as the daemon's user, or choose another runtime_dir", 0555, false},
        {"c.yaml", "is not a directory: remove it, or choose another runtime_dir", 0, false},
        {"../../proc/run", "a folder below /run takes sockets, or choose another", 0, true},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        SCOPED_HARNESS h = harness_make(ARM, "");
        char parent[96];
        if (cases[i].root ? geteuid() != 0 : cases[i].mode == 0555 && geteuid() == 0)
            continue;
        snprintf(parent, sizeof parent, "%s/parent", h.directory);
        assert_true(!cases[i].mode || mkdir(parent, 0755) == 0);
        assert_true(!cases[i].mode || chmod(parent, cases[i].mode) == 0);
        snprintf(h.runtime_dir, sizeof h.runtime_dir, "%s/%s", h.directory, cases[i].path);
        harness_configure(&h, ARM, "");
        assert_int_equal(harness_check(&h), 2);
        if (!harness_logged(&h, cases[i].text) ||
            !harness_logged(&h, "c.yaml:1:14: runtime_dir: '"))
            fail_msg("case %zu: '%s' is not said", i, cases[i].text);
        harness_assert_refused(&h, "runtime directory '");
        assert_true(!cases[i].mode || chmod(parent, 0755) == 0);
        assert_true(!cases[i].mode || rmdir(parent) == 0);
    }
}

/* A directory that was there keeps its owner; one of somebody else is refused. */
TEST(owners)
{
    static const char *const more[] = {"", "user: nobody\n"};
    const struct passwd *nobody = getpwnam("nobody");
    if (geteuid() != 0 || !nobody)
        skip();
    for (int i = 0; i < 2; i++) {
        struct stat info;
        const uid_t owner = i == 0 ? nobody->pw_uid : 0; /* the other one */
        SCOPED_HARNESS h = harness_make(ARM, more[i]);
        assert_int_equal(chmod(h.directory, 0755), 0);
        assert_int_equal(mkdir(h.runtime_dir, 0755), 0);
        assert_int_equal(chown(h.runtime_dir, owner, 0), 0);
        close(foreign_socket(&h, ".control.sock"));
        harness_assert_refused(&h, "must belong to user");
        assert_true(exists(&h, ".control.sock"));
        assert_int_equal(stat(h.runtime_dir, &info), 0);
        assert_int_equal(info.st_uid, owner);
    }
}

/* It is removed under a daemon that runs: old clients go on, and new ones can come soon. */
TEST(removed_while_it_runs)
{
    double qdd[7];
    SCOPED_HARNESS h = harness_serve(ARM, "");
    tfa_client *client = harness_connect(&h, "arm", TFA_WAIT_BLOCK);
    assert_int_equal(unlink(path_in(&h, "arm.sock")), 0);
    assert_int_equal(unlink(path_in(&h, ".control.sock")), 0);
    assert_int_equal(unlink(path_in(&h, "totalforced.lock")), 0);
    assert_int_equal(rmdir(h.runtime_dir), 0);
    assert_int_equal(ask_arm(client, 1, qdd, WAIT_NS), TFA_OK);
    assert_true(harness_logged(&h, "was removed"));
    assert_true(harness_logged_times(&h, "shared memory: 1 robots", 2)); /* it listens again */
    assert_true(exists(&h, "totalforced.lock") && exists(&h, "arm.sock"));
    assert_serves(&h);
    assert_int_equal(ask_arm(client, 1, qdd, WAIT_NS), TFA_OK);
    tfa_client_close(client);
    assert_int_equal(harness_stop(&h, SIGTERM), 0);
    assert_int_equal(access(h.runtime_dir, F_OK), -1);
}

/* Another daemon has a directory of that name by now: the sockets of that one stay. */
TEST(successor_keeps_its_sockets)
{
    harness first, second;
    char away[96];
    first = harness_serve(ARM, "");
    second = first;
    assert_int_equal(kill(first.pid, SIGSTOP), 0);
    snprintf(away, sizeof away, "%s/away", first.directory);
    assert_int_equal(rename(first.runtime_dir, away), 0);
    harness_start(&second, "arm");
    assert_int_equal(kill(first.pid, SIGCONT), 0);
    assert_true(harness_logged(&first, "another totalforced")); /* it has looked */
    assert_int_equal(harness_stop(&first, SIGTERM), 0);
    assert_serves(&second);
    harness_remove(&second);
}

/* ---- a race at the start ---- */

#define TRIES 20

/* Something else comes to the path of the runtime directory and goes, all the time: in exchange for
 * what is there, or where nothing is. */
typedef struct racer {
    char path[80], other[96];
    bool exchange;
    _Atomic bool stop;
    _Atomic unsigned swaps;
} racer;

static void *race(void *arg)
{
    racer *r = arg;
    while (!atomic_load(&r->stop)) {
        if (r->exchange)
            r->swaps += renameat2(AT_FDCWD, r->path, AT_FDCWD, r->other, RENAME_EXCHANGE) == 0;
        else
            r->swaps += rename(r->other, r->path) == 0 && rename(r->path, r->other) == 0;
        usleep(20); /* nothing depends on it: at every stage of a start */
    }
    return NULL;
}

typedef struct victim {
    char path[96];
    struct stat before;
} victim;

/* A directory of somebody else, in which a daemon would find things to remove. */
static void make_victim(victim *v, const harness *h)
{
    harness there = *h;
    snprintf(v->path, sizeof v->path, "%s/victim", h->directory);
    snprintf(there.runtime_dir, sizeof there.runtime_dir, "%.70s/victim", h->directory);
    assert_int_equal(mkdir(v->path, 0755), 0);
    close(foreign_socket(&there, "arm.sock"));
    close(foreign_socket(&there, ".control.sock"));
    FILE *lock = fopen(path_in(&there, "totalforced.lock"), "w");
    assert_non_null(lock);
    fputs("1 ready\narm\n", lock);
    fclose(lock);
    if (geteuid() == 0)
        assert_int_equal(chown(v->path, 65534, 65534), 0);
    assert_int_equal(stat(v->path, &v->before), 0);
}

/* Wherever it stands now. */
static void assert_untouched(const victim *v, const char *path)
{
    struct stat now;
    char entry[160];
    static const char *const names[] = {"arm.sock", ".control.sock", "totalforced.lock"};
    assert_int_equal(stat(path, &now), 0);
    assert_int_equal(now.st_ino, v->before.st_ino);
    assert_int_equal(now.st_uid, v->before.st_uid);
    assert_int_equal(now.st_gid, v->before.st_gid);
    assert_int_equal(now.st_mode, v->before.st_mode);
    assert_int_equal(now.st_mtim.tv_sec, v->before.st_mtim.tv_sec);
    assert_int_equal(now.st_mtim.tv_nsec, v->before.st_mtim.tv_nsec);
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        snprintf(entry, sizeof entry, "%.120s/%s", path, names[i]);
        assert_int_equal(stat(entry, &now), 0);
        assert_true(S_ISSOCK(now.st_mode) || now.st_size == 12);
    }
}

/* Until it serves, or has refused. */
static void await_start(const harness *h, unsigned ready)
{
    siginfo_t info = {.si_pid = 0};
    assert_true(WAIT_FOR(harness_log_lines(h, "ready:") != ready ||
                         waitid(P_PID, (id_t)h->pid, &info, WEXITED | WNOHANG | WNOWAIT) != 0 ||
                         info.si_pid != 0));
}

static void race_starts(harness *h, const char *other, bool exchange)
{
    racer r = {.exchange = exchange};
    pthread_t thread;
    unsigned started = 0;
    snprintf(r.path, sizeof r.path, "%s", h->runtime_dir);
    snprintf(r.other, sizeof r.other, "%s", other);
    assert_int_equal(pthread_create(&thread, NULL, race, &r), 0);
    assert_true(WAIT_FOR(atomic_load(&r.swaps) > TRIES)); /* it is under way */
    for (int i = 0; i < TRIES; i++) {
        harness_launch(h);
        await_start(h, started);
        const int status = harness_stop(h, SIGTERM);
        assert_true(WIFEXITED(status) && (WEXITSTATUS(status) == 0 || WEXITSTATUS(status) == 2));
        started = harness_log_lines(h, "ready:");
    }
    atomic_store(&r.stop, true);
    pthread_join(thread, NULL);
    print_message("%u of %d started, %u swaps\n", started, TRIES, r.swaps);
}

/* A link to another directory: whatever the daemon does, nothing happens behind it. */
TEST(a_link_that_comes_and_goes)
{
    victim v;
    char link[96];
    SCOPED_HARNESS h = harness_make(ARM, "");
    make_victim(&v, &h);
    snprintf(link, sizeof link, "%s/link", h.directory);
    assert_int_equal(mkdir(h.runtime_dir, 0755), 0);
    assert_int_equal(symlink(v.path, link), 0);
    race_starts(&h, link, true);
    assert_untouched(&v, v.path);
}

/* The other directory itself, which is not the daemon's, in place of the one that it makes: it is
 * refused, not taken over. */
TEST(a_foreign_directory_that_comes_and_goes)
{
    if (geteuid() != 0)
        skip();
    for (int exchange = 0; exchange < 2; exchange++) {
        victim v;
        struct stat info;
        SCOPED_HARNESS h = harness_make(ARM, "");
        make_victim(&v, &h);
        if (exchange)
            assert_int_equal(mkdir(h.runtime_dir, 0755), 0);
        race_starts(&h, v.path, exchange);
        const bool at_home = stat(v.path, &info) == 0 && info.st_ino == v.before.st_ino;
        assert_untouched(&v, at_home ? v.path : h.runtime_dir);
    }
}
