/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Laws of mechanics that the answers must obey: no oracle computes an answer here. Bounds are
 * about twenty times the worst that these seeds and files gave; each test prints that worst.
 */
#include "models.h"
#include "support/quad.h"
#include "support/questions.h"
#include "support/small_robot.h"
#include "support/step.h"
#include "test.h"

#define STATES 4

static void two_tips(const test_robot *robot, tfa_request *r)
{
    const uint32_t links = (uint32_t)robot->description->link_count;
    r->tip_count = 2;
    r->tips[0] = links - 1;
    r->tips[1] = links / 2;
}

/* ---- M qdd + h = tau ---- */

static double worst_residual;

static void equations_hold(test_robot *robot)
{
    random_states *x = fixture_states(robot, 0, STATES, 2);
    answers *a = answers_create(robot, STATES);
    for (uint32_t m = 0; (m = fixture_method(robot, TFA_OP_FORWARD_DYNAMICS, m)) != NO_METHOD;
         m++) {
        tfa_request r = fixture_request(robot, x);
        tfa_reply reply = answers_reply(a, 0, 0);
        r.method = (tfa_method)m;
        compute_ok(robot, robot->f64, &r, &reply);
        r.op = TFA_OP_INVERSE_DYNAMICS;
        r.method = TFA_METHOD_AUTO;
        r.qdd = a->qdd;
        r.base_acceleration = robot->n > robot->nv ? a->base_acceleration : NULL;
        compute_ok(robot, robot->f64, &r, &reply);
        /* relative to the forces that balance: tau alone may be far smaller than h */
        size_t nv = (size_t)STATES * robot->nv;
        double given = norm2(x->tau, nv) + 10 * robot->n;
        for (size_t k = 0; k < nv; k++)
            a->tau[k] -= x->tau[k];
        double residual = norm2(a->tau, nv);
        if (robot->n > robot->nv)
            for (int k = 0; k < 6 * STATES; k++)
                residual = fmax(residual, fabs(a->base_wrench[k] - x->base_wrench[k]));
        assert_within(robot, tfa_method_name(m), residual / given, 2e-12, &worst_residual);
    }
    answers_free(a);
    random_states_free(x);
}

TEST(inverse_dynamics_undoes_forward)
{
    for_every_robot(equations_hold, false);
    print_message("  worst residual %.2g\n", worst_residual);
}

/* ---- symmetry ---- */

static double asymmetry(const double *A, size_t n)
{
    double difference = 0;
    for (size_t i = 0; i < n; i++)
        for (size_t k = 0; k < i; k++)
            difference = fmax(difference, fabs(A[i * n + k] - A[k * n + i]));
    double size = norm2(A, n * n);
    return size > 0 ? difference / size : difference;
}

static void symmetric(test_robot *robot)
{
    random_states *x = fixture_states(robot, 0, STATES, 0);
    answers *a = answers_create(robot, STATES);
    tfa_request r = fixture_request(robot, x);
    tfa_reply reply = answers_reply(a, 0, 0);
    r.op = TFA_OP_MASS_MATRIX;
    compute_ok(robot, robot->f64, &r, &reply);
    for (size_t k = 0; k < STATES; k++)
        assert_within(robot, "M", asymmetry(a->mass_matrix + k * robot->n * robot->n, robot->n), 0,
                      NULL);
    r.op = TFA_OP_OPERATIONAL_INERTIA;
    two_tips(robot, &r);
    for (uint32_t m = 0; (m = fixture_method(robot, TFA_OP_OPERATIONAL_INERTIA, m)) != NO_METHOD;
         m++) {
        r.method = (tfa_method)m;
        compute_ok(robot, robot->f64, &r, &reply);
        for (size_t k = 0; k < STATES; k++)
            assert_within(robot, tfa_method_name(r.method), asymmetry(a->lambda_inv + 144 * k, 12),
                          2e-11, NULL);
    }
    answers_free(a);
    random_states_free(x);
}

EVERY_ROBOT(matrices_are_symmetric, symmetric, false)

/* ---- another observer ---- */

