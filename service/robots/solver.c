/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The solver of a worker: a workspace of its own, and the estimate policy; what it takes.
 */
#include <stdlib.h>
#include <string.h>

#include "platform/log.h"
#include "robots/robot.h"
#include "worker/cost_bound.h"

#define ALIGNMENT 64
#define LAMBDA_FLAGS (TFA_WANT_LAMBDA | TFA_WANT_MU | TFA_WANT_P)

/* Counts for each request, so no two workers may share its cache line. */
struct tfa_robot_solver {
    _Alignas(ALIGNMENT) tfa_workspace *workspace;
    void *memory;
    const tfa_model *model;
    tfa_batch_pool *pool; /* the robot's, or NULL */
    uint64_t from;        /* the pool's: states */
    uint32_t refused;     /* bits 1u << CONFIG_REFUSE_x */
    tfa_robot_solver *beside; /* of the thread beside the worker, or NULL */
    uint32_t estimate;        /* config_estimate */
    uint32_t every, until_next;
};

static tfa_workspace_options options_of(const tfa_robot *robot)
{
    static const tfa_precision precisions[] = {
        [CONFIG_PRECISION_F64] = TFA_F64,
        [CONFIG_PRECISION_F32] = TFA_F32,
    };
    const config_robot *c = robot->config;
    return (tfa_workspace_options){.precision = precisions[c->precision],
                                   .residual = (tfa_residual)c->residual,
                                   .methods =
                                       c->methods == CONFIG_METHODS_ALL ? TFA_METHODS_ALL : 0,
                                   .max_tips = c->max_tips,
                                   .specialised = robot->specialised};
}

/* A request of so many states is a large one. */
static uint64_t large_states(const tfa_robot *robot, const config_pool *pool)
{
    const uint32_t bodies = tfa_model_summarise(robot->model).bodies;
    return ((uint64_t)pool->from + bodies - 1) / (bodies ? bodies : 1);
}

static int open_pool(tfa_robot *robot, const config_pool *wanted, tfa_thread_pool *thread_pool)
{
    if (!thread_pool || robot->config->max_batch < large_states(robot, wanted))
        return TFA_OK;
    const tfa_workspace_options o = options_of(robot);
    const tfa_batch_pool_options options = {.precision = o.precision,
                                            .residual = o.residual,
                                            .methods = o.methods,
                                            .max_tips = o.max_tips,
                                            .thread_pool = thread_pool,
                                            .specialised = o.specialised};
    return tfa_batch_pool_create(robot->model, &options, &robot->pool);
}

