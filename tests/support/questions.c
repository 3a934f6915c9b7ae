/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 */
#include "questions.h"

#include "interface/fields.h"
#include "test.h"

#define NEVER TFA_ESTIMATE_NEVER
#define ALWAYS TFA_ESTIMATE_ALWAYS
#define USUAL .refine = TFA_REFINE_DEFAULT
#define FORWARD .op = TFA_OP_FORWARD_DYNAMICS
#define INVERSE .op = TFA_OP_INVERSE_DYNAMICS
#define LAMBDA .op = TFA_OP_OPERATIONAL_INERTIA
#define TASK .op = TFA_OP_TASK_TORQUES
#define DERIVATIVES .op = TFA_OP_DERIVATIVES
#define ID_DERIVATIVES .op = TFA_OP_INVERSE_DYNAMICS_DERIVATIVES
#define CONSTRAINED .op = TFA_OP_CONSTRAINED_DYNAMICS
#define IMPACT .op = TFA_OP_IMPACT
#define CONSTRAINED_ID .op = TFA_OP_CONSTRAINED_INVERSE_DYNAMICS
#define FORCES(where) .flags = TFA_WANT_JOINT_FORCES, .frame = TFA_FRAME_##where

const question questions[] = {
    {"forward dynamics", FORWARD, USUAL},
    {"at rest", FORWARD, USUAL, .resting = true},
    {"with wrenches", FORWARD, USUAL, .wrenches = true},
    {"at rest with wrenches", FORWARD, USUAL, .wrenches = true, .resting = true},
    {"estimated", FORWARD, USUAL, .estimate = ALWAYS},
    {"refined", FORWARD, .method = TFA_METHOD_ABA, .estimate = NEVER, .refine = 1},
    {"with one tip", FORWARD, USUAL, .tips = 1},
    {"with three tips", FORWARD, USUAL, .tips = 3, .flags = TFA_WANT_POSES},
    {"with a payload", FORWARD, USUAL, .payload = true},
    {"with a locked joint", FORWARD, USUAL, .locked = true},
    {"crba", FORWARD, USUAL, .method = TFA_METHOD_CRBA},
    {"tfa", FORWARD, USUAL, .method = TFA_METHOD_TFA},
    {"tfa, bare", FORWARD, .method = TFA_METHOD_TFA, .estimate = NEVER},
    {"tfa, twice refined", FORWARD, .method = TFA_METHOD_TFA, .estimate = NEVER, .refine = 2},
    {"tfa-cr", FORWARD, USUAL, .method = TFA_METHOD_TFA_CR},
    {"hessenberg", FORWARD, USUAL, .method = TFA_METHOD_HESSENBERG},
    {"cfa", FORWARD, USUAL, .method = TFA_METHOD_CFA},
    {"cfa-cr", FORWARD, USUAL, .method = TFA_METHOD_CFA_CR},
    {"dca", FORWARD, USUAL, .method = TFA_METHOD_DCA},
    {"scan", FORWARD, USUAL, .method = TFA_METHOD_SCAN},
    {"scan-two-pass", FORWARD, USUAL, .method = TFA_METHOD_SCAN_TWO_PASS},
    {"hybrid", FORWARD, USUAL, .method = TFA_METHOD_HYBRID},
    {"inverse dynamics", INVERSE, USUAL},
    {"inverse dynamics with wrenches", INVERSE, USUAL, .wrenches = true},
    {"inverse dynamics at rest", INVERSE, USUAL, .resting = true},
    {"joint forces", FORWARD, USUAL, FORCES(LOCAL_WORLD_ALIGNED)},
    {"joint forces at rest", FORWARD, USUAL, FORCES(LOCAL), .resting = true},
    {"joint forces with wrenches", FORWARD, USUAL, FORCES(LOCAL), .wrenches = true},
    {"joint forces with a payload", FORWARD, USUAL, FORCES(WORLD), .payload = true},
    {"joint forces with a locked joint", FORWARD, USUAL, FORCES(WORLD), .locked = true},
    {"joint forces by tfa", FORWARD, USUAL, FORCES(WORLD), .method = TFA_METHOD_TFA},
    {"joint forces with one tip", FORWARD, USUAL, FORCES(LOCAL), .tips = 1},
    {"joint forces of inverse dynamics", INVERSE, USUAL, FORCES(WORLD), .wrenches = true},
    {"mass matrix", .op = TFA_OP_MASS_MATRIX, USUAL},
    {"mass matrix and poses", .op = TFA_OP_MASS_MATRIX, USUAL, .tips = 2, .flags = TFA_WANT_POSES},
    {"derivatives", DERIVATIVES, USUAL},
    {"derivatives with wrenches", DERIVATIVES, USUAL, .wrenches = true, .frame = TFA_FRAME_WORLD},
    {"derivatives with a payload", DERIVATIVES, .estimate = NEVER, .payload = true},
    {"derivatives with a locked joint", DERIVATIVES, USUAL, .locked = true},
    {"derivatives by aba", DERIVATIVES, USUAL, .method = TFA_METHOD_ABA, .wrenches = true},
    {"derivatives of inverse dynamics", ID_DERIVATIVES, USUAL},
    {"the same with wrenches", ID_DERIVATIVES, USUAL, .wrenches = true},
    {"task torques", TASK, USUAL, .tips = 1},
    {"task torques at rest with poses", TASK, USUAL, .tips = 1, .flags = TFA_WANT_POSES,
     .resting = true},
    {"task torques of two tips with wrenches", TASK, USUAL, .tips = 2, .wrenches = true},
    {"task torques, estimated", TASK, USUAL, .tips = 1, .estimate = ALWAYS},
    {"lambda of one tip", LAMBDA, USUAL, .tips = 1},
    {"lambda of three tips", LAMBDA, USUAL, .tips = 3},
    {"lambda by propagation", LAMBDA, USUAL, .tips = 3, .method = TFA_METHOD_PROPAGATION},
    {"lambda by efpa", LAMBDA, USUAL, .tips = 3, .method = TFA_METHOD_EFPA},
    {"lambda by crba", LAMBDA, USUAL, .tips = 2, .method = TFA_METHOD_CRBA},
    {"lambda by tfa", LAMBDA, USUAL, .tips = 1, .method = TFA_METHOD_TFA},
    {"lambda by tfa-one-sided", LAMBDA, .refine = 0, .tips = 1, .method = TFA_METHOD_TFA_ONE_SIDED},
    {"lambda by scan", LAMBDA, USUAL, .tips = 1, .method = TFA_METHOD_SCAN},
    {"lambda, estimated", LAMBDA, USUAL, .tips = 1, .estimate = ALWAYS},
    {"lambda, refined", LAMBDA, .refine = 1, .tips = 1},
    {"constrained", CONSTRAINED, USUAL, .flags = TFA_WANT_DELASSUS},
    {"constrained, at rest", CONSTRAINED, USUAL, .resting = true},
    {"constrained, with wrenches", CONSTRAINED, USUAL, .wrenches = true},
    {"constrained, with a payload", CONSTRAINED, USUAL, .payload = true},
    {"constrained, with a locked joint", CONSTRAINED, USUAL, .locked = true},
    {"constrained, with a tip", CONSTRAINED, USUAL, .tips = 1, .flags = TFA_WANT_POSES},
    {"constrained, estimated", CONSTRAINED, USUAL, .estimate = ALWAYS},
    {"constrained, by crba", CONSTRAINED, USUAL, .method = TFA_METHOD_CRBA},
    {"impact", IMPACT, USUAL, .flags = TFA_WANT_DELASSUS},
    {"impact by crba", IMPACT, USUAL, .method = TFA_METHOD_CRBA},
    {"impact, with a payload", IMPACT, USUAL, .payload = true},
    {"constrained inverse dynamics", CONSTRAINED_ID, USUAL},
    {"the same with wrenches", CONSTRAINED_ID, USUAL, .wrenches = true},
};
const size_t question_count = sizeof questions / sizeof *questions;

