/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * What a workspace keeps from one request for the next shows in no bit: random sequences of
 * requests, many of them with the q of the one before, against a new workspace for each.
 */
#include "reductions.h"
#include "support/fixture.h"
#include "test.h"

#define SEEDS 40
#define REQUESTS 150
#define STATES 3 /* of the question; a request asks for one, or for all */
#define TIPS 3
#define MOST 96 /* freedoms */

/* Everything a reply can hold, for STATES states. */
struct everything {
    double qdd[STATES * MOST], tau[STATES * MOST], M[STATES * MOST * MOST];
    double base[STATES * 6], wrench[STATES * 6];
    double lambda[STATES * 36 * TIPS * TIPS], poses[STATES * 7 * TIPS];
    tfa_spectrum spectrum[STATES];
    tfa_answer answers[STATES];
    int32_t status;
    uint32_t field, index, state;
    uint64_t model;
};

static struct {
    unsigned requests, repeated, refused;
    unsigned op[5], locked, loaded, tips;
} tally;

static void answer(tfa_workspace *w, const tfa_request *q, struct everything *e)
{
    memset(e, 0x55, sizeof *e);
    tfa_reply reply = {.qdd = e->qdd,
                       .base_acceleration = e->base,
                       .tau = e->tau,
                       .base_wrench = e->wrench,
                       .lambda_inv = e->lambda,
                       .mass_matrix = e->M,
                       .spectrum = e->spectrum,
                       .poses = e->poses,
                       .answers = e->answers};
    (void)tfa_compute(w, q, &reply);
    e->status = reply.status;
    e->field = (uint32_t)reply.field;
    e->index = reply.index;
    e->state = reply.state;
    e->model = reply.model;
}

/* What the requests of a sequence choose from, and what changes from one to the next. */
struct sequence {
    const reduction *r;
    question a;
    random_source s;
    tfa_request q;
    uint32_t locked[MOST];
    double payloads[TFA_MAX_PAYLOADS * TFA_PAYLOAD_NUMBERS], gravity[3];
    double damaged[2 * MOST * STATES]; /* q with a NaN in it */
    double own_q[2 * MOST * STATES], pose[7 * STATES];
};

static bool one_in(struct sequence *x, uint32_t n)
{
    return random_below(&x->s, n) == 0;
}

static uint32_t choose_joints(struct sequence *x, uint32_t *joints)
{
    uint32_t count = 0;
    for (uint32_t k = 0; k < tfa_model_joint_count(x->r->model); k++)
        if (one_in(x, 4))
            joints[count++] = k;
    return count;
}

/* Another posture: state k alone, or all of them. */
static void change_state(struct sequence *x)
{
    tfa_request whole;
    uint32_t k = random_below(&x->s, STATES + 1);
    tfa_request from = k < STATES ? question_state(&x->a, x->r, k, &whole) : x->a.r;
    x->q.count = from.count;
    x->q.q = from.q;
    x->q.v = from.v;
    x->q.tau = from.tau;
    x->q.qdd = from.qdd;
    x->q.base_pose = from.base_pose;
    x->q.base_twist = from.base_twist;
    x->q.base_wrench = from.base_wrench;
    x->q.base_acceleration = from.base_acceleration;
    x->q.wrenches = from.wrenches;
}

/* The posture in memory of the sequence, one coordinate moved, or the base alone: the address of q
 * tells nothing of what is in it. */
static void nudge(struct sequence *x)
{
    const uint32_t nq = x->r->nq;
    if (nq > 0 && one_in(x, 2)) {
        memmove(x->own_q, x->q.q, (size_t)x->q.count * nq * sizeof *x->own_q);
        x->q.q = x->own_q;
        uint32_t j = random_below(&x->s, tfa_model_joint_count(x->r->model));
        tfa_joint_info info = tfa_model_joint(x->r->model, j);
        if (info.q_count < 7)
            x->own_q[info.q_index] += one_in(x, 2) ? 1e-9 : 0.25;
    } else if (x->q.base_pose) {
        memmove(x->pose, x->q.base_pose, 7 * (size_t)x->q.count * sizeof *x->pose);
        x->q.base_pose = x->pose;
        x->pose[random_below(&x->s, 3)] += 0.5;
    }
}

