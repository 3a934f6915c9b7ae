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

static tfa_model_options model_options(const struct contest *c)
{
    return (tfa_model_options){.base = c->robot->base,
                               .lock_massless_leaves = 1,
                               .snap = c->robot->snap,
                               .scene = suite_scene(c->task->scene)};
}

static void open_library(struct contest *c, const struct library *l)
{
    const struct task *t = c->task;
    const tfa_model_options options = model_options(c);
    /* large robots have no room for every method unless asked */
    const uint32_t methods = t->method == TFA_METHOD_AUTO ? 0 : TFA_METHOD_BIT(t->method);
    const tfa_workspace_options workspace = {
        .precision = t->precision,
        .residual = t->residual,
        .states = t->one_by_one || t->residual ? TFA_STATES_ONE : TFA_STATES_AUTO,
        .methods = methods,
        .specialised = t->scene ? NULL : l->specialised,
        .max_tips = t->tips};
    const tfa_batch_pool_options pool = {.threads = t->threads,
                                         .cpus = cpus_for(t->threads),
                                         .precision = t->precision,
                                         .methods = methods};
    struct contestant *w = &c->contestant[c->count];
    *w = (struct contestant){.name = l->name, .library = l};
    int status = l->tfa_model_create(c->robot->description, &options, NULL, &w->model);
    if (status == TFA_OK && t->threads > 1)
        status = l->tfa_batch_pool_create(w->model, &pool, &w->pool);
    else if (status == TFA_OK)
        status = l->tfa_workspace_create(w->model, &workspace, &w->workspace);
    c->count += status == TFA_OK;
    if (status != TFA_OK)
        l->tfa_model_free(w->model);
}

static void open_peer(struct contest *c, const struct peer *peer, const struct peer_lambda *lambda)
{
    char why[256] = "";
    struct contestant *w = &c->contestant[c->count];
    *w = (struct contestant){.name = peer->name, .peer = peer, .peers_lambda = lambda};
    w->peers_robot = peer->make(c->robot->path, c->robot->description, why, sizeof why);
    c->count += w->peers_robot != NULL;
}

/* Forward dynamics and Lambda^-1 of a tip on a fixed base is all that peers are asked for, in order
 * of the description. */
static int peers_answer(const struct contest *c)
{
    const struct task *t = c->task;
    const int asked = t->op == TFA_OP_FORWARD_DYNAMICS || t->op == TFA_OP_OPERATIONAL_INERTIA;
    return asked && t->method == TFA_METHOD_AUTO && t->states == 1 && t->threads == 1 &&
           t->tips <= 1 && t->estimate == TFA_ESTIMATE_NEVER && t->how <= HOW_COLD && !t->given &&
           !t->scene && c->robot->base == TFA_BASE_FIXED && c->robot->joints == c->nv &&
           c->nv <= PEER_BODIES_MAX;
}

static void open_peers(struct contest *c)
{
    if (!peers_answer(c))
        return;
    for (size_t k = 0; !c->task->tips && peer_table[k] && c->count < SUITE_CONTESTANTS; k++)
        open_peer(c, peer_table[k], NULL);
    for (const struct peer_lambda *l = peer_lambda_table;
         c->task->tips && l->peer && c->count < SUITE_CONTESTANTS; l++)
        open_peer(c, l->peer, l);
}

