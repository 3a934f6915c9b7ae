/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Jacobians, bias accelerations, twists and poses of tips, and poses of all frames, against the
 * oracle: with every op that may carry them, in every frame, in both kinds of rows, with joints
 * locked by the request, in each precision.
 */
#include "operational.h"
#include "support/fixture.h"
#include "test.h"

#define FLAGS                                                                                      \
    (TFA_WANT_POSES | TFA_WANT_FRAME_POSES | TFA_WANT_TWISTS | TFA_WANT_JACOBIAN |                 \
     TFA_WANT_BIAS_ACCELERATION)

static const tfa_op ops[] = {TFA_OP_KINEMATICS,       TFA_OP_FORWARD_DYNAMICS,
                             TFA_OP_INVERSE_DYNAMICS, TFA_OP_OPERATIONAL_INERTIA,
                             TFA_OP_MASS_MATRIX,      TFA_OP_BIAS,
                             TFA_OP_TASK_TORQUES};
#define OPS (sizeof ops / sizeof *ops)

/* Errors of Jacobians are relative to them or to this: a point on an axis has rounding only. */
#define REACH 0.1

enum { POSE, FRAME_POSE, TWIST, JACOBIAN, BIAS, TWIST_J, KINDS };
static op_bound bounds[2 * KINDS] = {
    {"pose", 3e-14, 0},
    {"frame poses", 3e-14, 0},
    {"twist", 3e-14, 0},
    {"jacobian", 3e-14, 0},
    {"bias_acceleration", 3e-14, 0},
    {"twist = J v", 3e-14, 0},
    {"pose, f128", 7e-15, 0},
    {"frame poses, f128", 7e-15, 0},
    {"twist, f128", 7e-15, 0},
    {"jacobian, f128", 7e-15, 0},
    {"bias_acceleration, f128", 7e-15, 0},
    {"twist = J v, f128", 7e-15, 0},
};

static void check_poses(op_case *c, const op_answers *a, uint32_t k, op_bound *b)
{
    for (uint32_t t = 0; t < a->tips; t++)
        op_within(
            c, &b[POSE],
            oracle_pose_error(c->o, c->whole_r.tips[t], a->poses + 7 * ((size_t)k * a->tips + t)));
    for (uint32_t f = 0; f < a->frames; f++)
        op_within(
            c, &b[FRAME_POSE],
            oracle_pose_error(c->o, c->link[f], a->frame_poses + 7 * ((size_t)k * a->frames + f)));
}

/* Linear rows of all tips, which are what twists and rows of points have in common, or all rows. */
static void check_twist(const op_case *c, const op_answers *a, uint32_t k, op_bound *b)
{
    double v[OP_FREEDOMS];
    quad Jv[OP_ROWS];
    const oracle_tips tips = op_tips(c);
    const double *J = a->jacobian + (size_t)k * a->rows * a->n;
    const double *twists = a->twists + (size_t)k * 6 * a->tips;
    op_velocities(c, k, v);
    double got[OP_ROWS];
    const double scale = fmax(REACH, op_norm(J, (size_t)a->rows * a->n)) * op_norm(v, a->n);
    for (uint32_t i = 0; i < a->rows; i++) {
        Jv[i] = 0;
        got[i] = twists[6 * (i / tips.rows) + i % tips.rows];
        for (uint32_t j = 0; j < a->n; j++)
            Jv[i] += (quad)J[(size_t)i * a->n + j] * v[j];
    }
    op_within(c, &b[TWIST_J], op_error(got, Jv, a->rows, scale));
}

