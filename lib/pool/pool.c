/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The public noun: a team with one workspace for each thread.
 */
#include <errno.h>
#include <stdlib.h>
#include <totalforce/pool.h>
#include <unistd.h>

#include "methods/methods.h"
#include "pool/team.h"

/* Tasks for each thread: enough that a thread which is stopped leaves work to the others. */
#define TASKS_PER_THREAD 4
#define MAX_THREADS 256
#define DEFAULT_SPIN_NS 50000

struct outcome {
    int32_t status;
    tfa_field field;
    uint32_t index, state;
};

struct tfa_pool {
    const tfa_model *model;
    struct team *team;
    uint32_t threads;
    tfa_workspace **workspace;
    struct outcome *outcome; /* by task */
    /* the request under way */
    const tfa_request *request;
    tfa_reply *reply;
    uint32_t tasks;
};

static int create_workspaces(tfa_pool *p, const tfa_pool_options *o)
{
    const tfa_workspace_options options = {.precision = o->precision, .residual = o->residual};
    p->workspace = calloc(p->threads, sizeof(tfa_workspace *));
    p->outcome = calloc((size_t)p->threads * TASKS_PER_THREAD, sizeof *p->outcome);
    int status = p->workspace && p->outcome ? TFA_OK : TFA_E_MEMORY;
    for (uint32_t k = 0; status == TFA_OK && k < p->threads; k++)
        status = tfa_workspace_create(p->model, &options, &p->workspace[k]);
    return status;
}

int tfa_pool_create(const tfa_model *model, const tfa_pool_options *options, tfa_pool **pool)
{
    static const tfa_pool_options defaults;
    const tfa_pool_options *o = options ? options : &defaults;
    if (!model || !pool || o->threads > MAX_THREADS)
        return TFA_E_ARGUMENT;
    *pool = NULL;
    tfa_pool *p = calloc(1, sizeof *p);
    if (!p)
        return TFA_E_MEMORY;
    long online = sysconf(_SC_NPROCESSORS_ONLN);
    p->threads = o->threads ? o->threads : (uint32_t)(online > 0 ? online : 1);
    p->threads = p->threads > MAX_THREADS ? MAX_THREADS : p->threads;
    p->model = model;
    int status = create_workspaces(p, o);
    if (status == TFA_OK) {
        int error =
            team_start(&p->team, p->threads, o->spin_ns ? o->spin_ns : DEFAULT_SPIN_NS, o->cpus);
        if (error) {
            errno = error;
            status = error == ENOMEM ? TFA_E_MEMORY : TFA_E_SYSTEM;
        }
    }
    if (status != TFA_OK) {
        tfa_pool_free(p);
        return status;
    }
    *pool = p;
    return TFA_OK;
}

void tfa_pool_free(tfa_pool *pool)
{
    if (!pool)
        return;
    if (pool->team)
        team_stop(pool->team);
    for (uint32_t k = 0; pool->workspace && k < pool->threads; k++)
        tfa_workspace_free(pool->workspace[k]);
    free(pool->workspace);
    free(pool->outcome);
    free(pool);
}

uint32_t tfa_pool_threads(const tfa_pool *pool)
{
    return pool->threads;
}

static const double *in(const double *array, size_t width, uint32_t first)
{
    return array ? array + width * first : NULL;
}

static double *out(double *array, size_t width, uint32_t first)
{
    return array ? array + width * first : NULL;
}

/* The states [first, first + count) of a request as a request of their own. */
static tfa_request slice_request(const tfa_pool *p, uint32_t first, uint32_t count)
{
    tfa_request r = *p->request;
    const size_t nq = tfa_model_q_count(p->model), nv = tfa_model_v_count(p->model);
    r.count = count;
    r.q = in(r.q, nq, first);
    r.v = in(r.v, nv, first);
    r.tau = in(r.tau, nv, first);
    r.qdd = in(r.qdd, nv, first);
    r.base_pose = in(r.base_pose, 7, first);
    r.base_twist = in(r.base_twist, 6, first);
    r.base_wrench = in(r.base_wrench, 6, first);
    r.base_acceleration = in(r.base_acceleration, 6, first);
    r.wrenches = in(r.wrenches, (size_t)6 * r.wrench_count, first);
    return r;
}

static tfa_reply slice_reply(const tfa_pool *p, uint32_t first)
{
    tfa_reply r = *p->reply;
    const size_t nv = tfa_model_v_count(p->model);
    const size_t n = nv + tfa_model_base_freedoms(p->model);
    const size_t tips = p->request->tip_count;
    r.qdd = out(r.qdd, nv, first);
    r.base_acceleration = out(r.base_acceleration, 6, first);
    r.tau = out(r.tau, nv, first);
    r.base_wrench = out(r.base_wrench, 6, first);
    r.lambda_inv = out(r.lambda_inv, 36 * tips * tips, first);
    r.mass_matrix = out(r.mass_matrix, n * n, first);
    r.poses = out(r.poses, 7 * tips, first);
    r.held = r.held ? r.held + nv * first : NULL;
    r.certificate = r.certificate ? r.certificate + first : NULL;
    r.spectrum = r.spectrum ? r.spectrum + first : NULL;
    r.answers = r.answers ? r.answers + first : NULL;
    return r;
}

/* Where slice `task` begins. Long batches are cut where vectors of states end. */
static uint32_t slice_start(const tfa_pool *p, uint32_t task)
{
    const uint32_t count = p->request->count, lanes = count >= 16 * p->tasks ? 8 : 1;
    const uint32_t start = (uint32_t)((uint64_t)count * task / p->tasks);
    return task == p->tasks ? count : start / lanes * lanes;
}

static void compute_slice(void *context, uint32_t task, uint32_t worker)
{
    tfa_pool *p = context;
    const uint32_t first = slice_start(p, task), last = slice_start(p, task + 1);
    tfa_request request = slice_request(p, first, last - first);
    tfa_reply reply = slice_reply(p, first);
    int status = tfa_compute_checked(p->workspace[worker], &request, &reply);
    p->outcome[task] = (struct outcome){status, reply.field, reply.index, first + reply.state};
}

int tfa_pool_compute(tfa_pool *pool, const tfa_request *request, tfa_reply *reply)
{
    if (request->count <= 1 || pool->threads == 1)
        return tfa_compute(pool->workspace[0], request, reply);
    int status = tfa_request_check(pool->model, request, reply);
    if (status != TFA_OK)
        return status;
    pool->request = request;
    pool->reply = reply;
    pool->tasks = pool->threads * TASKS_PER_THREAD;
    if (pool->tasks > request->count)
        pool->tasks = request->count;
    team_run(pool->team, compute_slice, pool, pool->tasks);
    for (uint32_t k = 0; k < pool->tasks; k++) {
        const struct outcome *o = &pool->outcome[k];
        if (o->status == TFA_OK)
            continue;
        reply->status = o->status;
        reply->field = o->field;
        reply->index = o->index;
        reply->state = o->state;
        return o->status;
    }
    return TFA_OK;
}
