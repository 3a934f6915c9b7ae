/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * An answer depends on its request only: in sequences of requests, many of them with the q of the
 * one before, with refused ones between them, it has the bits that a workspace just made gives; a
 * batch has those of its states one by one; and answers that need no solution have the same bits
 * whichever op and flags stand beside them.
 */
#include "operational.h"
#include "test.h"

#define FREEDOMS 30 /* robots larger than this take too long, but reduced ones */

static double desired[OP_STATES * OP_ROWS];
static const double weightless[3] = {0, 0, 0};
static uint32_t requests; /* of a sequence in double */

static struct {
    uint32_t compared, refused, repeated, locked, loaded;
} tally;

static bool one_in(op_case *c, uint32_t n)
{
    return random_below(&c->s, n) == 0;
}

/* What a sequence has chosen, tips and locks aside, which stand in the case. */
typedef struct sequence {
    uint32_t state;  /* OP_STATES: all */
    uint32_t absent; /* bits: velocities, wrenches, payload, torques */
    const double *gravity;
    tfa_request question; /* op, flags, rank_loss, refine */
    bool moved;           /* q and pose are own ones */
    bool any_method;      /* also one that the request may not permit */
    double q[2 * OP_FREEDOMS * OP_STATES], pose[7 * OP_STATES], field[3];
    double payload[TFA_PAYLOAD_NUMBERS];
    uint32_t payload_frame;
} sequence;

static void change_question(op_case *c, tfa_request *r)
{
    static const uint32_t refine[] = {TFA_REFINE_DEFAULT, TFA_REFINE_DEFAULT, 0, 1, 2};
    r->op = op_ops[random_below(&c->s, OP_OPS)];
    r->flags = (uint32_t)random_bits(&c->s) & op_flags(r->op);
    r->rank_loss = (tfa_rank_loss)random_below(&c->s, 2);
    r->refine = refine[random_below(&c->s, 5)];
}

static void change(op_case *c, sequence *x, bool first)
{
    if (first || one_in(c, 3)) {
        x->state = random_below(&c->s, OP_STATES + 1);
        x->moved = false;
    }
    if (first || one_in(c, 3))
        op_choose_tips(c, 1 + random_below(&c->s, OP_TIPS), (tfa_rows)random_below(&c->s, 2),
                       (tfa_reference_frame)random_below(&c->s, 3));
    if (one_in(c, 4) && (op_unlock(c), one_in(c, 2)))
        (void)op_lock(c);
    if (first || one_in(c, 3))
        x->absent = random_below(&c->s, 16) & random_below(&c->s, 16);
    if (one_in(c, 4)) {
        for (int k = 0; k < 3; k++)
            x->field[k] = random_uniform(&c->s, -10, 10);
        x->gravity = one_in(c, 3) ? weightless : one_in(c, 2) ? x->field : NULL;
    }
    if (first || one_in(c, 5)) {
        random_payload(&c->s, x->payload);
        x->payload_frame = one_in(c, 2) ? x->payload_frame : random_below(&c->s, c->link_count);
    }
    if (first || !one_in(c, 4))
        change_question(c, &x->question);
}

/* One coordinate moved, or the base, in memory of the sequence: the address of q tells nothing of
 * what is in it. */
static void nudge(op_case *c, sequence *x, const tfa_request *r)
{
    const tfa_joint_info info =
        tfa_model_joint(c->model, random_below(&c->s, tfa_model_joint_count(c->model)));
    memmove(x->q, r->q, (size_t)r->count * c->nq * sizeof *x->q);
    if (r->base_pose)
        memmove(x->pose, r->base_pose, 7 * (size_t)r->count * sizeof *x->pose);
    x->moved = true;
    if (r->base_pose && one_in(c, 2))
        x->pose[random_below(&c->s, 3)] += 0.5;
    else if (info.q_count < 7)
        x->q[info.q_index] += one_in(c, 2) ? 1e-9 : 0.25;
}

/* The next request of a sequence */
static tfa_request draw(op_case *c, sequence *x, bool first)
{
    change(c, x, first);
    tfa_request r = x->state < OP_STATES ? op_state(c, x->state) : c->r;
    if (c->nq > 0 && one_in(c, 6))
        nudge(c, x,
              x->moved ? &(tfa_request){.count = r.count,
                                        .q = x->q,
                                        .base_pose = r.base_pose ? x->pose : NULL}
                       : &r);
    r.q = x->moved ? x->q : r.q;
    r.base_pose = x->moved && r.base_pose ? x->pose : r.base_pose;
    r.op = x->question.op;
    r.flags = x->question.flags;
    r.rank_loss = x->question.rank_loss;
    r.refine = x->question.refine;
    r.task_acceleration = desired;
    r.gravity = x->gravity ? x->gravity : r.gravity;
    if (r.op == TFA_OP_MASS_MATRIX)
        r.locked_count = 0;
    if (x->absent & 1)
        r.v = r.base_twist = NULL;
    r.wrench_count = x->absent & 2 ? 0 : r.wrench_count;
    r.payload_count = x->absent & 4 ? 0 : 1;
    r.payloads = x->payload;
    r.payload_frames[0] = x->payload_frame;
    r.tau = x->absent & 8 ? NULL : r.tau;
    op_choose_method(c, &r);
    x->any_method = one_in(c, 20);
    if (x->any_method)
        r.method = tfa_method_describe(random_below(&c->s, TFA_METHOD_ABA + 4))->method;
    return r;
}

