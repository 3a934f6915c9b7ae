/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The terms of the equation of motion: their sum is what inverse dynamics gives, and each of them
 * is inverse dynamics with everything else zero. Terms without a cause are exactly zero.
 */
#include "operational.h"
#include "test.h"

enum {
    SUM,
    SUM_QDD,
    GRAVITY,
    VELOCITY,
    DAMPING,
    FRICTION,
    EXTERNAL,
    ARMATURE,
    BY_JACOBIAN,
    SQUARE,
    SAME,
    KINDS
};
/* In double; in f128 */
static op_bound bounds[KINDS] = {
    {"sum = inverse dynamics at qdd 0", {4e-14, 3e-15}, {0}},
    {"sum + M qdd = inverse dynamics", {4e-14, 3e-15}, {0}},
    {"gravity_force", {4e-14, 3e-15}, {0}},
    {"velocity_force", {4e-14, 3e-15}, {0}},
    {"damping_force", {4e-14, 3e-15}, {0}},
    {"friction_force", {4e-14, 3e-15}, {0}},
    {"external_force", {4e-14, 3e-15}, {0}},
    {"armature_force", {4e-14, 3e-15}, {0}},
    {"external = - J^T wrench", {4e-14, 3e-15}, {0}},
    {"v^2, v", {4e-14, 3e-15}, {0}},
    {"external_force at twice the speed", {4e-14, 3e-15}, {0}},
};

static const double weightless[3] = {0, 0, 0};

/* h of the oracle for a request, base first; with which losses */
enum { LOSSLESS, DAMPED, RUBBED };
static void oracle_h(op_case *c, const tfa_request *whole, uint32_t k, int losses, double *h)
{
    const tfa_request before = c->whole_r;
    oracle_use_damping(c->o, losses == DAMPED && c->damped);
    oracle_use_friction(c->o, losses == RUBBED ? c->friction_velocity : 0);
    c->whole_r = *whole;
    op_set_state(c, k);
    oracle_inverse(c->o, NULL, NULL, h + c->six, h);
    c->whole_r = before;
}

/* Largest of the terms: their rounding is relative to it where they cancel inside. */
static double size_of(const op_case *c, const op_answers *a, uint32_t k)
{
    const size_t at = (size_t)k * c->n;
    return norm2(a->gravity_force + at, c->n) + norm2(a->velocity_force + at, c->n) +
           norm2(a->damping_force + at, c->n) + norm2(a->friction_force + at, c->n) +
           norm2(a->external_force + at, c->n);
}

/* Forces that the motion and the wrenches would have along a freedom in the worst direction: those
 * that vanish by geometry have the rounding of these. */
struct sizes {
    double gravity, velocity, external;
};

#define LEVER 0.1 /* m */

static struct sizes all_sizes[OP_STATES];

static struct sizes sizes_of(op_case *c, uint32_t k)
{
    static double M[OP_FREEDOMS * OP_FREEDOMS];
    double v[OP_FREEDOMS];
    op_set_state(c, k);
    oracle_mass_matrix(c->o, M);
    op_velocities(c, k, v);
    const double *g = c->whole_r.gravity;
    const size_t wrenches = 6 * (size_t)c->r.wrench_count;
    return (struct sizes){(double)oracle_sums_of(c->o).mass * (g ? norm2(g, 3) : 9.80665) * LEVER,
                          norm2(M, (size_t)c->n * c->n) * norm2(v, c->n) * norm2(v, c->n),
                          norm2(c->r.wrenches + k * wrenches, wrenches) * LEVER};
}

static void check_external(op_case *c, const op_answers *a, uint32_t k)
{
    double want[OP_FREEDOMS];
    tfa_request pushed = c->whole_r;
    pushed.v = pushed.base_twist = NULL;
    pushed.gravity = weightless;
    oracle_h(c, &pushed, k, LOSSLESS, want);
    op_within(
        c, &bounds[EXTERNAL],
        op_difference(a->external_force + (size_t)k * c->n, want, c->n, all_sizes[k].external));
}

/* Those that do not depend on the frame */
static void check_terms(op_case *c, const op_answers *a, uint32_t k)
{
    double want[OP_FREEDOMS], lossless[OP_FREEDOMS];
    const size_t at = (size_t)k * c->n;
    const struct sizes sizes = all_sizes[k];
    tfa_request still = c->whole_r, moving = c->whole_r;
    still.v = still.base_twist = NULL;
    still.wrench_count = moving.wrench_count = 0;
    moving.gravity = weightless;
    oracle_h(c, &still, k, LOSSLESS, want);
    op_within(c, &bounds[GRAVITY], op_difference(a->gravity_force + at, want, c->n, sizes.gravity));
    oracle_h(c, &moving, k, LOSSLESS, lossless);
    op_within(c, &bounds[VELOCITY],
              op_difference(a->velocity_force + at, lossless, c->n, sizes.velocity));
    const double *const forces[] = {[DAMPED] = a->damping_force, [RUBBED] = a->friction_force};
    for (int losses = DAMPED; losses <= RUBBED; losses++) {
        oracle_h(c, &moving, k, losses, want);
        const double size = fmax(sizes.velocity, norm2(want, c->n));
        for (uint32_t i = 0; i < c->n; i++)
            want[i] -= lossless[i];
        op_within(c, &bounds[losses == DAMPED ? DAMPING : FRICTION],
                  op_difference(forces[losses] + at, want, c->n, size));
    }
}

