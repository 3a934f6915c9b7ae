/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Public thread pools and batch pools (one workspace of a model for each thread).
 */
#include <errno.h>
#include <stdlib.h>
#include <totalforce/batch_pool.h>
#include <unistd.h>

#include "engine/flush_to_zero.h"
#include "engine/methods.h"
#include "interface/parallel_for.h"
#include "thread_pool/thread_pool.h"

/* Tasks for each thread: several, so that a stopped thread leaves work to the others */
#define TASKS_PER_THREAD 4
#define MAX_THREADS 256
#define MAX_PRIORITY 99
#define DEFAULT_SPIN_NS 50000

struct task_result {
    int32_t status;
    tfa_field field;
    uint32_t index, state;
};

/* Executor of one state on the thread pool */
struct pool_executor {
    struct tfa_executor executor; /* first member: kernels see this only */
    struct tfa_thread_pool *thread_pool;
};

/* The members after `workspace` belong to the thread that has acquired the thread pool. */
struct tfa_batch_pool {
    const tfa_model *model;
    tfa_thread_pool *thread_pool, *owned_pool; /* owned_pool: released with the pool, or NULL */
    uint32_t threads;
    tfa_workspace **workspace;
    struct pool_executor executor;
    struct task_result *task_result; /* by task */
    /* the request under way: states first .. first + count - 1 */
    const tfa_request *request;
    const tfa_reply *reply;
    uint32_t first, count, tasks;
};

/* ---- thread pools ---- */

static void prepare_thread(void)
{
    tfa_stack_prepare();
    (void)tfa_flush_begin(); /* for its parts of one state, until it ends */
}

int tfa_thread_pool_create(const tfa_thread_pool_options *options, tfa_thread_pool **thread_pool)
{
    static const tfa_thread_pool_options defaults;
    const tfa_thread_pool_options *o = options ? options : &defaults;
    if (!thread_pool || o->threads > MAX_THREADS || o->priority > MAX_PRIORITY)
        return TFA_E_ARGUMENT;
    *thread_pool = NULL;
    const long online = sysconf(_SC_NPROCESSORS_ONLN);
    const uint32_t threads = o->threads ? o->threads : (uint32_t)(online > 0 ? online : 1);
    const struct thread_pool_options inner = {.threads =
                                                  threads < MAX_THREADS ? threads : MAX_THREADS,
                                              .spin_ns = o->spin_ns ? o->spin_ns : DEFAULT_SPIN_NS,
                                              .cpus = o->cpus,
                                              .priority = (int)o->priority,
                                              .thread_init = prepare_thread};
    const int error = thread_pool_start(thread_pool, &inner);
    if (!error)
        return TFA_OK;
    errno = error;
    return error == ENOMEM ? TFA_E_MEMORY : TFA_E_SYSTEM;
}

void tfa_thread_pool_free(tfa_thread_pool *thread_pool)
{
    if (thread_pool)
        thread_pool_stop(thread_pool);
}

/* ---- batch pools ---- */

static void executor_run(struct tfa_executor *executor, tfa_parallel_task *task, void *context,
                         uint32_t parts)
{
    thread_pool_run(((struct pool_executor *)executor)->thread_pool, task, context, parts);
}

static int create_workspaces(tfa_batch_pool *p, const tfa_batch_pool_options *o)
{
    const tfa_workspace_options options = {.precision = o->precision,
                                           .residual = o->residual,
                                           .methods = o->methods,
                                           .max_tips = o->max_tips,
                                           .specialised = o->specialised};
    p->workspace = calloc(p->threads, sizeof(tfa_workspace *));
    p->task_result = calloc((size_t)p->threads * TASKS_PER_THREAD, sizeof *p->task_result);
    int status = p->workspace && p->task_result ? TFA_OK : TFA_E_MEMORY;
    for (uint32_t k = 0; status == TFA_OK && k < p->threads * TASKS_PER_THREAD; k++)
        p->task_result[k].status =
            TFA_E_NOT_COMPUTED; /* touches the pages before the first request */
    for (uint32_t k = 0; status == TFA_OK && k < p->threads; k++)
        status = tfa_workspace_create(p->model, &options, &p->workspace[k]);
    return status;
}