static int compute_op(tfa_workspace *w, const tfa_request *r, op_answers *a)
{
    op_answers_clear(a);
    return tfa_compute(w, r, &a->reply);
}

static void same(const op_case *c, const tfa_request *r, const char *what, const op_answers *a,
                 const op_answers *b)
{
    assert_true(a->reply.status == b->reply.status && a->reply.field == b->reply.field &&
                a->reply.index == b->reply.index && a->reply.state == b->reply.state &&
                a->reply.model == b->reply.model);
    if (memcmp(a->memory, b->memory, a->size * sizeof *a->memory) != 0 ||
        memcmp(a->rank, b->rank, a->count * sizeof *a->rank) != 0 ||
        memcmp(a->spectrum, b->spectrum, a->count * sizeof *a->spectrum) != 0 ||
        memcmp(a->answers, b->answers, a->count * sizeof *a->answers) != 0) {
        size_t k = 0;
        while (k < a->size && memcmp(a->memory + k, b->memory + k, sizeof *a->memory) == 0)
            k++;
        fail_msg("%s: %s: op %d, flags %x, %u tips, %u rows, frame %d, %u locked, %u states: number"
                 " %zu of %zu is %.17g, not %.17g",
                 c->name, what, (int)r->op, (unsigned)r->flags, (unsigned)r->tip_count,
                 (unsigned)a->rows, (int)r->frame, (unsigned)r->locked_count, (unsigned)r->count, k,
                 a->size, k < a->size ? b->memory[k] : 0, k < a->size ? a->memory[k] : 0);
    }
    tally.compared++;
}

/* State k of answers to several, where those to one stand */
static void copy_state(const op_answers *all, uint32_t k, op_answers *one)
{
    for (uint32_t o = 0; o < TFA_WIRE_REPLY_BLOCKS; o++)
        if (op_output(all, o, k))
            memcpy(op_output(one, o, 0), op_output(all, o, k),
                   op_numbers(all, o) * tfa_outputs[o].size);
}

static void one_by_one(op_case *c, tfa_workspace *w, const tfa_request *r, const op_answers *all)
{
    const tfa_request before = c->r;
    c->r = *r;
    for (uint32_t k = 0; k < r->count; k++) {
        const tfa_request one = op_state(c, k);
        op_answers *a = op_answers_create(c, &one), *b = op_answers_create(c, &one);
        (void)compute_op(w, &one, a);
        (void)compute_op(w, &one, b);
        copy_state(all, k, b);
        same(c, r, "alone and in a batch", b, a);
        op_answers_free(b);
        op_answers_free(a);
    }
    c->r = before;
}

/* A request that is refused leaves no trace. */
static void disturb(op_case *c, tfa_workspace *used, const tfa_request *r, op_answers *a)
{
    static double damaged[2 * OP_FREEDOMS * OP_STATES];
    tfa_request q = *r;
    if (c->nq == 0)
        return;
    memcpy(damaged, r->q, (size_t)r->count * c->nq * sizeof *damaged);
    damaged[random_below(&c->s, c->nq)] = NAN;
    q.q = damaged;
    assert_int_not_equal(compute_op(used, &q, a), TFA_OK);
}

/* @param is_permitted  it has an answer, unless it loads a link that cannot be loaded */
static void step(op_case *c, tfa_workspace *used, tfa_workspace *w, const tfa_request *r,
                 bool is_permitted)
{
    op_answers *a = op_answers_create(c, r), *b = op_answers_create(c, r);
    const int status = compute_op(w, r, a);
    if (status != TFA_OK && is_permitted && a->reply.field != TFA_FIELD_PAYLOADS)
        op_compute(c, w, r, a); /* fails */
    if (one_in(c, 10))
        disturb(c, used, r, b);
    (void)compute_op(used, r, b);
    same(c, r, "workspace used before", a, b);
    (void)compute_op(used, r, b);
    same(c, r, "asked twice", a, b);
    if (r->count > 1 && status == TFA_OK)
        one_by_one(c, w, r, a);
    op_answers_free(b);
    op_answers_free(a);
    tally.refused += status != TFA_OK;
    tally.locked += r->locked_count > 0;
    tally.loaded += r->payload_count > 0;
}

