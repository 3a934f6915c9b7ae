/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The steady state of spinning: requests through two processes without one allocation, one system
 * call or one page fault in the worker's and the client's thread, while the daemon is given other
 * models.
 *
 * Both threads are filtered after a warm-up (syscall_filter.h): the first allocation or system call
 * would end its process. At the end the client goes, the worker wants to sleep, and the filter does
 * kill it: this shows that it was there all the time. The same with a pool that some requests go
 * to; there the calls are left by which a worker makes room for a thread of the pool. And the same
 * while a recorder takes every request.
 *
 *   test_no_syscalls [REQUESTS]    3000
 */
#include "harness.h"
#include "syscall_filter.h"
#include "test.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#define WARM_UP 1000        /* the filter comes after half of it */
#define FILTER_AFTER "1000" /* looks at the clock by the worker: two for each request */
#define BATCH 8
#define RELOADS 6

static unsigned requests = 3000;

/* ---- the client, in a process of its own ---- */

static double numbers[3][BATCH * 7 + 64];

/* Requests of all kinds, one after the other. */
static int ask(tfa_client *client, unsigned i)
{
    static double qdd[BATCH * 7], tau[BATCH * 7], lambda[36], mass[49];
    static tfa_answer answers[BATCH];
    static const tfa_op ops[] = {TFA_OP_FORWARD_DYNAMICS, TFA_OP_FORWARD_DYNAMICS,
                                 TFA_OP_INVERSE_DYNAMICS, TFA_OP_OPERATIONAL_INERTIA,
                                 TFA_OP_MASS_MATRIX,      TFA_OP_FORWARD_DYNAMICS};
    const unsigned kind = i % 6;
    const double *x = numbers[0] + i % 64;
    tfa_request r = {.op = ops[kind],
                     .refine = TFA_REFINE_DEFAULT,
                     .count = kind == 1 ? BATCH : 1,
                     .q = x,
                     .v = numbers[1],
                     .tau = numbers[2],
                     .tip_count = kind == 3 || kind == 5,
                     .tips = {9}};
    tfa_reply reply = {
        .qdd = qdd, .tau = tau, .lambda_inv = lambda, .mass_matrix = mass, .answers = answers};
    return tfa_client_call(client, &r, &reply, WAIT_NS, NULL);
}

static int client_process(const char *runtime_dir)
{
    const tfa_client_options options = {.runtime_dir = runtime_dir,
                                        .robot = "arm",
                                        .wait = TFA_WAIT_SPIN,
                                        .max_batch = BATCH,
                                        .connect_timeout_ms = WAIT_MS};
    struct rusage before, after;
    tfa_client *client;
    char byte = 'w';
    for (int k = 0; k < 3; k++)
        for (int i = 0; i < BATCH * 7 + 64; i++)
            numbers[k][i] = 0.01 * ((i * 37 + k * 11) % 100);
    if (tfa_client_connect(&options, &client) != TFA_OK)
        return 20;
    for (unsigned i = 0; i < WARM_UP; i++)
        if (ask(client, i) != TFA_OK)
            return 21;
    getrusage(RUSAGE_THREAD, &before);
    if (write(FILTER_WRITE_FD, &byte, 1) != 1 || read(FILTER_READ_FD, &byte, 1) != 1)
        return 22;
    if (tfa_test_filter_syscalls() != 0)
        return 23;
    getrusage(RUSAGE_THREAD, &before);
    int status = TFA_OK;
    for (unsigned i = 0; i < requests && status == TFA_OK; i++)
        status = ask(client, i);
    getrusage(RUSAGE_THREAD, &after);
    byte = 'o';
    if (status != TFA_OK)
        byte = 's';
    else if (after.ru_minflt != before.ru_minflt || after.ru_majflt != before.ru_majflt)
        byte = 'f';
    if (write(FILTER_WRITE_FD, &byte, 1) != 1 || read(FILTER_READ_FD, &byte, 1) != 1)
        _exit(24);
    _exit(0);
}

typedef struct child {
    pid_t pid;
    int to, from;
} child;

typedef enum run_kind { PLAIN, POOL, TAP } run_kind; /* of a run */

/* With a pool three threads spin, with a recorder a third process writes. */
static const unsigned fractions[] = {[PLAIN] = 1, [POOL] = 10, [TAP] = 5};

static child start_client(const harness *h, run_kind kind)
{
    char number[16];
    int in[2], out[2];
    child c;
    assert_int_equal(pipe2(in, O_CLOEXEC), 0);
    assert_int_equal(pipe2(out, O_CLOEXEC), 0);
    c.pid = fork();
    assert_true(c.pid >= 0);
    if (c.pid == 0) {
        (void)prctl(PR_SET_PDEATHSIG, SIGKILL);
        (void)dup2(in[0], FILTER_READ_FD);
        (void)dup2(out[1], FILTER_WRITE_FD);
        setenv("LD_PRELOAD", TFA_SYSCALL_FILTER, 1);
        snprintf(number, sizeof number, "%u", requests / fractions[kind]);
        execl("/proc/self/exe", "test_silent", "client", number, h->runtime_dir, (char *)NULL);
        _exit(127);
    }
    close(in[0]);
    close(out[1]);
    c.to = in[1];
    c.from = out[0];
    return c;
}

