/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * What a worker solves with: a workspace of its own, and the estimate policy.
 */
#include <stdlib.h>
#include <string.h>

#include "robot.h"

#define ALIGNMENT 64

/* Counts for each request, so no two workers may share its cache line. */
struct tfa_robot_solver {
    _Alignas(ALIGNMENT) tfa_workspace *workspace;
    void *memory;
    uint32_t estimate; /* config_estimate */
    uint32_t every, until_next;
};

static int make_workspace(const tfa_robot *robot, tfa_robot_solver *solver)
{
    static const tfa_precision precisions[] = {
        [CONFIG_PRECISION_F64] = TFA_F64,
        [CONFIG_PRECISION_F32] = TFA_F32,
    };
    const tfa_workspace_options options = {.precision = precisions[robot->config->precision],
                                           .residual = (tfa_residual)robot->config->residual};
    const size_t size = tfa_workspace_size(robot->model, &options);
    if (!size)
        return TFA_E_UNSUPPORTED;
    solver->memory = aligned_alloc(ALIGNMENT, (size + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT);
    if (!solver->memory)
        return TFA_E_MEMORY;
    memset(solver->memory, 0, size); /* every page is there before the first request */
    return tfa_workspace_init(solver->memory, size, robot->model, &options, &solver->workspace);
}

int tfa_robot_solver_create(const tfa_robot *robot, tfa_robot_solver **solver)
{
    *solver = NULL;
    tfa_robot_solver *made = aligned_alloc(ALIGNMENT, sizeof *made);
    if (!made)
        return TFA_E_MEMORY;
    *made = (tfa_robot_solver){.estimate = robot->config->estimate,
                               .every = robot->config->estimate_every,
                               .until_next = robot->config->estimate_every};
    int status = make_workspace(robot, made);
    if (status != TFA_OK) {
        tfa_robot_solver_free(made);
        return status;
    }
    *solver = made;
    return TFA_OK;
}

void tfa_robot_solver_free(tfa_robot_solver *solver)
{
    if (!solver)
        return;
    free(solver->memory);
    free(solver);
}

/* What a request gets that leaves the estimate open. DEFAULT is the library's: always for TFA. */
static tfa_estimate policy(tfa_robot_solver *solver, const tfa_request *request)
{
    if (request->hold != TFA_HOLD_NONE)
        return TFA_ESTIMATE_NEVER; /* held joints have a certificate instead */
    if (solver->estimate == CONFIG_ESTIMATE_NEVER)
        return TFA_ESTIMATE_NEVER;
    if (solver->estimate == CONFIG_ESTIMATE_ALWAYS)
        return TFA_ESTIMATE_ALWAYS;
    if (--solver->until_next)
        return TFA_ESTIMATE_DEFAULT;
    solver->until_next = solver->every;
    return TFA_ESTIMATE_ALWAYS;
}

int tfa_robot_solve(void *self, const tfa_request *request, tfa_reply *reply)
{
    tfa_robot_solver *solver = self;
    if (request->estimate != TFA_ESTIMATE_DEFAULT)
        return tfa_compute(solver->workspace, request, reply);
    tfa_request decided = *request;
    decided.estimate = policy(solver, request);
    return tfa_compute(solver->workspace, &decided, reply);
}
