/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Lambda, rank, mu and p by their definitions in the metric of the tips: Lambda is f(lambda_inv) of
 * the policy, lambda_inv that of the oracle; mu and p are Lambda times what the oracle says; errors
 * are those of a rounding of B with lambda_inv = B^T B, never of lambda_inv; and the equation of
 * motion in operational space holds.
 */
#include "operational.h"
#include "spectral.h"
#include "test.h"

#define TIPS 3
#define ROWS (6 * TIPS)
#define EPS 0x1p-52
#define FLAGS (TFA_WANT_LAMBDA | TFA_WANT_MU | TFA_WANT_P | TFA_WANT_SPECTRUM | TFA_WANT_POSES)

/* Errors in the metric of the tips, in units of what one rounding of B does. */
enum { LAMBDA, THRESHOLD, CONDITION, MU, P, KINDS };
enum { ROBOTS, QUAD, HEAVY, MECHANISMS }; /* sets */
static op_bound bounds[KINDS] = {
    {"lambda / sensitivity eps", {30, 2, 500000, 60}, {0}},
    {"threshold", {1e-13, 1e-15, 1e-8, 1e-13}, {0}},
    {"condition / root eps", {15, 1, 500000, 60}, {0}},
    {"mu / sensitivity eps", {10, 1, 100000, 60}, {0}},
    {"p / sensitivity eps", {10, 1, 100000, 60}, {0}},
};
static uint32_t full, deficient, immobile, in_doubt, estimated;

static void check_rank(const op_case *c, const spectral *s, const tfa_request *r,
                       const tfa_rank *rank)
{
    if (rank->rank != s->rank || rank->lost != s->m - s->rank)
        fail_msg("%s: rank %u of %u rows, %u lost, not %u", c->name, rank->rank, s->m, rank->lost,
                 s->rank);
    assert_true(rank->length == (r->characteristic_length
                                     ? *r->characteristic_length
                                     : tfa_model_characteristic_length(c->model)));
    op_within(c, &bounds[THRESHOLD], op_error(&rank->threshold, &s->threshold, 1, 0));
    const double condition = (double)s->condition;
    op_within(c, &bounds[CONDITION],
              fabs(rank->condition - condition) / condition / sqrt(condition) / EPS);
}

static quad dot(const quad *x, const quad *y, uint32_t n)
{
    quad sum = 0;
    for (uint32_t i = 0; i < n; i++)
        sum += x[i] * y[i];
    return sum;
}

/* out = J M^-1 force. Returns |M^-1/2 force|, to which rounding is relative. */
static double accelerate_tips(const op_case *c, const quad *J, const quad *force, uint32_t rows,
                              quad *out)
{
    static quad x[OP_FREEDOMS];
    memcpy(x, force, c->n * sizeof *x);
    oracle_accelerate(c->o, x);
    for (uint32_t i = 0; i < rows; i++)
        out[i] = dot(J + (size_t)i * c->n, x, c->n);
    return sqrt(fabs((double)dot(force, x, c->n)));
}

/* Forces of gravity, and all others, at zero acceleration; the state of the oracle is k's. */
static void forces_of(op_case *c, uint32_t k, quad *gravity, quad *others)
{
    const tfa_request before = c->whole_r;
    c->whole_r.v = c->whole_r.base_twist = NULL;
    c->whole_r.wrench_count = 0;
    op_set_state_locked(c, k);
    oracle_bias_force(c->o, gravity);
    c->whole_r = before;
    op_set_state_locked(c, k);
    oracle_bias_force(c->o, others);
    for (uint32_t i = 0; i < c->n; i++)
        others[i] -= gravity[i];
}

/* x = f(lambda_inv) y: rounding relative to |Lambda|^1/2 |M^-1/2 force| + |Lambda| |bias| */
static void check_product(const op_case *c, const spectral *s, const spectral_metric *metric,
                          const quad *y, double size, const double *x, op_bound *b)
{
    double of_product;
    const double error = spectral_product_error(s, metric, y, x, &of_product);
    op_within(c, b, error / fmax(size, of_product) / s->sensitivity / EPS);
}

/* Tips that cannot move at all, fixed to the world: rank 0, no force */
static void check_nothing(const op_case *c, const op_answers *a, uint32_t k)
{
    const uint32_t m = a->rows;
    immobile++;
    if (a->rank[k].rank != 0 || a->rank[k].threshold != 0 || !isinf(a->rank[k].condition))
        fail_msg("%s: rank %u, threshold %g, condition %g of zero", c->name, a->rank[k].rank,
                 a->rank[k].threshold, a->rank[k].condition);
    for (uint32_t i = 0; i < m; i++)
        assert_true(a->mu[(size_t)k * m + i] == 0 && a->p[(size_t)k * m + i] == 0);
    for (uint32_t i = 0; i < m * m; i++)
        assert_true(a->lambda[(size_t)k * m * m + i] == 0);
}

