/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Computes everything with a model, in random states, with buffers that end where they must.
 */
#include "interface/fields.h"
#include "invariants.h"
#include "use.h"

#include <math.h>
#include <stddef.h>
#include <string.h>
#include <totalforce/dynamics.h>

enum { MOST_FREEDOMS = 128, MOST_QUADRUPLE = 24, MOST_LISTED = 4 };

/* One request and the memory behind it; each array on the heap, so that its end is watched. */
struct exchange {
    const tfa_model *model;
    tfa_request request;
    tfa_reply reply;
};

static double *numbers(size_t n, double scale, struct random_source *c)
{
    double *array = malloc(n * sizeof *array + (n == 0));
    REQUIRE(array);
    for (size_t i = 0; i < n; i++)
        array[i] = scale * random_signed(c);
    static const double odd[] = {0, NAN, -INFINITY, 1e308, 1e-308, 1e15};
    if (n > 0 && random_percent(c, 3))
        array[random_below(c, n)] = odd[random_below(c, sizeof odd / sizeof *odd)];
    return array;
}

static uint32_t *indices(size_t n, size_t end, struct random_source *c)
{
    uint32_t *array = malloc(n * sizeof *array + (n == 0));
    REQUIRE(array);
    for (size_t i = 0; i < n; i++)
        array[i] = (uint32_t)(random_percent(c, 2) ? end : random_below(c, end));
    return array;
}

static void normalise(double *quaternion, struct random_source *c)
{
    double norm = 0;
    for (int i = 0; i < 4; i++)
        norm += quaternion[i] * quaternion[i];
    norm = sqrt(norm);
    for (int i = 0; i < 4 && norm > 0 && !random_percent(c, 1); i++)
        quaternion[i] /= norm;
}

static void choose_state(struct exchange *x, struct random_source *c)
{
    const tfa_model *m = x->model;
    tfa_request *r = &x->request;
    const size_t k = r->count, nq = tfa_model_q_count(m), nv = tfa_model_v_count(m);
    double *q = numbers(k * nq, random_percent(c, 90) ? 4 : 1e6, c);
    for (size_t s = 0; s < k; s++)
        for (uint32_t j = 0; j < tfa_model_joint_count(m); j++) {
            const tfa_joint_info joint = tfa_model_joint(m, j);
            if (joint.q_count == 7)
                normalise(q + s * nq + joint.q_index + 3, c);
        }
    r->q = q;
    r->v = numbers(k * nv, 3, c);
    r->tau = numbers(k * nv, 20, c);
    r->qdd = numbers(k * nv, 20, c);
    double *pose = numbers(k * 7, 1, c);
    for (size_t s = 0; s < k; s++)
        normalise(pose + 7 * s + 3, c);
    r->base_pose = pose;
    r->base_twist = numbers(k * 6, 1, c);
    r->base_wrench = numbers(k * 6, 10, c);
    r->base_acceleration = numbers(k * 6, 10, c);
}

static void choose_lists(struct exchange *x, struct random_source *c)
{
    tfa_request *r = &x->request;
    const size_t frames = tfa_model_frame_count(x->model);
    r->tip_count = (uint32_t)random_below(c, MOST_LISTED);
    r->wrench_count = (uint32_t)random_below(c, 3);
    r->payload_count = random_percent(c, 20) ? 1 + (uint32_t)random_below(c, 2) : 0;
    r->locked_count = random_percent(c, 25) ? 1 + (uint32_t)random_below(c, MOST_LISTED) : 0;
    for (int i = 0; i < MOST_LISTED; i++) {
        r->tips[i] = (uint32_t)random_below(c, frames);
        r->wrench_frames[i] = (uint32_t)random_below(c, frames + random_percent(c, 2));
        r->payload_frames[i] = (uint32_t)random_below(c, frames);
    }
    r->wrenches = numbers((size_t)r->count * r->wrench_count * 6, 10, c);
    double *payloads = numbers(r->payload_count * (size_t)TFA_PAYLOAD_NUMBERS, 0.1, c);
    for (size_t i = 0; i < r->payload_count; i++) {
        double *p = payloads + i * TFA_PAYLOAD_NUMBERS;
        p[0] = fabs(p[0]);
        p[4] = fabs(p[4]);
        p[9] = fabs(p[9]);
        p[7] = p[4] + p[9];
        p[5] = p[6] = p[8] = 0;
    }
    r->payloads = payloads;
    r->locked = indices(r->locked_count, tfa_model_joint_count(x->model), c);
}

