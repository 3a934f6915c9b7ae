/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A pendulum with damping and friction by its formula, tau = I qdd + m g l sin q + d v +
 * f v / sqrt(v^2 + s^2), from rest to speeds at which friction is all but constant, and with a
 * second one that follows the first. (Robots with friction by the oracle: the other laws.)
 */
#include "models.h"
#include "support/small_robot.h"
#include "test.h"

#define MASS 2.0
#define LENGTH 0.5
#define INERTIA 0.3 /* about the centre of mass */
#define G 9.80665
#define DAMPING 0.25
#define FRICTION 1.5
#define TIMES 3.0 /* the second pendulum turns so many times as fast, if there is one */

static const double speeds[] = {0, 1e-300, -1e-12, 1e-6, -0.003, 0.01, 0.02, -0.5, 3, 1e3, -1e9};
#define SPEEDS (sizeof speeds / sizeof *speeds)

/* Turns about y, hangs along -z; the second one hangs from the same root. */
static tfa_model *pendulum(uint32_t links, double friction_velocity)
{
    const tfa_model_options options = {.damping = 1,
                                       .friction = 1,
                                       .friction_velocity = friction_velocity,
                                       .mimic = TFA_MIMIC_PROJECT};
    small_robot r;
    small_robot_begin(&r);
    for (uint32_t k = 0; k < links; k++) {
        tfa_joint *j = small_robot_add(&r, 0, TFA_JOINT_CONTINUOUS, 0, 1, 0);
        small_robot_load(&r, k + 1, MASS, 1, INERTIA, 1);
        r.link[k + 1].com[2] = -LENGTH;
        j->damping = DAMPING;
        j->friction = FRICTION;
        j->mimic = k == 0 ? -1 : 0;
        j->multiplier = k == 0 ? 1 : TIMES;
    }
    return compiled(&r.d, &options);
}

/* Torque of one pendulum at its own q, v, qdd */
static double torque(double q, double v, double qdd, double s)
{
    return (INERTIA + MASS * LENGTH * LENGTH) * qdd + MASS * G * LENGTH * sin(q) + DAMPING * v +
           FRICTION * v / hypot(v, s);
}

/* d torque / dv */
static double slope(double v, double s)
{
    const double size = hypot(v, s);
    return DAMPING + FRICTION * (s / size) * (s / size) / size;
}

static void near(double got, double want, double size, double v)
{
    if (!(fabs(got - want) <= 4e-15 * (fabs(want) + size)))
        fail_msg("at %g rad/s: %.17g, not %.17g", v, got, want);
}

static void check_speed(tfa_workspace *w, uint32_t links, double v, double s)
{
    const double q = 0.7, qdd = -1.3, times = links > 1 ? TIMES : 0;
    const double want =
        torque(q, v, qdd, s) + times * torque(times * q, times * v, times * qdd, s) * (links > 1);
    const double inertia = (INERTIA + MASS * LENGTH * LENGTH) * (1 + times * times);
    const double size = inertia + MASS * G * LENGTH * (1 + times);
    double tau = 0, back = 0, by_v = 0, friction = 0, external = 1;
    tfa_answer answer;
    tfa_request r = {.op = TFA_OP_INVERSE_DYNAMICS, .count = 1, .q = &q, .v = &v, .qdd = &qdd};
    tfa_reply reply = {.tau = &tau};
    assert_int_equal(tfa_compute(w, &r, &reply), TFA_OK);
    near(tau, want, size, v);
    r = (tfa_request){.op = TFA_OP_FORWARD_DYNAMICS,
                      .estimate = TFA_ESTIMATE_ALWAYS,
                      .count = 1,
                      .q = &q,
                      .v = &v,
                      .tau = &tau};
    reply = (tfa_reply){.qdd = &back, .answers = &answer};
    assert_int_equal(tfa_compute(w, &r, &reply), TFA_OK);
    near(back, qdd, (fabs(tau) + size) / inertia, v);
    assert_true(answer.error_estimate >= 0 &&
                answer.error_estimate < 1e-13 * (1 + (fabs(tau) + size) / inertia));
    r = (tfa_request){
        .op = TFA_OP_INVERSE_DYNAMICS_DERIVATIVES, .count = 1, .q = &q, .v = &v, .qdd = &qdd};
    reply = (tfa_reply){.dtau_dv = &by_v};
    assert_int_equal(tfa_compute(w, &r, &reply), TFA_OK);
    near(by_v, slope(v, s) + times * times * slope(times * v, s), 0, v);
    r = (tfa_request){.op = TFA_OP_BIAS, .count = 1, .q = &q, .v = &v};
    reply = (tfa_reply){.friction_force = &friction, .external_force = &external};
    assert_int_equal(tfa_compute(w, &r, &reply), TFA_OK);
    near(friction, FRICTION * (v / hypot(v, s) + times * (times * v) / hypot(times * v, s)), 0, v);
    assert_true(external == 0);
}

TEST(pendulum_by_its_formula)
{
    static const double scales[] = {0, 0.5, 1e-9};
    for (uint32_t links = 1; links <= 2; links++)
        for (size_t k = 0; k < sizeof scales / sizeof *scales; k++) {
            tfa_model *model = pendulum(links, scales[k]);
            tfa_workspace *w = workspace_for(model, NULL);
            assert_int_equal(tfa_model_v_count(model), 1);
            for (size_t i = 0; i < SPEEDS; i++)
                check_speed(w, links, speeds[i], scales[k] > 0 ? scales[k] : TFA_FRICTION_VELOCITY);
            tfa_workspace_free(w);
            tfa_model_free(model);
        }
}