/* The estimate is never below a thirtieth of the error, where that of M is in it. */
static void check_estimate(const op_case *c, const op_answers *a, uint32_t k, double error)
{
    if (!(a->answers[k].flags & TFA_ANSWER_ESTIMATED) && (c->heavy || c->chain))
        return;
    estimated++;
    if (a->rank[k].error_estimate < error / 30 && error > 32 * EPS) /* the answer is in double */
        fail_msg("%s: lambda errs by %g, estimate %g", c->name, error, a->rank[k].error_estimate);
}

static void check_products(op_case *c, const spectral *s, const spectral_metric *metric,
                           const op_answers *a, uint32_t k, const quad *J)
{
    static quad gravity[OP_FREEDOMS], others[OP_FREEDOMS];
    const uint32_t m = a->rows;
    const oracle_tips tips = op_tips(c);
    const double unit = op_norm_quad(s->L, (size_t)m * m);
    quad y[ROWS], bias[ROWS], in_metric[ROWS];
    forces_of(c, k, gravity, others);
    const double for_p = accelerate_tips(c, J, gravity, m, y);
    check_product(c, s, metric, y, sqrt(unit) * for_p, a->p + (size_t)k * m, &bounds[P]);
    const double for_mu = accelerate_tips(c, J, others, m, y);
    oracle_bias_acceleration(c->o, &tips, bias);
    spectral_acceleration(metric, bias, in_metric);
    for (uint32_t i = 0; i < m; i++)
        y[i] -= in_metric[i];
    check_product(c, s, metric, y, sqrt(unit) * for_mu + unit * op_norm_quad(in_metric, m),
                  a->mu + (size_t)k * m, &bounds[MU]);
}

static void check_state(op_case *c, const tfa_request *r, const op_answers *a, uint32_t k)
{
    static spectral s;
    static quad J[ROWS * OP_FREEDOMS], A[ROWS * ROWS];
    const uint32_t m = a->rows;
    const double *lambda = a->lambda + (size_t)k * m * m;
    const spectral_metric metric = spectral_metric_of(c, a, k);
    op_set_state_locked(c, k);
    spectral_jacobian(c, &metric, J);
    oracle_inverse_of_rows(c->o, J, m, A);
    if (op_norm_quad(A, (size_t)m * m) < 1e-20) { /* zero but for rounding of the oracle */
        check_nothing(c, a, k);
        return;
    }
    spectral_of(&s, A, m, spectral_policy(r), spectral_threshold(r, m));
    if (spectral_in_doubt(&s)) {
        in_doubt++;
        return;
    }
    check_rank(c, &s, r, &a->rank[k]);
    full += s.rank == m;
    deficient += s.rank < m;
    const double relative = spectral_error(&s, &metric, lambda);
    op_within(c, &bounds[LAMBDA], relative / s.sensitivity / EPS);
    check_estimate(c, a, k, relative);
    for (uint32_t i = 0; i < m; i++)
        for (uint32_t j = 0; j < i; j++)
            assert_true(lambda[i * m + j] == lambda[j * m + i]);
    check_products(c, &s, &metric, a, k, J);
}

static void check(op_case *c, tfa_workspace *w, const tfa_request *r)
{
    c->set = w == c->f128 ? QUAD : c->heavy ? HEAVY : c->chain ? MECHANISMS : ROBOTS;
    op_answers *a = op_answer(c, w, r);
    check_state(c, r, a, random_below(&c->s, r->count));
    op_answers_free(a);
}

