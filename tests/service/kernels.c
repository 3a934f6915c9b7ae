/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Specialised kernels in the daemon: loaded at the start, taken by a reload, refused with a reason.
 * The generic kernel serves in all other cases, and clients notice nothing.
 */
#include "bench.h"
#include "harness.h"
#include "test.h"

#include <signal.h>
#include <sys/stat.h>
#include <sys/wait.h>

/* A folder with a fake kernel for the arm, and a daemon that is told of it */
struct served {
    bench b;
    harness h;
    char kernel[400], more[256];
};

static void open_served(struct served *s, const char *mode)
{
    char name[TFA_SPECIALISED_NAME_SIZE];
    bench_open(&s->b);
    tfa_specialised_name(s->b.arm, name);
    snprintf(s->kernel, sizeof s->kernel, "%s/%s", s->b.kernels, name);
    snprintf(s->more, sizeof s->more, "specialise: %s\nspecialise_directory: %s\n", mode,
             s->b.kernels);
    s->h = harness_make(ARM, s->more);
}

static void close_served(struct served *s)
{
    assert_int_equal(harness_stop(&s->h, SIGTERM), 0);
    harness_remove(&s->h);
    bench_close(&s->b);
}

static void it_answers(const harness *h)
{
    double qdd[7];
    SCOPED_CLIENT *client = harness_connect(h, "arm", TFA_WAIT_BLOCK);
    assert_int_equal(ask_arm(client, 0.3, qdd, WAIT_NS), TFA_OK);
    assert_true(isfinite(qdd[0]));
}

TEST(a_kernel_is_loaded)
{
    struct served s;
    open_served(&s, "load");
    bench_build(&s.b, s.b.arm, "SOUND", s.kernel);
    harness_start(&s.h, "arm");
    assert_true(harness_logged(&s.h, "robot 'arm': specialised kernel"));
    it_answers(&s.h);
    close_served(&s);
}

TEST(kernels_are_off_by_default)
{
    struct served s;
    open_served(&s, "off");
    bench_build(&s.b, s.b.arm, "SOUND", s.kernel);
    harness_start(&s.h, "arm");
    it_answers(&s.h);
    assert_int_equal(harness_log_lines(&s.h, "specialised kernel"), 0);
    close_served(&s);
}

/* The reason is in the log, and the robot is served all the same. */
TEST(a_bad_kernel_is_refused)
{
    struct served s;
    open_served(&s, "load");
    bench_build(&s.b, s.b.arm, "WRONG_ANSWER", s.kernel);
    harness_start(&s.h, "arm");
    assert_true(harness_logged(&s.h, "robot 'arm': the generic kernel answers"));
    assert_true(harness_logged(&s.h, "inverse dynamics: tau of state 0"));
    it_answers(&s.h);
    close_served(&s);
    open_served(&s, "load");
    bench_build(&s.b, s.b.arm, "SOUND", s.kernel);
    assert_int_equal(chmod(s.b.kernels, 0777), 0);
    harness_start(&s.h, "arm");
    assert_true(harness_logged(&s.h, "can be written by others (mode 0777)"));
    it_answers(&s.h);
    close_served(&s);
}

/* A reload takes a kernel that appeared, another build of it, and drops one that is gone; who is
 * connected stays. */
TEST(a_reload_exchanges_kernels)
{
    struct served s;
    double qdd[7];
    open_served(&s, "load");
    harness_start(&s.h, "arm");
    assert_true(harness_logged(&s.h, "robot 'arm': no specialised kernel yet"));
    SCOPED_CLIENT *client = harness_connect(&s.h, "arm", TFA_WAIT_BLOCK);
    bench_build(&s.b, s.b.arm, "SOUND", s.kernel);
    for (unsigned turn = 1; turn <= 2; turn++) {
        assert_int_equal(kill(s.h.pid, SIGHUP), 0);
        assert_true(harness_logged_times(&s.h, "reload: done", turn));
        assert_int_equal(ask_arm(client, 0.3, qdd, WAIT_NS), TFA_OK);
    }
    assert_int_equal(harness_log_lines(&s.h, "reload: done, 1 of 1"),
                     1); /* the same the second time */
    assert_int_equal(harness_log_lines(&s.h, "reload: done, 0 of 1"), 1);
    assert_int_equal(remove(s.kernel), 0);
    assert_int_equal(kill(s.h.pid, SIGHUP), 0);
    assert_true(harness_logged_times(&s.h, "reload: done, 1 of 1", 2));
    assert_int_equal(ask_arm(client, 0.3, qdd, WAIT_NS), TFA_OK);
    close_served(&s);
}

TEST(a_folder_must_be_named)
{
    SCOPED_HARNESS h = harness_make(ARM, "specialise: load\n");
    harness_assert_refused(&h, "needs 'specialise_directory'");
}

/* The daemon starts no compiler. */
TEST(build_mode_is_refused)
{
    struct served s;
    open_served(&s, "build");
    harness_assert_refused(&s.h, "specialise: 'build'");
    harness_remove(&s.h);
    bench_close(&s.b);
}
