/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Task torques: forward dynamics with them gives the accelerations that were asked for; posture
 * torques act in the null space only; without any the torques are J^T F, those that disturb the
 * unforced motion least (Gauss). Where rank is lost they are what the policy's Lambda makes of the
 * definition, and the tips miss the acceleration that the reply gives up.
 */
#include "operational.h"
#include "spectral.h"
#include "test.h"

#define TIPS 2
#define ROWS (6 * TIPS)
#define WELL_CONDITIONED 1e7

enum { DESIRED, POSTURES, ROW_SPACE, DEFINITION, GAUSS, GIVEN_UP, KINDS };
enum { DOUBLE, QUAD, HEAVY }; /* sets */

/* The first two are relative to the terms that add up, |J| |qdd| + |bias_acceleration|, wherever
 * the rank is full. */
static op_bound bounds[KINDS] = {
    {"J qdd + bias_acceleration = desired", {5e-12, 1e-11, 1e-8}, {0}},
    {"two postures, one acceleration", {5e-12, 1e-11, 1e-8}, {0}},
    {"tau = J^T (lambda a + mu + p)", {1e-13, 4e-15, 1e-7}, {0}},
    {"tau by definition", {1e-14, 4e-15, 3e-10}, {0}},
    {"least disturbance", {1e-13, 1e-13, 1e-10}, {0}},
    {"missing = given up", {3e-11, 2e-12, 5e-8}, {0}},
};
/* The first two again, on robots with a condition below WELL_CONDITIONED */
static op_bound robot_bounds[2] = {
    {"J qdd + bias_acceleration, robots", {2e-12, 4e-15}, {0}},
    {"two postures, robots", {2e-12, 4e-15}, {0}},
};
static uint32_t reached, by_definition, damped, immobile;

struct task {
    op_case *c;
    tfa_workspace *w, *forward; /* of the task, of forward dynamics */
    tfa_request r;
    double desired[OP_STATES * ROWS];
    double posture[2][OP_STATES * OP_FREEDOMS];
    double wide;   /* threshold by which many directions are lost */
    op_answers *a; /* of the task; with J, bias_acceleration, lambda, mu, p */
};

static bool is_full(const struct task *t, uint32_t k)
{
    return t->a->rank[k].rank == t->a->rows;
}

static bool is_well_conditioned(const struct task *t, uint32_t k)
{
    return is_full(t, k) && t->a->rank[k].condition < WELL_CONDITIONED;
}

/* An error of kind DESIRED or POSTURES in state k, whose rank is full */
static void within(const struct task *t, uint32_t k, int kind, double error)
{
    op_within(t->c, &bounds[kind], error);
    if (!t->c->chain && is_well_conditioned(t, k))
        op_within(t->c, &robot_bounds[kind], error);
}

/* ---- the definition ---- */

/* x = desired - J M^-1 (tau - h) - bias_acceleration in the metric; h as the state stands.
 * Returns the size of the terms. */
static double task_error(const struct task *t, uint32_t k, const double *tau,
                         const spectral_metric *metric, const quad *J, quad *x)
{
    static quad force[OP_FREEDOMS];
    op_case *c = t->c;
    const oracle_tips tips = op_tips(c);
    const uint32_t m = t->a->rows;
    quad wanted[ROWS];
    oracle_bias_force(c->o, force);
    for (uint32_t i = 0; i < c->n; i++)
        force[i] = tau[i] - force[i];
    oracle_accelerate(c->o, force);
    oracle_bias_acceleration(c->o, &tips, wanted);
    for (uint32_t i = 0; i < m; i++)
        wanted[i] = t->desired[(size_t)k * m + i] - wanted[i];
    spectral_acceleration(metric, wanted, x);
    const double size =
        op_norm_quad(x, m) + op_norm_quad(J, (size_t)m * c->n) * op_norm_quad(force, c->n);
    for (uint32_t i = 0; i < m; i++)
        for (uint32_t j = 0; j < c->n; j++)
            x[i] -= J[(size_t)i * c->n + j] * force[j];
    return size;
}

/* Moved by tau the tips miss the sum of given_up times direction of answers a. */
static void check_given_up(const struct task *t, const op_answers *a, uint32_t k, const double *tau,
                           const spectral_metric *metric, const quad *J)
{
    const uint32_t m = a->rows;
    const double *lost = a->lost + (size_t)k * TFA_LOST_MAX * (2 + m);
    quad missing[ROWS], sum[ROWS] = {0}, want[ROWS];
    double got[ROWS];
    if (a->rank[k].lost > TFA_LOST_MAX) /* the reply may lack some */
        return;
    const double size = task_error(t, k, tau, metric, J, missing);
    for (uint32_t l = 0; l < TFA_LOST_MAX; l++, lost += 2 + m) {
        damped += lost[0] > 0 && lost[1] != 0;
        for (uint32_t i = 0; i < m; i++)
            sum[i] += (quad)lost[1] * lost[2 + i];
    }
    spectral_acceleration(metric, sum, want);
    for (uint32_t i = 0; i < m; i++)
        got[i] = (double)missing[i];
    op_within(t->c, &bounds[GIVEN_UP], op_error(got, want, m, size));
}

