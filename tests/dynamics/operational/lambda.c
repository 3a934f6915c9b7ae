/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Lambda, rank, mu and p by their definitions: Lambda is f(lambda_inv) of the policy; where the
 * rank is full it is the inverse, otherwise with truncation the pseudoinverse; mu and p are Lambda
 * times what the oracle says; and the equation of motion in operational space holds.
 */
#include "operational.h"
#include "spectral.h"
#include "test.h"

#define TIPS 3
#define ROWS (6 * TIPS)
#define EPS 0x1p-52
#define FLAGS (TFA_WANT_LAMBDA | TFA_WANT_MU | TFA_WANT_P | TFA_WANT_SPECTRUM)

/* Errors of Lambda in units of what one rounding of lambda_inv does to it. */
enum { LAMBDA, THRESHOLD, CONDITION, IDENTITY, PENROSE, MU, P, KINDS };
enum { ROBOTS, QUAD, HEAVY, MECHANISMS, SETS };
static op_bound bounds[SETS * KINDS] = {
    {"lambda / sensitivity eps", 60, 0},
    {"threshold", 2e-14, 0},
    {"1 / condition", 2e-14, 0},
    {"lambda lambda_inv = 1 / condition eps", 60, 0},
    {"Moore-Penrose / sensitivity eps", 150, 0},
    {"mu", 3e-13, 0},
    {"p", 3e-13, 0},
    {"lambda / sensitivity eps, f128", 10, 0},
    {"threshold, f128", 2e-14, 0},
    {"1 / condition, f128", 2e-14, 0},
    {"identity, f128", 10, 0},
    {"Moore-Penrose, f128", 10, 0},
    {"mu, f128", 2e-14, 0},
    {"p, f128", 2e-14, 0},
    {"lambda / sensitivity eps, heavy", 60, 0},
    {"threshold, heavy", 2e-14, 0},
    {"1 / condition, heavy", 2e-14, 0},
    {"identity, heavy", 60, 0},
    {"Moore-Penrose, heavy", 150, 0},
    {"mu, heavy", 3e-8, 0},
    {"p, heavy", 3e-8, 0},
    {"lambda / sensitivity eps, mechanisms", 60, 0},
    {"threshold, mechanisms", 2e-14, 0},
    {"1 / condition, mechanisms", 2e-14, 0},
    {"identity, mechanisms", 60, 0},
    {"Moore-Penrose, mechanisms", 150, 0},
    {"mu, mechanisms", 3e-12, 0},
    {"p, mechanisms", 3e-12, 0},
};
static uint32_t full, deficient, immobile, in_doubt;

static double threshold_of(const tfa_request *r, uint32_t rows)
{
    if (r->rank_threshold)
        return *r->rank_threshold;
    return r->rank_loss == TFA_RANK_DAMP ? TFA_RANK_THRESHOLD_DAMP : TFA_RANK_THRESHOLD(rows);
}

static void check_rank(const op_case *c, const spectral *s, const tfa_rank *rank, op_bound *b)
{
    if (rank->rank != s->rank || rank->padding != 0)
        fail_msg("%s: rank %u of %u rows, not %u", c->name, rank->rank, s->m, s->rank);
    op_within(c, &b[THRESHOLD], op_error(&rank->threshold, &s->threshold, 1, 0));
    const double inverse = (double)(s->least / s->most);
    assert_true(rank->condition >= 1);
    op_within(c, &b[CONDITION], fabs(1 / rank->condition - fmax(0, inverse)));
}

/* out = A B, m x m */
static void multiply(const double *A, const double *B, uint32_t m, quad *out)
{
    for (uint32_t i = 0; i < m; i++)
        for (uint32_t j = 0; j < m; j++) {
            out[i * m + j] = 0;
            for (uint32_t k = 0; k < m; k++)
                out[i * m + j] += (quad)A[i * m + k] * B[k * m + j];
        }
}

/* Penrose's four equations, A L A = A up to what was truncated. */
static void check_penrose(const op_case *c, const spectral *s, const double *A, const double *L,
                          op_bound *b)
{
    const uint32_t m = s->m;
    quad AL[ROWS * ROWS], error[4] = {0};
    double half[ROWS * ROWS], largest = 0;
    multiply(A, L, m, AL);
    for (uint32_t i = 0; i < m * m; i++) {
        half[i] = (double)AL[i];
        largest = fmax(largest, fabs(L[i]));
    }
    for (uint32_t i = 0; i < m; i++)
        for (uint32_t j = 0; j < m; j++) {
            quad ala = -(quad)A[i * m + j], lal = -(quad)L[i * m + j];
            for (uint32_t k = 0; k < m; k++) {
                ala += (quad)half[i * m + k] * A[k * m + j];
                lal += (quad)L[i * m + k] * half[k * m + j];
            }
            const quad skew = AL[i * m + j] - AL[j * m + i];
            error[0] += ala * ala;
            error[1] += lal * lal;
            error[2] += skew * skew;
        }
    const double unit = fmax(1, s->sensitivity) * EPS;
    const double range =
        (double)(quad_sqrt(error[0]) / s->most) - (double)(s->threshold / s->most) * m;
    op_within(c, &b[PENROSE], range / unit);
    if (largest > 0)
        op_within(c, &b[PENROSE], (double)quad_sqrt(error[1]) / largest / unit);
    op_within(c, &b[PENROSE], (double)quad_sqrt(error[2]) / unit);
    for (uint32_t i = 0; i < m; i++)
        for (uint32_t j = 0; j < i; j++)
            assert_true(fabs(L[i * m + j] - L[j * m + i]) <= 4 * EPS * largest);
}