int tfa_batch_pool_create(const tfa_model *model, const tfa_batch_pool_options *options,
                          tfa_batch_pool **pool)
{
    static const tfa_batch_pool_options defaults;
    const tfa_batch_pool_options *o = options ? options : &defaults;
    if (!model || !pool)
        return TFA_E_ARGUMENT;
    *pool = NULL;
    tfa_batch_pool *p = calloc(1, sizeof *p);
    if (!p)
        return TFA_E_MEMORY;
    const tfa_thread_pool_options owned_pool = {o->threads, o->spin_ns, o->cpus, o->priority};
    p->model = model;
    p->thread_pool = o->thread_pool;
    int status = o->thread_pool ? TFA_OK : tfa_thread_pool_create(&owned_pool, &p->owned_pool);
    if (p->owned_pool)
        p->thread_pool = p->owned_pool;
    if (status == TFA_OK) {
        p->threads = thread_pool_threads(p->thread_pool);
        p->executor = (struct pool_executor){{p->threads, executor_run}, p->thread_pool};
        status = create_workspaces(p, o);
    }
    if (status != TFA_OK) {
        tfa_batch_pool_free(p);
        return status;
    }
    *pool = p;
    return TFA_OK;
}

void tfa_batch_pool_free(tfa_batch_pool *pool)
{
    if (!pool)
        return;
    tfa_thread_pool_free(pool->owned_pool);
    for (uint32_t k = 0; pool->workspace && k < pool->threads; k++)
        tfa_workspace_free(pool->workspace[k]);
    free(pool->workspace);
    free(pool->task_result);
    free(pool);
}

uint32_t tfa_batch_pool_threads(const tfa_batch_pool *pool)
{
    return pool->threads;
}

/* ---- one request ---- */

/* First state of a task. Long batches are cut at full vectors of states. */
static uint32_t task_start(const tfa_batch_pool *p, uint32_t task)
{
    const uint32_t lanes = p->count >= 16 * p->tasks ? 8 : 1;
    const uint32_t start = (uint32_t)((uint64_t)p->count * task / p->tasks);
    return p->first + (task == p->tasks ? p->count : start / lanes * lanes);
}

static void compute_task(void *context, uint32_t task, uint32_t worker)
{
    tfa_batch_pool *p = context;
    tfa_reply reply = *p->reply; /* its own status and failed field */
    int status = tfa_compute_checked(p->workspace[worker], p->request, task_start(p, task),
                                     task_start(p, task + 1), &reply);
    p->task_result[task] = (struct task_result){status, reply.field, reply.index, reply.state};
}

/* Computes one state after the other, all threads on each; without the executor again afterwards,
 * because in a batch every thread uses its own workspace. */
static void compute_state_in_parallel(tfa_batch_pool *p, tfa_reply *reply)
{
    tfa_workspace_set_executor(p->workspace[0], &p->executor.executor);
    (void)tfa_compute_checked(p->workspace[0], p->request, p->first, p->first + p->count, reply);
    tfa_workspace_set_executor(p->workspace[0], NULL);
}

/* Spreads the states over the threads; reports the first failure. */
static void compute_batch_in_parallel(tfa_batch_pool *p, tfa_reply *reply)
{
    const tfa_reply checked = *reply;
    p->reply = &checked;
    p->tasks = p->threads * TASKS_PER_THREAD;
    if (p->tasks > p->count)
        p->tasks = p->count;
    thread_pool_run(p->thread_pool, compute_task, p, p->tasks);
    for (uint32_t k = 0; reply->status == TFA_OK && k < p->tasks; k++) {
        const struct task_result *o = &p->task_result[k];
        if (o->status == TFA_OK)
            continue;
        reply->status = o->status;
        reply->field = o->field;
        reply->index = o->index;
        reply->state = o->state;
    }
}

/* By parts of a state if there are fewer states than threads */
static void compute(tfa_batch_pool *p, const tfa_request *request, uint32_t first, uint32_t count,
                    tfa_reply *reply)
{
    p->request = request;
    p->first = first;
    p->count = count;
    if (p->threads > 1 &&
        (count <= 1 || (count < p->threads && tfa_method_is_parallel(p->model, request))))
        compute_state_in_parallel(p, reply);
    else if (p->threads > 1)
        compute_batch_in_parallel(p, reply);
    else
        (void)tfa_compute_checked(p->workspace[0], request, first, first + count, reply);
}

int tfa_batch_pool_compute_states(tfa_batch_pool *pool, const tfa_request *request, uint32_t first,
                                  uint32_t count, tfa_reply *reply)
{
    const int status = tfa_reserved_check(pool->workspace[0], request, reply);
    if (status != TFA_OK)
        return status;
    if (!thread_pool_acquire(pool->thread_pool))
        return TFA_E_BUSY;
    compute(pool, request, first, count, reply);
    thread_pool_release(pool->thread_pool);
    return reply->status;
}

int tfa_batch_pool_compute(tfa_batch_pool *pool, const tfa_request *request, tfa_reply *reply)
{
    int status = tfa_request_check(pool->model, request, reply);
    if (status == TFA_OK)
        status = tfa_batch_pool_compute_states(pool, request, 0, request->count, reply);
    if (status == TFA_E_BUSY)
        reply->status = status;
    return status;
}
