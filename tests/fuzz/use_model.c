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
    tfa_request request;
    tfa_reply reply;
    size_t count, n, tips; /* states, rows of M, tips */
    double *q, *v, *tau, *qdd, *pose, *twist, *wrench, *acceleration, *wrenches, *payloads, *task;
    double *wanted; /* of constraints */
    uint32_t *locked;
    double gravity[3];
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

static void choose_state(struct exchange *x, const tfa_model *m, struct random_source *c)
{
    size_t k = x->count;
    size_t nq = tfa_model_q_count(m);
    size_t nv = tfa_model_v_count(m);
    x->q = numbers(k * nq, random_percent(c, 90) ? 4 : 1e6, c);
    for (size_t s = 0; s < k; s++)
        for (uint32_t j = 0; j < tfa_model_joint_count(m); j++) {
            const tfa_joint_info joint = tfa_model_joint(m, j);
            if (joint.q_count == 7)
                normalise(x->q + s * nq + joint.q_index + 3, c);
        }
    x->v = numbers(k * nv, 3, c);
    x->tau = numbers(k * nv, 20, c);
    x->qdd = numbers(k * nv, 20, c);
    x->pose = numbers(k * 7, 1, c);
    for (size_t s = 0; s < k; s++)
        normalise(x->pose + 7 * s + 3, c);
    x->twist = numbers(k * 6, 1, c);
    x->wrench = numbers(k * 6, 10, c);
    x->acceleration = numbers(k * 6, 10, c);
}

static void choose_lists(struct exchange *x, const tfa_model *m, struct random_source *c)
{
    tfa_request *r = &x->request;
    size_t frames = tfa_model_frame_count(m);
    size_t joints = tfa_model_joint_count(m);
    x->tips = random_below(c, MOST_LISTED);
    r->tip_count = (uint32_t)x->tips;
    r->wrench_count = (uint32_t)random_below(c, 3);
    r->payload_count = random_percent(c, 20) ? 1 + (uint32_t)random_below(c, 2) : 0;
    r->locked_count = random_percent(c, 25) ? 1 + (uint32_t)random_below(c, MOST_LISTED) : 0;
    for (int i = 0; i < MOST_LISTED; i++) {
        r->tips[i] = (uint32_t)random_below(c, frames);
        r->wrench_frames[i] = (uint32_t)random_below(c, frames + random_percent(c, 2));
        r->payload_frames[i] = (uint32_t)random_below(c, frames);
    }
    x->wrenches = numbers(x->count * r->wrench_count * 6, 10, c);
    x->payloads = numbers(r->payload_count * (size_t)TFA_PAYLOAD_NUMBERS, 0.1, c);
    for (size_t i = 0; i < r->payload_count; i++) {
        double *p = x->payloads + i * TFA_PAYLOAD_NUMBERS;
        p[0] = fabs(p[0]);
        p[4] = fabs(p[4]);
        p[9] = fabs(p[9]);
        p[7] = p[4] + p[9];
        p[5] = p[6] = p[8] = 0;
    }
    x->locked = indices(r->locked_count, joints, c);
}

/* Arrays of a reply: their numbers of a state, and the ops whose status they go with; 0: none. */
enum { OF_1, OF_V, OF_N, OF_TIPS, OF_ROWS, OF_FRAMES, OF_CONSTRAINTS, SIZES };
#define ARRAY(member, times, one, other, ops)                                                      \
    {                                                                                              \
        offsetof(tfa_reply, member), times, one, other, ops                                        \
    }
