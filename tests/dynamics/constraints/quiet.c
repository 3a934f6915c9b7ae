/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Constrained dynamics without one allocation or system call: a process that a filter would end
 * (syscall_filter.h) answers it with sets of constraints that change, full and lost ranks, and
 * forward dynamics and task torques between. The same process with one allocation is ended.
 */
#include "constrained_robot.h"
#include "models.h"
#include "test.h"

#include <sys/wait.h>
#include <unistd.h>

#include "service/syscall_filter.h"

enum { REQUESTS = 2000, N = 18 };

/* Exit status: 0 when all are answered */
static int ask_all(tfa_workspace *w, const tfa_model *model)
{
    static const double pose[7] = {0, 0, 0.3, 0, 0, 0, 1}, wanted[6] = {1, 2, 3}, gains[2] = {9, 6};
    static const tfa_op ops[] = {TFA_OP_CONSTRAINED_DYNAMICS, TFA_OP_FORWARD_DYNAMICS,
                                 TFA_OP_CONSTRAINED_DYNAMICS, TFA_OP_TASK_TORQUES};
    static double q[12], v[12], tau[12], qdd[N], F[ROWS], position[ROWS], lost[6 * (2 + ROWS)];
    static double delassus[ROWS * ROWS], torques[N];
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
                           .lost = lost,
                           .rank = &rank};
        r.op = ops[k % 4];
        r.base_pose = pose;
        for (int j = 0; j < 12; j++)
            q[j] = 0.01 * ((7 * k + 13 * j) % 300) * (k % 5 != 0); /* 0: legs straight */
        r.tip_count = r.op == TFA_OP_TASK_TORQUES;
        r.tips[0] = tfa_model_frame_count(model) - 1;
        r.task_acceleration = wanted;
        r.stabilisation = gains;
        if (r.op == TFA_OP_CONSTRAINED_DYNAMICS) {
            r.constraints = 1 + (uint32_t)k / 2 % 15;
            r.flags = k % 3 ? 0 : TFA_WANT_DELASSUS;
        }
        failed |= tfa_compute(w, &r, &reply) != TFA_OK;
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
    if (!tfa_test_filter_syscalls || tfa_test_filter_syscalls() != 0)
        _exit(99);
    const int failed = ask_all(w, model);
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