/* Rotors turn with what their freedom is tied to: T^T R T qdd. Locked joints do not accelerate. */
static void check_armature(const op_case *c, const op_answers *a, uint32_t k, const double *qdd)
{
    double want[OP_FREEDOMS] = {0};
    for (uint32_t v = 0, within; v < c->whole_nv; v++) {
        const tfa_joint *j = &c->whole->joints[oracle_joint_of_freedom(c->o, v, &within)];
        const oracle_tie t = c->tie ? c->tie[c->six + v] : (oracle_tie){c->six + v, 1};
        if (t.to != ORACLE_STILL)
            want[t.to] += t.multiplier * t.multiplier * j->armature * qdd[t.to];
    }
    op_within(c, &bounds[ARMATURE],
              op_difference(a->armature_force + (size_t)k * c->n, want, c->n, 0));
}

/* Accelerations of state k, base first, zero where the request locks. */
static void accelerations(const op_case *c, uint32_t k, double *qdd)
{
    for (uint32_t i = 0; i < c->n; i++)
        qdd[i] = i < c->six ? c->r.base_acceleration[6 * (size_t)k + i]
                            : c->r.qdd[(size_t)k * c->nv + i - c->six];
    for (uint32_t l = 0; l < c->r.locked_count; l++) {
        const tfa_joint_info j = tfa_model_joint(c->model, c->r.locked[l]);
        memset(qdd + c->six + j.v_index, 0, j.v_count * sizeof *qdd);
    }
}

static void check_sum(op_case *c, tfa_workspace *w, const tfa_request *r, const op_answers *a)
{
    double qdd[OP_FREEDOMS], tau[OP_FREEDOMS], sum[OP_FREEDOMS], h[OP_FREEDOMS];
    static double inertial[OP_FREEDOMS];
    tfa_request id = *r;
    id.op = TFA_OP_INVERSE_DYNAMICS;
    op_answers *full = op_answers_create(c, &id), *none = op_answers_create(c, &id);
    op_compute(c, w, &id, full);
    id.qdd = id.base_acceleration = NULL;
    op_compute(c, w, &id, none);
    for (uint32_t k = 0; k < r->count; k++) {
        const size_t at = (size_t)k * c->n;
        accelerations(c, k, qdd);
        for (uint32_t i = 0; i < c->n; i++)
            sum[i] = a->gravity_force[at + i] + a->velocity_force[at + i] +
                     a->damping_force[at + i] + a->friction_force[at + i] +
                     a->external_force[at + i];
        op_forces(c, none, k, tau);
        op_within(c, &bounds[SUM], op_difference(sum, tau, c->n, size_of(c, a, k)));
        check_armature(c, a, k, qdd);
        if (k > 0)
            continue;
        op_set_state(c, k);
        oracle_inverse(c->o, NULL, NULL, h + c->six, h);
        oracle_inverse(c->o, qdd + c->six, qdd, inertial + c->six, inertial);
        const double size = size_of(c, a, k) + norm2(inertial, c->n);
        for (uint32_t i = 0; i < c->n; i++)
            sum[i] += inertial[i] - h[i];
        op_forces(c, full, k, tau);
        op_within(c, &bounds[SUM_QDD], op_difference(sum, tau, c->n, size));
    }
    op_answers_free(none);
    op_answers_free(full);
}

/* - J^T wrench with the library's own J of the links that are pushed */
static void check_jacobian(op_case *c, tfa_workspace *w, const tfa_request *r)
{
    double want[OP_FREEDOMS];
    tfa_request q = *r;
    q.tip_count = q.wrench_count;
    memcpy(q.tips, q.wrench_frames, sizeof q.wrench_frames);
    q.rows = TFA_ROWS_POSE;
    q.flags = TFA_WANT_JACOBIAN;
    op_answers *a = op_answer(c, w, &q);
    for (uint32_t k = 0; k < q.count; k++) {
        const double *J = a->jacobian + (size_t)k * a->rows * c->n;
        const double *wrench = q.wrenches + (size_t)k * a->rows;
        const double size = norm2(J, (size_t)a->rows * c->n) * norm2(wrench, a->rows);
        for (uint32_t i = 0; i < c->n; i++) {
            want[i] = 0;
            for (uint32_t row = 0; row < a->rows; row++)
                want[i] -= J[(size_t)row * c->n + i] * wrench[row];
        }
        op_within(c, &bounds[BY_JACOBIAN],
                  op_difference(a->external_force + (size_t)k * c->n, want, c->n, size));
    }
    op_answers_free(a);
}

