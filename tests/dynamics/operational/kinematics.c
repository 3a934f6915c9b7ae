/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Jacobians, bias accelerations, twists and poses of tips, poses of all frames, and mass, centre of
 * mass, momentum and energy against the oracle: with every op that may carry them, in every frame,
 * in both kinds of rows, with joints locked by the request, in each precision. Sums are over the
 * oracle's links that move, payloads included, and not over those that are fixed to the world.
 */
#include "operational.h"
#include "test.h"

/* Errors of Jacobians are relative to them or to this: a point on an axis has rounding only. */
#define REACH 0.1

enum {
    POSE,
    FRAME_POSE,
    TWIST,
    JACOBIAN,
    BIAS,
    TWIST_J,
    MASS,
    COM,
    COM_VELOCITY,
    COM_JACOBIAN,
    LINEAR,
    ANGULAR,
    KINETIC,
    POTENTIAL,
    QUADRATIC,
    KINDS
};
/* In double; in f128 */
static op_bound bounds[KINDS] = {
    {"pose", {3e-14, 7e-15}, {0}},
    {"frame poses", {3e-14, 7e-15}, {0}},
    {"twist", {3e-14, 7e-15}, {0}},
    {"jacobian", {3e-14, 7e-15}, {0}},
    {"bias_acceleration", {3e-14, 7e-15}, {0}},
    {"twist = J v", {3e-14, 7e-15}, {0}},
    {"mass", {2e-14, 3e-15}, {0}},
    {"com", {2e-14, 3e-15}, {0}},
    {"com_velocity", {2e-14, 3e-15}, {0}},
    {"com_jacobian", {2e-14, 3e-15}, {0}},
    {"linear momentum", {2e-14, 3e-15}, {0}},
    {"angular momentum", {2e-14, 3e-15}, {0}},
    {"kinetic energy", {2e-14, 3e-15}, {0}},
    {"potential energy", {2e-14, 3e-15}, {0}},
    {"kinetic energy, v^T M v / 2", {4e-14, 2e-14}, {0}},
};

static void check_poses(op_case *c, const op_answers *a, uint32_t k)
{
    for (uint32_t t = 0; t < a->tips; t++)
        op_within(
            c, &bounds[POSE],
            oracle_pose_error(c->o, c->whole_r.tips[t], a->poses + 7 * ((size_t)k * a->tips + t)));
    for (uint32_t f = 0; f < a->frames; f++)
        op_within(
            c, &bounds[FRAME_POSE],
            oracle_pose_error(c->o, c->link[f], a->frame_poses + 7 * ((size_t)k * a->frames + f)));
}

/* Linear rows of all tips, which are what twists and rows of points have in common, or all rows. */
static void check_twist(const op_case *c, const op_answers *a, uint32_t k)
{
    double v[OP_FREEDOMS];
    quad Jv[OP_ROWS];
    const oracle_tips tips = op_tips(c);
    const double *J = a->jacobian + (size_t)k * a->rows * a->n;
    const double *twists = a->twists + (size_t)k * 6 * a->tips;
    op_velocities(c, k, v);
    double got[OP_ROWS];
    const double scale = fmax(REACH, norm2(J, (size_t)a->rows * a->n)) * norm2(v, a->n);
    for (uint32_t i = 0; i < a->rows; i++) {
        Jv[i] = 0;
        got[i] = twists[6 * (i / tips.rows) + i % tips.rows];
        for (uint32_t j = 0; j < a->n; j++)
            Jv[i] += (quad)J[(size_t)i * a->n + j] * v[j];
    }
    op_within(c, &bounds[TWIST_J], op_error(got, Jv, a->rows, scale));
}