static void check_identity(const op_case *c, const spectral *s, const double *A, const double *L,
                           op_bound *b)
{
    const uint32_t m = s->m;
    quad AL[ROWS * ROWS], error = 0;
    multiply(A, L, m, AL);
    for (uint32_t i = 0; i < m * m; i++) {
        const quad off = AL[i] - (i % (m + 1) == 0);
        error += off * off;
    }
    op_within(c, &b[IDENTITY], (double)(quad_sqrt(error) * s->least / s->most) / EPS);
}

/* out = J M^-1 force. Returns |J| |M^-1 force|, to which rounding is relative. */
static double accelerate_tips(const op_case *c, const quad *J, quad *force, uint32_t rows,
                              quad *out)
{
    oracle_accelerate(c->o, force);
    for (uint32_t i = 0; i < rows; i++) {
        out[i] = 0;
        for (uint32_t k = 0; k < c->n; k++)
            out[i] += J[(size_t)i * c->n + k] * force[k];
    }
    return op_norm_quad(J, (size_t)rows * c->n) * op_norm_quad(force, c->n);
}

/* What Lambda is multiplied with in p and mu, and its sizes before anything cancels */
static void parts_of(op_case *c, uint32_t k, uint32_t rows, quad *for_p, quad *for_mu,
                     double sizes[2])
{
    static quad J[ROWS * OP_FREEDOMS], gravity[OP_FREEDOMS], h[OP_FREEDOMS];
    const oracle_tips tips = op_tips(c);
    const tfa_request before = c->whole_r;
    quad bias[ROWS];
    c->whole_r.v = c->whole_r.base_twist = NULL;
    c->whole_r.wrench_count = 0;
    op_set_state_locked(c, k);
    oracle_bias_force(c->o, gravity);
    c->whole_r = before;
    op_set_state_locked(c, k);
    oracle_bias_force(c->o, h);
    oracle_jacobian(c->o, &tips, J);
    oracle_bias_acceleration(c->o, &tips, bias);
    for (uint32_t i = 0; i < c->n; i++)
        h[i] -= gravity[i];
    sizes[0] = accelerate_tips(c, J, gravity, rows, for_p);
    sizes[1] = accelerate_tips(c, J, h, rows, for_mu) + op_norm_quad(bias, rows);
    for (uint32_t i = 0; i < rows; i++)
        for_mu[i] -= bias[i];
}