static void in_sequence(op_case *c, tfa_precision precision, tfa_residual residual, uint32_t steps)
{
    static sequence x;
    const double *before = NULL;
    tfa_workspace *used = fixture_mixed(c->model, precision, residual);
    x = (sequence){0};
    for (uint32_t k = 0; k < steps; k++) {
        const tfa_request r = draw(c, &x, k == 0);
        tfa_workspace *w = fixture_mixed(c->model, precision, residual);
        tally.repeated += r.q == before;
        before = r.q;
        step(c, used, w, &r, !x.any_method);
        tfa_workspace_free(w);
    }
    tfa_workspace_free(used);
}

static void reuse(op_case *c)
{
    if (c->n > FREEDOMS && !c->tie)
        return;
    for (size_t k = 0; k < sizeof desired / sizeof *desired; k++)
        desired[k] = random_uniform(&c->s, -5, 5);
    in_sequence(c, TFA_F64, TFA_RESIDUAL_SAME, requests);
    in_sequence(c, TFA_F32, TFA_RESIDUAL_F64, requests);
    if (c->n <= 8)
        in_sequence(c, TFA_F128, TFA_RESIDUAL_SAME, requests / 2);
}

TEST(answers_depend_on_their_request_only)
{
    requests = 12;
    op_for_each(OP_FIXTURE | OP_CHAINS, reuse);
    requests = 100;
    op_for_each(OP_REDUCED, reuse);
    print_message("  %u answers compared; of the requests %u refused, %u with the q before, %u "
                  "locked, %u loaded\n",
                  tally.compared, tally.refused, tally.repeated, tally.locked, tally.loaded);
    const uint32_t few = tally.compared / 200;
    assert_true(tally.refused < tally.compared / 4 && tally.repeated > few);
    assert_true(tally.locked > few && tally.loaded > few);
}

/* ---- beside others ---- */

static void beside_others(op_case *c)
{
    op_choose_tips(c, 2, (tfa_rows)random_below(&c->s, 2),
                   (tfa_reference_frame)random_below(&c->s, 3));
    tfa_request r = c->r;
    r.op = TFA_OP_KINEMATICS;
    r.flags = OP_KINEMATICS;
    r.task_acceleration = desired;
    op_answers *a = op_answers_create(c, &r), *b = op_answers_create(c, &r);
    op_compute(c, c->f64, &r, a);
    for (size_t k = 0; k < OP_OPS; k++) {
        r.op = op_ops[k];
        r.flags = op_flags(r.op);
        op_compute(c, c->f64, &r, b);
        for (uint32_t state = 0; state < r.count; state++)
            op_same(c, "beside others", a, state, b, state, op_outputs_of(OP_KINEMATICS));
    }
    r.op = TFA_OP_KINEMATICS;
    op_answers_clear(b);
    for (uint32_t flag = 1; flag <= OP_KINEMATICS; flag *= 2) {
        r.flags = flag & OP_KINEMATICS;
        assert_int_equal(tfa_compute(c->f64, &r, &b->reply), TFA_OK);
    }
    for (uint32_t state = 0; state < r.count; state++)
        op_same(c, "alone", a, state, b, state, op_outputs_of(OP_KINEMATICS));
    op_answers_free(b);
    op_answers_free(a);
}

TEST(motion_is_the_same_beside_other_answers)
{
    op_for_each(OP_ALL, beside_others);
}

/* ---- what is not asked for ---- */

static bool untouched(const double *x, size_t count)
{
    for (size_t k = 0; x && k < count; k++)
        if (!isnan(x[k]))
            return false;
    return true;
}

/* Buffers without a flag, or of another op, stay as they are; a flag without a buffer is fine. */
static void only_what_is_asked(op_case *c)
{
    op_choose_tips(c, 2, TFA_ROWS_POSE, TFA_FRAME_LOCAL);
    tfa_request r = c->r;
    r.task_acceleration = desired;
    op_answers *a = op_answers_create(c, &r);
    for (size_t k = 0; k < OP_OPS; k++) {
        r.op = op_ops[k];
        r.flags = 0;
        op_compute(c, c->f64, &r, a);
        for (uint32_t o = 0; o < TFA_WIRE_REPLY_BLOCKS; o++)
            if (tfa_outputs[o].size == sizeof(double) && !op_asked(&r, o))
                assert_true(untouched(op_output(a, o, 0), r.count * op_numbers(a, o)));
        r.flags = op_flags(r.op);
        tfa_reply reply = {0};
        assert_int_equal(tfa_compute(c->f64, &r, &reply), TFA_OK);
    }
    op_answers_free(a);
}

TEST(only_what_is_asked_for)
{
    op_for_each(OP_ALL, only_what_is_asked);
}