static const double payload[TFA_PAYLOAD_NUMBERS] = {1.5,   0.01, -0.02, 0.03, 0.02,
                                                    0.001, 0,    0.03,  0,    0.01};
static const uint32_t first_joint[] = {0};

bool question_fits(const test_robot *robot, const question *q)
{
    const bool constrained = (TFA_OP_BIT(q->op) & TFA_OPS_CONSTRAINED) != 0;
    if (constrained != (tfa_model_constraint_count(robot->model) != 0))
        return false;
    random_states *x = random_states_create(1, robot->description, robot->o, 1, 1);
    const tfa_request r = question_request(robot, q, x, 1);
    tfa_reply reply = {0};
    const int status = tfa_request_check(robot->model, &r, &reply);
    random_states_free(x);
    const int inverts = (tfa_method_describe(q->method)->refuses & TFA_REFUSES_NO_INVERSE) != 0;
    return status == TFA_OK && !(inverts && tfa_model_summarise(robot->model).singular_body >= 0);
}

tfa_request question_request(const test_robot *robot, const question *q, const random_states *x,
                             uint32_t count)
{
    tfa_request r = fixture_request(robot, x);
    const uint32_t frames = tfa_model_frame_count(robot->model);
    r.op = q->op;
    r.method = q->method;
    r.estimate = q->estimate;
    r.refine = q->refine;
    r.flags = q->flags;
    r.frame = q->frame;
    r.count = count;
    r.tip_count = q->tips;
    for (uint32_t t = 0; t < q->tips; t++) /* the last links: ends of branches, as a rule */
        r.tips[t] = frames > 1 + t ? frames - 1 - t : 0;
    if (q->op == TFA_OP_TASK_TORQUES)
        r.task_acceleration = x->wrenches; /* as many numbers for each tip */
    r.constraints = tfa_all_constraints(tfa_model_constraint_count(robot->model));
    if (!q->wrenches)
        r.wrench_count = 0;
    if (q->resting)
        r.v = r.base_twist = NULL;
    if (q->payload) {
        r.payload_count = 1;
        r.payload_frames[0] = frames - 1;
        r.payloads = payload;
    }
    if (q->locked) {
        r.locked_count = 1;
        r.locked = first_joint;
    }
    return r;
}