/* x = f(lambda_inv) y */
static void check_product(const op_case *c, const spectral *s, const quad *y, double size,
                          const double *x, op_bound *b)
{
    const uint32_t m = s->m;
    quad want[ROWS];
    for (uint32_t i = 0; i < m; i++) {
        want[i] = 0;
        for (uint32_t j = 0; j < m; j++)
            want[i] += s->L[i * m + j] * y[j];
    }
    /* rounding of lambda_inv may be the larger part */
    op_within(c, b,
              op_error(x, want, m, op_norm_quad(s->L, (size_t)m * m) * size) /
                  (1 + s->sensitivity * 1e-3));
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

static void check_state(op_case *c, const tfa_request *r, const op_answers *a, uint32_t k,
                        op_bound *b)
{
    static spectral s;
    quad for_p[ROWS], for_mu[ROWS];
    double sizes[2];
    const uint32_t m = a->rows;
    const double *A = a->lambda_inv + (size_t)k * m * m, *L = a->lambda + (size_t)k * m * m;
    if (op_norm(A, (size_t)m * m) == 0) {
        check_nothing(c, a, k);
        return;
    }
    spectral_of(&s, A, m, r->rank_loss, threshold_of(r, m));
    if (spectral_in_doubt(&s) || !(s.most > 1e-12)) {
        in_doubt++;
        return;
    }
    check_rank(c, &s, &a->rank[k], b);
    full += s.rank == m;
    deficient += s.rank < m;
    const double unit = fmax(1, s.sensitivity) * EPS;
    op_within(c, &b[LAMBDA], op_error(L, s.L, (size_t)m * m, 0) / unit);
    if (r->rank_loss == TFA_RANK_TRUNCATE)
        check_penrose(c, &s, A, L, b);
    if (s.rank == m)
        check_identity(c, &s, A, L, b);
    parts_of(c, k, m, for_p, for_mu, sizes);
    check_product(c, &s, for_p, sizes[0], a->p + (size_t)k * m, &b[P]);
    check_product(c, &s, for_mu, sizes[1], a->mu + (size_t)k * m, &b[MU]);
}

static void check(op_case *c, tfa_workspace *w, const tfa_request *r, op_bound *b)
{
    op_answers *a = op_answers_create(c, r);
    op_compute(c, w, r, a);
    check_state(c, r, a, random_below(&c->s, r->count), b);
    op_answers_free(a);
}

static void with_policy(op_case *c, tfa_rank_loss policy, tfa_rows rows)
{
    static const tfa_op ops[] = {TFA_OP_OPERATIONAL_INERTIA, TFA_OP_FORWARD_DYNAMICS,
                                 TFA_OP_TASK_TORQUES};
    static const double thresholds[] = {1e-3, 1e-7, 0.3};
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
    r.task_acceleration = wanted;
    op_choose_method(c, &r);
    const int set = c->heavy ? HEAVY : c->chain ? MECHANISMS : ROBOTS;
    check(c, random_below(&c->s, 4) ? c->f64 : c->f32, &r, bounds + set * KINDS); /* in double */
    r.count = 1;
    if (random_below(&c->s, 4) == 0)
        check(c, c->f128, &r, bounds + QUAD * KINDS);
}

static void by_definition(op_case *c)
{
    for (int k = 0; k < 4; k++)
        with_policy(c, k % 2 ? TFA_RANK_DAMP : TFA_RANK_TRUNCATE, (tfa_rows)(k / 2));
    if (op_lock(c))
        with_policy(c, (tfa_rank_loss)random_below(&c->s, 2), (tfa_rows)random_below(&c->s, 2));
}

TEST(lambda_is_its_definition)
{
    op_for_each(OP_ALL, by_definition);
    op_print(bounds, SETS * KINDS);
    print_message("  %u of full rank, %u deficient, %u immobile, %u too close to tell\n", full,
                  deficient, immobile, in_doubt);
    assert_true(full > 100 && deficient > 100 && immobile > 10 && in_doubt < full);
}

/* ---- Lambda (J qdd + bias_acceleration) + mu + p = F for tau = J^T F ---- */

static op_bound equation[] = {{"operational equation of motion / condition", 2e-13, 0},
                              {"the same, heavy", 3e-8, 0}};
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

static void check_equation(op_case *c, const tfa_request *r, const op_answers *a, uint32_t k)
{
    double F[ROWS], tau[OP_FREEDOMS], acceleration[ROWS], got[ROWS], size;
    const uint32_t m = a->rows;
    const double *J = a->jacobian + (size_t)k * m * c->n, *L = a->lambda + (size_t)k * m * m;
    if (a->rank[k].rank < m || a->rank[k].condition > 1e6)
        return;
    for (uint32_t i = 0; i < m; i++)
        F[i] = random_uniform(&c->s, -10, 10);
    push(c, a, k, F, tau);
    tfa_request q = op_state(c, k);
    q.op = TFA_OP_FORWARD_DYNAMICS;
    q.tip_count = 0;
    q.tau = tau + c->six;
    q.base_wrench = tau;
    op_answers *b = op_answers_create(c, &q);
    op_compute(c, c->f64, &q, b);
    for (uint32_t i = 0; i < m; i++) {
        acceleration[i] = a->bias_acceleration[(size_t)k * m + i];
        for (uint32_t j = 0; j < c->n; j++)
            acceleration[i] += J[(size_t)i * c->n + j] *
                               (j < c->six ? b->base_acceleration[j] : b->qdd[j - c->six]);
    }
    size = op_norm(F, m) + op_norm(L, (size_t)m * m) * op_norm(acceleration, m) +
           op_norm(a->mu + (size_t)k * m, m) + op_norm(a->p + (size_t)k * m, m);
    for (uint32_t i = 0; i < m; i++) {
        got[i] = a->mu[(size_t)k * m + i] + a->p[(size_t)k * m + i];
        for (uint32_t j = 0; j < m; j++)
            got[i] += L[i * m + j] * acceleration[j];
    }
    op_within(c, &equation[c->heavy], op_difference(got, F, m, size) / a->rank[k].condition);
    equations++;
    op_answers_free(b);
    (void)r;
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
        op_answers *a = op_answers_create(c, &r);
        op_compute(c, c->f64, &r, a);
        for (uint32_t state = 0; state < r.count; state++)
            check_equation(c, &r, a, state);
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