static void choose_request(struct exchange *x, struct random_source *c)
{
    tfa_request *r = &x->request;
    r->count = 1 + (uint32_t)random_below(c, 3);
    choose_state(x, c);
    choose_lists(x, c);
    r->rows = (tfa_rows)random_below(c, 2);
    r->rank_loss = (tfa_rank_loss)random_below(c, 3);
    r->constraints = tfa_all_constraints(tfa_model_constraint_count(x->model));
    if (r->constraints && random_percent(c, 50))
        r->constraints &= (uint32_t)random_below(c, UINT32_MAX);
    r->task_acceleration = numbers((size_t)r->count * 6 * r->tip_count, 10, c);
    r->refine = random_percent(c, 60) ? TFA_REFINE_DEFAULT : (uint32_t)random_below(c, 3);
    r->estimate = (tfa_estimate)random_below(c, 3);
    r->frame = (tfa_reference_frame)random_below(c, 3);
    r->flags =
        (uint32_t)random_below(c, TFA_WANT_ALL + 1) & (uint32_t)random_below(c, TFA_WANT_ALL + 1);
    r->constraint_acceleration =
        numbers((size_t)r->count * 6 * (size_t)__builtin_popcount(r->constraints), 10, c);
    if (random_percent(c, 10))
        r->gravity = numbers(3, 5, c);
}

static void free_request(tfa_request *r)
{
#define FREE(name, member, ...) free((void *)(uintptr_t)r->member);
    TFA_INPUT_LIST(FREE)
#undef FREE
}

/* Numbers of an output of the request */
static size_t numbers_of(const struct exchange *x, const tfa_output *output)
{
    const tfa_model *m = x->model;
    const tfa_extents n =
        tfa_extents_of(tfa_model_q_count(m), tfa_model_v_count(m), tfa_model_base_freedoms(m),
                       tfa_model_frame_count(m), 0, &x->request);
    return n.count * tfa_extent(output->rows, &n) * tfa_extent(output->columns, &n);
}

static void make_reply(struct exchange *x)
{
    for (const tfa_output *o = tfa_outputs; o < tfa_outputs + TFA_WIRE_REPLY_BLOCKS; o++) {
        void *buffer = calloc(numbers_of(x, o) + (numbers_of(x, o) == 0), o->size);
        REQUIRE(buffer);
        tfa_output_set_buffer(o, &x->reply, buffer);
    }
}

static void free_reply(const tfa_reply *reply)
{
    for (const tfa_output *o = tfa_outputs; o < tfa_outputs + TFA_WIRE_REPLY_BLOCKS; o++)
        free(tfa_output_buffer(o, reply));
}

static void require_finite(const double *array, size_t n)
{
    for (size_t i = 0; i < n; i++)
        REQUIRE(isfinite(array[i]));
}

/* An answer that is not finite is not called an answer. */
static void check(const struct exchange *x)
{
    if (x->reply.status != TFA_OK)
        return;
    for (const tfa_output *o = tfa_outputs; o < tfa_outputs + TFA_WIRE_REPLY_BLOCKS; o++)
        if (o->ops & TFA_OP_BIT(x->request.op) && o->size == sizeof(double))
            require_finite(tfa_output_buffer(o, &x->reply), numbers_of(x, o));
}

static void compute_everything(tfa_workspace *w, struct exchange *x)
{
    for (int op = TFA_OP_FORWARD_DYNAMICS; op <= TFA_OP_LAST; op++) {
        x->request.op = (tfa_op)op;
        make_reply(x);
        for (int method = TFA_METHOD_AUTO; method <= TFA_METHOD_PROPAGATION; method++) {
            x->request.method = (tfa_method)method;
            int status = tfa_compute(w, &x->request, &x->reply);
            REQUIRE(status == x->reply.status);
            check(x);
        }
        free_reply(&x->reply);
    }
}

static void use_precision(const tfa_model *m, tfa_precision precision, struct random_source *c)
{
    const tfa_workspace_options options = {.precision = precision};
    tfa_workspace *w = NULL;
    int status = tfa_workspace_create(m, &options, &w);
    if (status == TFA_E_UNSUPPORTED)
        return;
    REQUIRE(status == TFA_OK);
    struct exchange x = {.model = m};
    choose_request(&x, c);
    compute_everything(w, &x);
    free_request(&x.request);
    tfa_workspace_free(w);
}

void use_model(const tfa_model *model, struct random_source *c)
{
    size_t freedoms = tfa_model_v_count(model) + tfa_model_base_freedoms(model);
    if (freedoms > MOST_FREEDOMS)
        return; /* more of the same, only slower */
    use_precision(model, TFA_F64, c);
    if (freedoms <= MOST_QUADRUPLE && random_percent(c, 10))
        use_precision(model, TFA_F128, c);
}