static int make_workspace(const tfa_robot *robot, tfa_robot_solver *solver)
{
    const tfa_workspace_options options = options_of(robot);
    const size_t size = tfa_workspace_size(robot->model, &options);
    if (!size)
        return TFA_E_UNSUPPORTED;
    solver->memory = aligned_alloc(ALIGNMENT, (size + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT);
    if (!solver->memory)
        return TFA_E_MEMORY;
    memset(solver->memory, 0, size); /* every page is there before the first request */
    return tfa_workspace_init(solver->memory, size, robot->model, &options, &solver->workspace);
}

int tfa_robot_solver_create(const tfa_robot *robot, const config_pool *pool, bool of_worker,
                            tfa_robot_solver **solver)
{
    *solver = NULL;
    tfa_robot_solver *made = aligned_alloc(ALIGNMENT, sizeof *made);
    if (!made)
        return TFA_E_MEMORY;
    *made = (tfa_robot_solver){.model = robot->model,
                               .pool = robot->pool,
                               .from = large_states(robot, pool),
                               .refused = config_refusals(robot->config),
                               .estimate = robot->config->estimate,
                               .every = robot->config->estimate_every,
                               .until_next = robot->config->estimate_every};
    int status = make_workspace(robot, made);
    if (status == TFA_OK && of_worker && pool->threads && robot->max_state_us)
        status = tfa_robot_solver_create(robot, pool, false, &made->beside);
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
    tfa_robot_solver_free(solver->beside);
    free(solver->memory);
    free(solver);
}

tfa_worker_robot tfa_robot_for_worker(const tfa_robot *robot, tfa_robot_solver *solver)
{
    return (tfa_worker_robot){.shape = robot->shape,
                              .solve = tfa_robot_solve,
                              .warm_up = tfa_robot_warm_up,
                              .self = solver,
                              .long_self = solver->beside,
                              .max_state_ns = 1000 * robot->max_state_us,
                              .parts = robot->parts};
}

/* ---- what a robot needs besides ---- */

static void check_time(const tfa_robot *robot)
{
    const tfa_request forward = {.op = TFA_OP_FORWARD_DYNAMICS, .refine = TFA_REFINE_DEFAULT};
    const uint32_t us = tfa_cost_bound(robot->parts, &forward) / 1000 + 1;
    if (us > robot->max_state_us)
        tfa_log(TFA_LOG_WARNING,
                "robot '%s': forward dynamics takes up to %u us and is refused: raise max_state_us "
                "(%u)",
                robot->name, us, robot->max_state_us);
}

static int measure(tfa_robot *robot, const config *settings)
{
    tfa_robot_solver *solver;
    int status = tfa_robot_solver_create(robot, &settings->pool, false, &solver);
    if (status != TFA_OK)
        return status;
    robot->parts = calloc(1, sizeof *robot->parts);
    const tfa_worker_robot measured = tfa_robot_for_worker(robot, solver);
    status = robot->parts ? tfa_cost_measure(robot->model, &measured, robot->parts) : TFA_E_MEMORY;
    tfa_robot_solver_free(solver);
    return status;
}

int tfa_robot_prepare(tfa_robot *robot, const config *settings, tfa_thread_pool *thread_pool)
{
    int status = open_pool(robot, &settings->pool, thread_pool);
    robot->max_state_us = settings->max_state_us;
    if (status != TFA_OK || !robot->max_state_us)
        return status;
    status = measure(robot, settings);
    if (status == TFA_OK)
        check_time(robot);
    return status;
}

/* ---- requests ---- */

/* Estimate policy of a request that leaves it open. DEFAULT is the library's: where the sentinel
 * trips, and always for methods with inverse inertias. */
static tfa_estimate estimate_policy(tfa_robot_solver *solver)
{
    if (solver->estimate == CONFIG_ESTIMATE_DEFAULT)
        return TFA_ESTIMATE_DEFAULT;
    if (solver->estimate == CONFIG_ESTIMATE_NEVER)
        return TFA_ESTIMATE_NEVER;
    if (solver->estimate == CONFIG_ESTIMATE_ALWAYS)
        return TFA_ESTIMATE_ALWAYS;
    if (--solver->until_next)
        return TFA_ESTIMATE_DEFAULT;
    solver->until_next = solver->every;
    return TFA_ESTIMATE_ALWAYS;
}

static bool is_large(const tfa_robot_solver *solver, const tfa_request *request)
{
    return solver->pool && request->count >= solver->from;
}

/* Some states of a checked request, alone if the pool serves another worker. */
static int solve_states(const tfa_robot_solver *solver, const tfa_request *request, uint32_t first,
                        uint32_t count, tfa_reply *reply)
{
    if (is_large(solver, request)) {
        const int status =
            tfa_batch_pool_compute_states(solver->pool, request, first, count, reply);
        if (status != TFA_E_BUSY)
            return status;
    }
    return tfa_compute_states(solver->workspace, request, first, count, reply);
}

/* The field for which a request is refused by configuration; TFA_FIELD_NONE: it is not. */
static tfa_field refused_field(uint32_t refused, const tfa_request *r)
{
    if (refused >> CONFIG_REFUSE_SEVERAL_TIPS & 1 && r->tip_count > 1)
        return TFA_FIELD_TIPS;
    if (refused >> CONFIG_REFUSE_SPECTRUM & 1 && r->flags & TFA_WANT_SPECTRUM)
        return TFA_FIELD_OP;
    if (refused >> CONFIG_REFUSE_LAMBDA & 1 &&
        (r->flags & LAMBDA_FLAGS || r->op == TFA_OP_TASK_TORQUES))
        return TFA_FIELD_OP;
    if (refused >> CONFIG_REFUSE_DERIVATIVES & 1 &&
        TFA_OP_BIT(r->op) & (TFA_OPS_DERIVATIVES | TFA_OPS_ID_DERIVATIVES))
        return TFA_FIELD_OP;
    if (refused >> CONFIG_REFUSE_MASS_MATRIX & 1 && r->op == TFA_OP_MASS_MATRIX)
        return TFA_FIELD_OP;
    if (refused >> CONFIG_REFUSE_METHODS & 1 && r->method != TFA_METHOD_AUTO)
        return TFA_FIELD_METHOD;
    if (refused >> CONFIG_REFUSE_ESTIMATES & 1 && r->estimate == TFA_ESTIMATE_ALWAYS)
        return TFA_FIELD_ESTIMATE;
    if (refused >> CONFIG_REFUSE_BATCHES & 1 && r->count > 1)
        return TFA_FIELD_COUNT;
    return TFA_FIELD_NONE;
}

int tfa_robot_solve(void *self, tfa_request *request, tfa_reply *reply, uint32_t first,
                    uint32_t count)
{
    tfa_robot_solver *solver = self;
    if (first == 0 && solver->refused) {
        reply->field = refused_field(solver->refused, request);
        if (reply->field != TFA_FIELD_NONE)
            return reply->status = TFA_E_REFUSED;
    }
    if (first == 0 && request->estimate == TFA_ESTIMATE_DEFAULT)
        request->estimate = estimate_policy(solver);
    if (first == 0 && count == request->count && !is_large(solver, request))
        return tfa_compute(solver->workspace, request, reply);
    if (first == 0 && tfa_request_check(solver->model, request, reply) != TFA_OK)
        return reply->status;
    return solve_states(solver, request, first, count, reply);
}

void tfa_robot_warm_up(void *self, const tfa_request *request, tfa_reply *reply)
{
    const tfa_robot_solver *solver = self;
    if (!is_large(solver, request))
        (void)tfa_compute(solver->workspace, request, reply);
}