static void with_policy(op_case *c, tfa_rank_loss policy, tfa_rows rows)
{
    static const tfa_op ops[] = {TFA_OP_OPERATIONAL_INERTIA, TFA_OP_FORWARD_DYNAMICS,
                                 TFA_OP_TASK_TORQUES};
    static const double thresholds[] = {1e-3, 1e-7, 0.1};
    static const double length = 0.7;
    double wanted[OP_STATES * ROWS] = {0};
    op_choose_tips(c, 1 + random_below(&c->s, TIPS), rows,
                   (tfa_reference_frame)random_below(&c->s, 3));
    if (random_below(&c->s, 4) == 0) { /* two on one link */
        c->r.tip_count = c->whole_r.tip_count = 2;
        c->r.tips[1] = c->r.tips[0];
        c->whole_r.tips[1] = c->whole_r.tips[0];
    }
    tfa_request r = c->r;
    r.op = ops[random_below(&c->s, 3)];
    r.flags = FLAGS;
    r.rank_loss = policy;
    r.rank_threshold = random_below(&c->s, 2) ? &thresholds[random_below(&c->s, 3)] : NULL;
    r.characteristic_length = random_below(&c->s, 4) ? NULL : &length;
    r.task_acceleration = wanted;
    op_choose_method(c, &r);
    check(c, random_below(&c->s, 4) ? c->f64 : c->f32, &r); /* in double */
    r.count = 1;
    if (random_below(&c->s, 4) == 0)
        check(c, c->f128, &r);
}

static void by_definition(op_case *c)
{
    for (int k = 0; k < 4; k++)
        with_policy(c, (tfa_rank_loss)(k % 3), (tfa_rows)(k / 2));
    if (op_lock(c))
        with_policy(c, (tfa_rank_loss)random_below(&c->s, 3), (tfa_rows)random_below(&c->s, 2));
}

TEST(lambda_is_its_definition)
{
    op_for_each(OP_ALL, by_definition);
    op_print(bounds, KINDS);
    print_message(
        "  %u of full rank, %u deficient, %u immobile, %u too close to tell, %u estimates\n", full,
        deficient, immobile, in_doubt, estimated);
    assert_true(full > 100 && deficient > 100 && immobile > 10 && in_doubt < full &&
                estimated > 50);
}

/* ---- Lambda (J qdd + bias_acceleration) + mu + p = F for tau = J^T F ---- */

static op_bound equation[] = {{"operational equation of motion / condition", {3e-14}, {0}},
                              {"the same, heavy", {1e-9}, {0}}};
static uint32_t equations;

static void push(op_case *c, const op_answers *a, uint32_t k, const double *F, double *tau)
{
    const double *J = a->jacobian + (size_t)k * a->rows * c->n;
    for (uint32_t i = 0; i < c->n; i++) {
        tau[i] = 0;
        for (uint32_t row = 0; row < a->rows; row++)
            tau[i] += J[(size_t)row * c->n + i] * F[row];
    }
}

static void check_equation(op_case *c, const op_answers *a, uint32_t k)
{
    double F[ROWS], tau[OP_FREEDOMS], qdd[OP_FREEDOMS], acceleration[ROWS], got[ROWS], size;
    const uint32_t m = a->rows;
    const double *L = a->lambda + (size_t)k * m * m;
    if (a->rank[k].rank < m || a->rank[k].condition > 1e6)
        return;
    for (uint32_t i = 0; i < m; i++)
        F[i] = random_uniform(&c->s, -10, 10);
    push(c, a, k, F, tau);
    op_move(c, c->f64, k, tau, qdd);
    (void)op_tip_acceleration(a, k, qdd, acceleration);
    size = norm2(F, m) + norm2(L, (size_t)m * m) * norm2(acceleration, m) +
           norm2(a->mu + (size_t)k * m, m) + norm2(a->p + (size_t)k * m, m);
    for (uint32_t i = 0; i < m; i++) {
        got[i] = a->mu[(size_t)k * m + i] + a->p[(size_t)k * m + i];
        for (uint32_t j = 0; j < m; j++)
            got[i] += L[i * m + j] * acceleration[j];
    }
    op_within(c, &equation[c->heavy], op_difference(got, F, m, size) / a->rank[k].condition);
    equations++;
}

static void equation_of_motion(op_case *c)
{
    for (int k = 0; k < 6; k++) {
        if (k == 4 && !op_lock(c))
            return;
        op_choose_tips(c, 1, k % 2 ? TFA_ROWS_POINT : TFA_ROWS_POSE, (tfa_reference_frame)(k % 3));
        tfa_request r = c->r;
        r.op = k % 3 ? TFA_OP_OPERATIONAL_INERTIA : TFA_OP_FORWARD_DYNAMICS;
        r.flags = FLAGS | TFA_WANT_JACOBIAN | TFA_WANT_BIAS_ACCELERATION;
        op_choose_method(c, &r);
        op_answers *a = op_answer(c, c->f64, &r);
        for (uint32_t state = 0; state < r.count; state++)
            check_equation(c, a, state);
        op_answers_free(a);
    }
}

TEST(operational_equation_of_motion)
{
    op_for_each(OP_ALL, equation_of_motion);
    op_print(equation, 2);
    print_message("  %u equations\n", equations);
    assert_true(equations > 300);
}
