/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Closing loops. Of every robot: constraints that are met at a drawn posture, opened by moving the
 * joints that are not measured; what is found meets them, keeps what is measured, and its
 * velocities differ from the given ones by a motion that the constraints do not admit. Of a
 * four-bar linkage: the angles of its closed form.
 */
#include <totalforce/close_loops.h>

#include "constrained_robot.h"
#include "models.h"
#include "support/small_robot.h"
#include "support/step.h"
#include "test.h"

static uint32_t cases, most_iterations, with_measured, with_free_base, open_velocities;
static double worst_position, worst_velocity;

static void assert_near(double x, double reference, double bound)
{
    if (!(fabs(x - reference) <= bound))
        fail_msg("%.17g, expected %.17g within %g", x, reference, bound);
}

typedef struct found {
    tfa_posture p;
    double q[FREEDOMS * 2], v[FREEDOMS], base_pose[7], base_twist[6];
} found;

static int close_loops(tfa_workspace *w, const tfa_request *r, const tfa_loop_options *o, found *f)
{
    f->p =
        (tfa_posture){.q = f->q, .v = f->v, .base_pose = f->base_pose, .base_twist = f->base_twist};
    return tfa_close_loops(w, r, o, &f->p);
}

/* ---- every robot ---- */

/* a^-1 b of poses */
static void relative_pose(const double *a, const double *b, double *out)
{
    const double back[4] = {-a[3], -a[4], -a[5], a[6]};
    const double apart[3] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]};
    rotate_vector(back, apart, out);
    const double *x = back, *y = b + 3;
    for (int i = 0; i < 3; i++)
        out[3 + i] = x[3] * y[i] + y[3] * x[i] + x[(i + 1) % 3] * y[(i + 2) % 3] -
                     x[(i + 2) % 3] * y[(i + 1) % 3];
    out[6] = x[3] * y[3] - x[0] * y[0] - x[1] * y[1] - x[2] * y[2];
}

/* Moves the first frame of each constraint to where the second one is. */
static void meet_at(constrained_robot *c, const tfa_request *state)
{
    for (uint32_t k = 0; k < c->count; k++) {
        double poses[2][7] = {{0}, {0, 0, 0, 0, 0, 0, 1}}, *second = c->constraint[k].pose[1];
        tfa_request r = *state;
        r.op = TFA_OP_KINEMATICS;
        r.flags = TFA_WANT_POSES;
        r.tips[0] = c->link[k][1];
        r.tips[1] = c->link[k][0];
        r.tip_count = c->link[k][0] == WORLD ? 1 : 2;
        tfa_reply reply = {.poses = poses[0]};
        compute_ok(c->robot, c->robot->f64, &r, &reply);
        memset(second + 3, 0, 4 * sizeof *second);
        second[6] = 1;
        double turned[3];
        rotate_vector(poses[0] + 3, second, turned);
        for (int e = 0; e < 3; e++)
            poses[0][e] += turned[e];
        relative_pose(poses[1], poses[0], c->constraint[k].pose[0]);
    }
}

/* The largest errors at what was found, by constrained dynamics */
static void check_errors(const constrained_robot *c, const found *f)
{
    double position[ROWS], velocity[ROWS];
    tfa_request r = {.op = TFA_OP_CONSTRAINED_DYNAMICS,
                     .count = 1,
                     .q = f->q,
                     .v = f->v,
                     .base_pose = f->base_pose,
                     .base_twist = f->base_twist,
                     .refine = TFA_REFINE_DEFAULT,
                     .constraints = (1u << c->count) - 1};
    tfa_reply reply = {.constraint_position = position, .constraint_velocity = velocity};
    assert_int_equal(tfa_compute(c->f64, &r, &reply), TFA_OK);
    for (uint32_t k = 0; k < 6 * c->count; k++)
        if (c->constraint[k / 6].rows >> k % 6 & 1) {
            assert_within(c->robot, "position", fabs(position[k]), 1e-10, &worst_position);
            assert_within(c->robot, "velocity", fabs(velocity[k]), 1e-10, &worst_velocity);
        }
}

/* (v+ - v)^T M v+ = 0: the nearest velocities by kinetic energy, of those that keep what is
 * measured */
