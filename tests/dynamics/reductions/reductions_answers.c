/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Every answer of a reduced model against the oracle. See reductions.h.
 */
#include "reductions.h"

#include "support/fixture.h"
#include "support/oracle_operational.h"
#include "test.h"

#define ROWS (6 * REDUCTION_TIPS)
#define POSE 3e-14
#define METHODS 32
#define PRECISIONS 3

/* What was compared, or which method answered which op */
typedef struct tally {
    char what[40];
    double worst;
    uint32_t count, refused, fell_back;
} tally;
static tally tallies[128];
static uint32_t answered[2][METHODS];

static tally *tally_of(const char *what)
{
    size_t k = 0;
    while (tallies[k].what[0] && strcmp(tallies[k].what, what) != 0)
        k++;
    assert_true(k + 1 < sizeof tallies / sizeof *tallies);
    snprintf(tallies[k].what, sizeof tallies[k].what, "%s", what);
    return &tallies[k];
}

void reduction_print(void)
{
    for (const tally *t = tallies; t->what[0]; t++)
        print_message("  %-32s worst %.1e of %6u, refused %u, fell back %u\n", t->what, t->worst,
                      t->count, t->refused, t->fell_back);
    memset(tallies, 0, sizeof tallies);
}

uint32_t reduction_answered(tfa_op op, uint32_t method)
{
    return answered[op == TFA_OP_FORWARD_DYNAMICS][method];
}

static void bounded(const reduction *r, const char *what, double error, double bound)
{
    tally *t = tally_of(what);
    t->count++;
    t->worst = fmax(t->worst, error);
    if (!(error <= bound))
        fail_msg("%s: %s: error %.3g, bound %g", r->name, what, error, bound);
}

void reduction_within(const reduction *r, const char *what, const double *x, const double *want,
                      size_t n, double bound)
{
    bounded(r, what, relative_error(x, want, n), bound);
}

/* Asks one method in one precision; false when it refuses. */
static bool ask(const reduction *r, const tfa_request *q, int precision, tfa_reply *reply,
                char what[40])
{
    static const char *const names[PRECISIONS] = {"", ", f128", ", f32+f64"};
    tfa_workspace *const w[PRECISIONS] = {r->f64, r->f128, r->mixed};
    const bool forward = q->op == TFA_OP_FORWARD_DYNAMICS;
    tfa_answer answer = {0};
    reply->answers = &answer;
    snprintf(what, 40, "%s %s%s", forward ? "qdd" : "lambda_inv", tfa_method_name(q->method),
             names[precision]);
    const bool is_answered = reduction_ask(r, w[precision], q, reply);
    tally *t = tally_of(what);
    t->refused += !is_answered;
    t->fell_back += is_answered && answer.flags & TFA_ANSWER_FALLBACK;
    answered[forward][q->method] += is_answered;
    return is_answered;
}

static double bound_of(const reduction_bounds *bounds, int precision, bool inverted)
{
    const double all[PRECISIONS] = {bounds->f64, bounds->f128, bounds->mixed};
    return inverted && precision != 1 ? fmax(bounds->inverted, all[precision]) : all[precision];
}

/* Of a method that answers the op: what it refuses of locked joints, it refuses by name. */
static bool is_refused(const reduction *r, const tfa_request *q, const tfa_method_info *row)
{
    tfa_reply reply = {0};
    if (!(q->locked_count && row->refuses & TFA_REFUSES_LOCKED))
        return false;
    assert_int_equal(tfa_compute(r->f64, q, &reply), TFA_E_METHOD);
    if (!(row->refuses & (TFA_REFUSES_ARMATURE | TFA_REFUSES_MIMICS)))
        assert_int_equal(reply.field, TFA_FIELD_LOCKED); /* and not of the robot */
    return true;
}

static void set_oracle(reduction *r, const tfa_request *whole, const oracle_tie *tie)
{
    oracle_tie_freedoms(r->o, tie, r->n);
    oracle_set_state(r->o, whole, 0);
}

static void check_zeros(const reduction *r, const tfa_request *q, const double *qdd)
{
    for (uint32_t k = 0; k < q->locked_count; k++) {
        const tfa_joint_info info = tfa_model_joint(r->model, q->locked[k]);
        for (uint32_t i = 0; i < info.v_count; i++)
            assert_true(qdd[info.v_index + i] == 0);
    }
}

