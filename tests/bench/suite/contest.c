/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A task for one robot: its inputs, and who answers them.
 */
#include "suite.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static double uniform(void)
{
    static uint64_t x = 88172645463325252u;
    x ^= x << 13;
    x ^= x >> 7;
    x ^= x << 17;
    return (double)(x >> 11) / (double)(1ull << 52) - 1;
}

/* ---- who answers ---- */

static void open_library(struct contest *c, const struct library *l)
{
    const struct task *t = c->task;
    const tfa_model_options options = {
        .base = c->robot->base, .lock_massless_leaves = 1, .snap = c->robot->snap};
    /* large robots have no room for every method unless asked */
    const uint32_t methods = t->method == TFA_METHOD_AUTO ? 0 : TFA_METHOD_BIT(t->method);
    const tfa_workspace_options workspace = {
        .precision = t->precision, .methods = methods, .specialised = l->specialised};
    const tfa_pool_options pool = {.threads = t->threads,
                                   .cpus = cpus_for(t->threads),
                                   .precision = t->precision,
                                   .methods = methods};
    struct contestant *w = &c->who[c->count];
    *w = (struct contestant){.name = l->name, .library = l};
    int status = l->tfa_model_create(c->robot->description, &options, NULL, &w->model);
    if (status == TFA_OK && t->threads > 1)
        status = l->tfa_pool_create(w->model, &pool, &w->pool);
    else if (status == TFA_OK)
        status = l->tfa_workspace_create(w->model, &workspace, &w->workspace);
    c->count += status == TFA_OK;
    if (status != TFA_OK)
        l->tfa_model_free(w->model);
}

static void open_peer(struct contest *c, const struct peer *peer)
{
    char why[256] = "";
    struct contestant *w = &c->who[c->count];
    *w = (struct contestant){.name = peer->name, .peer = peer};
    w->peers_robot = peer->make(c->robot->path, c->robot->description, why, sizeof why);
    c->count += w->peers_robot != NULL;
}

/* Forward dynamics on a fixed base is all that peers are asked for, in order of the description. */
static int peers_take(const struct contest *c)
{
    const struct task *t = c->task;
    return t->op == TFA_OP_FORWARD_DYNAMICS && t->method == TFA_METHOD_AUTO && t->states == 1 &&
           t->threads == 1 && !t->tips && t->estimate == TFA_ESTIMATE_NEVER &&
           c->robot->base == TFA_BASE_FIXED && c->robot->joints == c->nv &&
           c->nv <= PEER_BODIES_MAX;
}

static void close_contestant(struct contestant *w)
{
    if (w->library) {
        w->library->tfa_pool_free(w->pool);
        w->library->tfa_workspace_free(w->workspace);
        w->library->tfa_model_free(w->model);
    } else {
        w->peer->release(w->peers_robot);
    }
}

/* ---- what is asked ---- */

static void fill(struct contest *c, size_t all)
{
    for (size_t k = 0; k < all * c->nq; k++)
        c->q[k] = 3 * uniform();
    for (double *x = c->v; x < c->pose; x++)
        *x = uniform();
    for (size_t k = 0; k < 6 * all; k++)
        c->twist[k] = uniform();
    for (size_t s = 0; s < all; s++) {
        double *pose = c->pose + 7 * s, size = 0;
        for (int e = 0; e < 7; e++)
            pose[e] = uniform();
        for (int e = 3; e < 7; e++)
            size += pose[e] * pose[e];
        for (int e = 3; e < 7; e++)
            pose[e] /= sqrt(size);
    }
}

static int make_inputs(struct contest *c)
{
    const struct task *t = c->task;
    const size_t n = t->states, all = t->states > 1 ? n : SUITE_STATES;
    const size_t nv = c->nv, nm = nv + 6, six = 6 * (size_t)t->tips;
    const size_t mass = t->op == TFA_OP_MASS_MATRIX ? nm * nm : 0;
    c->answers = n * (nv + 6 + six * six + mass);
    c->block = calloc(all * (c->nq + 2 * nv + 13) + c->answers, sizeof *c->block);
    if (!c->block)
        return -1;
    c->q = c->block;
    c->v = c->q + all * c->nq;
    c->tau = c->v + all * nv;
    c->pose = c->tau + all * nv;
    c->twist = c->pose + 7 * all;
    c->out = c->twist + 6 * all;
    fill(c, all);
    c->request = (tfa_request){.op = t->op,
                               .method = t->method,
                               .estimate = t->estimate,
                               .refine = t->refine,
                               .count = t->states,
                               .tip_count = t->tips};
    robot_tips(c->robot, t->tips);
    memcpy(c->request.tips, c->robot->tips, sizeof c->request.tips);
    c->reply = (tfa_reply){.qdd = c->out,
                           .tau = c->out,
                           .base_acceleration = c->out + n * nv,
                           .base_wrench = c->out + n * nv,
                           .lambda_inv = c->out + n * nm,
                           .mass_matrix = c->out + n * (nm + six * six)};
    return 0;
}

