/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A four-bar linkage in space, its loop closed by a hinge: five rows, of which a plane mechanism
 * moves two. Crank, coupler and rocker have angles al(theta) by closure, lengths a, b, c and ground
 * d, and Lagrange's equation in theta alone:
 *
 *     a e(al1) + b e(al2) = (d, 0) + c e(al3),   e(al) = (cos al, sin al)
 *     sum m r'.r' + I al'^2  times  theta'' = Q - sum m r'.(r'' theta'^2 + g) + I al' al'' theta'^2
 *
 * A parallelogram (a = c, b = d) loses a row where it is flat: there the answer says so, and the
 * residual is what damping gives up, x (1 - d^2/t^2) of the eigenvalue d in that direction.
 */
#include "constrained_robot.h"
#include "models.h"
#include "support/small_robot.h"
#include "test.h"

#include <float.h>

enum { LINKS = 3, CRANK = 0, COUPLER, ROCKER };

typedef struct four_bar {
    double length[LINKS], ground, mass[LINKS], inertia[LINKS], com[LINKS][2];
    bool parallel; /* the branch on which the coupler does not turn */
} four_bar;

static const four_bar crank_rocker = {.length = {0.3, 0.8, 0.7},
                                      .ground = 0.9,
                                      .mass = {1.2, 2.5, 1.7},
                                      .inertia = {0.01, 0.15, 0.08},
                                      .com = {{0.1, 0.02}, {0.35, 0.1}, {0.4, -0.05}}};
static const four_bar parallelogram = {.length = {0.4, 0.9, 0.4},
                                       .ground = 0.9,
                                       .mass = {1, 3, 2},
                                       .inertia = {0.02, 0.2, 0.03},
                                       .com = {{0.2, 0.01}, {0.4, 0}, {0.15, 0.02}},
                                       .parallel = true};

/* ---- the closed form ---- */

typedef struct angles {
    double al[LINKS], d1[LINKS], d2[LINKS]; /* and their derivatives by theta */
} angles;

static angles close(const four_bar *f, double theta)
{
    const double a = f->length[CRANK], b = f->length[COUPLER], c = f->length[ROCKER];
    angles x = {.al = {theta, 0, theta}, .d1 = {1, 0, 1}};
    if (f->parallel)
        return x;
    const double far[2] = {f->ground - a * cos(theta), -a * sin(theta)};
    const double L = hypot(far[0], far[1]);
    const double u = atan2(far[1], far[0]) + acos((L * L + b * b - c * c) / (2 * b * L));
    const double w = atan2(b * sin(u) - far[1], b * cos(u) - far[0]), s = sin(w - u);
    const double u1 = -a * sin(w - theta) / (b * s), w1 = -a * sin(u - theta) / (c * s);
    const double u2 = (a * cos(w - theta) + b * u1 * u1 * cos(w - u) - c * w1 * w1) / (b * s);
    const double w2 = (a * cos(u - theta) + b * u1 * u1 - c * w1 * w1 * cos(w - u)) / (c * s);
    return (angles){{theta, u, w}, {1, u1, w1}, {0, u2, w2}};
}

/* com of link k by theta: `order` 1 or 2 of the derivative; x, z */
static void com_derivative(const four_bar *f, const angles *x, int k, int order, double out[2])
{
    const double arm[2][2] = {{f->length[CRANK], 0}, {f->com[k][0], f->com[k][1]}};
    out[0] = out[1] = 0;
    for (int part = k != COUPLER; part < 2; part++) { /* of the coupler the crank, too */
        const int turning = part ? k : CRANK;
        const double c = cos(x->al[turning]), s = sin(x->al[turning]);
        const double r[2] = {arm[part][0] * c - arm[part][1] * s,
                             arm[part][0] * s + arm[part][1] * c};
        const double first = order == 1 ? x->d1[turning] : x->d2[turning];
        const double second = order == 1 ? 0 : x->d1[turning] * x->d1[turning];
        out[0] -= first * r[1] + second * r[0];
        out[1] += first * r[0] - second * r[1];
    }
}

/* q: theta, coupler on crank, rocker */
static void by_lagrange(const four_bar *f, const angles *x, double speed, const double *tau,
                        double qdd[LINKS])
{
    const double square = speed * speed;
    double mass = 0, force = tau[0] + tau[1] * (x->d1[COUPLER] - 1) + tau[2] * x->d1[ROCKER];
    for (int k = 0; k < LINKS; k++) {
        double r1[2], r2[2];
        com_derivative(f, x, k, 1, r1);
        com_derivative(f, x, k, 2, r2);
        mass += f->mass[k] * (r1[0] * r1[0] + r1[1] * r1[1]) + f->inertia[k] * x->d1[k] * x->d1[k];
        force -= f->mass[k] * ((r1[0] * r2[0] + r1[1] * r2[1]) * square + 9.80665 * r1[1]) +
                 f->inertia[k] * x->d1[k] * x->d2[k] * square;
    }
    const double theta = force / mass;
    for (int k = 0; k < LINKS; k++)
        qdd[k] = x->d1[k] * theta + x->d2[k] * square;
    qdd[1] -= theta;
}

/* ---- the robot ---- */

typedef struct linkage {
    const four_bar *f;
    small_robot robot;
    test_robot fixture;
    constrained_robot c;
} linkage;

static void open_linkage(const four_bar *f, linkage *x)
{
    static const double across[4] = {-M_SQRT1_2, 0, 0, M_SQRT1_2}; /* z along y */
    static const uint32_t parent[LINKS] = {0, 1, 0};
    x->f = f;
    small_robot_begin(&x->robot);
    for (uint32_t k = 0; k < LINKS; k++) {
        tfa_joint *joint = small_robot_add(&x->robot, parent[k], TFA_JOINT_REVOLUTE, 0, -1, 0);
        joint->xyz[0] = k == COUPLER ? f->length[CRANK] : k == ROCKER ? f->ground : 0;
        small_robot_load(&x->robot, k + 1, f->mass[k], f->inertia[k], f->inertia[k], f->inertia[k]);
        x->robot.link[k + 1].com[0] = f->com[k][0];
        x->robot.link[k + 1].com[2] = f->com[k][1];
    }
    fixture_open_description("four-bar", &x->robot.d, TFA_BASE_FIXED, &x->fixture);
    x->c = (constrained_robot){.robot = &x->fixture};
    tfa_constraint *loop = constrained_add(&x->c, 1 + ROCKER, 1 + COUPLER, TFA_CONSTRAINT_HINGE);
    loop->pose[0][0] = f->length[ROCKER];
    loop->pose[1][0] = f->length[COUPLER];
    memcpy(loop->pose[0] + 3, across, sizeof across);
    memcpy(loop->pose[1] + 3, across, sizeof across);
    assert_true(constrained_open(&x->c));
}

static void close_linkage(linkage *x)
{
    constrained_close(&x->c);
    fixture_close(&x->fixture);
}

static tfa_request request_at(const linkage *x, const angles *at, double speed, double *q,
                              double *v)
{
    static const double tau[LINKS] = {0.7, -0.4, 1.1};
    for (int k = 0; k < LINKS; k++) {
        q[k] = at->al[k] - (k == COUPLER ? at->al[CRANK] : 0);
        v[k] = speed * (at->d1[k] - (k == COUPLER ? 1 : 0));
    }
    tfa_request r = request_fd(q, v, tau);
    r.op = TFA_OP_CONSTRAINED_DYNAMICS;
    r.constraints = (1u << x->c.count) - 1;
    return r;
}

/* ---- tests ---- */

/* Returns how many directions are lost. */
static uint32_t compare(const linkage *x, double theta, double speed, double bound, double *worst)
{
    const angles at = close(x->f, theta);
    double q[LINKS], v[LINKS], qdd[LINKS];
    const tfa_request r = request_at(x, &at, speed, q, v);
    constrained_answer a;
    by_lagrange(x->f, &at, speed, r.tau, qdd);
    for (int w = 0; w < 2; w++) {
        constrained_ask(&x->c, w ? x->c.f128 : x->c.f64, &r, &a);
        assert_true(a.answer.flags & TFA_ANSWER_RANK_LOSS);
        for (int e = 2; e < 5; e++) /* out of the plane */
            assert_true(fabs(a.F[e]) <= 1e-12 * (1 + norm2(a.F, 6)));
        if (a.rank.lost == 3)
            assert_within(&x->fixture, "qdd", relative_error(a.qdd, qdd, LINKS), bound, worst);
    }
    return a.rank.lost;
}

TEST(closed_form_at_every_crank_angle)
{
    linkage x;
    double worst = 0;
    open_linkage(&crank_rocker, &x);
    for (int k = 0; k < 360; k++)
        assert_int_equal(compare(&x, M_PI / 180 * k, k % 7 - 3, 2e-13, &worst), 3);
    print_message("  qdd within %.1e\n", worst);
    close_linkage(&x);
}

static uint32_t partly; /* directions that damping gives up by more than 0, less than 1 */

/* The missing acceleration is that which damping gives up in the lost directions, no more. */
static void check_damped(const linkage *x, double theta)
{
    static relative_motion m;
    const angles at = close(x->f, theta);
    const double wanted[6] = {1, -0.5};
    double q[LINKS], v[LINKS], free_qdd[LINKS], missing[6] = {0};
    tfa_request r = request_at(x, &at, 2, q, v);
    constrained_answer a;
    r.constraint_acceleration = wanted;
    constrained_ask(&x->c, x->c.f64, &r, &a);
    assert_int_equal(a.rank.lost, 4);
    relative_motion_of(&x->c, &r, &m);
    oracle_forward(x->fixture.o, r.tau, NULL, free_qdd, NULL);
    const double length[6] = {1, 1, 1, a.rank.length, a.rank.length, a.rank.length};
    for (uint32_t k = 0; k < a.rank.lost; k++) {
        const double *lost = a.lost + k * (2 + 6), *u = lost + 2; /* sqrt(d), given up, direction */
        double along = 0, part = lost[0] * lost[0] / a.rank.threshold;
        for (uint32_t e = 0; e < 5; e++) {
            quad error = wanted[e] - m.bias[e];
            for (uint32_t j = 0; j < LINKS; j++)
                error -= m.J[LINKS * e + j] * free_qdd[j];
            along += (double)error * u[e] * length[e] * length[e];
            missing[e] += lost[1] * u[e];
        }
        assert_true(part <= 1);
        partly += part > 1e-6 && fabs(along) > 0.1;
        assert_true(fabs(lost[1] - along * (1 - part * part)) <= 1e-9);
    }
    for (int e = 0; e < 6; e++)
        assert_true(fabs(a.residual[e] + missing[e]) <= 1e-9);
    for (int k = 0; k < LINKS; k++)
        assert_true(isfinite(a.qdd[k]));
}

TEST(flat_parallelogram)
{
    static const double off[] = {1, 0.1, 1e-2, 3e-3, 1e-3, 1e-4, 1e-6, 1e-9, 1e-12, 0};
    linkage x;
    uint32_t damped = 0;
    open_linkage(&parallelogram, &x);
    for (size_t k = 0; k < sizeof off / sizeof *off; k++)
        for (int flat = 0; flat < 2; flat++) {
            const double theta = M_PI * flat + off[k];
            const uint32_t lost =
                compare(&x, theta, 2, 10 * DBL_EPSILON / fmax(off[k] * off[k], 1e-9), NULL);
            assert_true(lost == (off[k] > 2e-3 ? 3 : 4));
            if (lost == 4)
                check_damped(&x, theta);
            damped += lost == 4;
        }
    assert_true(damped >= 8 && partly >= 2);
    close_linkage(&x);
}