static void double_speed(const op_case *c, const tfa_request *r, double *v, double *twist)
{
    for (size_t k = 0; k < (size_t)r->count * c->nv; k++)
        v[k] = 2 * r->v[k];
    for (size_t k = 0; k < (size_t)r->count * c->six; k++)
        twist[k] = 2 * r->base_twist[k];
}

static void check_scaling(op_case *c, tfa_workspace *w, const tfa_request *r, const op_answers *a)
{
    static double v[OP_STATES * OP_FREEDOMS], twist[OP_STATES * 6];
    double want[OP_FREEDOMS];
    tfa_request q = *r;
    op_answers *fast = op_answers_create(c, &q);
    double_speed(c, r, v, twist);
    q.v = v;
    q.base_twist = c->six ? twist : NULL;
    op_compute(c, w, &q, fast);
    for (size_t k = 0; k < q.count; k++) {
        const size_t at = k * c->n;
        const struct sizes sizes = all_sizes[k];
        for (uint32_t i = 0; i < c->n; i++)
            want[i] = 4 * a->velocity_force[at + i];
        op_within(c, &bounds[SQUARE],
                  op_difference(fast->velocity_force + at, want, c->n, sizes.velocity));
        for (uint32_t i = 0; i < c->n; i++)
            want[i] = 2 * a->damping_force[at + i];
        op_within(c, &bounds[SQUARE], op_difference(fast->damping_force + at, want, c->n, 0));
        assert_memory_equal(fast->gravity_force + at, a->gravity_force + at, c->n * sizeof *want);
        op_within(c, &bounds[SAME],
                  op_difference(fast->external_force + at, a->external_force + at, c->n,
                                norm2(a->damping_force + at, c->n) +
                                    norm2(a->friction_force + at, c->n)));
    }
    op_answers_free(fast);
}

static void check_zero(const op_case *c, const char *what, const double *x, size_t n)
{
    for (size_t k = 0; k < n; k++)
        if (!(x[k] == 0))
            fail_msg("%s: %s[%zu] is %g", c->name, what, k, x[k]);
}

/* Nothing of an earlier request with everything remains in one with nothing. */
static void check_zeros(op_case *c, tfa_workspace *w, const tfa_request *r)
{
    tfa_request q = *r;
    const size_t n = (size_t)q.count * c->n;
    op_answers *a = op_answers_create(c, &q);
    q.v = q.base_twist = q.qdd = q.base_acceleration = NULL;
    op_compute(c, w, &q, a);
    check_zero(c, "velocity_force", a->velocity_force, n);
    check_zero(c, "damping_force", a->damping_force, n);
    check_zero(c, "friction_force", a->friction_force, n);
    check_zero(c, "armature_force", a->armature_force, n);
    q = *r;
    q.gravity = weightless;
    q.wrench_count = 0;
    op_compute(c, w, &q, a);
    check_zero(c, "gravity_force", a->gravity_force, n);
    check_zero(c, "external_force", a->external_force, n);
    op_answers_free(a);
}

static void with_workspace(op_case *c, tfa_workspace *w, const tfa_request *r)
{
    c->set = w == c->f128;
    op_answers *a = op_answer(c, w, r);
    assert_true(isnan(a->jacobian[0]) && isnan(a->com[0]) && isnan(a->tau[0]));
    const uint32_t state = random_below(&c->s, r->count);
    if (r->frame == TFA_FRAME_LOCAL)
        check_terms(c, a, state);
    check_external(c, a, state);
    oracle_use_damping(c->o, c->damped);
    oracle_use_friction(c->o, c->friction_velocity);
    check_sum(c, w, r, a);
    check_jacobian(c, w, r);
    check_scaling(c, w, r, a);
    check_zeros(c, w, r);
    op_answers_free(a);
}

static void terms(op_case *c)
{
    for (uint32_t k = 0; k < OP_STATES; k++)
        all_sizes[k] = sizes_of(c, k);
    for (int frame = 0; frame < 3; frame++) {
        op_choose_tips(c, 1, TFA_ROWS_POSE, (tfa_reference_frame)frame);
        tfa_request r = c->r;
        r.op = TFA_OP_BIAS;
        with_workspace(c, c->f64, &r);
        if (frame == 1)
            with_workspace(c, c->f128, &r);
    }
    if (op_lock(c)) {
        tfa_request r = c->r;
        r.op = TFA_OP_BIAS;
        with_workspace(c, c->f64, &r);
    }
}

TEST(terms_of_the_equation_of_motion)
{
    op_for_each(OP_ALL, terms);
    op_print(bounds, KINDS);
}