/* The same posture, but other velocities and forces. */
static void change_motion(struct sequence *x)
{
    x->q.v = one_in(x, 3) ? NULL : x->q.count == STATES ? x->a.v : x->a.v + x->r->nv;
    x->q.tau = one_in(x, 3) ? NULL : x->q.count == STATES ? x->a.tau : x->a.tau + x->r->nv;
    x->q.wrench_count = one_in(x, 2) ? 0 : x->a.r.wrench_count;
}

static void change_gravity(struct sequence *x)
{
    for (int i = 0; i < 3; i++)
        x->gravity[i] = random_uniform(&x->s, -10, 10);
    x->q.gravity = one_in(x, 2) ? NULL : x->gravity;
}

static void change_payloads(struct sequence *x)
{
    question_load(&x->a, x->r, &x->s, random_below(&x->s, 3), x->payloads);
    x->q.payload_count = x->a.r.payload_count;
    x->q.payloads = x->payloads;
    memcpy(x->q.payload_frames, x->a.r.payload_frames, sizeof x->q.payload_frames);
}

static void change_tips(struct sequence *x)
{
    question_tips(&x->a, x->r, random_below(&x->s, (uint32_t)x->r->whole->link_count),
                  random_below(&x->s, TIPS + 1));
    x->q.tip_count = x->a.r.tip_count;
    memcpy(x->q.tips, x->a.r.tips, sizeof x->q.tips);
}

static void change_locks(struct sequence *x)
{
    x->q.locked = x->locked;
    x->q.locked_count = one_in(x, 2) ? 0 : choose_joints(x, x->locked);
}

static void change_question(struct sequence *x)
{
    static const tfa_method methods[] = {
        TFA_METHOD_AUTO,          TFA_METHOD_AUTO, TFA_METHOD_ABA,           TFA_METHOD_CRBA,
        TFA_METHOD_TFA,           TFA_METHOD_RNEA, TFA_METHOD_TFA_ONE_SIDED, TFA_METHOD_PROPAGATION,
        TFA_METHOD_TFA_CR,        TFA_METHOD_CFA,  TFA_METHOD_CFA_CR,        TFA_METHOD_SCAN,
        TFA_METHOD_SCAN_TWO_PASS, TFA_METHOD_DCA,  TFA_METHOD_HESSENBERG,    TFA_METHOD_EFPA,
        TFA_METHOD_PV_OSIMR};
    static const uint32_t refine[] = {TFA_REFINE_DEFAULT, TFA_REFINE_DEFAULT, 0, 1, 2};
    x->q.op = (tfa_op)(1 + random_below(&x->s, 4));
    x->q.method = methods[random_below(&x->s, sizeof methods / sizeof *methods)];
    x->q.refine = refine[random_below(&x->s, 5)];
    x->q.estimate = (tfa_estimate)random_below(&x->s, 3);
    x->q.frame = (tfa_reference_frame)random_below(&x->s, 3);
    x->q.flags = random_below(&x->s, 4);
}

static void change(struct sequence *x)
{
    if (one_in(x, 3))
        change_state(x);
    if (one_in(x, 6))
        nudge(x);
    if (one_in(x, 3))
        change_motion(x);
    if (one_in(x, 4))
        change_gravity(x);
    if (one_in(x, 5))
        change_payloads(x);
    if (one_in(x, 3))
        change_tips(x);
    if (one_in(x, 4))
        change_locks(x);
    if (!one_in(x, 4))
        change_question(x);
}

