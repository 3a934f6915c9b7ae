/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Scene adviser (advise.h), by public requests only.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <totalforce/advise.h>

/* Margins of the bound: 0.1 %, and the rounding 64 eps (|x|_M + |M^-1 tau|_M) for each body.
 * Largest rounding found: 9 eps |x|_M, random robot of 10 bodies. */
#define MARGIN 1.001
#define ROUNDING (64 * 0x1p-52)

/* One number for each freedom and state, base separately */
struct vectors {
    double *joints, *base;
};

struct adviser {
    const tfa_model *model;
    tfa_workspace *workspace;
    tfa_request states; /* of the whole robot */
    tfa_reply *reply;
    tfa_advice *advice;
    uint32_t joints, nq, nv, base;
    double *memory;
    double *q, *v;           /* of the states in the scene */
    double *size, *rounding; /* of each state: |x|_M; its rounding and that of the forces */
    struct vectors y, f, z;
};

static const double zero_gravity[3];

/* ---- requests ---- */

static int forward(struct adviser *a, const tfa_request *r, struct vectors *qdd)
{
    a->reply->qdd = qdd->joints;
    a->reply->base_acceleration = qdd->base;
    return tfa_compute(a->workspace, r, a->reply);
}

/* M qdd + h of the states, or M qdd without bias */
static int inverse(struct adviser *a, const struct vectors *qdd, int bias, struct vectors *tau)
{
    tfa_request r = a->states;
    a->reply->tau = tau->joints;
    a->reply->base_wrench = tau->base;
    r.op = TFA_OP_INVERSE_DYNAMICS;
    r.method = TFA_METHOD_AUTO;
    r.qdd = qdd->joints;
    r.base_acceleration = qdd->base;
    if (!bias) {
        r.v = r.base_twist = NULL;
        r.gravity = zero_gravity;
        r.wrench_count = 0;
    }
    return tfa_compute(a->workspace, &r, a->reply);
}

/* M^-1 tau, optionally with the states' wrenches */
static int solve_mass(struct adviser *a, const struct vectors *tau, int wrenches,
                      struct vectors *qdd)
{
    tfa_request r = a->states;
    r.v = r.base_twist = NULL;
    r.gravity = zero_gravity;
    r.tau = tau->joints;
    r.base_wrench = tau->base;
    if (!wrenches)
        r.wrench_count = 0;
    return forward(a, &r, qdd);
}

/* x^T y of state k */
static double dot(const struct adviser *a, const struct vectors *x, const struct vectors *y,
                  uint32_t k)
{
    double sum = 0;
    for (size_t j = (size_t)a->nv * k; j < (size_t)a->nv * (k + 1); j++)
        sum += x->joints[j] * y->joints[j];
    for (size_t j = 6 * (size_t)k; x->base && j < 6 * ((size_t)k + 1); j++)
        sum += x->base[j] * y->base[j];
    return sum;
}

/* sqrt(x^T y); rounding may make x^T y negative */
static double energy_norm(const struct adviser *a, const struct vectors *x, const struct vectors *y,
                          uint32_t k)
{
    const double square = dot(a, x, y, k);
    return isfinite(square) ? sqrt(fmax(square, 0)) : INFINITY;
}

/* ---- the bound ---- */

/* |x|_M and the rounding of each state */
static int measure_states(struct adviser *a)
{
    const struct vectors tau = {(double *)(uintptr_t)a->states.tau,
                                (double *)(uintptr_t)a->states.base_wrench};
    const double unit = ROUNDING * tfa_model_summarise(a->model).bodies;
    int status = forward(a, &a->states, &a->y);
    if (status == TFA_OK)
        status = inverse(a, &a->y, 0, &a->f);
    for (uint32_t k = 0; status == TFA_OK && k < a->states.count; k++)
        a->size[k] = energy_norm(a, &a->y, &a->f, k);
    if (status == TFA_OK)
        status = solve_mass(a, &tau, 1, &a->z);
    if (status == TFA_OK)
        status = inverse(a, &a->z, 0, &a->f);
    for (uint32_t k = 0; status == TFA_OK && k < a->states.count; k++)
        a->rounding[k] = unit * (a->size[k] + energy_norm(a, &a->z, &a->f, k));
    return status;
}

