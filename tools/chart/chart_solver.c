/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * What computes the rows of a case: a workspace or a pool for each precision, with a specialised
 * kernel or without; and the batches it is given.
 */
#include "chart.h"

#include <stdlib.h>
#include <string.h>
#include <totalforce/specialised.h>

static chart_solver make_solver(const chart_case *c, uint32_t precision, tfa_specialised *kernel)
{
    chart_solver solver = {0};
    tfa_workspace_options options = chart_precisions[precision];
    options.specialised = kernel;
    const tfa_batch_pool_options pool = {.thread_pool = c->thread_pool,
                                         .precision = options.precision,
                                         .residual = options.residual,
                                         .methods = options.methods,
                                         .specialised = kernel};
    solver.status = c->threads > 1 ? tfa_batch_pool_create(c->model, &pool, &solver.pool)
                                   : tfa_workspace_create(c->model, &options, &solver.workspace);
    return solver;
}

static void free_solver(chart_solver *solver)
{
    tfa_batch_pool_free(solver->pool);
    tfa_workspace_free(solver->workspace);
    *solver = (chart_solver){0};
}

int chart_solvers_open(chart_case *c, const chart_options *o)
{
    const int specialised = chart_is_specialised(c->strategy);
    const tfa_thread_pool_options threads = {.threads = c->threads};
    char why[512];
    /* one for all: the idle threads of another would spin on the same processors */
    if (c->threads > 1) {
        const int status = tfa_thread_pool_create(&threads, &c->thread_pool);
        if (status != TFA_OK)
            return status;
    }
    if (specialised && tfa_specialised_find(o->kernels, c->model, &c->kernel, why, sizeof why) != 0)
        fprintf(stderr, "totalforce chart: %s: no specialised kernel: %s\n", c->name, why);
    for (uint32_t k = 0; k < o->precision_count; k++)
        if (!specialised || c->kernel)
            c->solvers[o->precisions[k]] = make_solver(c, o->precisions[k], c->kernel);
    c->baseline = make_solver(c, CHART_F64, NULL);
    return c->baseline.status;
}

void chart_solvers_close(chart_case *c)
{
    for (int p = 0; p < CHART_PRECISION_COUNT; p++)
        free_solver(&c->solvers[p]);
    free_solver(&c->baseline);
    tfa_thread_pool_free(c->thread_pool);
    tfa_specialised_free(c->kernel);
    c->kernel = NULL;
}

int chart_solve(const chart_solver *solver, const tfa_request *request, tfa_reply *reply)
{
    return solver->pool ? tfa_batch_pool_compute(solver->pool, request, reply)
                        : tfa_compute(solver->workspace, request, reply);
}

/* `count` rows of `width` numbers, those of `from` over and over. */
static double *repeat(double **at, const double *from, size_t width, uint32_t count,
                      uint32_t states)
{
    double *start = *at;
    for (uint32_t s = 0; from && s < count; s++, *at += width)
        memcpy(*at, from + s % states * width, width * sizeof(double));
    return from ? start : NULL;
}

int chart_batch_make(chart_batch *b, const chart_data *d, uint32_t bodies)
{
    const uint32_t count = bodies <= 128 ? CHART_BATCH_STATES : 64;
    const size_t width = (size_t)d->q + 2 * (size_t)d->v + 7 + d->answer;
    double *at = b->block = calloc(count * width, sizeof(double));
    b->reply.answers = calloc(count, sizeof *b->reply.answers);
    if (!at || !b->reply.answers) {
        chart_batch_free(b);
        return TFA_E_MEMORY;
    }
    b->request = chart_request(d, 0);
    b->request.count = count;
    b->request.q = repeat(&at, b->request.q, d->q, count, d->states);
    b->request.v = repeat(&at, b->request.v, d->v, count, d->states);
    b->request.tau = repeat(&at, b->request.tau, d->v, count, d->states);
    b->request.base_pose = repeat(&at, b->request.base_pose, 7, count, d->states);
    if (d->op == CHART_LAMBDA) {
        b->reply.lambda_inv = at;
        return TFA_OK;
    }
    b->reply.qdd = at;
    b->reply.base_acceleration = d->base ? at + (size_t)count * d->v : NULL;
    return TFA_OK;
}

void chart_batch_answer(const chart_batch *b, const chart_data *d, uint32_t state)
{
    if (d->op == CHART_LAMBDA) {
        memcpy(d->found, b->reply.lambda_inv + (size_t)state * d->answer,
               d->answer * sizeof(double));
        return;
    }
    memcpy(d->found, b->reply.qdd + (size_t)state * d->v, d->v * sizeof(double));
    if (d->base)
        memcpy(d->found + d->v, b->reply.base_acceleration + (size_t)state * d->base,
               d->base * sizeof(double));
}

void chart_batch_free(chart_batch *b)
{
    free(b->reply.answers);
    free(b->block);
    *b = (chart_batch){0};
}