static void check_nearest(const constrained_robot *c, const tfa_request *given, const found *f,
                          bool base_is_free)
{
    static double M[FREEDOMS * FREEDOMS];
    const uint32_t n = c->robot->n, six = n - c->robot->nv;
    double work = 0, size = 1e-300;
    tfa_request r = {.op = TFA_OP_MASS_MATRIX, .count = 1, .q = f->q, .base_pose = f->base_pose};
    tfa_reply reply = {.mass_matrix = M};
    assert_int_equal(tfa_compute(c->f64, &r, &reply), TFA_OK);
    if (given->locked_count || (six && !base_is_free))
        return; /* v+ of free joints is not admissible by itself */
    for (uint32_t i = 0; i < n; i++)
        for (uint32_t j = 0; j < n; j++) {
            const double before = j < six ? given->base_twist[j] : given->v[j - six];
            const double after = j < six ? f->base_twist[j] : f->v[j - six];
            const double x = (i < six ? f->base_twist[i] : f->v[i - six]) * M[i * n + j];
            work += x * (after - before);
            size = fmax(size, fabs(before * M[i * n + j] * (after - before)));
        }
    assert_within(c->robot, "nearest", fabs(work) / size, 1e-8, NULL);
}

static void check_measured(const constrained_robot *c, const tfa_request *r, const found *f,
                           bool base_is_free)
{
    for (uint32_t k = 0; k < r->locked_count; k++) {
        const tfa_joint_info j = tfa_model_joint(c->model, r->locked[k]);
        assert_memory_equal(f->q + j.q_index, r->q + j.q_index, j.q_count * sizeof *f->q);
        for (uint32_t e = 0; e < j.v_count; e++)
            assert_true(f->v[j.v_index + e] == r->v[j.v_index + e]);
    }
    if (c->robot->base == TFA_BASE_FLOATING && !base_is_free) {
        assert_memory_equal(f->base_pose, r->base_pose, sizeof f->base_pose);
        assert_memory_equal(f->base_twist, r->base_twist, sizeof f->base_twist);
    }
}

/* ---- one of them ---- */

typedef struct opened {
    constrained_robot c;
    random_states *states; /* the posture that meets the constraints */
    tfa_request r;         /* the start */
    tfa_loop_options options;
    uint32_t measured[FREEDOMS];
    double q[2 * FREEDOMS], base_pose[7];
} opened;

/* Moves the joints that are not measured, and a free base. */
static void open_loops(opened *x, random_source *s)
{
    double step[FREEDOMS + 6];
    const uint32_t six = x->c.robot->n - x->c.robot->nv, joints = tfa_model_joint_count(x->c.model);
    uint32_t *count = &x->r.locked_count;
    for (uint32_t k = 0; k < x->c.robot->n; k++)
        step[k] = k < six && !x->options.base_is_free ? 0 : random_uniform(s, -0.05, 0.05);
    for (uint32_t k = 0; k < joints; k++)
        if (*count < x->c.robot->nv / 4 && random_below(s, 2))
            x->measured[(*count)++] = k;
    memcpy(x->q, x->states->q, x->c.robot->nq * sizeof *x->q);
    memcpy(x->base_pose, x->states->base_pose, sizeof x->base_pose);
    step_model(x->c.model, x->states->q, x->states->base_pose, step, 1, x->q, x->base_pose);
    for (uint32_t k = 0; k < *count; k++) {
        const tfa_joint_info j = tfa_model_joint(x->c.model, x->measured[k]);
        memcpy(x->q + j.q_index, x->states->q + j.q_index, j.q_count * sizeof *x->q);
    }
    x->r.q = x->q;
    x->r.locked = x->measured;
    if (x->options.base_is_free)
        x->r.base_pose = x->base_pose;
}

static void check_found(const opened *x, int status, const found *f)
{
    const bool is_free = x->options.base_is_free;
    assert_within(x->c.robot, "closure", f->p.position, TFA_LOOP_TOLERANCE, NULL);
    check_measured(&x->c, &x->r, f, is_free);
    if (status == TFA_OK) {
        check_errors(&x->c, f);
        check_nearest(&x->c, &x->r, f, is_free);
        return;
    }
    /* velocities that were measured too often contradict each other */
    assert_int_equal(status, TFA_E_OPEN);
    assert_true(f->p.lost > 0 && f->p.velocity > TFA_LOOP_TOLERANCE);
    assert_int_equal(f->p.field, TFA_FIELD_CONSTRAINTS);
    open_velocities++;
}