static void check_motion(op_case *c, const op_answers *a, uint32_t k)
{
    static quad J[OP_ROWS * OP_FREEDOMS];
    quad x[OP_ROWS];
    double v[OP_FREEDOMS];
    const oracle_tips tips = op_tips(c);
    const size_t entries = (size_t)a->rows * a->n;
    oracle_jacobian(c->o, &tips, J);
    op_velocities(c, k, v);
    const double size = fmax(REACH, op_norm_quad(J, entries)), speed = norm2(v, c->n);
    op_within(c, &bounds[JACOBIAN], op_error(a->jacobian + k * entries, J, entries, REACH));
    oracle_twists(c->o, &tips, x);
    op_within(c, &bounds[TWIST],
              op_error(a->twists + (size_t)k * 6 * a->tips, x, 6 * (size_t)a->tips, size * speed));
    oracle_bias_acceleration(c->o, &tips, x);
    op_within(
        c, &bounds[BIAS],
        op_error(a->bias_acceleration + (size_t)k * a->rows, x, a->rows, size * speed * speed));
}

/* Reach of the robot around its centre of mass: the lever of momenta that cancel. */
static double reach_of(op_case *c, const oracle_centroid *sums)
{
    double reach = 0, p[3], R[9];
    for (uint32_t f = 0; f < c->link_count; f++) {
        oracle_pose(c->o, c->link[f], p, R);
        reach = fmax(reach, op_difference((double[3]){(double)sums->com[0], (double)sums->com[1],
                                                      (double)sums->com[2]},
                                          p, 3, 0) *
                                norm2(p, 3));
    }
    return reach;
}

static void check_sums(op_case *c, const op_answers *a, uint32_t k)
{
    static quad J[3 * OP_FREEDOMS];
    double v[OP_FREEDOMS], gravity[3] = {0, 0, -9.80665};
    const size_t entries = 3 * (size_t)c->n;
    op_velocities(c, k, v);
    const oracle_centroid sums = oracle_sums_of(c->o);
    const double mass = (double)sums.mass, speed = norm2(v, c->n);
    oracle_com_jacobian(c->o, J);
    if (c->whole_r.gravity)
        memcpy(gravity, c->whole_r.gravity, sizeof gravity);
    const double moving = op_norm_quad(J, entries) * speed;
    /* rounding of momenta that cancel: they are as large as that of the fastest mass */
    const double momentum = mass * moving + (double)quad_sqrt(2 * sums.kinetic * sums.mass);
    const double weight = mass * norm2(gravity, 3) * fmax(1, op_norm_quad(sums.com, 3));
    op_within(c, &bounds[MASS], op_error(a->mass + k, &sums.mass, 1, 0));
    op_within(c, &bounds[COM], op_error(a->com + 3 * (size_t)k, sums.com, 3, 1));
    op_within(c, &bounds[COM_VELOCITY],
              op_error(a->com_velocity + 3 * (size_t)k, sums.velocity, 3, moving));
    op_within(c, &bounds[COM_JACOBIAN], op_error(a->com_jacobian + k * entries, J, entries, 0));
    op_within(c, &bounds[LINEAR],
              op_error(a->momentum + 6 * (size_t)k, sums.momentum, 3, momentum));
    op_within(c, &bounds[ANGULAR],
              op_error(a->momentum + 6 * (size_t)k + 3, sums.momentum + 3, 3,
                       momentum * (1 + reach_of(c, &sums))));
    op_within(c, &bounds[KINETIC], op_error(a->energy + 2 * (size_t)k, &sums.kinetic, 1, 0));
    op_within(c, &bounds[POTENTIAL],
              op_error(a->energy + 2 * (size_t)k + 1, &sums.potential, 1, weight));
}

/* T = v^T M v / 2 with the library's own M: of projected mimics, too */
static void check_quadratic(op_case *c, const op_answers *a, uint32_t k)
{
    double v[OP_FREEDOMS], T = 0;
    const double *M = a->mass_matrix + (size_t)k * c->n * c->n;
    op_velocities(c, k, v);
    for (uint32_t i = 0; i < c->n; i++)
        for (uint32_t j = 0; j < c->n; j++)
            T += v[i] * M[(size_t)i * c->n + j] * v[j] / 2;
    op_within(c, &bounds[QUADRATIC], op_difference(a->energy + 2 * (size_t)k, &T, 1, 0));
}