#define MOST_TIPS 3
#define DERIVATIVES_EACH 5

answers *answers_create(const test_robot *robot, uint32_t count)
{
    answers *a = calloc(1, sizeof *a);
    const size_t nv = robot->nv, n = robot->n, k = count;
    a->count = count;
    a->n = robot->n;
    a->nv = robot->nv;
    a->frames = tfa_model_frame_count(robot->model);
    a->closed = 6 * tfa_model_constraint_count(robot->model);
    a->numbers = 2 * nv + 12 + (size_t)a->closed * (4 + a->closed) +
                 (size_t)36 * MOST_TIPS * MOST_TIPS + (1 + DERIVATIVES_EACH) * n * n +
                 7 * MOST_TIPS + 6 * (size_t)a->frames + nv + 6;
    a->memory = malloc(k * a->numbers * sizeof(double));
    a->each = malloc(k * sizeof *a->each);
    double *at = a->memory;
    a->qdd = at;
    a->tau = at += k * nv;
    a->base_acceleration = at += k * nv;
    a->base_wrench = at += k * 6;
    a->lambda_inv = at += k * 6;
    a->mass_matrix = at += k * 36 * MOST_TIPS * MOST_TIPS;
    a->poses = at += k * n * n;
    a->joint_forces = at += k * 7 * MOST_TIPS;
    a->derivatives = at += 6 * k * a->frames;
    a->constraints = at += DERIVATIVES_EACH * k * n * n;
    a->v = at += (size_t)a->closed * (4 + a->closed) * k;
    a->base_twist = at + k * nv;
    return a;
}