/* Puts locked joints at rest at their locked position. */
static void pose_scene(struct adviser *a, const uint32_t *locked, uint32_t count)
{
    const tfa_request *s = &a->states;
    memcpy(a->q, s->q, (size_t)s->count * a->nq * sizeof *a->q);
    if (s->v)
        memcpy(a->v, s->v, (size_t)s->count * a->nv * sizeof *a->v);
    for (uint32_t i = 0; i < count; i++) {
        const tfa_joint_info j = tfa_model_joint(a->model, locked[i]);
        for (size_t k = 0; k < s->count; k++) {
            memcpy(a->q + k * a->nq + j.q_index, a->advice->q + j.q_index,
                   j.q_count * sizeof *a->q);
            memset(a->v + k * a->nv + j.v_index, 0, j.v_count * sizeof *a->v);
        }
    }
}

/* r = M y + h - tau of the whole robot, and M^-1 r */
static int equation_residual(struct adviser *a, const uint32_t *locked, uint32_t count)
{
    tfa_request scene = a->states;
    pose_scene(a, locked, count);
    scene.q = a->q;
    scene.v = scene.v ? a->v : NULL;
    scene.locked = locked;
    scene.locked_count = count;
    int status = forward(a, &scene, &a->y);
    if (status == TFA_OK)
        status = inverse(a, &a->y, 1, &a->f);
    for (size_t j = 0; a->states.tau && j < (size_t)a->nv * a->states.count; j++)
        a->f.joints[j] -= a->states.tau[j];
    for (size_t j = 0; a->f.base && a->states.base_wrench && j < 6 * (size_t)scene.count; j++)
        a->f.base[j] -= a->states.base_wrench[j];
    return status == TFA_OK ? solve_mass(a, &a->f, 0, &a->z) : status;
}

/* Largest bound over the states with these joints locked; infinite without a finite answer. */
static int bound(struct adviser *a, const uint32_t *locked, uint32_t count, double *worst,
                 uint32_t *state)
{
    const int status = equation_residual(a, locked, count);
    *worst = status == TFA_OK ? 0 : INFINITY;
    *state = a->reply->state;
    for (uint32_t k = 0; status == TFA_OK && k < a->states.count; k++) {
        const double r = MARGIN * energy_norm(a, &a->f, &a->z, k) + a->rounding[k];
        const double size = a->size[k] - a->rounding[k];
        const double relative = r == 0 ? 0 : size > 0 ? r / size : INFINITY;
        if (relative >= *worst) {
            *worst = relative;
            *state = k;
        }
    }
    return status == TFA_E_NOT_COMPUTED ? TFA_OK : status;
}

/* ---- the choice ---- */

/* Middle of the range; joints of several coordinates as in the first state */
static void choose_positions(struct adviser *a)
{
    const double *q = a->states.q;
    for (uint32_t i = 0; i < a->joints; i++) {
        const tfa_joint_info j = tfa_model_joint(a->model, i);
        double *at = a->advice->q + j.q_index, low = q[j.q_index], high = low;
        memcpy(at, q + j.q_index, j.q_count * sizeof *at);
        for (size_t k = 1; j.q_count == 1 && k < a->states.count; k++) {
            low = fmin(low, q[k * a->nq + j.q_index]);
            high = fmax(high, q[k * a->nq + j.q_index]);
        }
        if (high > low)
            *at = low + (high - low) / 2;
    }
}

static int rank(struct adviser *a)
{
    int status = TFA_OK;
    for (uint32_t j = 0; status == TFA_OK && j < a->joints; j++) {
        uint32_t state;
        status = bound(a, &j, 1, &a->advice->single_error[j], &state);
    }
    return status;
}

/* Joint with the next larger bound after joint `last` (-1: the smallest); -1: none left */
static int64_t next_joint(const struct adviser *a, int64_t last)
{
    const double *single_error = a->advice->single_error;
    int64_t best = -1;
    for (uint32_t j = 0; j < a->joints; j++) {
        const int behind = last < 0 || single_error[j] > single_error[last] ||
                           (single_error[j] == single_error[last] && j > last);
        if (behind && (best < 0 || single_error[j] < single_error[best]))
            best = j;
    }
    return best;
}

