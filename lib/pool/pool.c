/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The public nouns: a team, and a pool, which is a team with one workspace of a model for each
 * thread.
 */
#include <errno.h>
#include <stdlib.h>
#include <totalforce/pool.h>
#include <unistd.h>

#include "kernel/crew.h"
#include "methods/methods.h"
#include "pool/team.h"

/* Tasks for each thread: enough that a thread which is stopped leaves work to the others. */
#define TASKS_PER_THREAD 4
#define MAX_THREADS 256
#define MAX_PRIORITY 99
#define DEFAULT_SPIN_NS 50000

struct tfa_team {
    struct team *team;
    uint32_t threads;
};

struct outcome {
    int32_t status;
    tfa_field field;
    uint32_t index, state;
};

/* The team at work on one state */
struct pool_crew {
    struct tfa_crew crew; /* first: what kernels see of it */
    struct team *team;
};

/* What is below the workspaces belongs to the thread that has taken the team. */
struct tfa_pool {
    const tfa_model *model;
    tfa_team *team, *own; /* own: to be released with the pool; or NULL */
    uint32_t threads;
    tfa_workspace **workspace;
    struct pool_crew crew;
    struct outcome *outcome; /* by task */
    /* the request under way: states first .. first + count - 1 */
    const tfa_request *request;
    const tfa_reply *reply;
    uint32_t first, count, tasks;
};

/* ---- teams ---- */

int tfa_team_create(const tfa_team_options *options, tfa_team **team)
{
    static const tfa_team_options defaults;
    const tfa_team_options *o = options ? options : &defaults;
    if (!team || o->threads > MAX_THREADS || o->priority > MAX_PRIORITY)
        return TFA_E_ARGUMENT;
    *team = NULL;
    tfa_team *t = calloc(1, sizeof *t);
    if (!t)
        return TFA_E_MEMORY;
    const long online = sysconf(_SC_NPROCESSORS_ONLN);
    t->threads = o->threads ? o->threads : (uint32_t)(online > 0 ? online : 1);
    t->threads = t->threads > MAX_THREADS ? MAX_THREADS : t->threads;
    const struct team_options inner = {.threads = t->threads,
                                       .spin_ns = o->spin_ns ? o->spin_ns : DEFAULT_SPIN_NS,
                                       .cpus = o->cpus,
                                       .priority = (int)o->priority,
                                       .begin = tfa_stack_prepare};
    const int error = team_start(&t->team, &inner);
    if (error) {
        free(t);
        errno = error;
        return error == ENOMEM ? TFA_E_MEMORY : TFA_E_SYSTEM;
    }
    *team = t;
    return TFA_OK;
}

void tfa_team_free(tfa_team *team)
{
    if (team)
        team_stop(team->team);
    free(team);
}

/* ---- pools ---- */

static void run_crew(struct tfa_crew *crew, tfa_crew_task *task, void *context, uint32_t parts)
{
    team_run(((struct pool_crew *)crew)->team, task, context, parts);
}

static int create_workspaces(tfa_pool *p, const tfa_pool_options *o)
{
    const tfa_workspace_options options = {.precision = o->precision,
                                           .residual = o->residual,
                                           .methods = o->methods,
                                           .specialised = o->specialised};
    p->workspace = calloc(p->threads, sizeof(tfa_workspace *));
    p->outcome = calloc((size_t)p->threads * TASKS_PER_THREAD, sizeof *p->outcome);
    int status = p->workspace && p->outcome ? TFA_OK : TFA_E_MEMORY;
    for (uint32_t k = 0; status == TFA_OK && k < p->threads * TASKS_PER_THREAD; k++)
        p->outcome[k].status =
            TFA_E_NOT_COMPUTED; /* its pages are there before the first request */
    for (uint32_t k = 0; status == TFA_OK && k < p->threads; k++)
        status = tfa_workspace_create(p->model, &options, &p->workspace[k]);
    return status;
}