void answers_free(answers *a)
{
    free(a->each);
    free(a->memory);
    free(a);
}

tfa_reply answers_reply(const answers *a, uint32_t k, uint32_t tips)
{
    const size_t square = (size_t)a->n * a->n, all = square * a->count;
    double *const derivatives = a->derivatives + square * k;
    const size_t of_constraints = (size_t)a->closed * a->count;
    double *const constraints = a->constraints + (size_t)a->closed * k;
    return (tfa_reply){.qdd = a->qdd + (size_t)k * a->nv,
                       .tau = a->tau + (size_t)k * a->nv,
                       .base_acceleration = a->base_acceleration + 6 * (size_t)k,
                       .base_wrench = a->base_wrench + 6 * (size_t)k,
                       .lambda_inv = a->lambda_inv + 36 * (size_t)k * tips * tips,
                       .mass_matrix = a->mass_matrix + (size_t)k * a->n * a->n,
                       .poses = a->poses + 7 * (size_t)k * tips,
                       .joint_forces = a->joint_forces + 6 * (size_t)k * a->frames,
                       .dqdd_dq = derivatives,
                       .dqdd_dv = derivatives + all,
                       .dqdd_dtau = derivatives + 2 * all,
                       .dtau_dq = derivatives + 3 * all,
                       .dtau_dv = derivatives + 4 * all,
                       .constraint_wrenches = constraints,
                       .constraint_position = constraints + of_constraints,
                       .constraint_velocity = constraints + 2 * of_constraints,
                       .constraint_residual = constraints + 3 * of_constraints,
                       .delassus =
                           a->constraints + 4 * of_constraints + (size_t)a->closed * a->closed * k,
                       .v = a->v + (size_t)k * a->nv,
                       .base_twist = a->base_twist + 6 * (size_t)k,
                       .answers = a->each + k};
}

void answers_clear(answers *a)
{
    for (size_t k = 0; k < a->count * a->numbers; k++)
        a->memory[k] = NAN;
    memset(a->each, 0, a->count * sizeof *a->each);
}

void answers_ask(answers *a, tfa_workspace *w, const tfa_request *r)
{
    answers_clear(a);
    tfa_reply reply = answers_reply(a, 0, 0);
    (void)tfa_compute(w, r, &reply);
}

void assert_same_answers(const test_robot *robot, const question *q, const char *what,
                         const answers *x, const answers *y)
{
    for (uint32_t k = 0; k < x->count; k++)
        if (x->each[k].status != y->each[k].status || x->each[k].method != y->each[k].method ||
            x->each[k].flags != y->each[k].flags ||
            memcmp(&x->each[k].error_estimate, &y->each[k].error_estimate, sizeof(double)) != 0)
            fail_msg("%s: %s: %s: state %u: status %d and %d, method %d and %d, flags %d and %d, "
                     "estimate %.17g and %.17g",
                     robot->name, q->name, what, (unsigned)k, x->each[k].status, y->each[k].status,
                     x->each[k].method, y->each[k].method, x->each[k].flags, y->each[k].flags,
                     x->each[k].error_estimate, y->each[k].error_estimate);
    for (size_t k = 0; k < x->count * x->numbers; k++)
        if (memcmp(x->memory + k, y->memory + k, sizeof(double)) != 0 &&
            !(x->memory[k] == 0 && y->memory[k] == 0)) /* zeros of either sign */
            fail_msg("%s: %s: %s: number %zu of %zu for %u states: %.17g and %.17g", robot->name,
                     q->name, what, k, x->numbers, (unsigned)x->count, x->memory[k], y->memory[k]);
}