/* Position x y z and quaternion, seen by an observer turned by `quat` and moved by `shift`. */
static void move_pose(const double quat[4], const double shift[3], double *xyz, double *q)
{
    double spin[4];
    rotate_vector(quat, xyz, xyz);
    for (int i = 0; i < 3; i++) {
        int a = (i + 1) % 3, b = (i + 2) % 3;
        xyz[i] += shift[i];
        spin[i] = quat[3] * q[i] + q[3] * quat[i] + quat[a] * q[b] - quat[b] * q[a];
    }
    spin[3] = quat[3] * q[3] - quat[0] * q[0] - quat[1] * q[1] - quat[2] * q[2];
    memcpy(q, spin, sizeof spin);
}

/* Turns and shifts what stands in the world: the base, or the joints on a fixed root. */
static void move_world(test_robot *robot, random_states *x, const double quat[4],
                       const double shift[3])
{
    tfa_description *d = robot->description;
    rotate_vector(quat, x->gravity, x->gravity);
    if (robot->n > robot->nv) {
        for (int k = 0; k < STATES; k++)
            move_pose(quat, shift, x->base_pose + 7 * k, x->base_pose + 7 * k + 3);
        return;
    }
    const uint32_t root = description_root(d);
    for (size_t j = 0; j < d->joint_count; j++)
        if (d->joints[j].parent == root) {
            move_pose(quat, shift, d->joints[j].xyz, d->joints[j].quat);
            memset(d->joints[j].quat_low, 0, sizeof d->joints[j].quat_low);
        }
}

static double worst_observer;

static void same_for_another_observer(test_robot *robot)
{
    random_source s = {robot->seed};
    random_states *x = fixture_states(robot, 0, STATES, 0);
    answers *a = answers_create(robot, STATES), *b = answers_create(robot, STATES);
    tfa_request r = fixture_request(robot, x);
    tfa_reply reply = answers_reply(a, 0, 0);
    r.gravity = x->gravity; /* it turns with the world */
    r.frame = TFA_FRAME_LOCAL;
    r.tip_count = 1;
    r.tips[0] = robot->description->joints[robot->description->joint_count - 1].child;
    compute_ok(robot, robot->f64, &r, &reply);

    double quat[4], shift[3] = {0.4, -1.2, 0.7};
    random_quaternion(&s, quat);
    move_world(robot, x, quat, shift);
    const tfa_model_options options = fixture_options(robot);
    tfa_model *moved = compiled(robot->description, &options);
    tfa_workspace *w = workspace_for(moved, NULL);
    reply = answers_reply(b, 0, 0);
    compute_ok(robot, w, &r, &reply);
    size_t nv = (size_t)STATES * robot->nv;
    double error = relative_error(b->qdd, a->qdd, nv);
    if (robot->n > robot->nv)
        error += relative_error(b->base_acceleration, a->base_acceleration, 6 * STATES);
    assert_within(robot, "qdd", error, 5e-14, &worst_observer);
    assert_within(robot, "lambda_inv", relative_error(b->lambda_inv, a->lambda_inv, 36 * STATES),
                  5e-14, &worst_observer);
    tfa_workspace_free(w);
    tfa_model_free(moved);
    answers_free(b);
    answers_free(a);
    random_states_free(x);
}

TEST(observers_agree)
{
    for_every_robot(same_for_another_observer, false);
    print_message("  worst difference %.2g\n", worst_observer);
}

/* ---- energy ---- */

/* v^T M v / 2 of state 0 */
static double kinetic_energy(const test_robot *robot, const random_states *x, answers *a)
{
    tfa_request r = fixture_request(robot, x);
    tfa_reply reply = answers_reply(a, 0, 0);
    double T = 0;
    const uint32_t six = robot->n - robot->nv;
    r.op = TFA_OP_MASS_MATRIX;
    compute_ok(robot, robot->f64, &r, &reply);
    for (uint32_t i = 0; i < robot->n; i++)
        for (uint32_t k = 0; k < robot->n; k++)
            T += (i < six ? x->base_twist[i] : x->v[i - six]) * a->mass_matrix[i * robot->n + k] *
                 (k < six ? x->base_twist[k] : x->v[k - six]) / 2;
    return T;
}