/* tau = posture + J^T f(lambda_inv) x, but for locked joints, which anything may hold. Both tau
 * with the base first. */
static void check_definition(const struct task *t, const op_answers *a, uint32_t k,
                             const double *posture, const double *tau)
{
    static spectral s;
    static quad J[ROWS * OP_FREEDOMS], A[ROWS * ROWS], want[OP_FREEDOMS];
    quad x[ROWS], F[ROWS];
    double got[OP_FREEDOMS];
    op_case *c = t->c;
    const uint32_t m = t->a->rows;
    const spectral_metric metric = spectral_metric_of(c, t->a, k);
    op_set_state_locked(c, k);
    spectral_jacobian(c, &metric, J); /* of the joints that are not locked */
    oracle_inverse_of_rows(c->o, J, m, A);
    spectral_of(&s, A, m, spectral_policy(&t->r), spectral_threshold(&t->r, m));
    if (spectral_in_doubt(&s) || !(s.most > 1e-12))
        return;
    const double size = task_error(t, k, posture, &metric, J, x);
    for (uint32_t i = 0; i < m; i++) {
        F[i] = 0;
        for (uint32_t j = 0; j < m; j++)
            F[i] += s.L[i * m + j] * x[j];
    }
    for (uint32_t i = 0; i < c->n; i++) {
        got[i] = tau[i];
        want[i] = posture[i];
        for (uint32_t j = 0; j < m; j++)
            want[i] += J[(size_t)j * c->n + i] * F[j];
    }
    for (uint32_t l = 0; l < c->r.locked_count; l++) {
        const tfa_joint_info j = tfa_model_joint(c->model, c->r.locked[l]);
        for (uint32_t i = 0; i < j.v_count; i++)
            got[c->six + j.v_index + i] = 0, want[c->six + j.v_index + i] = 0;
    }
    const double scale =
        op_norm_quad(J, (size_t)m * c->n) * op_norm_quad(s.L, (size_t)m * m) * size +
        norm2(posture, c->n);
    op_within(c, &bounds[DEFINITION], op_error(got, want, c->n, scale));
    check_given_up(t, a, k, tau, &metric, J);
    by_definition++;
}

/* ---- laws ---- */

static void check_desired(const struct task *t, uint32_t k, const double *tau)
{
    double qdd[OP_FREEDOMS], x[ROWS];
    const uint32_t m = t->a->rows;
    const double *desired = t->desired + (size_t)k * m;
    op_move(t->c, t->forward, k, tau, qdd);
    const double size = op_tip_acceleration(t->a, k, qdd, x);
    within(t, k, DESIRED, op_difference(x, desired, m, size));
    reached++;
}

/* tau = J^T (lambda a + mu + p): in the row space of J */
static void check_row_space(const struct task *t, uint32_t k, const double *tau)
{
    const op_answers *a = t->a;
    const op_case *c = t->c;
    const uint32_t m = a->rows;
    const double *L = a->lambda + (size_t)k * m * m, *J = a->jacobian + (size_t)k * m * c->n;
    const double *desired = t->desired + (size_t)k * m;
    double F[ROWS], want[OP_FREEDOMS];
    for (uint32_t i = 0; i < m; i++) {
        F[i] = a->mu[(size_t)k * m + i] + a->p[(size_t)k * m + i];
        for (uint32_t j = 0; j < m; j++)
            F[i] += L[i * m + j] * desired[j];
    }
    for (uint32_t i = 0; i < c->n; i++) {
        want[i] = 0;
        for (uint32_t j = 0; j < m; j++)
            want[i] += J[(size_t)j * c->n + i] * F[j];
    }
    for (uint32_t l = 0; l < c->r.locked_count; l++) {
        const tfa_joint_info j = tfa_model_joint(c->model, c->r.locked[l]);
        memcpy(want + c->six + j.v_index, tau + c->six + j.v_index, j.v_count * sizeof *want);
    }
    const double size = norm2(L, (size_t)m * m) * norm2(desired, m) +
                        norm2(a->mu + (size_t)k * m, m) + norm2(a->p + (size_t)k * m, m);
    op_within(c, &bounds[ROW_SPACE],
              op_difference(tau, want, c->n, size * norm2(J, (size_t)m * c->n)));
}

/* |qdd - qdd of no torques|_M is least without posture torques. */
static void check_gauss(const struct task *t, uint32_t k, const double *alone, const double *other)
{
    op_case *c = t->c;
    double unforced[OP_FREEDOMS], with[OP_FREEDOMS], without[OP_FREEDOMS];
    const double zero[OP_FREEDOMS] = {0};
    op_move(t->c, t->forward, k, zero, unforced);
    op_move(t->c, t->forward, k, alone, without);
    op_move(t->c, t->forward, k, other, with);
    op_set_state_locked(c, k);
    const double least =
        oracle_energy_norm(c->o, without + c->six, without, unforced + c->six, unforced);
    const double more = oracle_energy_norm(c->o, with + c->six, with, unforced + c->six, unforced);
    op_within(c, &bounds[GAUSS], fmax(0, least - more) / (least + more + 1e-6));
}