static const struct {
    size_t member, times;
    int one, other;
    uint32_t ops;
} arrays_of_reply[] = {
    ARRAY(qdd, 1, OF_V, OF_1, TFA_OPS_FD | TFA_OPS_CONSTRAINED_FD),
    ARRAY(base_acceleration, 6, OF_1, OF_1, 0),
    ARRAY(tau, 1, OF_V, OF_1, TFA_OPS_ID | TFA_OPS_TASK | TFA_OPS_CONSTRAINED_ID),
    ARRAY(base_wrench, 6, OF_1, OF_1, 0),
    ARRAY(lambda_inv, 1, OF_ROWS, OF_ROWS, TFA_OPS_OSIM | TFA_OPS_TASK),
    ARRAY(mass_matrix, 1, OF_N, OF_N, TFA_OPS_M),
    ARRAY(poses, 7, OF_TIPS, OF_1, 0),
    ARRAY(frame_poses, 7, OF_FRAMES, OF_1, 0),
    ARRAY(joint_forces, 6, OF_FRAMES, OF_1, 0),
    ARRAY(twists, 6, OF_TIPS, OF_1, 0),
    ARRAY(jacobian, 1, OF_ROWS, OF_N, 0),
    ARRAY(bias_acceleration, 1, OF_ROWS, OF_1, 0),
    ARRAY(com, 3, OF_1, OF_1, 0),
    ARRAY(com_velocity, 3, OF_1, OF_1, 0),
    ARRAY(com_jacobian, 3, OF_N, OF_1, 0),
    ARRAY(mass, 1, OF_1, OF_1, 0),
    ARRAY(momentum, 6, OF_1, OF_1, 0),
    ARRAY(energy, 2, OF_1, OF_1, 0),
    ARRAY(lambda, 1, OF_ROWS, OF_ROWS, 0),
    ARRAY(mu, 1, OF_ROWS, OF_1, 0),
    ARRAY(p, 1, OF_ROWS, OF_1, 0),
    ARRAY(gravity_force, 1, OF_N, OF_1, 0),
    ARRAY(velocity_force, 1, OF_N, OF_1, 0),
    ARRAY(damping_force, 1, OF_N, OF_1, 0),
    ARRAY(external_force, 1, OF_N, OF_1, 0),
    ARRAY(armature_force, 1, OF_N, OF_1, 0),
    ARRAY(dqdd_dq, 1, OF_N, OF_N, TFA_OPS_DERIVATIVES),
    ARRAY(dqdd_dv, 1, OF_N, OF_N, TFA_OPS_DERIVATIVES),
    ARRAY(dqdd_dtau, 1, OF_N, OF_N, TFA_OPS_DERIVATIVES),
    ARRAY(dtau_dq, 1, OF_N, OF_N, TFA_OPS_ID_DERIVATIVES),
    ARRAY(dtau_dv, 1, OF_N, OF_N, TFA_OPS_ID_DERIVATIVES),
    ARRAY(constraint_wrenches, 6, OF_CONSTRAINTS, OF_1, TFA_OPS_CONSTRAINED),
    ARRAY(constraint_position, 6, OF_CONSTRAINTS, OF_1, TFA_OPS_CONSTRAINED),
    ARRAY(constraint_velocity, 6, OF_CONSTRAINTS, OF_1, TFA_OPS_CONSTRAINED),
    ARRAY(constraint_residual, 6, OF_CONSTRAINTS, OF_1, TFA_OPS_CONSTRAINED),
    ARRAY(delassus, 36, OF_CONSTRAINTS, OF_CONSTRAINTS, 0),
    ARRAY(v, 1, OF_V, OF_1, TFA_OPS_IMPACT),
    ARRAY(base_twist, 6, OF_1, OF_1, 0),
    ARRAY(friction_force, 1, OF_N, OF_1, 0),
    ARRAY(regressor, TFA_LINK_PARAMETERS, OF_N, OF_TIPS, TFA_OPS_REGRESSOR),
    ARRAY(joint_regressor, TFA_JOINT_PARAMETERS, OF_V, OF_1, TFA_OPS_REGRESSOR),
    ARRAY(generalised_momentum, 1, OF_N, OF_1, 0),
    ARRAY(momentum_rate, 1, OF_N, OF_1, 0),
};
enum { REPLY_ARRAYS = sizeof arrays_of_reply / sizeof *arrays_of_reply };

static double **array_of_reply(struct exchange *x, int i)
{
    return (double **)(void *)((char *)&x->reply + arrays_of_reply[i].member);
}

static size_t numbers_of_reply(const struct exchange *x, const tfa_model *m, int i)
{
    const size_t rows = x->request.rows == TFA_ROWS_POINT ? 3 : 6;
    const size_t sizes[SIZES] = {1,
                                 tfa_model_v_count(m),
                                 x->n,
                                 x->tips,
                                 rows * x->tips,
                                 tfa_model_frame_count(m),
                                 (size_t)__builtin_popcount(x->request.constraints)};
    return x->count * arrays_of_reply[i].times * sizes[arrays_of_reply[i].one] *
           sizes[arrays_of_reply[i].other];
}

