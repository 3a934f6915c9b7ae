/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A machine that has no more to give: address space, the disk of the runtime directory, /dev/shm.
 * A new client or the start is refused with the reason; whoever is connected goes on. Mounts are
 * made in a mount namespace of the test's own; where that is not permitted it is skipped.
 */
#include "raw_client.h"

#include "support/sanitized.h"
#include "test.h"

#include <fcntl.h>
#include <sched.h>
#include <signal.h>
#include <sys/mount.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#define SKIPPED 77

/* ---- memory ---- */

static rlim_t address_space(pid_t process)
{
    char path[64];
    unsigned long pages = 0;
    snprintf(path, sizeof path, "/proc/%d/statm", (int)process);
    FILE *in = fopen(path, "r");
    assert_non_null(in);
    assert_int_equal(fscanf(in, "%lu", &pages), 1);
    fclose(in);
    return pages * (rlim_t)sysconf(_SC_PAGESIZE);
}

/* Clients of some megabytes come while the daemon has no more than it had. */
TEST(address_space_runs_out)
{
    static const char *const backends[] = {"backend: shm\n", "backend: memfd\n"};
#ifdef SANITIZED
    skip(); /* the sanitizer ends a program without memory */
#endif
    for (int i = 0; i < 2; i++) {
        struct rlimit before, few;
        tfa_client *client;
        SCOPED_SCENE s = open_scene(backends[i]);
        tfa_client_options options = harness_options(&s.h, "arm");
        options.slots = 16;
        options.max_batch = 64;
        assert_int_equal(prlimit(s.h.pid, RLIMIT_AS, NULL, &before), 0);
        few = before;
        few.rlim_cur = address_space(s.h.pid) + 65536;
        assert_int_equal(prlimit(s.h.pid, RLIMIT_AS, &few, NULL), 0);
        for (int k = 0; k < 20; k++) {
            assert_int_equal(tfa_client_connect(&options, &client), TFA_E_MEMORY);
            assert_unharmed(&s);
        }
        assert_true(harness_logged(&s.h, "KiB: Cannot allocate memory"));
        assert_int_equal(prlimit(s.h.pid, RLIMIT_AS, &before, NULL), 0);
        assert_int_equal(tfa_client_connect(&options, &client), TFA_OK);
        tfa_client_close(client);
    }
}

/* ---- mounts of our own ---- */

/* Runs `check` in a mount namespace. It returns whether all is as it should be. */
static void in_namespace(bool (*check)(void))
{
    const pid_t child = fork();
    if (child == 0) {
        if (unshare(CLONE_NEWNS) != 0 || mount("none", "/", NULL, MS_REC | MS_PRIVATE, NULL) != 0)
            _exit(SKIPPED);
        _exit(!check());
    }
    const int status = child_end(child);
    if (status == SKIPPED) {
        print_message("not allowed to mount\n");
        skip();
    }
    assert_int_equal(status, 0);
}

static bool asks(tfa_client *client)
{
    double qdd[7];
    for (int i = 0; i < 20; i++)
        if (ask_arm(client, i, qdd, WAIT_NS) != TFA_OK)
            return false;
    return true;
}

/* A runtime directory on a disk of one page and so many files. */
static void mount_runtime_dir(const harness *h, int files)
{
    char options[64];
    snprintf(options, sizeof options, "size=4k,mode=0755,nr_inodes=%d", files);
    if (mkdir(h->runtime_dir, 0755) != 0 || mount("run", h->runtime_dir, "tmpfs", 0, options) != 0)
        _exit(SKIPPED);
}

static bool fill(const harness *h)
{
    static const char page[4096];
    char path[160];
    snprintf(path, sizeof path, "%s/full", h->runtime_dir);
    const int fd = open(path, O_WRONLY | O_CREAT | O_CLOEXEC, 0600);
    while (write(fd, page, sizeof page) > 0)
        ;
    return close(fd) == 0;
}

static void unmount(harness *h)
{
    (void)umount2(h->runtime_dir, MNT_DETACH);
    harness_remove(h);
}

/* Sockets take no room: it warns that the lock file says nothing, and serves. */
static bool start_on_a_full_disk(void)
{
    harness h;
    h = harness_make(ARM, "");
    mount_runtime_dir(&h, 100);
    bool good = fill(&h);
    harness_start(&h, "arm");
    tfa_client *client = harness_connect(&h, "arm", TFA_WAIT_BLOCK);
    good = good && asks(client) && harness_logged(&h, "cannot be written: No space left");
    tfa_client_close(client);
    good = good && harness_stop(&h, SIGTERM) == 0;
    unmount(&h);
    return good;
}