/* What the client says. */
static char read_result(const child *c)
{
    char byte = 0;
    int status;
    if (read(c->from, &byte, 1) == 1)
        return byte;
    waitpid(c->pid, &status, 0);
    fail_msg("the client ended: %s %d", WIFSIGNALED(status) ? "signal" : "exit",
             WIFSIGNALED(status) ? WTERMSIG(status) : WEXITSTATUS(status));
    return 0;
}

/* Other models for the worker, which it takes over as silently as it answers. */
static void reload_meanwhile(const harness *h, const char *more)
{
    for (unsigned i = 1; i <= RELOADS; i++) {
        harness_configure(h, i % 2 ? ARM "    gravity: [0, 0, -1.62]\n" : ARM, more);
        assert_int_equal(kill(h->pid, SIGHUP), 0);
        if (!harness_logged_times(h, "reload: done, 1 of 1", i))
            return; /* the worker is dead: why, is seen elsewhere */
    }
}

/* `totalforce record`, which has the robot's tap when this returns. */
static pid_t start_recorder(const harness *h)
{
    const pid_t pid = fork();
    if (pid == 0) {
        (void)prctl(PR_SET_PDEATHSIG, SIGKILL);
        execl(TFA_BINARY_DIR "/bin/totalforce", "totalforce", "record", "arm", "-o", "/dev/null",
              "--runtime-dir", h->runtime_dir, (char *)NULL);
        _exit(127);
    }
    assert_true(pid > 0);
    assert_true(harness_logged(h, "records"));
    return pid;
}

static void without_system_calls(run_kind kind)
{
    if (sysconf(_SC_NPROCESSORS_ONLN) < 2) {
        print_message("skipped: spinning needs two processors\n");
        skip();
    }
    const bool pool = kind == POOL;
    pid_t recorder = 0;
    const char *more = pool ? "pool: {threads: 2, from: 50, spin_ns: 4000000000}\n" : "";
    int status;
    SCOPED_HARNESS h = harness_make(ARM, more);
    snprintf(h.preload, sizeof h.preload, "%s", TFA_SYSCALL_FILTER);
    setenv("TFA_FILTER_THREAD", "worker0", 1);
    setenv("TFA_FILTER_AFTER", FILTER_AFTER, 1);
    if (pool)
        setenv("TFA_FILTER_POOL", "1", 1);
    harness_start(&h, "arm");
    unsetenv("TFA_FILTER_POOL");
    unsetenv("TFA_FILTER_THREAD");
    unsetenv("TFA_FILTER_AFTER");
    if (kind == TAP)
        recorder = start_recorder(&h);
    child client = start_client(&h, kind);
    assert_int_equal(read_result(&client), 'w');
    const long faults = harness_thread_faults(&h, "worker0");
    assert_true(faults >= 0);
    assert_int_equal(write(client.to, "g", 1), 1);
    if (kind != TAP) /* it would end the recording */
        reload_meanwhile(&h, more);
    assert_int_equal(read_result(&client), 'o'); /* o: good, s: a status, f: page faults */
    assert_int_equal(waitpid(h.pid, &status, WNOHANG), 0);
    assert_int_equal(harness_thread_faults(&h, "worker0"), faults);
    assert_int_equal(write(client.to, "g", 1), 1);
    assert_int_equal(waitpid(client.pid, &status, 0), client.pid);
    assert_int_equal(status, 0);
    /* the negative control: with nobody to spin for, the worker sleeps, and sleeping is a call */
    assert_int_equal(waitpid(h.pid, &status, 0), h.pid);
    h.pid = 0;
    assert_true(WIFSIGNALED(status));
    assert_int_equal(WTERMSIG(status), SIGSYS);
    if (recorder) /* its daemon is gone */
        assert_int_equal(waitpid(recorder, &status, 0), recorder);
}

TEST(requests_without_a_system_call)
{
    without_system_calls(PLAIN);
}

TEST(with_a_pool)
{
    without_system_calls(POOL);
}

TEST(with_a_recorder)
{
    without_system_calls(TAP);
}

/* The other half of the filter kills, too. */
TEST(the_filter_is_active)
{
    int status;
    pid_t pid = fork();
    if (pid == 0) {
        setenv("LD_PRELOAD", TFA_SYSCALL_FILTER, 1);
        execl("/proc/self/exe", "test_silent", "allocate", (char *)NULL);
        _exit(127);
    }
    assert_int_equal(waitpid(pid, &status, 0), pid);
    assert_true(WIFSIGNALED(status));
    assert_int_equal(WTERMSIG(status), SIGILL);
}

int main(int argc, char **argv)
{
    if (argc == 4 && strcmp(argv[1], "client") == 0) {
        requests = (unsigned)atoi(argv[2]);
        return client_process(argv[3]);
    }
    if (argc == 2 && strcmp(argv[1], "allocate") == 0) {
        if (tfa_test_filter_syscalls() != 0)
            return 1;
        void *volatile memory = malloc(1);
        free(memory);
        return 0;
    }
    if (argc == 2)
        requests = (unsigned)atoi(argv[1]);
    return test_run(NULL, NULL);
}