/* Most combinations are refused; what the sequence asks for is bent to one that is answered. */
static tfa_request plausible(struct sequence *x)
{
    tfa_request q = x->q;
    if (one_in(x, 10))
        return q;
    if (q.op == TFA_OP_INVERSE_DYNAMICS || q.op == TFA_OP_MASS_MATRIX)
        q.method = TFA_METHOD_AUTO;
    if (q.op == TFA_OP_FORWARD_DYNAMICS &&
        (q.method == TFA_METHOD_RNEA || q.method == TFA_METHOD_TFA_ONE_SIDED ||
         q.method == TFA_METHOD_PROPAGATION || q.method == TFA_METHOD_EFPA ||
         q.method == TFA_METHOD_PV_OSIMR))
        q.method = TFA_METHOD_ABA;
    if (q.op == TFA_OP_OPERATIONAL_INERTIA && q.method == TFA_METHOD_RNEA)
        q.method = TFA_METHOD_PROPAGATION;
    if (q.op == TFA_OP_MASS_MATRIX || q.method == TFA_METHOD_CRBA || q.method == TFA_METHOD_EFPA ||
        reduction_may_refuse(q.method))
        q.locked_count = 0;
    return q;
}

/* A request that is refused leaves no trace either. */
static void disturb(struct sequence *x, tfa_workspace *w, struct everything *e)
{
    tfa_request q = x->q;
    if (x->r->nq == 0)
        return;
    memcpy(x->damaged, q.q, q.count * x->r->nq * sizeof *q.q);
    x->damaged[random_below(&x->s, x->r->nq)] = NAN;
    q.q = x->damaged;
    answer(w, &q, e);
    assert_int_not_equal(e->status, TFA_OK);
}

static void count(const tfa_request *q, const tfa_request *before, int32_t status)
{
    tally.requests++;
    tally.refused += status != TFA_OK;
    if (status != TFA_OK)
        return;
    tally.repeated += q->q == before->q;
    tally.op[q->op]++;
    tally.locked += q->locked_count > 0;
    tally.loaded += q->payload_count > 0;
    tally.tips += q->tip_count > 0;
}

static void explain(const reduction *r, uint32_t step, const tfa_request *q,
                    const struct everything *a, const struct everything *b)
{
    print_message("request %u: op %d, method %s, refine %d, flags %u, count %u, tips %u, payloads "
                  "%u, locked %u; status %d and %d\n",
                  (unsigned)step, (int)q->op, tfa_method_name((uint32_t)q->method), (int)q->refine,
                  (unsigned)q->flags, (unsigned)q->count, (unsigned)q->tip_count,
                  (unsigned)q->payload_count, (unsigned)q->locked_count, a->status, b->status);
    static const struct {
        const char *name;
        size_t at, size;
    } parts[] = {
#define PART(name) {#name, offsetof(struct everything, name), sizeof a->name}
        PART(qdd),    PART(tau),   PART(M),        PART(base),    PART(wrench),
        PART(lambda), PART(poses), PART(spectrum), PART(answers), PART(status),
        PART(field),  PART(index), PART(model)};
    for (size_t k = 0; k < sizeof parts / sizeof *parts; k++)
        if (memcmp((const char *)a + parts[k].at, (const char *)b + parts[k].at, parts[k].size))
            print_message("  %s differs\n", parts[k].name);
    fail_msg("%s: a workspace remembers", r->name);
}

