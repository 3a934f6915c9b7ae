/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Loops in motion, integrated by Runge and Kutta's method of fourth order. Swinging freely they
 * keep their energy: forces of constraints do no work. Opened a little they close as their gains
 * say, e'' + k1 e' + k0 e = wanted.
 */
#include "constrained_robot.h"
#include "models.h"
#include "support/small_robot.h"
#include "support/step.h"
#include "test.h"

#define STEP 5e-4
enum { Q = 8 }; /* most joints, of one freedom each, on a fixed base */

typedef struct motion {
    constrained_robot *c;
    uint32_t n;
    double q[Q], v[Q], wanted[ROWS];
    const double *gains;
} motion;

static tfa_request request_of(const motion *x, const double *q, const double *v)
{
    static const double none[3] = {0}; /* or the freedom left to a hinge turns its axes of error */
    tfa_request r = request_fd(q, v, NULL);
    r.op = TFA_OP_CONSTRAINED_DYNAMICS;
    r.gravity = x->gains ? none : NULL;
    r.constraints = (1u << x->c->count) - 1;
    r.stabilisation = x->gains;
    r.constraint_acceleration = x->gains ? x->wanted : NULL;
    return r;
}

static void step(motion *x)
{
    static const double part[4] = {0, 0.5, 0.5, 1}, weight[4] = {1. / 6, 1. / 3, 1. / 3, 1. / 6};
    double q[Q], v[Q], dq[Q] = {0}, dv[Q] = {0}, q_sum[Q], v_sum[Q];
    memcpy(q_sum, x->q, sizeof q_sum);
    memcpy(v_sum, x->v, sizeof v_sum);
    for (int k = 0; k < 4; k++) {
        constrained_answer a;
        for (uint32_t j = 0; j < x->n; j++) {
            q[j] = x->q[j] + part[k] * STEP * dq[j];
            v[j] = x->v[j] + part[k] * STEP * dv[j];
        }
        const tfa_request r = request_of(x, q, v);
        constrained_ask(x->c, x->c->f64, &r, &a);
        memcpy(dq, v, sizeof dq);
        memcpy(dv, a.qdd, x->n * sizeof *dv);
        for (uint32_t j = 0; j < x->n; j++) {
            q_sum[j] += weight[k] * STEP * dq[j];
            v_sum[j] += weight[k] * STEP * dv[j];
        }
    }
    memcpy(x->q, q_sum, sizeof q_sum);
    memcpy(x->v, v_sum, sizeof v_sum);
}

/* To the nearest state in which points meet and do not part. Returns how far off it was. */
static double project(motion *x)
{
    static relative_motion m;
    quad less[FREEDOMS];
    double off = 0;
    for (int part = 0; part < 2; part++) {
        const tfa_request r = request_of(x, x->q, x->v);
        relative_motion_of(x->c, &r, &m);
        (void)least_norm(x->c, &m, part ? m.velocity : m.position, less);
        for (uint32_t j = 0; j < x->n; j++) {
            double *at = part ? &x->v[j] : &x->q[j];
            *at = (double)(*at - less[j]);
            off = fmax(off, fabs((double)less[j]));
        }
    }
    return off;
}

static double energy_of(const motion *x, double *kinetic)
{
    double energy[2];
    tfa_request r = request_fd(x->q, x->v, NULL);
    r.op = TFA_OP_KINEMATICS;
    r.flags = TFA_WANT_ENERGY;
    tfa_reply reply = {.energy = energy};
    compute_ok(x->c->robot, x->c->f64, &r, &reply);
    *kinetic = fmax(*kinetic, energy[0]);
    return energy[0] + energy[1];
}

/* ---- loops ---- */

/* Moves the first frame to where the second one is at q; in the world with its axes, too. */
static void close_at(constrained_robot *c, uint32_t k, const double *q)
{
    double poses[2][7], apart[3];
    tfa_constraint *x = &c->constraint[k];
    tfa_request r = request_fd(q, NULL, NULL);
    tfa_reply reply = {.poses = poses[0]};
    r.op = TFA_OP_KINEMATICS;
    r.flags = TFA_WANT_POSES;
    r.tip_count = 2;
    r.tips[0] = c->link[k][1];
    r.tips[1] = c->link[k][0] == WORLD ? 0 : c->link[k][0];
    compute_ok(c->robot, c->robot->f64, &r, &reply);
    rotate_vector(poses[0] + 3, x->pose[1], apart);
    if (c->link[k][0] == WORLD) {
        memcpy(x->pose[0] + 3, poses[0] + 3, 4 * sizeof(double));
        memset(poses[1], 0, 6 * sizeof(double));
        poses[1][6] = 1;
    }
    const double back[4] = {-poses[1][3], -poses[1][4], -poses[1][5], poses[1][6]};
    for (int e = 0; e < 3; e++)
        apart[e] += poses[0][e] - poses[1][e];
    rotate_vector(back, apart, x->pose[0]);
}

/* Five bars in the plane of x and z, the ground one of them, that hinges join */
static void open_five_bar(small_robot *r, test_robot *robot)
{
    static const struct {
        uint32_t parent;
        double x, mass;
    } bars[] = {{0, 0, 1}, {1, 0.4, 0.7}, {0, 0.5, 1.3}, {3, 0.35, 0.9}};
    small_robot_begin(r);
    for (uint32_t k = 0; k < 4; k++) {
        tfa_joint *joint = small_robot_add(r, bars[k].parent, TFA_JOINT_REVOLUTE, 0, -1, 0);
        joint->xyz[0] = bars[k].x;
        small_robot_load(r, k + 1, bars[k].mass, 0.02, 0.02, 0.02);
        r->link[k + 1].com[0] = 0.2;
    }
    fixture_open_description("five-bar", &r->d, TFA_BASE_FIXED, robot);
}