/* (tau - g(q) - d) . v with g the forces that hold the robot at rest, d damping and friction */
static double power(const test_robot *robot, const random_states *x, answers *a)
{
    tfa_request r = fixture_request(robot, x);
    tfa_reply reply = answers_reply(a, 0, 0);
    double P = 0;
    r.op = TFA_OP_INVERSE_DYNAMICS;
    r.v = r.qdd = r.base_twist = r.base_acceleration = NULL;
    compute_ok(robot, robot->f64, &r, &reply);
    for (uint32_t k = 0, within; k < robot->nv; k++) {
        const uint32_t joint = oracle_joint_of_freedom(robot->o, k, &within);
        const tfa_joint *j = &robot->description->joints[joint];
        const double v = x->v[k],
                     per_v = j->damping + j->friction / hypot(v, TFA_FRICTION_VELOCITY);
        P += (x->tau[k] - a->tau[k] - (robot->lossy ? per_v * v : 0)) * v;
    }
    for (uint32_t k = 0; k < robot->n - robot->nv; k++)
        P += (x->base_wrench[k] - a->base_wrench[k]) * x->base_twist[k];
    return P;
}

static double worst_power;

static void energy_balances(test_robot *robot)
{
    const double dt = 1e-6;
    double T[2], want;
    random_states *x = fixture_states(robot, 0, 1, 0);
    random_states *y = fixture_states(robot, 0, 1, 0);
    answers *a = answers_create(robot, STATES);
    tfa_request r = fixture_request(robot, x);
    tfa_reply reply = answers_reply(a, 0, 0);
    want = power(robot, x, a);
    compute_ok(robot, robot->f64, &r, &reply);
    for (int side = 0; side < 2; side++) {
        step_state(robot->description, robot->o, x, a->qdd, a->base_acceleration, side ? dt : -dt,
                   y);
        T[side] = kinetic_energy(robot, y, a);
    }
    /* differences of T lose its digits by 1 / dt; their own error goes with (dt qdd)^2 */
    double scale = 1 + fabs(want) + T[0], size = 1 + dt * norm2(a->qdd, robot->nv);
    assert_within(robot, "power", fabs((T[1] - T[0]) / (2 * dt) - want) / scale, 1e-5 * size * size,
                  &worst_power);
    answers_free(a);
    random_states_free(y);
    random_states_free(x);
}

TEST(work_becomes_energy)
{
    for_every_robot(energy_balances, false);
    print_message("  worst imbalance %.2g\n", worst_power);
}

/* Whole turns of a joint change nothing, near the origin and far from it: the angle that is left
 * after as many turns as a double can count. */
TEST(windings_do_not_matter)
{
    static const double turns[] = {1, -3, 1e6, -1e9};
    small_robot robot;
    small_robot_begin(&robot);
    small_robot_add(&robot, 0, TFA_JOINT_CONTINUOUS, 0, 1, 0);
    small_robot_load(&robot, 1, 2, 0.02, 0.03, 0.04);
    robot.link[1].com[0] = 0.3;
    robot.link[1].com[1] = 0.1;
    tfa_model *model = compiled(&robot.d, NULL);
    tfa_workspace *w = workspace_for(model, NULL);
    for (size_t k = 0; k < sizeof turns / sizeof *turns; k++) {
        const double wound = 0.7 + 2 * M_PI * turns[k];
        /* the angle that this double stands for: 2 pi in three parts, in quadruple precision */
        const quad turn =
            (quad)6.283185307179586 + (quad)2.4492935982947064e-16 + (quad)-5.989539619436679e-33;
        const double left = (double)((quad)wound - (quad)turns[k] * turn);
        double qdd[2];
        for (int e = 0; e < 2; e++) {
            tfa_request r = {.op = TFA_OP_FORWARD_DYNAMICS, .count = 1, .q = e ? &left : &wound};
            tfa_reply reply = {.qdd = &qdd[e]};
            assert_int_equal(tfa_compute(w, &r, &reply), TFA_OK);
        }
        assert_true(fabs(qdd[0] - qdd[1]) <= 1e-14 * fabs(qdd[1]));
    }
    tfa_workspace_free(w);
    tfa_model_free(model);
}