static int choose(struct adviser *a, double tolerance)
{
    tfa_advice *advice = a->advice;
    const uint32_t most = a->base ? a->joints : a->joints - 1;
    for (int64_t j = next_joint(a, -1);
         j >= 0 && advice->single_error[j] <= tolerance && advice->count < most;
         j = next_joint(a, j)) {
        double error;
        uint32_t state;
        advice->joints[advice->count] = (uint32_t)j;
        const int status = bound(a, advice->joints, advice->count + 1, &error, &state);
        if (status != TFA_OK)
            return status;
        if (!(error <= tolerance))
            continue;
        advice->error = error;
        advice->state = state;
        advice->freedoms += tfa_model_joint(a->model, (uint32_t)j).v_count;
        advice->count++;
    }
    return TFA_OK;
}

/* ---- memory ---- */

static double *slice(double **at, size_t count)
{
    double *x = *at;
    *at += count;
    return x;
}

static struct vectors slice_vectors(const struct adviser *a, double **at)
{
    double *joints = slice(at, a->states.count * (size_t)a->nv);
    return (struct vectors){joints, a->base ? slice(at, 6 * (size_t)a->states.count) : NULL};
}

static int allocate(struct adviser *a)
{
    const size_t count = a->states.count;
    tfa_advice *advice = a->advice;
    a->memory = calloc(count * (a->nq + 4 * (size_t)a->nv + 3 * (size_t)a->base + 2) + 1,
                       sizeof *a->memory);
    advice->q = calloc(a->nq + (size_t)1, sizeof *advice->q);
    advice->single_error = calloc(a->joints + (size_t)1, sizeof *advice->single_error);
    advice->joints = calloc(a->joints + (size_t)1, sizeof *advice->joints);
    if (!a->memory || !advice->q || !advice->single_error || !advice->joints)
        return TFA_E_MEMORY;
    double *at = a->memory;
    a->q = slice(&at, count * a->nq);
    a->v = slice(&at, count * a->nv);
    a->size = slice(&at, count);
    a->rounding = slice(&at, count);
    a->y = slice_vectors(a, &at);
    a->f = slice_vectors(a, &at);
    a->z = slice_vectors(a, &at);
    return tfa_workspace_create(a->model, NULL, &a->workspace);
}

void tfa_advice_free(tfa_advice *advice)
{
    free(advice->joints);
    free(advice->q);
    free(advice->single_error);
    *advice = (tfa_advice){0};
}

/* ---- the whole ---- */

/* The states as forward dynamics by aba, or by auto with mimic joints */
static tfa_request plain_states(const tfa_model *model, const tfa_request *states)
{
    tfa_request r = *states;
    r.op = TFA_OP_FORWARD_DYNAMICS;
    r.method = tfa_model_summarise(model).mimics ? TFA_METHOD_AUTO : TFA_METHOD_ABA;
    r.estimate = TFA_ESTIMATE_NEVER;
    r.refine = 0;
    r.flags = r.tip_count = r.locked_count = 0;
    return r;
}

static int advise(struct adviser *a, double tolerance)
{
    int status = tfa_request_check(a->model, &a->states, a->reply);
    if (status == TFA_OK)
        status = allocate(a);
    if (status == TFA_OK)
        status = measure_states(a);
    if (status == TFA_OK) {
        choose_positions(a);
        status = rank(a);
    }
    if (status == TFA_OK)
        status = choose(a, tolerance);
    tfa_workspace_free(a->workspace);
    free(a->memory);
    if (status != TFA_OK)
        tfa_advice_free(a->advice);
    *a->reply = (tfa_reply){.status = status,
                            .field = a->reply->field,
                            .index = a->reply->index,
                            .state = a->reply->state};
    return status;
}

int tfa_advise(const tfa_model *model, const tfa_request *states, double tolerance,
               tfa_advice *advice, tfa_reply *reply)
{
    if (!model || !states || !advice || !reply)
        return TFA_E_ARGUMENT;
    *advice = (tfa_advice){0};
    *reply = (tfa_reply){0};
    if (!(tolerance > 0 && isfinite(tolerance)))
        return reply->status = TFA_E_ARGUMENT;
    struct adviser a = {.model = model,
                        .states = plain_states(model, states),
                        .reply = reply,
                        .advice = advice,
                        .joints = tfa_model_joint_count(model),
                        .nq = tfa_model_q_count(model),
                        .nv = tfa_model_v_count(model),
                        .base = tfa_model_base_freedoms(model)};
    return advise(&a, tolerance);
}