static void make_reply(struct exchange *x, const tfa_model *m)
{
    struct random_source none = {0};
    for (int i = 0; i < REPLY_ARRAYS; i++)
        *array_of_reply(x, i) = numbers(numbers_of_reply(x, m, i), 0, &none);
    x->reply.spectrum = calloc(x->count, sizeof *x->reply.spectrum);
    x->reply.rank = calloc(x->count, sizeof *x->reply.rank);
    x->reply.answers = calloc(x->count, sizeof *x->reply.answers);
    REQUIRE(x->reply.spectrum && x->reply.rank && x->reply.answers);
}

static void make_exchange(struct exchange *x, const tfa_model *m, struct random_source *c)
{
    memset(x, 0, sizeof *x);
    tfa_request *r = &x->request;
    x->count = 1 + random_below(c, 3);
    x->n = tfa_model_base_freedoms(m) + tfa_model_v_count(m);
    choose_state(x, m, c);
    choose_lists(x, m, c);
    r->count = (uint32_t)x->count;
    r->rows = (tfa_rows)random_below(c, 2);
    r->rank_loss = (tfa_rank_loss)random_below(c, 3);
    r->constraints = tfa_all_constraints(tfa_model_constraint_count(m));
    if (r->constraints && random_percent(c, 50))
        r->constraints &= (uint32_t)random_below(c, UINT32_MAX);
    make_reply(x, m);
    x->task = numbers(x->count * 6 * x->tips, 10, c);
    r->refine = random_percent(c, 60) ? TFA_REFINE_DEFAULT : (uint32_t)random_below(c, 3);
    r->estimate = (tfa_estimate)random_below(c, 3);
    r->frame = (tfa_reference_frame)random_below(c, 3);
    r->flags =
        (uint32_t)random_below(c, TFA_WANT_ALL + 1) & (uint32_t)random_below(c, TFA_WANT_ALL + 1);
    r->task_acceleration = x->task;
    x->wanted = numbers(x->count * 6 * (size_t)__builtin_popcount(r->constraints), 10, c);
    r->constraint_acceleration = x->wanted;
    r->q = x->q;
    r->v = x->v;
    r->tau = x->tau;
    r->qdd = x->qdd;
    r->base_pose = x->pose;
    r->base_twist = x->twist;
    r->base_wrench = x->wrench;
    r->base_acceleration = x->acceleration;
    r->wrenches = x->wrenches;
    r->payloads = x->payloads;
    r->locked = x->locked;
    if (random_percent(c, 10))
        r->gravity = memcpy(x->gravity, (double[]){1, -2, 3}, sizeof x->gravity);
}

static void free_exchange(struct exchange *x)
{
    double *const arrays[] = {x->q,        x->v,        x->tau,    x->qdd,
                              x->pose,     x->twist,    x->wrench, x->acceleration,
                              x->wrenches, x->payloads, x->task,   x->wanted};
    for (size_t i = 0; i < sizeof arrays / sizeof *arrays; i++)
        free(arrays[i]);
    for (int i = 0; i < REPLY_ARRAYS; i++)
        free(*array_of_reply(x, i));
    free(x->locked);
    free(x->reply.spectrum);
    free(x->reply.rank);
    free(x->reply.answers);
}

static void require_finite(const double *array, size_t n)
{
    for (size_t i = 0; i < n; i++)
        REQUIRE(isfinite(array[i]));
}

/* An answer that is not finite is not called an answer. */
static void check(struct exchange *x, const tfa_model *m)
{
    if (x->reply.status != TFA_OK)
        return;
    for (int i = 0; i < REPLY_ARRAYS; i++)
        if (arrays_of_reply[i].ops & TFA_OP_BIT(x->request.op))
            require_finite(*array_of_reply(x, i), numbers_of_reply(x, m, i));
}

static void compute_everything(tfa_workspace *w, struct exchange *x, const tfa_model *m)
{
    for (int op = TFA_OP_FORWARD_DYNAMICS; op <= TFA_OP_LAST; op++)
        for (int method = TFA_METHOD_AUTO; method <= TFA_METHOD_PROPAGATION; method++) {
            x->request.op = (tfa_op)op;
            x->request.method = (tfa_method)method;
            int status = tfa_compute(w, &x->request, &x->reply);
            REQUIRE(status == x->reply.status);
            check(x, m);
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
    struct exchange x;
    make_exchange(&x, m, c);
    compute_everything(w, &x, m);
    free_exchange(&x);
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