static void check_motion(op_case *c, const op_answers *a, uint32_t k, op_bound *b)
{
    static quad J[OP_ROWS * OP_FREEDOMS];
    quad x[OP_ROWS];
    double v[OP_FREEDOMS];
    const oracle_tips tips = op_tips(c);
    const size_t entries = (size_t)a->rows * a->n;
    oracle_jacobian(c->o, &tips, J);
    op_velocities(c, k, v);
    const double size = fmax(REACH, op_norm_quad(J, entries)), speed = op_norm(v, c->n);
    op_within(c, &b[JACOBIAN], op_error(a->jacobian + k * entries, J, entries, REACH));
    oracle_twists(c->o, &tips, x);
    op_within(c, &b[TWIST],
              op_error(a->twists + (size_t)k * 6 * a->tips, x, 6 * (size_t)a->tips, size * speed));
    oracle_bias_acceleration(c->o, &tips, x);
    op_within(
        c, &b[BIAS],
        op_error(a->bias_acceleration + (size_t)k * a->rows, x, a->rows, size * speed * speed));
}

static void check(op_case *c, tfa_workspace *w, tfa_request *r, op_bound *b)
{
    op_answers *a = op_answers_create(c, r);
    op_compute(c, w, r, a);
    const uint32_t k = random_below(&c->s, r->count); /* the oracle is slow */
    op_set_motion(c, k);
    check_poses(c, a, k, b);
    check_motion(c, a, k, b);
    check_twist(c, a, k, b);
    op_answers_free(a);
}

/* One op in one frame, with one kind of rows */
static void with_op(op_case *c, tfa_op op, int frame, tfa_rows rows)
{
    double wanted[OP_STATES * OP_ROWS] = {0};
    op_choose_tips(c, 1 + random_below(&c->s, OP_TIPS), rows, (tfa_reference_frame)frame);
    tfa_request r = c->r;
    r.op = op;
    r.flags = FLAGS;
    r.task_acceleration = wanted;
    if (op == TFA_OP_MASS_MATRIX)
        r.locked_count = 0;
    op_choose_method(c, &r);
    check(c, c->f64, &r, bounds);
    if (frame == 0) /* solutions in float, the rest in double */
        check(c, c->f32, &r, bounds);
    r.count = 1;
    if (frame == 2)
        check(c, c->f128, &r, bounds + KINDS);
}

static void tips_move(op_case *c)
{
    for (int frame = 0; frame < 3; frame++)
        for (int rows = 0; rows < 2; rows++)
            with_op(c, ops[random_below(&c->s, OPS)], frame, rows ? TFA_ROWS_POINT : TFA_ROWS_POSE);
    if (op_lock(c))
        for (int frame = 0; frame < 3; frame++)
            with_op(c, ops[random_below(&c->s, OPS)], frame, (tfa_rows)random_below(&c->s, 2));
}

TEST(tips_move_as_the_oracle_says)
{
    op_for_each(OP_ALL, tips_move);
    op_print(bounds, 2 * KINDS);
}

/* Every op on a few robots, so that none is left to chance. */
static void every_op(op_case *c)
{
    if (c->n > 12)
        return;
    for (size_t k = 0; k < OPS; k++)
        for (int frame = 0; frame < 3; frame++)
            with_op(c, ops[k], frame, (tfa_rows)(k % 2));
}

TEST(every_op_carries_them)
{
    op_for_each(OP_REDUCED, every_op);
}

/* Robots at rest: v NULL */
static void at_rest(op_case *c)
{
    op_choose_tips(c, 2, TFA_ROWS_POSE, TFA_FRAME_WORLD);
    tfa_request r = c->r;
    r.op = TFA_OP_KINEMATICS;
    r.flags = TFA_WANT_TWISTS | TFA_WANT_BIAS_ACCELERATION;
    op_answers *a = op_answers_create(c, &r);
    op_compute(c, c->f64, &r, a); /* what the workspace remembers of it must not matter */
    r.v = r.base_twist = NULL;
    op_compute(c, c->f64, &r, a);
    for (uint32_t i = 0; i < r.count * 12; i++) {
        assert_true(a->twists[i] == 0);
        assert_true(a->bias_acceleration[i] == 0);
    }
    assert_true(isnan(a->jacobian[0]) && isnan(a->poses[0]) && isnan(a->com[0]));
    op_answers_free(a);
}

TEST(nothing_moves_at_rest)
{
    op_for_each(OP_ALL, at_rest);
}