/* A state of a batch has the bits of the same state asked alone. */
static void check_single(const reduction *r, uint32_t step, const tfa_request *batch, uint32_t k,
                         struct everything *all, tfa_workspace *w)
{
    static struct everything alone, slice;
    const uint32_t nv = r->nv, n = r->n;
    tfa_request q = *batch;
    q.count = 1;
    q.q += (size_t)k * r->nq;
    q.v = q.v ? q.v + (size_t)k * nv : NULL;
    q.tau = q.tau ? q.tau + (size_t)k * nv : NULL;
    q.qdd += (size_t)k * nv;
    if (n > nv) {
        q.base_pose += 7 * (size_t)k;
        q.base_twist += 6 * (size_t)k;
        q.base_wrench += 6 * (size_t)k;
        q.base_acceleration += 6 * (size_t)k;
    }
    q.wrenches += 6 * (size_t)q.wrench_count * k;
    answer(w, &q, &alone);
    memset(&slice, 0x55, sizeof slice);
    const size_t rows = 6 * (size_t)q.tip_count, poses = 7 * (size_t)q.tip_count;
    memcpy(slice.qdd, all->qdd + (size_t)k * nv, nv * sizeof *slice.qdd);
    memcpy(slice.tau, all->tau + (size_t)k * nv, nv * sizeof *slice.tau);
    memcpy(slice.M, all->M + (size_t)k * n * n, (size_t)n * n * sizeof *slice.M);
    memcpy(slice.base, all->base + (size_t)k * 6, 6 * sizeof *slice.base);
    memcpy(slice.wrench, all->wrench + (size_t)k * 6, 6 * sizeof *slice.wrench);
    memcpy(slice.lambda, all->lambda + rows * rows * k, rows * rows * sizeof *slice.lambda);
    memcpy(slice.poses, all->poses + poses * k, poses * sizeof *slice.poses);
    slice.spectrum[0] = all->spectrum[k];
    slice.answers[0] = all->answers[k];
    memcpy(&slice.status, &alone.status, sizeof slice - offsetof(struct everything, status));
    if (memcmp(&alone, &slice, sizeof alone) != 0)
        explain(r, step, &q, &alone, &slice);
}

static void sequence(const reduction *r, uint64_t seed, const tfa_workspace_options *o,
                     uint32_t requests)
{
    static struct everything kept, fresh;
    static struct sequence x;
    memset(&x, 0, sizeof x);
    x.r = r;
    x.s.state = seed;
    if (!question_open(&x.a, r, seed, STATES, 2))
        return;
    tfa_workspace *w = fixture_mixed(r->model, o->precision, o->residual);
    x.q = x.a.r;
    for (uint32_t step = 0; step < requests; step++) {
        const tfa_request before = x.q;
        if (step > 0)
            change(&x);
        const tfa_request q = plausible(&x);
        if (one_in(&x, 10))
            disturb(&x, w, &kept);
        tfa_workspace *other = fixture_mixed(r->model, o->precision, o->residual);
        answer(w, &q, &kept);
        answer(other, &q, &fresh);
        for (uint32_t k = 0; q.count == STATES && fresh.status == TFA_OK && k < STATES; k++)
            check_single(r, step, &q, k, &fresh, other);
        tfa_workspace_free(other);
        count(&q, &before, fresh.status);
        if (memcmp(&kept, &fresh, sizeof kept) != 0)
            explain(r, step, &q, &kept, &fresh);
    }
    tfa_workspace_free(w);
    question_close(&x.a);
}

static void run(tfa_precision precision, tfa_residual residual, uint64_t seeds, uint32_t requests)
{
    memset(&tally, 0, sizeof tally);
    for (uint64_t seed = 4001; seed <= 4000 + seeds; seed++)
        for (int base = 0; base < 2; base++) {
            reduction r;
            reduction_open(&r, seed, REDUCE_ANYTHING, base ? TFA_BASE_FLOATING : TFA_BASE_FIXED);
            if (r.n > 0)
                sequence(&r, seed,
                         &(tfa_workspace_options){.precision = precision, .residual = residual},
                         requests);
            reduction_close(&r);
        }
    print_message("  %u requests, %u refused; of the others %u with the q before, %u forward, %u "
                  "inverse, %u lambda_inv, %u M, %u locked, %u loaded, %u with tips\n",
                  tally.requests, tally.refused, tally.repeated, tally.op[1], tally.op[2],
                  tally.op[3], tally.op[4], tally.locked, tally.loaded, tally.tips);
    const unsigned few = tally.requests / 200;
    assert_true(tally.refused < tally.requests / 2 && tally.repeated > few);
    assert_true(tally.locked > few && tally.loaded > few && tally.tips > few);
}

TEST(in_double)
{
    run(TFA_F64, TFA_RESIDUAL_SAME, SEEDS, REQUESTS);
}

TEST(in_quadruple)
{
    run(TFA_F128, TFA_RESIDUAL_SAME, SEEDS / 4, REQUESTS / 2);
}

TEST(in_float_and_double)
{
    run(TFA_F32, TFA_RESIDUAL_F64, SEEDS, REQUESTS);
}