static void close_contestant(struct contestant *w)
{
    if (w->library) {
        w->library->tfa_batch_pool_free(w->pool);
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
    for (size_t k = 0; k < 6 * all; k++)
        c->wrench[k] = 10 * uniform();
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

static void give(struct contest *c)
{
    static const double gravity[3] = {1, -2, -9};
    static const double payload[TFA_PAYLOAD_NUMBERS] = {0.8,  0.02, 0,    0.05, 2e-3,
                                                        1e-4, 0,    2e-3, 0,    1e-3};
    c->request.gravity = c->task->given == A_GRAVITY ? gravity : NULL;
    c->request.payload_count = c->task->given == A_PAYLOAD;
    c->request.payloads = payload;
    c->request.payload_frames[0] = robot_deepest(c->robot);
    c->request.wrench_count = c->task->given == A_WRENCH;
    c->request.wrench_frames[0] = robot_deepest(c->robot);
}

static void find_tips(struct contest *c)
{
    const struct library *l = c->contestant[0].library;
    robot_tips(c->robot, c->task->tips);
    memcpy(c->request.tips, c->robot->tips, sizeof c->request.tips);
    if (c->task->scene && l->tfa_model_find_frame)
        c->request.tips[0] = (uint32_t)l->tfa_model_find_frame(c->contestant[0].model, SUITE_PALM);
    else if (c->task->deepest_tip)
        c->request.tips[0] = robot_deepest(c->robot);
}

static int make_inputs(struct contest *c)
{
    const struct task *t = c->task;
    const size_t n = t->states, all = t->states > 1 ? n : SUITE_STATES;
    const size_t nv = c->nv, nm = nv + 6, six = 6 * (size_t)t->tips;
    const size_t mass = t->op == TFA_OP_MASS_MATRIX ? nm * nm : 0;
    const int differentiates =
        t->op == TFA_OP_DERIVATIVES || t->op == TFA_OP_INVERSE_DYNAMICS_DERIVATIVES;
    const size_t square = differentiates ? nm * nm : 0;
    const size_t forces =
        t->flags & TFA_WANT_JOINT_FORCES
            ? 6 * (size_t)c->contestant[0].library->tfa_model_frame_count(c->contestant[0].model)
            : 0;
    c->answers = n * (nv + 6 + six * six + mass + 3 * square + forces);
    c->block = calloc(all * (c->nq + 2 * nv + 19) + c->answers, sizeof *c->block);
    if (!c->block)
        return -1;
    c->q = c->block;
    c->v = c->q + all * c->nq;
    c->tau = c->v + all * nv;
    c->pose = c->tau + all * nv;
    c->twist = c->pose + 7 * all;
    c->wrench = c->twist + 6 * all;
    c->out = c->wrench + 6 * all;
    fill(c, all);
    c->request = (tfa_request){.op = t->op,
                               .method = t->method,
                               .estimate = t->estimate,
                               .refine = t->refine,
                               .flags = t->flags,
                               .count = t->states,
                               .tip_count = t->tips};
    find_tips(c);
    give(c);
    double *const derivatives = c->out + n * (nm + six * six);
    c->reply = (tfa_reply){.qdd = c->out,
                           .tau = c->out,
                           .base_acceleration = c->out + n * nv,
                           .base_wrench = c->out + n * nv,
                           .lambda_inv = c->out + n * nm,
                           .mass_matrix = c->out + n * (nm + six * six),
                           .dqdd_dq = derivatives,
                           .dqdd_dv = derivatives + n * square,
                           .dqdd_dtau = derivatives + 2 * n * square,
                           .dtau_dq = derivatives,
                           .dtau_dv = derivatives + n * square,
                           .joint_forces = derivatives + 3 * n * square};
    return 0;
}

static void set_state(struct contest *c, size_t state)
{
    tfa_request *r = &c->request;
    const double *tau = c->tau + state * c->nv;
    r->q = c->q + (c->task->how == HOW_SAME_Q ? 0 : state) * c->nq;
    r->v = c->v + state * c->nv;
    r->tau = r->op == TFA_OP_FORWARD_DYNAMICS || r->op == TFA_OP_DERIVATIVES ? tau : NULL;
    r->qdd = r->op == TFA_OP_INVERSE_DYNAMICS || r->op == TFA_OP_INVERSE_DYNAMICS_DERIVATIVES
                 ? tau
                 : NULL;
    r->base_pose = c->robot->base == TFA_BASE_FLOATING
                       ? c->pose + 7 * (c->task->how == HOW_SAME_Q ? 0 : state)
                       : NULL;
    r->base_twist = c->robot->base == TFA_BASE_FLOATING ? c->twist + 6 * state : NULL;
    r->wrenches = c->wrench + 6 * state;
}

/* The state after this one is where its answer leads in a tenth of a microsecond: it waits for the
 * answer, and the robot stays where it is. */
static void chain_states(struct contest *c)
{
    const size_t now = c->next % SUITE_STATES, after = (c->next + 1) % SUITE_STATES;
    const double *q = c->q + now * c->nq, *v = c->v + now * c->nv;
    double *q2 = c->q + after * c->nq, *v2 = c->v + after * c->nv;
    for (size_t k = 0; k < c->nv; k++) {
        v2[k] = v[k] + 1e-13 * c->out[k];
        q2[k] = q[k] + 1e-13 * v2[k] + (q[k] < 3 ? 1e-9 : -1e-9);
    }
}

static int ask_peer(struct contest *c, const struct contestant *w)
{
    const tfa_request *r = &c->request;
    const tfa_description *d = c->robot->description;
    if (r->op == TFA_OP_FORWARD_DYNAMICS)
        w->peer->forward(w->peers_robot, r->q, r->v, r->tau, c->out);
    return !w->peers_lambda ||
           w->peers_lambda->lambda(w->peers_robot, r->q, d->links[r->tips[0]].name,
                                   c->reply.lambda_inv) == 0;
}

static int call_library(struct contest *c, const struct contestant *w, size_t state)
{
    set_state(c, state);
    if (w->peer)
        return ask_peer(c, w);
    return (w->pool ? w->library->tfa_batch_pool_compute(w->pool, &c->request, &c->reply)
                    : w->library->tfa_compute(w->workspace, &c->request, &c->reply)) == TFA_OK;
}

/* What a robot costs before its first request */
static int prepare(struct contest *c, const struct contestant *w)
{
    const struct library *l = w->library;
    const tfa_model_options options = model_options(c);
    tfa_report report = {0};
    tfa_description *d = NULL;
    tfa_model *m = NULL;
    tfa_workspace *workspace = NULL;
    const int status = c->task->how == HOW_PARSE ? l->tfa_urdf_load(c->robot->path, &d, &report)
                       : c->task->how == HOW_COMPILE
                           ? l->tfa_model_create(c->robot->description, &options, &report, &m)
                           : l->tfa_workspace_create(w->model, NULL, &workspace);
    l->tfa_workspace_free(workspace);
    l->tfa_model_free(m);
    l->tfa_description_free(d);
    l->tfa_report_free(&report);
    return status == TFA_OK;
}

size_t contest_bytes(struct contest *c, uint32_t contestant)
{
    const struct contestant *w = &c->contestant[contestant];
    const tfa_model_options options = model_options(c);
    return c->task->bytes(w->library, c->robot->description, &options, w->model);
}

int contest_call(struct contest *c, uint32_t contestant)
{
    if (c->task->how >= HOW_PARSE)
        return prepare(c, &c->contestant[contestant]);
    const int good = call_library(c, &c->contestant[contestant],
                                  c->task->states > 1 ? 0 : c->next % SUITE_STATES);
    if (c->task->how == HOW_CHAINED)
        chain_states(c);
    c->next++;
    return good;
}

const char *contest_method(struct contest *c, uint32_t contestant)
{
    const struct contestant *w = &c->contestant[contestant];
    tfa_answer *answers = calloc(c->task->states, sizeof *answers);
    if (!w->library || !answers || c->task->how >= HOW_PARSE) {
        free(answers);
        return "";
    }
    c->reply.answers = answers;
    (void)call_library(c, w, 0);
    const char *name = w->library->tfa_method_name(answers[0].method);
    c->reply.answers = NULL;
    free(answers);
    return name;
}

/* The answer of a state into c->out, and 0 elsewhere */
static int answer_state(struct contest *c, const struct contestant *w, size_t state)
{
    memset(c->out, 0, c->answers * sizeof *c->out);
    return call_library(c, w, state);
}

/* |out - first| / |first| */
static double distance(const struct contest *c, const double *first)
{
    double sum = 0, size = 0;
    for (size_t k = 0; k < c->answers; k++) {
        sum += (c->out[k] - first[k]) * (c->out[k] - first[k]);
        size += first[k] * first[k];
    }
    return sqrt(sum / size);
}

double contest_difference(struct contest *c, uint32_t contestant)
{
    double *first = malloc(c->answers * sizeof *first), far = NAN;
    if (first && answer_state(c, &c->contestant[0], 0)) {
        memcpy(first, c->out, c->answers * sizeof *first);
        (void)answer_state(c, &c->contestant[contestant], 0);
        far = distance(c, first);
    }
    free(first);
    return far;
}

/* The same request in quadruple precision, by the plainest method */
static int ask_exact(struct contest *c, const struct contestant *exact, size_t state)
{
    const tfa_request request = c->request;
    c->request.method = request.op == TFA_OP_FORWARD_DYNAMICS      ? TFA_METHOD_ABA
                        : request.op == TFA_OP_OPERATIONAL_INERTIA ? TFA_METHOD_PROPAGATION
                                                                   : TFA_METHOD_AUTO;
    c->request.refine = 0;
    c->request.estimate = TFA_ESTIMATE_NEVER;
    const int good = answer_state(c, exact, state);
    c->request = request;
    return good;
}

double contest_error(struct contest *c, uint32_t contestant)
{
    static const tfa_workspace_options quadruple = {.precision = TFA_F128};
    const struct library *l = c->contestant[0].library;
    struct contestant exact = {.library = l, .model = c->contestant[0].model};
    double *first = malloc(c->answers * sizeof *first), most = 0;
    int good = first && c->task->states == 1 && c->task->how < HOW_PARSE &&
               l->tfa_workspace_create(exact.model, &quadruple, &exact.workspace) == TFA_OK;
    for (size_t state = 0; good && state < SUITE_STATES; state++) {
        good = ask_exact(c, &exact, state);
        memcpy(first, c->out, c->answers * sizeof *first);
        good = good && answer_state(c, &c->contestant[contestant], state);
        most = fmax(most, distance(c, first));
    }
    l->tfa_workspace_free(exact.workspace);
    free(first);
    return good ? most : NAN;
}

/* ---- all of it ---- */

static void remove_failed(struct contest *c)
{
    uint32_t kept = 0;
    for (uint32_t k = 0; k < c->count; k++)
        if (call_library(c, &c->contestant[k], 0) &&
            (c->task->how < HOW_PARSE || c->contestant[k].library))
            c->contestant[kept++] = c->contestant[k];
        else
            close_contestant(&c->contestant[k]);
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
    c->nq = libraries[0].tfa_model_q_count(c->contestant[0].model);
    c->nv = libraries[0].tfa_model_v_count(c->contestant[0].model);
    open_peers(c);
    if (c->nq == c->nv && make_inputs(c) == 0)
        remove_failed(c);
    if (c->block && c->count > 0 && c->contestant[0].library == &libraries[0])
        return 0;
    contest_close(c);
    return -1;
}

void contest_close(struct contest *c)
{
    for (uint32_t k = 0; k < c->count; k++)
        close_contestant(&c->contestant[k]);
    free(c->block);
    *c = (struct contest){0};
}
