/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The daemon's worker in a thread, solving with tfa_compute.
 */
#include "test_worker.h"

#include "worker/cost_bound.h"
#include "worker/worker.h"

#include <pthread.h>
#include <time.h>

typedef struct solver {
    const tfa_model *model;
    tfa_workspace *workspace;
    uint32_t delay_us;
    bool is_worker;
} solver;

static solver solvers[2 * TEST_ROBOTS]; /* the worker's, the gateway's */
static tfa_worker_robot served[2 * TEST_ROBOTS];
static pthread_t thread;
static pthread_mutex_t gate = PTHREAD_MUTEX_INITIALIZER; /* locked: the worker's answers are held */

/* Many tips are long, all else is short, whatever the machine. */
static const tfa_cost_parts *make_parts(void)
{
    static tfa_cost_parts parts = {.tips = {0, 1, 3, TFA_DEFAULT_TIPS, TFA_DEFAULT_TIPS}};
    for (int op = 1; op <= TFA_OP_LAST; op++)
        for (int method = 0; method < TFA_COST_METHODS; method++)
            for (int k = 0; k < TFA_COST_POINTS; k++)
                parts.of[op][method].plain.at[k] = 1000 + 10000 * parts.tips[k];
    return &parts;
}

static int solve(void *self, tfa_request *request, tfa_reply *reply, uint32_t first, uint32_t count)
{
    const solver *s = self;
    const struct timespec delay = {.tv_sec = s->delay_us / 1000000,
                                   .tv_nsec = s->delay_us % 1000000 * 1000};
    if (s->delay_us > 0)
        clock_nanosleep(CLOCK_MONOTONIC, 0, &delay, NULL);
    if (s->is_worker) {
        pthread_mutex_lock(&gate);
        pthread_mutex_unlock(&gate);
    }
    if (first == 0 && tfa_request_check(s->model, request, reply) != TFA_OK)
        return reply->status;
    return tfa_compute_states(s->workspace, request, first, count, reply);
}

static void *worker_thread(void *worker)
{
    tfa_worker_run(worker);
    return NULL;
}

struct tfa_worker *test_worker_start(const test_robot robots[TEST_ROBOTS], uint32_t delay_us)
{
    tfa_worker *worker;
    for (uint32_t i = 0; i < 2 * TEST_ROBOTS; i++) {
        const tfa_model *model = robots[i % TEST_ROBOTS].model;
        if (tfa_workspace_create(model, NULL, &solvers[i].workspace) != TFA_OK)
            return NULL;
        solvers[i].model = model;
        solvers[i].delay_us = delay_us;
        solvers[i].is_worker = i < TEST_ROBOTS;
        served[i] = (tfa_worker_robot){
            .shape = {.q_count = tfa_model_q_count(model),
                      .v_count = tfa_model_v_count(model),
                      .base_freedoms = tfa_model_base_freedoms(model),
                      .frames = tfa_model_frame_count(model),
                      .max_batch = TEST_BATCH,
                      .max_tips = TFA_DEFAULT_TIPS},
            .solve = solve,
            .self = &solvers[i],
            .parts = make_parts(),
        };
    }
    const tfa_worker_options options = {
        .robots = served, .robot_count = TEST_ROBOTS, .spin_ns = 50000, .wait = TFA_WAIT_HYBRID};
    if (tfa_worker_create(&options, &worker) != TFA_OK)
        return NULL;
    return pthread_create(&thread, NULL, worker_thread, worker) == 0 ? worker : NULL;
}

void test_worker_hold(bool hold)
{
    static bool held;
    if (hold != held)
        (hold ? pthread_mutex_lock : pthread_mutex_unlock)(&gate);
    held = hold;
}

void test_worker_stop(struct tfa_worker *worker)
{
    tfa_worker_stop(worker);
    pthread_join(thread, NULL);
    tfa_worker_destroy(worker);
    for (uint32_t i = 0; i < 2 * TEST_ROBOTS; i++)
        tfa_workspace_free(solvers[i].workspace);
}

const struct tfa_worker_robot *test_gateway_solvers(void)
{
    return served + TEST_ROBOTS;
}
