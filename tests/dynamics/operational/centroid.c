/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Mass, centre of mass, momentum and energy against sums over the oracle's links: of those that
 * move, payloads included, and not of those that are fixed to the world.
 */
#include "operational.h"
#include "support/fixture.h"
#include "test.h"

#define FLAGS (TFA_WANT_COM | TFA_WANT_MOMENTUM | TFA_WANT_ENERGY)

static const tfa_op ops[] = {TFA_OP_KINEMATICS,       TFA_OP_FORWARD_DYNAMICS,
                             TFA_OP_INVERSE_DYNAMICS, TFA_OP_OPERATIONAL_INERTIA,
                             TFA_OP_MASS_MATRIX,      TFA_OP_BIAS,
                             TFA_OP_TASK_TORQUES};
#define OPS (sizeof ops / sizeof *ops)

enum { MASS, COM, VELOCITY, JACOBIAN, LINEAR, ANGULAR, KINETIC, POTENTIAL, QUADRATIC, KINDS };
static op_bound bounds[2 * KINDS] = {
    {"mass", 2e-14, 0},
    {"com", 2e-14, 0},
    {"com_velocity", 2e-14, 0},
    {"com_jacobian", 2e-14, 0},
    {"linear momentum", 2e-14, 0},
    {"angular momentum", 2e-14, 0},
    {"kinetic energy", 2e-14, 0},
    {"potential energy", 2e-14, 0},
    {"kinetic energy, v^T M v / 2", 4e-14, 0},
    {"mass, f128", 3e-15, 0},
    {"com, f128", 3e-15, 0},
    {"com_velocity, f128", 3e-15, 0},
    {"com_jacobian, f128", 3e-15, 0},
    {"linear momentum, f128", 3e-15, 0},
    {"angular momentum, f128", 3e-15, 0},
    {"kinetic energy, f128", 3e-15, 0},
    {"potential energy, f128", 3e-15, 0},
    {"kinetic energy, v^T M v / 2, f128", 2e-14, 0},
};

/* Reach of the robot around its centre of mass: the lever of momenta that cancel. */
static double reach_of(op_case *c, const oracle_centroid *sums)
{
    double reach = 0, p[3], R[9];
    for (uint32_t f = 0; f < c->link_count; f++) {
        oracle_pose(c->o, c->link[f], p, R);
        reach = fmax(reach, op_difference((double[3]){(double)sums->com[0], (double)sums->com[1],
                                                      (double)sums->com[2]},
                                          p, 3, 0) *
                                op_norm(p, 3));
    }
    return reach;
}

static void check_state(op_case *c, const op_answers *a, uint32_t k, op_bound *b)
{
    static quad J[3 * OP_FREEDOMS];
    double v[OP_FREEDOMS], gravity[3] = {0, 0, -9.80665};
    const size_t entries = 3 * (size_t)c->n;
    op_set_motion(c, k);
    op_velocities(c, k, v);
    const oracle_centroid sums = oracle_sums_of(c->o);
    const double mass = (double)sums.mass, speed = op_norm(v, c->n);
    oracle_com_jacobian(c->o, J);
    if (c->whole_r.gravity)
        memcpy(gravity, c->whole_r.gravity, sizeof gravity);
    const double moving = op_norm_quad(J, entries) * speed;
    /* rounding of momenta that cancel: they are as large as that of the fastest mass */
    const double momentum = mass * moving + (double)quad_sqrt(2 * sums.kinetic * sums.mass);
    const double weight = mass * op_norm(gravity, 3) * fmax(1, op_norm_quad(sums.com, 3));
    op_within(c, &b[MASS], op_error(a->mass + k, &sums.mass, 1, 0));
    op_within(c, &b[COM], op_error(a->com + 3 * (size_t)k, sums.com, 3, 1));
    op_within(c, &b[VELOCITY], op_error(a->com_velocity + 3 * (size_t)k, sums.velocity, 3, moving));
    op_within(c, &b[JACOBIAN], op_error(a->com_jacobian + k * entries, J, entries, 0));
    op_within(c, &b[LINEAR], op_error(a->momentum + 6 * (size_t)k, sums.momentum, 3, momentum));
    op_within(c, &b[ANGULAR],
              op_error(a->momentum + 6 * (size_t)k + 3, sums.momentum + 3, 3,
                       momentum * (1 + reach_of(c, &sums))));
    op_within(c, &b[KINETIC], op_error(a->energy + 2 * (size_t)k, &sums.kinetic, 1, 0));
    op_within(c, &b[POTENTIAL],
              op_error(a->energy + 2 * (size_t)k + 1, &sums.potential, 1, weight));
}

/* T = v^T M v / 2 with the library's own M: of projected mimics, too */
static void check_quadratic(op_case *c, const op_answers *a, uint32_t k, op_bound *b)
{
    double v[OP_FREEDOMS], T = 0;
    const double *M = a->mass_matrix + (size_t)k * c->n * c->n;
    op_velocities(c, k, v);
    for (uint32_t i = 0; i < c->n; i++)
        for (uint32_t j = 0; j < c->n; j++)
            T += v[i] * M[(size_t)i * c->n + j] * v[j] / 2;
    op_within(c, &b[QUADRATIC], op_difference(a->energy + 2 * (size_t)k, &T, 1, 0));
}

static void check(op_case *c, tfa_workspace *w, const tfa_request *r, op_bound *b)
{
    op_answers *a = op_answers_create(c, r);
    op_compute(c, w, r, a);
    const uint32_t k = random_below(&c->s, r->count); /* the oracle is slow */
    check_state(c, a, k, b);
    if (r->op == TFA_OP_MASS_MATRIX)
        check_quadratic(c, a, k, b);
    assert_true(isnan(a->poses[0]) && isnan(a->frame_poses[0]));
    op_answers_free(a);
}

static void with_op(op_case *c, tfa_op op)
{
    double wanted[OP_STATES * OP_ROWS] = {0};
    op_choose_tips(c, 1 + random_below(&c->s, 2), TFA_ROWS_POSE,
                   (tfa_reference_frame)random_below(&c->s, 3));
    tfa_request r = c->r;
    r.op = op;
    r.flags = FLAGS;
    r.task_acceleration = wanted;
    if (op == TFA_OP_KINEMATICS) /* they need no tips */
        r.tip_count = random_below(&c->s, 2);
    if (op == TFA_OP_MASS_MATRIX)
        r.locked_count = 0;
    op_choose_method(c, &r);
    check(c, c->f64, &r, bounds);
    if (op != TFA_OP_MASS_MATRIX) /* M itself is in float */
        check(c, c->f32, &r, bounds);
    r.count = 1;
    check(c, c->f128, &r, bounds + KINDS);
}

static void sums(op_case *c)
{
    with_op(c, TFA_OP_KINEMATICS);
    with_op(c, TFA_OP_MASS_MATRIX);
    with_op(c, ops[random_below(&c->s, OPS)]);
    if (op_lock(c)) {
        with_op(c, TFA_OP_KINEMATICS);
        with_op(c, ops[random_below(&c->s, OPS)]);
    }
}

TEST(sums_over_what_moves)
{
    op_for_each(OP_ALL, sums);
    op_print(bounds, 2 * KINDS);
}

/* ---- far away ---- */

static op_bound far_away = {"com_jacobian 1e6 m away", 1e-14, 0};

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

static void every_op(op_case *c)
{
    for (size_t k = 0; k < OPS && c->n <= 12; k++)
        with_op(c, ops[k]);
}

TEST(every_op_carries_them)
{
    op_for_each(OP_REDUCED, every_op);
}
