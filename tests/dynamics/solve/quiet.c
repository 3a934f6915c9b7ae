/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Constrained dynamics, regressor and observer without one allocation or system call: a process
 * that a filter would end (syscall_filter.h) answers them with sets of constraints that change,
 * full and lost ranks, and forward dynamics and task torques between. The same process with one
 * allocation is ended.
 */
#include "constraints/constrained_robot.h"
#include "models.h"
#include "test.h"

#include <sys/wait.h>
#include <unistd.h>

#include "service/syscall_filter.h"

enum { REQUESTS = 2000, N = 18 };

/* A sample and the wrench at the last link. @return 0 when both are answered */
static int observe(tfa_workspace *w, tfa_observer *observer, int k, const double *q,
                   const double *v, const double *pose, const double *tau)
{
    tfa_request r;
    tfa_reply reply;
    double wrench[6];
    tfa_observer_request(observer, &r, &reply);
    r.q = q;
    r.v = v;
    r.base_pose = pose;
    int failed = tfa_compute(w, &r, &reply) != TFA_OK;
    failed |= tfa_observer_update(observer, 1e-3 * k, tau, NULL, &reply) == TFA_OBSERVER_INVALID;
    tfa_observer_wrench_request(observer, 1, &r, &reply);
    r.q = q;
    r.base_pose = pose;
    failed |= tfa_compute(w, &r, &reply) != TFA_OK;
    return failed | (tfa_observer_wrench(observer, &reply, wrench) != TFA_OK);
}

/* Exit status: 0 when all are answered */
static int ask_all(tfa_workspace *w, const tfa_model *model, tfa_observer *observer)
{
    static const double pose[7] = {0, 0, 0.3, 0, 0, 0, 1}, wanted[6] = {1, 2, 3}, gains[2] = {9, 6};
    static const tfa_op ops[] = {TFA_OP_CONSTRAINED_DYNAMICS, TFA_OP_FORWARD_DYNAMICS,
                                 TFA_OP_CONSTRAINED_DYNAMICS, TFA_OP_TASK_TORQUES,
                                 TFA_OP_REGRESSOR};
    static double q[12], v[12], tau[12], qdd[N], F[ROWS], position[ROWS], lost[6 * (2 + ROWS)];
    static double delassus[ROWS * ROWS], torques[N], regressor[N * TFA_LINK_PARAMETERS];
    tfa_rank rank;
    int failed = 0;
    for (int k = 0; k < REQUESTS; k++) {
        tfa_request r = request_fd(q, v, tau);
        tfa_reply reply = {.qdd = qdd + 6,
                           .base_acceleration = qdd,
                           .tau = torques,
                           .constraint_wrenches = F,
                           .constraint_position = position,
                           .delassus = delassus,
                           .regressor = regressor,
                           .lost = lost,
                           .rank = &rank};
        r.op = ops[k % 5];
        r.base_pose = pose;
        for (int j = 0; j < 12; j++)
            q[j] = 0.01 * ((7 * k + 13 * j) % 300) * (k % 5 != 0); /* 0: legs straight */
        r.tip_count = r.op == TFA_OP_TASK_TORQUES || r.op == TFA_OP_REGRESSOR;
        r.tips[0] = tfa_model_frame_count(model) - 1;
        r.task_acceleration = wanted;
        r.stabilisation = gains;
        if (r.op == TFA_OP_CONSTRAINED_DYNAMICS) {
            r.constraints = 1 + (uint32_t)k / 2 % 15;
            r.flags = k % 3 ? 0 : TFA_WANT_DELASSUS;
        }
        failed |= tfa_compute(w, &r, &reply) != TFA_OK;
        failed |= observe(w, observer, k, q, v, pose, tau);
    }
    return failed;
}

/* The filtered process; `allocate`: what it may not do. It ends by _exit, a system call that the
 * filter lets through. */
static int filtered(const char *kind)
{
    static const char *const feet[MOST] = {"FL_foot", "FR_foot", "RL_foot", "RR_foot"};
    tfa_constraint on[MOST];
    const tfa_scene scene = {.constraints = on, .constraint_count = MOST};
    const tfa_model_options options = {.base = TFA_BASE_FLOATING, .scene = &scene};
    for (int k = 0; k < MOST; k++) /* two of them redundant together */
        on[k] = (tfa_constraint){.name = feet[k],
                                 .link = {NULL, feet[k]},
                                 .rows = k & 1 ? TFA_CONSTRAINT_WELD : TFA_CONSTRAINT_POINT};
    tfa_model *model = bundled_model("quadruped.urdf", &options);
    tfa_workspace *w = workspace_for(model, NULL);
    tfa_observer *observer;
    if (tfa_observer_create(6, N - 6, &(tfa_observer_options){.gain = 50}, &observer) != TFA_OK)
        _exit(98);
    if (!tfa_test_filter_syscalls || tfa_test_filter_syscalls() != 0)
        _exit(99);
    const int failed = ask_all(w, model, observer);
    void *volatile memory = strcmp(kind, "allocate") == 0 ? malloc(1) : NULL;
    if (memory)
        free(memory);
    _exit(failed);
}

static int status_of(const char *kind)
{
    int status;
    const pid_t pid = fork();
    assert_true(pid >= 0);
    if (pid == 0) {
        setenv("LD_PRELOAD", TFA_SYSCALL_FILTER, 1);
        execl("/proc/self/exe", "test_quiet", kind, (char *)NULL);
        _exit(127);
    }
    assert_int_equal(waitpid(pid, &status, 0), pid);
    return status;
}

TEST(no_allocation_and_no_system_call)
{
    assert_int_equal(status_of("ask"), 0);
}

TEST(the_filter_is_active)
{
    const int status = status_of("allocate");
    assert_true(WIFSIGNALED(status));
    assert_int_equal(WTERMSIG(status), SIGILL);
}

int main(int argc, char **argv)
{
    return argc == 2 ? filtered(argv[1]) : test_run(NULL, NULL);
}