TEST(the_disk_of_the_runtime_directory_is_full)
{
    in_namespace(start_on_a_full_disk);
}

/* The directory itself, what fills it, the lock file: no socket can be made. */
static bool start_without_files(void)
{
    harness h;
    h = harness_make(ARM, "");
    mount_runtime_dir(&h, 3);
    bool good = fill(&h);
    const int status = harness_run(&h);
    good = good && WIFEXITED(status) && WEXITSTATUS(status) == 2 &&
           harness_logged(&h, "No space left on device");
    unmount(&h);
    return good;
}

TEST(the_runtime_directory_takes_no_more_files)
{
    in_namespace(start_without_files);
}

/* It fills up while the daemon runs, which needs no more of it. */
static bool fill_while_it_runs(void)
{
    harness h;
    h = harness_make(ARM, "");
    mount_runtime_dir(&h, 100);
    harness_start(&h, "arm");
    tfa_client *first = harness_connect(&h, "arm", TFA_WAIT_BLOCK);
    bool good = fill(&h);
    tfa_client *second = harness_connect(&h, "arm", TFA_WAIT_BLOCK);
    good = good && asks(first) && asks(second);
    tfa_client_close(first);
    tfa_client_close(second);
    good = good && harness_stop(&h, SIGTERM) == 0;
    unmount(&h);
    return good;
}

TEST(the_disk_fills_up_while_it_runs)
{
    in_namespace(fill_while_it_runs);
}

/* A client is refused, and the file system called by its name. */
static bool fill_shm(void)
{
    char text[400];
    tfa_client *client;
    if (mount("shm", "/dev/shm", "tmpfs", 0, "size=64k") != 0)
        _exit(SKIPPED);
    SCOPED_HARNESS h = harness_make(ARM, "");
    tfa_client_options options = harness_options(&h, "arm");
    options.slots = 1;
    options.max_batch = 64;
    harness_launch(&h);
    int status = TFA_E_DISCONNECTED;
    (void)WAIT_FOR((status = tfa_client_connect(&options, &client)) != TFA_E_DISCONNECTED);
    (void)tfa_client_explain(&options, status, text, sizeof text);
    print_message("%s\n", text);
    return status == TFA_E_REFUSED && strstr(text, "/dev/shm") != NULL;
}

TEST(shared_memory_is_full)
{
    in_namespace(fill_shm);
}

/* Puts a /dev with the devices that a program may need, and without shm, in place of the other. */
static void take_shm_away(const harness *h)
{
    static const char *const devices[] = {"null", "zero", "random", "urandom"};
    char dev[96], path[128], device[32];
    snprintf(dev, sizeof dev, "%s/dev", h->directory);
    if (mkdir(dev, 0755) != 0 || mount("dev", dev, "tmpfs", 0, "mode=0755") != 0)
        _exit(SKIPPED);
    for (size_t i = 0; i < sizeof devices / sizeof *devices; i++) {
        snprintf(path, sizeof path, "%s/%s", dev, devices[i]);
        snprintf(device, sizeof device, "/dev/%s", devices[i]);
        close(open(path, O_WRONLY | O_CREAT | O_CLOEXEC, 0666));
        if (mount(device, path, NULL, MS_BIND, NULL) != 0)
            _exit(SKIPPED);
    }
    if (mount(dev, "/dev", NULL, MS_MOVE, NULL) != 0)
        _exit(SKIPPED);
}

static bool lose_shm(void)
{
    char text[400] = "";
    tfa_client *client;
    SCOPED_HARNESS h = harness_serve(ARM, "");
    tfa_client *first = harness_connect(&h, "arm", TFA_WAIT_BLOCK);
    take_shm_away(&h);
    tfa_client_options options = harness_options(&h, "arm");
    const int status = tfa_client_connect(&options, &client);
    (void)tfa_client_explain(&options, status, text, sizeof text);
    print_message("%s\n", text);
    bool good = status != TFA_OK && strstr(text, "/dev/shm: No such") != NULL && asks(first);
    tfa_client_close(first);
    good = good && harness_stop(&h, SIGTERM) == 0;
    return good;
}

TEST(shared_memory_is_gone)
{
    in_namespace(lose_shm);
}

int main(void)
{
    signal(SIGPIPE, SIG_IGN);
    return test_run(NULL, NULL);
}