static void law(test_robot *robot)
{
    static opened x;
    static found f;
    random_source s = {robot->seed + 41 + robot->base};
    x = (opened){.c = {.robot = robot}};
    if (robot->n > 100)
        return;
    constrained_draw(&x.c, &s, 1 + random_below(&s, 2));
    x.states = fixture_states(robot, 5, 1, 0);
    x.r = constrained_request(&x.c, x.states);
    meet_at(&x.c, &x.r);
    if (constrained_open(&x.c)) {
        x.options.base_is_free = robot->base == TFA_BASE_FLOATING && random_below(&s, 2);
        open_loops(&x, &s);
        int status = close_loops(x.c.f64, &x.r, &x.options, &f);
        if (status == TFA_E_UNSUPPORTED && f.p.field == TFA_FIELD_LOCKED) {
            x.r.locked_count = 0; /* with followers without mass */
            status = close_loops(x.c.f64, &x.r, &x.options, &f);
        }
        check_found(&x, status, &f);
        with_measured += x.r.locked_count > 0;
        with_free_base += x.options.base_is_free;
        most_iterations = f.p.iterations > most_iterations ? f.p.iterations : most_iterations;
        cases++;
        constrained_close(&x.c);
    }
    random_states_free(x.states);
}

TEST(loops_close_near_the_start)
{
    for_every_robot(law, false);
    print_message("  %u robots, at most %u iterations; position %.1e, velocity %.1e; measured "
                  "velocities of %u contradict each other\n",
                  cases, most_iterations, worst_position, worst_velocity, open_velocities);
    assert_true(cases > 20 && with_measured > 10 && with_free_base > 5 && most_iterations < 20);
}

/* ---- a four-bar linkage ---- */

enum { CRANK, COUPLER, ROCKER, BARS };
static const double length[BARS] = {0.3, 0.8, 0.7}, ground = 0.9;

static void open_four_bar(small_robot *small, test_robot *robot, constrained_robot *c)
{
    static const uint32_t parent[BARS] = {0, 1, 0};
    small_robot_begin(small);
    for (uint32_t k = 0; k < BARS; k++) {
        tfa_joint *joint = small_robot_add(small, parent[k], TFA_JOINT_REVOLUTE, 0, -1, 0);
        joint->xyz[0] = k == COUPLER ? length[CRANK] : k == ROCKER ? ground : 0;
        small_robot_load(small, k + 1, 1, 0.02, 0.02, 0.02);
    }
    fixture_open_description("four-bar", &small->d, TFA_BASE_FIXED, robot);
    *c = (constrained_robot){.robot = robot};
    tfa_constraint *loop = constrained_add(c, 1 + ROCKER, 1 + COUPLER, 0x05);
    loop->pose[0][0] = length[ROCKER];
    loop->pose[1][0] = length[COUPLER];
    assert_true(constrained_open(c));
}

static void close_four_bar(test_robot *robot, constrained_robot *c)
{
    constrained_close(c);
    fixture_close(robot);
}

/* Angles of coupler and rocker to the ground, and their derivatives by that of the crank */
static void solve_four_bar(double theta, double al[2], double d[2])
{
    const double a = length[CRANK], b = length[COUPLER], c = length[ROCKER];
    const double x = ground - a * cos(theta), y = -a * sin(theta), L = hypot(x, y);
    al[0] = atan2(y, x) + acos((L * L + b * b - c * c) / (2 * b * L));
    al[1] = atan2(b * sin(al[0]) - y, b * cos(al[0]) - x);
    d[0] = -a * sin(al[1] - theta) / (b * sin(al[1] - al[0]));
    d[1] = -a * sin(al[0] - theta) / (c * sin(al[1] - al[0]));
}

TEST(four_bar_has_the_angles_of_its_closed_form)
{
    static const uint32_t crank[] = {CRANK};
    small_robot small;
    test_robot robot;
    constrained_robot c;
    open_four_bar(&small, &robot, &c);
    double q[BARS] = {0, 1, 1.5}, v[BARS] = {2.5}, al[2], d[2];
    for (int k = 0; k <= 12; k++) {
        found f;
        q[CRANK] = k * M_PI / 6;
        const tfa_request r = {
            .q = q, .v = v, .constraints = 1, .locked = crank, .locked_count = 1};
        assert_int_equal(close_loops(c.f64, &r, NULL, &f), TFA_OK);
        solve_four_bar(q[CRANK], al, d);
        assert_near(f.q[COUPLER], al[0] - q[CRANK], 1e-9);
        assert_near(f.q[ROCKER], al[1], 1e-9);
        assert_near(f.v[COUPLER], (d[0] - 1) * v[CRANK], 1e-8);
        assert_near(f.v[ROCKER], d[1] * v[CRANK], 1e-8);
        assert_int_equal(f.p.rank, 2);
        memcpy(q, f.q, sizeof q); /* the next one begins here */
    }
    close_four_bar(&robot, &c);
}