int tfa_pool_create(const tfa_model *model, const tfa_pool_options *options, tfa_pool **pool)
{
    static const tfa_pool_options defaults;
    const tfa_pool_options *o = options ? options : &defaults;
    if (!model || !pool)
        return TFA_E_ARGUMENT;
    *pool = NULL;
    tfa_pool *p = calloc(1, sizeof *p);
    if (!p)
        return TFA_E_MEMORY;
    const tfa_team_options own = {o->threads, o->spin_ns, o->cpus, o->priority};
    p->model = model;
    p->team = o->team;
    int status = o->team ? TFA_OK : tfa_team_create(&own, &p->own);
    if (p->own)
        p->team = p->own;
    if (status == TFA_OK) {
        p->threads = p->team->threads;
        p->crew = (struct pool_crew){{p->threads, run_crew}, p->team->team};
        status = create_workspaces(p, o);
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
    tfa_team_free(pool->own);
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

/* ---- one request ---- */

/* Where the states of task `task` begin. Long batches are cut where vectors of states end. */
static uint32_t task_start(const tfa_pool *p, uint32_t task)
{
    const uint32_t lanes = p->count >= 16 * p->tasks ? 8 : 1;
    const uint32_t start = (uint32_t)((uint64_t)p->count * task / p->tasks);
    return p->first + (task == p->tasks ? p->count : start / lanes * lanes);
}

static void compute_task(void *context, uint32_t task, uint32_t worker)
{
    tfa_pool *p = context;
    tfa_reply reply = *p->reply; /* of its own: status and culprit */
    int status = tfa_compute_checked(p->workspace[worker], p->request, task_start(p, task),
                                     task_start(p, task + 1), &reply);
    p->outcome[task] = (struct outcome){status, reply.field, reply.index, reply.state};
}

/* One state after the other, all threads on each. The crew leaves again: a batch has every thread
 * compute in a workspace of its own. */
static void compute_together(tfa_pool *p, tfa_reply *reply)
{
    tfa_workspace_employ(p->workspace[0], &p->crew.crew);
    (void)tfa_compute_checked(p->workspace[0], p->request, p->first, p->first + p->count, reply);
    tfa_workspace_employ(p->workspace[0], NULL);
}

/* The states spread over the threads; the first failure is told. */
static void compute_spread(tfa_pool *p, tfa_reply *reply)
{
    const tfa_reply checked = *reply;
    p->reply = &checked;
    p->tasks = p->threads * TASKS_PER_THREAD;
    if (p->tasks > p->count)
        p->tasks = p->count;
    team_run(p->team->team, compute_task, p, p->tasks);
    for (uint32_t k = 0; reply->status == TFA_OK && k < p->tasks; k++) {
        const struct outcome *o = &p->outcome[k];
        if (o->status == TFA_OK)
            continue;
        reply->status = o->status;
        reply->field = o->field;
        reply->index = o->index;
        reply->state = o->state;
    }
}

/* In parts, if there are not states enough for all threads */
static void compute(tfa_pool *p, const tfa_request *request, uint32_t first, uint32_t count,
                    tfa_reply *reply)
{
    p->request = request;
    p->first = first;
    p->count = count;
    if (p->threads > 1 &&
        (count <= 1 || (count < p->threads && tfa_goes_in_parts(p->model, request))))
        compute_together(p, reply);
    else if (p->threads > 1)
        compute_spread(p, reply);
    else
        (void)tfa_compute_checked(p->workspace[0], request, first, first + count, reply);
}

int tfa_pool_compute_states(tfa_pool *pool, const tfa_request *request, uint32_t first,
                            uint32_t count, tfa_reply *reply)
{
    const int status = tfa_room_check(pool->workspace[0], request, reply);
    if (status != TFA_OK)
        return status;
    if (!team_take(pool->team->team))
        return TFA_E_BUSY;
    compute(pool, request, first, count, reply);
    team_leave(pool->team->team);
    return reply->status;
}

int tfa_pool_compute(tfa_pool *pool, const tfa_request *request, tfa_reply *reply)
{
    int status = tfa_request_check(pool->model, request, reply);
    if (status == TFA_OK)
        status = tfa_pool_compute_states(pool, request, 0, request->count, reply);
    if (status == TFA_E_BUSY)
        reply->status = status;
    return status;
}