/* The oracle's state is that of `whole`. */
static void by_every_method(const reduction *r, const tfa_request *request,
                            const tfa_request *whole, const reduction_bounds *bounds)
{
    static double L[ROWS * ROWS], want_L[ROWS * ROWS];
    double x[REDUCTION_MOST] = {0}, want[REDUCTION_MOST] = {0}, poses[7 * REDUCTION_TIPS];
    const uint32_t base = r->n - r->nv, tips = request->tip_count;
    const bool forward = request->op == TFA_OP_FORWARD_DYNAMICS;
    tfa_request q = *request;
    assert_true(r->n <= REDUCTION_MOST && tips <= REDUCTION_TIPS);
    if (forward)
        oracle_forward(r->o, q.tau, q.base_wrench, want + base, want);
    oracle_lambda_inv(r->o, whole->tips, tips, q.frame, want_L);
    q.flags = tips ? TFA_WANT_POSES : 0;
    for (uint32_t m = 0; tfa_method_describe(m); m++) {
        const tfa_method_info *row = tfa_method_describe(m);
        q.method = row->method;
        if (!(row->ops & TFA_OP_BIT(q.op)) || is_refused(r, &q, row))
            continue;
        for (int p = 0; p < PRECISIONS; p += forward ? 1 : 2) {
            char what[40];
            tfa_reply reply = {
                .qdd = x + base, .base_acceleration = x, .lambda_inv = L, .poses = poses};
            q.refine = p == 2 ? TFA_REFINE_DEFAULT : request->refine;
            if (bound_of(bounds, p, false) == 0 || !ask(r, &q, p, &reply, what))
                continue;
            if (forward) {
                reduction_within(r, what, x, want, r->n, bound_of(bounds, p, false));
                check_zeros(r, &q, x + base);
            }
            reduction_within(r, forward ? "lambda_inv besides qdd" : what, L, want_L,
                             36 * (size_t)tips * tips,
                             bound_of(bounds, p, row->refuses & TFA_REFUSES_NO_INVERSE));
            for (uint32_t t = 0; t < tips; t++)
                bounded(r, "pose", oracle_pose_error(r->o, whole->tips[t], poses + 7 * t), POSE);
        }
    }
}

void reduction_check_forward(reduction *r, const tfa_request *one, const tfa_request *whole,
                             const oracle_tie *tie, const reduction_bounds *bounds)
{
    tfa_request q = *one;
    q.op = TFA_OP_FORWARD_DYNAMICS;
    set_oracle(r, whole, tie);
    by_every_method(r, &q, whole, bounds);
}

void reduction_check_lambda(reduction *r, const tfa_request *one, const tfa_request *whole,
                            const oracle_tie *tie, const reduction_bounds *bounds, int frames)
{
    tfa_request q = *one;
    q.op = TFA_OP_OPERATIONAL_INERTIA;
    set_oracle(r, whole, tie);
    for (int frame = 0; frame < frames; frame++) {
        q.frame = (tfa_reference_frame)frame;
        by_every_method(r, &q, whole, bounds);
    }
}

/* tau in double and in f128, of the oracle's state */
static void compare_tau(const reduction *r, const char *what, const tfa_request *q,
                        const double *qdd, const reduction_bounds *bounds)
{
    double x[REDUCTION_MOST] = {0}, want[REDUCTION_MOST] = {0};
    const uint32_t base = r->n - r->nv;
    tfa_reply reply = {.tau = x + base, .base_wrench = x};
    oracle_inverse(r->o, qdd, q->base_acceleration, want + base, want);
    for (int wide = 0; wide < 2; wide++) {
        (void)reduction_ask(r, wide ? r->f128 : r->f64, q, &reply);
        reduction_within(r, what, x, want, r->n, wide ? bounds->f128 : bounds->f64);
    }
}

static void check_mass_matrix(const reduction *r, const tfa_request *one,
                              const reduction_bounds *bounds)
{
    static double M[REDUCTION_MOST * REDUCTION_MOST], want[REDUCTION_MOST * REDUCTION_MOST];
    tfa_request q = *one;
    tfa_reply reply = {.mass_matrix = M};
    q.op = TFA_OP_MASS_MATRIX;
    q.locked_count = 0;
    oracle_mass_matrix(r->o, want);
    for (int wide = 0; wide < 2; wide++) {
        (void)reduction_ask(r, wide ? r->f128 : r->f64, &q, &reply);
        reduction_within(r, "mass matrix", M, want, (size_t)r->n * r->n,
                         wide ? bounds->f128 : bounds->f64);
    }
}

void reduction_check_inverse(reduction *r, const tfa_request *one, const tfa_request *whole,
                             const reduction_bounds *bounds)
{
    double qdd[REDUCTION_MOST];
    tfa_request q = *one, w = *whole;
    memcpy(qdd, q.qdd, r->nv * sizeof *qdd);
    for (uint32_t k = 0; k < q.locked_count; k++) {
        const tfa_joint_info info = tfa_model_joint(r->model, q.locked[k]);
        memset(qdd + info.v_index, 0, info.v_count * sizeof *qdd);
    }
    q.op = TFA_OP_INVERSE_DYNAMICS;
    q.tip_count = 0;
    set_oracle(r, whole, r->tie);
    compare_tau(r, "tau", &q, qdd, bounds);
    check_mass_matrix(r, &q, bounds);
    q.v = q.qdd = q.base_twist = q.base_acceleration = NULL;
    w.v = w.base_twist = NULL;
    q.wrench_count = w.wrench_count = 0;
    for (int axis = 0; axis < 3; axis++) {
        double g[3] = {0, 0, 0};
        g[axis] = 9.81;
        q.gravity = w.gravity = g;
        set_oracle(r, &w, r->tie);
        compare_tau(r, "tau of gravity", &q, NULL, bounds);
    }
}
