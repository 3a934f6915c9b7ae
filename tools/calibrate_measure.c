/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * One pair of a calibration: two ways to the same answer, in turns.
 */
#include "calibrate.h"
#include "chart.h"
#include "mechanism.h"

#include <stdlib.h>
#include <time.h>

/* States that calls go through, so that none finds its factors kept; those of a batch at most. */
enum { STATES = 8, BATCH_BODIES = 7, TREE_BODIES = 40, PAIRS_MIN = 5, PAIRS_MAX = 201 };

/* A turn must be long against a clock read and a sleeping thread that has to be woken once. */
#define TURN_SECONDS 200e-6

/* The two ways, and what is asked of both */
struct pair {
    const calibrate_contest *contest;
    tfa_model *model;
    tfa_workspace *one, *next;
    tfa_pool *pool; /* of the next way, with several threads */
    tfa_request request;
    tfa_reply reply;
    double *block, *q, *v, *tau, *out;
    uint32_t turn;
};

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static uint32_t bodies_of(const calibrate_contest *c, uint32_t size)
{
    return c->axis == CALIBRATE_CHAIN  ? size
           : c->axis == CALIBRATE_TIPS ? TREE_BODIES
                                       : BATCH_BODIES;
}

static uint32_t states_of(const calibrate_contest *c, uint32_t size)
{
    return c->axis == CALIBRATE_STATES ? size
           : c->axis == CALIBRATE_WORK ? (size + BATCH_BODIES - 1) / BATCH_BODIES
                                       : 1;
}

static int compile(struct pair *p, uint32_t bodies)
{
    const mechanism_options m = mechanism_defaults(
        p->contest->axis == CALIBRATE_TIPS ? MECHANISM_SIDE_BRANCHES : MECHANISM_RANDOM, bodies);
    tfa_description *description = mechanism_make(&m);
    if (!description)
        return TFA_E_MEMORY;
    const int status = tfa_model_create(description, NULL, NULL, &p->model);
    mechanism_free(description);
    return status;
}

/* Lanes and pool at once wherever there are two states: the contest is to say what they are worth. */
static int make_ways(struct pair *p)
{
    tfa_crossovers eager = *tfa_crossovers_default();
    eager.lanes_from = eager.pool_from = 2;
    const tfa_workspace_options lanes = {.crossovers = &eager}, single = {.states = TFA_STATES_ONE};
    const tfa_pool_options pool = {.threads = p->contest->threads, .crossovers = &eager};
    int status = tfa_workspace_create(
        p->model, p->contest->axis == CALIBRATE_STATES ? &single : &lanes, &p->one);
    if (status == TFA_OK)
        status = tfa_workspace_create(p->model, &lanes, &p->next);
    if (status == TFA_OK && p->contest->threads > 1)
        status = tfa_pool_create(p->model, &pool, &p->pool);
    return status;
}

/* Numbers for STATES turns of `states` states */
static int make_question(struct pair *p, uint32_t states, uint32_t tips)
{
    const size_t nq = tfa_model_q_count(p->model), nv = tfa_model_v_count(p->model);
    const size_t answers = nv > 36 * (size_t)tips * tips ? nv : 36 * (size_t)tips * tips;
    const size_t all = (size_t)states * STATES;
    uint64_t random = 1;
    p->block = calloc(all * (nq + 2 * nv) + states * answers, sizeof *p->block);
    if (!p->block)
        return TFA_E_MEMORY;
    p->q = p->block;
    p->v = p->q + all * nq;
    p->tau = p->v + all * nv;
    p->out = p->tau + all * nv;
    for (double *x = p->q; x < p->out; x++)
        *x = mechanism_random_uniform(&random, -1, 1);
    p->request = (tfa_request){
        .op = p->contest->op, .estimate = TFA_ESTIMATE_NEVER, .count = states, .tip_count = tips};
    const uint32_t frames = tfa_model_frame_count(p->model);
    for (uint32_t t = 0; t < tips; t++) /* the last frame is the end of a chain */
        p->request.tips[t] = frames - 1 - t * (frames - 1) / (tips > 1 ? tips : 2);
    p->reply = (tfa_reply){.qdd = p->out, .lambda_inv = p->out};
    return TFA_OK;
}

static int open_pair(struct pair *p, uint32_t size)
{
    const uint32_t tips = p->contest->op != TFA_OP_OPERATIONAL_INERTIA ? 0
                          : p->contest->axis == CALIBRATE_TIPS         ? size
                                                                       : 1;
    int status = compile(p, bodies_of(p->contest, size));
    if (status == TFA_OK)
        status = make_ways(p);
    return status == TFA_OK ? make_question(p, states_of(p->contest, size), tips) : status;
}

static void close_pair(struct pair *p)
{
    free(p->block);
    tfa_pool_free(p->pool);
    tfa_workspace_free(p->next);
    tfa_workspace_free(p->one);
    tfa_model_free(p->model);
}

static int ask(struct pair *p, int next)
{
    const size_t at = (size_t)(p->turn++ % STATES) * p->request.count;
    p->request.method = next ? p->contest->next : p->contest->old;
    p->request.q = p->q + at * tfa_model_q_count(p->model);
    p->request.v = p->v + at * tfa_model_v_count(p->model);
    p->request.tau = p->tau + at * tfa_model_v_count(p->model);
    return next && p->pool ? tfa_pool_compute(p->pool, &p->request, &p->reply)
                           : tfa_compute(next ? p->next : p->one, &p->request, &p->reply);
}

/* Seconds for one of `calls` calls; negative: one failed */
static double turn(struct pair *p, int next, uint32_t calls)
{
    const double start = now();
    for (uint32_t k = 0; k < calls; k++)
        if (ask(p, next) != TFA_OK)
            return -1;
    return (now() - start) / calls;
}

/* The lower quartile: what the machine does to others makes times longer, never shorter. */
static double quartile(double *seconds, uint32_t count)
{
    (void)chart_median(seconds, count); /* sorts */
    return seconds[count / 4];
}

static double take_turns(struct pair *p, double seconds)
{
    double times[2][PAIRS_MAX];
    uint32_t calls[2], n = 0;
    for (int next = 0; next < 2; next++) {
        const double first = turn(p, next, 2);
        if (first < 0)
            return -1;
        calls[next] = first < TURN_SECONDS ? (uint32_t)(TURN_SECONDS / (first + 1e-8)) + 1 : 1;
    }
    const double end = now() + seconds;
    for (; n < PAIRS_MIN || (n < PAIRS_MAX && now() < end); n++)
        for (int next = 0; next < 2; next++)
            times[next][n] = turn(p, next, calls[next]);
    return quartile(times[1], n) / quartile(times[0], n);
}

int calibrate_measure(const calibrate_contest *contest, uint32_t size, uint32_t budget_ms,
                      double *ratio)
{
    struct pair p = {.contest = contest};
    int status = open_pair(&p, size);
    if (status == TFA_OK) {
        *ratio = take_turns(&p, 1e-3 * budget_ms);
        if (*ratio < 0)
            status = p.reply.status;
    }
    close_pair(&p);
    return status;
}
