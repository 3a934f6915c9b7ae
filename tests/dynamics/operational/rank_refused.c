/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * TFA_RANK_REFUSE: the states whose rank is lost say so, and nothing else changes: every answer of
 * the others, and what does not depend on Lambda of these, has the bits of TFA_RANK_TRUNCATE. And
 * damping is continuous in the threshold.
 */
#include "operational.h"
#include "test.h"

#define ROWS 6
#define FLAGS                                                                                      \
    (TFA_WANT_LAMBDA | TFA_WANT_MU | TFA_WANT_P | TFA_WANT_JACOBIAN | TFA_WANT_BIAS_ACCELERATION | \
     TFA_WANT_COM | TFA_WANT_POSES | TFA_WANT_SPECTRUM)

/* What is made of Lambda; nothing else depends on the rank. The status of a state is its own. */
#define OF_LAMBDA                                                                                  \
    (OP_OUTPUT(LAMBDA) | OP_OUTPUT(MU) | OP_OUTPUT(P) | OP_OUTPUT(OUT_TAU) |                       \
     OP_OUTPUT(OUT_BASE_WRENCH))
#define OTHERS ~(OF_LAMBDA | OP_OUTPUT(ANSWERS))

static uint32_t refused, accepted, mixed;

static void check_state(const op_case *c, const op_answers *a, const op_answers *b, uint32_t k,
                        int *first)
{
    const bool lost = a->rank[k].rank < a->rows;
    const int status = b->answers[k].status;
    if (status != (lost ? TFA_E_RANK : TFA_OK))
        fail_msg("%s: state %u of rank %u: %s", c->name, (unsigned)k, a->rank[k].rank,
                 tfa_status_text(status));
    op_same(c, "refused or not", a, k, b, k, OTHERS);
    if (lost) {
        *first = *first < 0 ? (int)k : *first;
        refused++;
        return;
    }
    op_same(c, "not refused", a, k, b, k, OF_LAMBDA);
    accepted++;
}

static void refuse(op_case *c, tfa_workspace *w, tfa_request *r)
{
    op_answers *a = op_answers_create(c, r), *b = op_answers_create(c, r);
    int first = -1;
    r->rank_loss = TFA_RANK_TRUNCATE;
    op_compute(c, w, r, a);
    r->rank_loss = TFA_RANK_REFUSE;
    const int status = tfa_compute(w, r, &b->reply);
    for (uint32_t k = 0; k < r->count; k++)
        check_state(c, a, b, k, &first);
    assert_int_equal(status, first < 0 ? TFA_OK : TFA_E_RANK);
    assert_int_equal(b->reply.status, status);
    if (first >= 0) {
        assert_int_equal(b->reply.state, first);
        assert_int_equal(b->reply.index, a->rank[first].rank);
        assert_int_equal(b->reply.field, TFA_FIELD_TIPS);
    }
    r->rank_loss = TFA_RANK_TRUNCATE; /* the next request sees nothing of it */
    op_compute(c, w, r, b);
    assert_memory_equal(a->memory, b->memory, a->size * sizeof *a->memory);
    op_answers_free(b);
    op_answers_free(a);
}

/* Between the conditions of two states: one of them keeps its rank, the other loses it. */
static double between(const op_case *c, const tfa_request *r)
{
    double least = INFINITY, most = 0;
    op_answers *a = op_answer(c, c->f64, r);
    for (uint32_t k = 0; k < r->count; k++) {
        least = fmin(least, a->rank[k].condition);
        most = fmax(most, a->rank[k].condition);
    }
    op_answers_free(a);
    if (!(least < 1e9) || most < 1.01 * least)
        return 0;
    mixed++;
    return 1 / sqrt(least * fmin(most, 1e10));
}

static void refusals(op_case *c)
{
    static const tfa_op ops[] = {TFA_OP_OPERATIONAL_INERTIA, TFA_OP_FORWARD_DYNAMICS,
                                 TFA_OP_TASK_TORQUES};
    double desired[OP_STATES * 2 * ROWS] = {0};
    tfa_workspace *mixed_precision = fixture_mixed(c->model, TFA_F32, TFA_RESIDUAL_F64);
    for (int pass = 0; pass < 6; pass++) {
        op_choose_tips(c, pass == 5 ? 2 : 1, pass % 2 ? TFA_ROWS_POINT : TFA_ROWS_POSE,
                       (tfa_reference_frame)(pass % 3));
        tfa_request r = c->r;
        r.op = ops[random_below(&c->s, 3)];
        r.flags = FLAGS;
        r.task_acceleration = desired;
        op_choose_method(c, &r);
        refuse(c, pass == 4 ? c->f128 : c->f64, &r);
        const double threshold = between(c, &r);
        r.rank_threshold = &threshold;
        if (threshold > 0) {
            refuse(c, c->f64, &r);
            refuse(c, mixed_precision, &r);
        }
    }
    tfa_workspace_free(mixed_precision);
}

TEST(lost_rank_is_refused)
{
    op_for_each(OP_ALL, refusals);
    print_message("  %u states refused, %u not, %u requests with both\n", refused, accepted, mixed);
    assert_true(refused > 500 && accepted > 500 && mixed > 100);
}

/* ---- damping ---- */

static op_bound jump = {"jump of damped lambda", {3e-7}, {0}};
static uint32_t crossings;

/* The threshold crosses the least eigenvalue from below. */
static void across(op_case *c)
{
    const double off = 1e-8;
    op_choose_tips(c, 1, TFA_ROWS_POSE, TFA_FRAME_LOCAL);
    tfa_request r = c->r;
    r.op = TFA_OP_OPERATIONAL_INERTIA;
    r.flags = TFA_WANT_LAMBDA;
    r.rank_loss = TFA_RANK_DAMP;
    r.count = 1;
    op_answers *a = op_answers_create(c, &r), *b = op_answers_create(c, &r);
    op_compute(c, c->f64, &r, a);
    double threshold = 1e-6, above = 0.5;
    r.rank_threshold = &threshold;
    op_compute(c, c->f64, &r, a);
    if (a->rank[0].rank == ROWS) {
        for (int k = 0; k < 40 && above > threshold * (1 + off); k++) {
            const double below = threshold;
            threshold = sqrt(below * above);
            op_compute(c, c->f64, &r, b);
            if (b->rank[0].rank < ROWS) {
                above = threshold;
                threshold = below;
            }
        }
        op_compute(c, c->f64, &r, a);
        assert_int_equal(a->rank[0].rank, ROWS);
        threshold = above;
        op_compute(c, c->f64, &r, b);
        assert_true(b->rank[0].rank < ROWS);
        op_within(c, &jump, op_difference(b->lambda, a->lambda, ROWS * ROWS, 0));
        crossings++;
    }
    op_answers_free(b);
    op_answers_free(a);
}

TEST(damping_is_continuous)
{
    op_for_each(OP_ALL, across);
    op_print(&jump, 1);
    assert_true(crossings > 20);
}