static void check(op_case *c, tfa_workspace *w, tfa_request *r)
{
    c->set = w == c->f128;
    op_answers *a = op_answer(c, w, r);
    const uint32_t k = random_below(&c->s, r->count); /* the oracle is slow */
    op_set_motion(c, k);
    check_sums(c, a, k);
    if (r->op == TFA_OP_MASS_MATRIX && w != c->f32) /* whose M itself is in float */
        check_quadratic(c, a, k);
    if (r->tip_count) {
        check_poses(c, a, k);
        check_motion(c, a, k);
        check_twist(c, a, k);
    }
    op_answers_free(a);
}

/* One op in one frame, with one kind of rows */
static void with_op(op_case *c, tfa_op op, int frame, tfa_rows rows)
{
    double wanted[OP_STATES * OP_ROWS] = {0};
    op_choose_tips(c, 1 + random_below(&c->s, OP_TIPS), rows, (tfa_reference_frame)frame);
    tfa_request r = c->r;
    r.op = op;
    r.flags = OP_KINEMATICS;
    r.task_acceleration = wanted;
    if (op == TFA_OP_MASS_MATRIX)
        r.locked_count = 0;
    op_choose_method(c, &r);
    check(c, c->f64, &r);
    if (frame == 0) /* solutions in float, the rest in double */
        check(c, c->f32, &r);
    r.count = 1;
    if (frame == 2)
        check(c, c->f128, &r);
    if (op != TFA_OP_KINEMATICS || rows == TFA_ROWS_POINT)
        return;
    r.count = c->r.count;
    r.tip_count = 0; /* which sums do not need */
    r.flags = TFA_WANT_COM | TFA_WANT_MOMENTUM | TFA_WANT_ENERGY;
    check(c, c->f64, &r);
}

static void moves(op_case *c)
{
    for (int frame = 0; frame < 3; frame++)
        for (int rows = 0; rows < 2; rows++)
            with_op(c, op_ops[random_below(&c->s, OP_OPS)], frame,
                    rows ? TFA_ROWS_POINT : TFA_ROWS_POSE);
    with_op(c, TFA_OP_MASS_MATRIX, 1 + (int)random_below(&c->s, 2), TFA_ROWS_POSE);
    with_op(c, TFA_OP_KINEMATICS, 1, TFA_ROWS_POSE);
    if (op_lock(c))
        for (int frame = 0; frame < 3; frame++)
            with_op(c, op_ops[random_below(&c->s, OP_OPS)], frame,
                    (tfa_rows)random_below(&c->s, 2));
}

TEST(everything_moves_as_the_oracle_says)
{
    op_for_each(OP_ALL, moves);
    op_print(bounds, KINDS);
}

/* Every op on a few robots, so that none is left to chance. */
static void every_op(op_case *c)
{
    for (size_t k = 0; k < OP_OPS && c->n <= 12; k++)
        for (int frame = 0; frame < 3; frame++)
            with_op(c, op_ops[k], frame, (tfa_rows)(k % 2));
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
    op_answers *a =
        op_answer(c, c->f64, &r); /* what the workspace remembers of it must not matter */
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

/* ---- far away ---- */

static op_bound far_away = {"com_jacobian 1e6 m away", {1e-14}, {0}};

/* Where the base stands changes nothing. */
static void shifted(op_case *c)
{
    double pose[7];
    tfa_request r = op_state(c, 0);
    if (c->base != TFA_BASE_FLOATING)
        return;
    r.op = TFA_OP_KINEMATICS;
    r.flags = TFA_WANT_COM;
    op_answers *near = op_answers_create(c, &r), *far = op_answers_create(c, &r);
    op_compute(c, c->f64, &r, near);
    memcpy(pose, r.base_pose, sizeof pose);
    for (int e = 0; e < 3; e++)
        pose[e] = e == 1 ? -1e6 : 1e6;
    r.base_pose = pose;
    op_compute(c, c->f64, &r, far);
    op_within(c, &far_away,
              op_difference(far->com_jacobian, near->com_jacobian, 3 * (size_t)c->n, 0));
    op_answers_free(far);
    op_answers_free(near);
}

TEST(far_from_the_origin)
{
    op_for_each(OP_ALL, shifted);
    op_print(&far_away, 1);
}