static void point_at(struct contest *c, size_t state)
{
    tfa_request *r = &c->request;
    const double *tau = c->tau + state * c->nv;
    r->q = c->q + state * c->nq;
    r->v = c->v + state * c->nv;
    r->tau = r->op == TFA_OP_FORWARD_DYNAMICS ? tau : NULL;
    r->qdd = r->op == TFA_OP_INVERSE_DYNAMICS ? tau : NULL;
    r->base_pose = c->robot->base == TFA_BASE_FLOATING ? c->pose + 7 * state : NULL;
    r->base_twist = c->robot->base == TFA_BASE_FLOATING ? c->twist + 6 * state : NULL;
}

/* The state after this one is where its answer leads in a tenth of a microsecond: it waits for the
 * answer, and the robot stays where it is. */
static void lead_on(struct contest *c)
{
    const size_t now = c->next % SUITE_STATES, after = (c->next + 1) % SUITE_STATES;
    const double *q = c->q + now * c->nq, *v = c->v + now * c->nv;
    double *q2 = c->q + after * c->nq, *v2 = c->v + after * c->nv;
    for (size_t k = 0; k < c->nv; k++) {
        v2[k] = v[k] + 1e-13 * c->out[k];
        q2[k] = q[k] + 1e-13 * v2[k] + (q[k] < 3 ? 1e-9 : -1e-9);
    }
}

static int ask(struct contest *c, uint32_t who, size_t state)
{
    struct contestant *w = &c->who[who];
    point_at(c, state);
    if (w->peer) {
        w->peer->forward(w->peers_robot, c->request.q, c->request.v, c->request.tau, c->out);
        return 1;
    }
    return (w->pool ? w->library->tfa_pool_compute(w->pool, &c->request, &c->reply)
                    : w->library->tfa_compute(w->workspace, &c->request, &c->reply)) == TFA_OK;
}

int contest_ask(struct contest *c, uint32_t who)
{
    const int good = ask(c, who, c->task->states > 1 ? 0 : c->next % SUITE_STATES);
    if (c->task->how == HOW_CHAINED)
        lead_on(c);
    c->next++;
    return good;
}

const char *contest_method(struct contest *c, uint32_t who)
{
    const struct contestant *w = &c->who[who];
    tfa_answer *answers = calloc(c->task->states, sizeof *answers);
    if (!w->library || !answers) {
        free(answers);
        return "";
    }
    c->reply.answers = answers;
    (void)ask(c, who, 0);
    const char *name = w->library->tfa_method_name(answers[0].method);
    c->reply.answers = NULL;
    free(answers);
    return name;
}

double contest_difference(struct contest *c, uint32_t who)
{
    double *first = malloc(c->answers * sizeof *first), sum = 0, size = 0;
    if (!first)
        return NAN;
    memset(c->out, 0, c->answers * sizeof *first);
    (void)ask(c, 0, 0);
    memcpy(first, c->out, c->answers * sizeof *first);
    memset(c->out, 0, c->answers * sizeof *first);
    (void)ask(c, who, 0);
    for (size_t k = 0; k < c->answers; k++) {
        sum += (c->out[k] - first[k]) * (c->out[k] - first[k]);
        size += first[k] * first[k];
    }
    free(first);
    return sqrt(sum / size);
}

/* ---- all of it ---- */

static void drop_silent(struct contest *c)
{
    uint32_t kept = 0;
    for (uint32_t k = 0; k < c->count; k++)
        if (ask(c, k, 0))
            c->who[kept++] = c->who[k];
        else
            close_contestant(&c->who[k]);
    c->count = kept;
}

int contest_open(struct contest *c, const struct task *task, struct robot *robot,
                 const struct library *libraries, uint32_t count)
{
    *c = (struct contest){.task = task, .robot = robot};
    for (uint32_t k = 0; k < count; k++)
        open_library(c, &libraries[k]);
    if (c->count == 0)
        return -1;
    c->nq = libraries[0].tfa_model_q_count(c->who[0].model);
    c->nv = libraries[0].tfa_model_v_count(c->who[0].model);
    for (size_t k = 0; peer_table[k] && c->count < SUITE_WHO && peers_take(c); k++)
        open_peer(c, peer_table[k]);
    if (c->nq == c->nv && make_inputs(c) == 0)
        drop_silent(c);
    if (c->block && c->count > 0 && c->who[0].library == &libraries[0])
        return 0;
    contest_close(c);
    return -1;
}

void contest_close(struct contest *c)
{
    for (uint32_t k = 0; k < c->count; k++)
        close_contestant(&c->who[k]);
    free(c->block);
    *c = (struct contest){0};
}