static void check_posture(struct task *t, int which)
{
    double x[2][ROWS], qdd[OP_FREEDOMS], alone[OP_FREEDOMS], other[OP_FREEDOMS];
    double posture[OP_FREEDOMS] = {0};
    op_case *c = t->c;
    t->r.tau = t->posture[which];
    op_answers *b = op_answer(c, t->w, &t->r);
    for (uint32_t k = 0; k < t->r.count; k++) {
        const uint32_t m = t->a->rows;
        op_forces(c, t->a, k, alone);
        op_forces(c, b, k, other);
        memcpy(posture + c->six, t->r.tau + (size_t)k * c->nv, c->nv * sizeof *posture);
        if (which == 0 && k + 1 == t->r.count)
            check_definition(t, b, k, posture, other);
        if (!is_full(t, k))
            continue;
        check_desired(t, k, other);
        op_move(t->c, t->forward, k, alone, qdd);
        (void)op_tip_acceleration(t->a, k, qdd, x[0]);
        op_move(t->c, t->forward, k, other, qdd);
        const double size = op_tip_acceleration(t->a, k, qdd, x[1]);
        within(t, k, POSTURES, op_difference(x[1], x[0], m, size));
        if (which == 0 && k == 0)
            check_gauss(t, k, alone, other);
    }
    op_answers_free(b);
}

static void check_immobile(struct task *t, uint32_t k)
{
    const uint32_t m = t->a->rows;
    if (norm2(t->a->lambda_inv + (size_t)k * m * m, (size_t)m * m) > 0)
        return;
    double tau[OP_FREEDOMS];
    op_forces(t->c, t->a, k, tau);
    for (uint32_t i = 0; i < t->c->n; i++)
        assert_true(tau[i] == 0);
    immobile++;
}

static void with_task(struct task *t)
{
    op_case *c = t->c;
    const double none[OP_FREEDOMS] = {0};
    t->r.tau = NULL;
    t->a = op_answer(c, t->w, &t->r);
    for (uint32_t k = 0; k < t->r.count; k++) {
        double tau[OP_FREEDOMS];
        op_forces(c, t->a, k, tau);
        check_immobile(t, k);
        if (k == 0)
            check_definition(t, t->a, k, none, tau);
        if (!is_full(t, k))
            continue;
        check_desired(t, k, tau);
        if (is_well_conditioned(t, k))
            check_row_space(t, k, tau);
    }
    for (int which = 0; which < 2; which++)
        check_posture(t, which);
    op_answers_free(t->a);
}

static void choose_task(struct task *t, op_case *c, int pass)
{
    op_choose_tips(c, 1 + (uint32_t)(pass % TIPS), pass % 2 ? TFA_ROWS_POSE : TFA_ROWS_POINT,
                   (tfa_reference_frame)(pass % 3));
    t->c = c;
    for (size_t k = 0; k < OP_STATES * ROWS; k++)
        t->desired[k] = random_uniform(&c->s, -10, 10);
    for (size_t k = 0; k < OP_STATES * (size_t)c->nv; k++) {
        t->posture[0][k] = random_uniform(&c->s, -10, 10);
        t->posture[1][k] = random_uniform(&c->s, -10, 10);
    }
    t->r = c->r;
    t->r.op = TFA_OP_TASK_TORQUES;
    t->r.base_wrench = NULL;
    t->r.rank_loss = (tfa_rank_loss)random_below(&c->s, 3);
    t->wide = 1e-2;
    t->r.rank_threshold = (c->n + (uint32_t)pass) % 3 ? NULL : &t->wide;
    t->r.task_acceleration = t->desired;
    t->r.flags = TFA_WANT_JACOBIAN | TFA_WANT_BIAS_ACCELERATION | TFA_WANT_LAMBDA | TFA_WANT_MU |
                 TFA_WANT_P | TFA_WANT_POSES;
    op_choose_method(c, &t->r);
}

static void tasks(op_case *c)
{
    static struct task t;
    for (int pass = 0; pass < 6; pass++) {
        if (pass == 4 && !op_lock(c))
            return;
        choose_task(&t, c, pass);
        t.r.count = 1 + (uint32_t)(pass % 2) * (OP_STATES - 1);
        t.forward = c->f64;
        t.w = pass == 3 ? c->f32 : c->f64; /* what float lacks is in double */
        c->set = c->heavy ? HEAVY : DOUBLE;
        with_task(&t);
        if (pass != 2)
            continue;
        t.w = t.forward = c->f128;
        c->set = QUAD;
        with_task(&t);
    }
}

TEST(tips_accelerate_as_asked)
{
    op_for_each(OP_ALL, tasks);
    op_print(bounds, KINDS);
    op_print(robot_bounds, 2);
    print_message("  %u accelerations, %u by definition, %u directions damped, %u immobile\n",
                  reached, by_definition, damped, immobile);
    assert_true(reached > 500 && by_definition > 500 && damped > 100 && immobile > 10);
}