/* Out of reach the points come as near as they can; the posture and its error are those. */
TEST(loops_out_of_reach_stay_open)
{
    static const uint32_t both[] = {CRANK, COUPLER};
    small_robot small;
    test_robot robot;
    constrained_robot c;
    found f;
    open_four_bar(&small, &robot, &c);
    const double q[BARS] = {M_PI / 2, M_PI / 2, 2}; /* the coupler ends at -0.8, 0.3 */
    tfa_request r = {.q = q, .constraints = 1, .locked = both, .locked_count = 2};
    assert_int_equal(close_loops(c.f64, &r, NULL, &f), TFA_E_OPEN);
    const double reach = hypot(ground + length[COUPLER], length[CRANK]) - length[ROCKER];
    const double angle = atan2(length[CRANK], -ground - length[COUPLER]);
    assert_near(f.q[ROCKER], angle, 1e-4);
    assert_true(f.p.position <= reach + 1e-8 && f.p.position > reach / 2);
    assert_int_equal(f.p.rank, 1);
    const tfa_loop_options few = {.iterations = 2};
    r.locked_count = 1;
    assert_int_equal(close_loops(c.f64, &r, &few, &f), TFA_E_OPEN);
    assert_int_equal(f.p.iterations, 2);
    close_four_bar(&robot, &c);
}

/* ---- one free body ---- */

TEST(half_a_turn_is_no_closure)
{
    small_robot small;
    test_robot robot;
    found f;
    double pose[7] = {0.3, 0, 0, 1, 0, 0, 0};
    small_robot_begin(&small);
    small_robot_add(&small, 0, TFA_JOINT_REVOLUTE, 0, 0, 1);
    small_robot_load(&small, 0, 2, 0.1, 0.2, 0.15);
    small_robot_load(&small, 1, 1, 0.01, 0.02, 0.02);
    fixture_open_description("body", &small.d, TFA_BASE_FLOATING, &robot);
    for (int weld = 0; weld < 2; weld++) {
        static const double q[1] = {0};
        constrained_robot c = {.robot = &robot};
        constrained_add(&c, WORLD, 0, weld ? TFA_CONSTRAINT_WELD : TFA_CONSTRAINT_HINGE);
        assert_true(constrained_open(&c));
        const tfa_loop_options options = {.base_is_free = 1};
        const tfa_request r = {.q = q, .base_pose = pose, .constraints = 1};
        assert_int_equal(close_loops(c.f64, &r, &options, &f), TFA_E_OPEN);
        assert_true(f.p.position == M_PI);
        pose[6] = 1; /* a quarter turn */
        pose[3] = 0.9;
        const double norm = norm2(pose + 3, 4);
        pose[3] /= norm;
        pose[6] /= norm;
        assert_int_equal(close_loops(c.f64, &r, &options, &f), TFA_OK);
        assert_near(f.base_pose[6] * f.base_pose[6] + f.base_pose[5] * f.base_pose[5], 1, 1e-9);
        pose[3] = 1;
        pose[6] = 0;
        constrained_close(&c);
    }
    fixture_close(&robot);
}

/* ---- refused ---- */

TEST(calls_that_cannot_be_answered)
{
    small_robot small;
    test_robot robot;
    constrained_robot c;
    found f;
    open_four_bar(&small, &robot, &c);
    const double q[BARS] = {0}, bad[BARS] = {0, NAN};
    const tfa_loop_options free_base = {.base_is_free = 1};
    tfa_request r = {.q = q, .constraints = 1};
    assert_int_equal(tfa_close_loops(c.f64, &r, NULL, NULL), TFA_E_ARGUMENT);
    assert_int_equal(close_loops(NULL, &r, NULL, &f), TFA_E_ARGUMENT);
    assert_int_equal(close_loops(c.f64, NULL, NULL, &f), TFA_E_ARGUMENT);
    assert_int_equal(close_loops(c.f64, &r, &free_base, &f), TFA_E_ARGUMENT);
    assert_int_equal(f.p.field, TFA_FIELD_BASE_POSE);
    r.constraints = 0;
    assert_int_equal(close_loops(c.f64, &r, NULL, &f), TFA_E_SIZE);
    r.constraints = 2;
    assert_int_equal(close_loops(c.f64, &r, NULL, &f), TFA_E_ARGUMENT);
    assert_int_equal(f.p.field, TFA_FIELD_CONSTRAINTS);
    r.constraints = 1;
    r.q = bad;
    assert_int_equal(close_loops(c.f64, &r, NULL, &f), TFA_E_VALUE);
    assert_int_equal(f.p.field, TFA_FIELD_Q);
    assert_int_equal(f.p.index, 1);
    r.q = NULL;
    assert_int_equal(close_loops(c.f64, &r, NULL, &f), TFA_E_ARGUMENT);
    close_four_bar(&robot, &c);
}