static const struct loop {
    uint32_t chain, first, second, rows; /* chain: joints of one in space; 0: a five-bar */
    double bound;                        /* of the energy */
} loops[] = {{0, 4, 2, TFA_CONSTRAINT_HINGE, 1e-6},
             {7, WORLD, 7, TFA_CONSTRAINT_POINT, 1e-8},
             {8, 2, 8, TFA_CONSTRAINT_POINT, 1e-8}};

static void open_loop(const struct loop *of, small_robot *small, test_robot *robot,
                      constrained_robot *c, motion *x)
{
    static const double q[Q] = {2, -1.3, 1, 0.4, -0.7, 1.1, 0.6, -0.9};
    if (of->chain)
        fixture_open_chain(CHAIN_RANDOM, of->chain, 5, TFA_BASE_FIXED, robot);
    else
        open_five_bar(small, robot);
    *c = (constrained_robot){.robot = robot};
    tfa_constraint *loop = constrained_add(c, of->first, of->second, of->rows);
    loop->pose[1][0] = 0.3;
    for (int side = 0; side < 2 && !of->chain; side++) { /* z along y */
        loop->pose[side][3] = -M_SQRT1_2;
        loop->pose[side][6] = M_SQRT1_2;
    }
    close_at(c, 0, q);
    *x = (motion){.c = c, .n = robot->n};
    memcpy(x->q, q, sizeof q);
}

/* ---- tests ---- */

static void swing(const struct loop *of)
{
    small_robot small;
    test_robot robot;
    constrained_robot c;
    motion x;
    random_source s = {3};
    double kinetic = 0, off = 0, error = 0;
    open_loop(of, &small, &robot, &c, &x);
    assert_true(constrained_open(&c));
    for (uint32_t j = 0; j < x.n; j++)
        x.v[j] = random_uniform(&s, -1, 1);
    (void)project(&x);
    const double energy = energy_of(&x, &kinetic);
    for (int k = 1; k <= TEST_ROUNDS(6000); k++) {
        step(&x);
        off = k % 10 ? off : fmax(off, project(&x));
        error = fmax(error, fabs(energy_of(&x, &kinetic) - energy));
    }
    print_message("  %s: %.1e of %.1f J kinetic; %.1e off\n", robot.name, error / kinetic, kinetic,
                  off);
    assert_within(&robot, "energy", error / kinetic, of->bound, NULL);
    assert_within(&robot, "closure", off, 1e-6, NULL);
    constrained_close(&c);
    fixture_close(&robot);
}

TEST(free_loops_keep_their_energy)
{
    for (size_t k = 0; k < sizeof loops / sizeof *loops; k++)
        swing(&loops[k]);
}

/* Critically damped, from e0 at rest to wanted / k0 */
static double closing(double e0, double wanted, double root, double time)
{
    const double end = wanted / (root * root);
    return end + (e0 - end) * (1 + root * time) * exp(-root * time);
}

/* Linear rows to the error of the integration, angular ones to first order of the error */
static void close_loop(uint32_t rows)
{
    enum { ROOT = 20, STEPS = 600 };
    static const double gains[2] = {ROOT * ROOT, 2 * ROOT};
    const struct loop of = {7, WORLD, 7, rows, 0};
    small_robot small;
    test_robot robot;
    constrained_robot c;
    motion x;
    constrained_answer first, a;
    double worst[2] = {0};
    open_loop(&of, &small, &robot, &c, &x);
    for (int e = 0; e < 3; e++) {
        c.constraint[0].pose[0][e] += 1e-3 * (e - 1.5);
        c.constraint[0].pose[1][3 + e] = 5e-4 * (1 - 2 * (e == 1));
        x.wanted[e] = x.wanted[3 + e] = 0.1 * (e + 1);
    }
    c.constraint[0].pose[1][6] = 1;
    assert_true(constrained_open(&c));
    x.gains = gains;
    for (int k = 0; k <= TEST_ROUNDS(STEPS); k++) {
        const tfa_request r = request_of(&x, x.q, x.v);
        constrained_ask(&c, c.f64, &r, &a);
        first = k ? first : a;
        for (int e = 0; e < 6; e++) {
            const double want = closing(first.position[e], x.wanted[e], ROOT, k * STEP);
            if (rows >> e & 1)
                assert_within(&robot, e < 3 ? "error" : "angular error", fabs(a.position[e] - want),
                              e < 3 ? 1e-10 : 2e-6, &worst[e / 3]);
        }
        step(&x);
    }
    print_message("  rows %02x: %.1e m, %.1e rad\n", (unsigned)rows, worst[0], worst[1]);
    assert_true(norm2(first.position, 3) > 1e-3);
    assert_int_equal(a.rank.lost, 0);
    constrained_close(&c);
    fixture_close(&robot);
}

TEST(opened_loops_close_as_their_gains_say)
{
    static const uint32_t rows[] = {TFA_CONSTRAINT_POINT, TFA_CONSTRAINT_HINGE, TFA_CONSTRAINT_WELD,
                                    0x2f, 0x37};
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++)
        close_loop(rows[k]);
}
