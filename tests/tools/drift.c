/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * `totalforce drift`: the integrators have their orders, a pendulum its period and its energy, the
 * line of aba in double lies on that of quadruple precision, and a sign that is wrong shows.
 */
#include "drift/drift.h"
#include "test.h"

#include <math.h>

static int oscillate(void *context, const double *q, const double *v, double *a)
{
    const double *sign = context;
    (void)v;
    a[0] = *sign * q[0];
    return TFA_OK;
}

/* Error of cos t after 2 s */
static double error_of(drift_integrator integrator, int steps)
{
    double q = 1.0, v = 0.0, sign = -1.0, scratch[DRIFT_SCRATCH];
    const drift_system system = {
        .n = 1, .accelerate = oscillate, .context = &sign, .scratch = scratch};
    for (int k = 0; k < steps; k++)
        assert_int_equal(drift_step(integrator, &system, 2.0 / steps, &q, &v), TFA_OK);
    return hypot(q - cos(2.0), v + sin(2.0));
}

TEST(integrators_have_their_orders)
{
    static const double orders[DRIFT_INTEGRATOR_COUNT] = {1.0, 4.0, 8.0};
    for (int k = 0; k < DRIFT_INTEGRATOR_COUNT; k++) {
        const drift_integrator integrator = (drift_integrator)k;
        const int steps = integrator == DRIFT_GBS8 ? 4 : 32;
        const double order = log2(error_of(integrator, steps) / error_of(integrator, 2 * steps));
        print_message("%s: order %.2f\n", drift_integrator_words[k], order);
        assert_true(fabs(order - orders[k]) < 0.5);
    }
}

static drift_options options_of(drift_integrator integrator, double step, double seconds)
{
    drift_options o = {.bodies = 1,
                       .target = {.label = "straight", .kind = MECHANISM_STRAIGHT},
                       .methods = {TFA_METHOD_ABA},
                       .method_count = 1,
                       .precisions = {CHART_F64},
                       .precision_count = 1,
                       .steps = {step},
                       .step_count = 1,
                       .integrator = integrator,
                       .samples = 10,
                       .seconds = seconds,
                       .turn = 1.0,
                       .seed = 3};
    return o;
}

/* A rod of 1 kg and 1 m, radius 0.1 m, on a joint across it: E = I w^2 / 2 + m g cos(q) / 2. */
#define WEIGHT 9.80665
#define INERTIA (1.0 / 3.0 + 0.25 * 0.01)

TEST(a_pendulum_has_its_energy_and_its_period)
{
    const drift_options o = options_of(DRIFT_GBS8, 1e-3, 1.0);
    drift_case c;
    double energy[2];
    assert_int_equal(drift_case_open(&c, &o), TFA_OK);
    const double q = 0.7, v = -1.3;
    assert_int_equal(drift_energy(&c, &q, &v, energy), TFA_OK);
    print_message("%.17g %.17g\n", energy[0], energy[1]);
    assert_true(fabs(energy[0] - 0.5 * INERTIA * v * v) < 1e-14);
    assert_true(fabs(energy[1] - 0.5 * WEIGHT * cos(q)) < 1e-14);
    assert_true(fabs(c.scale - 0.5 * WEIGHT) < 1e-14);

    /* released at an angle of 1 from straight down: T = 2 pi / (w0 agm(1, cos(1 / 2))), Gauss */
    double a = 1.0, b = cos(0.5);
    for (int k = 0; k < 6; k++) {
        const double mean = 0.5 * (a + b);
        b = sqrt(a * b);
        a = mean;
    }
    const double period = 2.0 * M_PI / (sqrt(0.5 * WEIGHT / INERTIA) * a);
    drift_options swing = options_of(DRIFT_GBS8, period / 1000, period);
    drift_line line = {.choice = {.method = TFA_METHOD_ABA}, .step = period / 1000};
    c.start[0] = M_PI - 1.0;
    c.energy = 0.5 * WEIGHT * cos(c.start[0]);
    swing.samples = 2;
    assert_int_equal(drift_run(&line, &c, &swing, NULL, NULL), TFA_OK);
    assert_int_equal(line.count, 2);
    assert_true(drift_largest(&line, 2) < 1e-14);
    drift_line_free(&line);
    drift_case_close(&c);
}

/* Largest errors of aba in double and of the floor */
static void lines_of(const drift_options *o, double *largest, double *floor)
{
    drift_case c;
    assert_int_equal(drift_case_open(&c, o), TFA_OK);
    for (int exact = 0; exact < 2; exact++) {
        drift_line line = {
            .choice = {.method = TFA_METHOD_ABA}, .step = o->steps[0], .floor = exact};
        assert_int_equal(drift_run(&line, &c, o, NULL, NULL), TFA_OK);
        assert_int_equal(line.status, TFA_OK);
        *(exact ? floor : largest) = drift_largest(&line, line.count);
        drift_line_free(&line);
    }
    drift_case_close(&c);
    print_message("aba %.1e, floor %.1e\n", *largest, *floor);
}

TEST(aba_in_double_drifts_as_the_integrator)
{
    double largest, floor;
    drift_options o = options_of(DRIFT_RK4, 1e-3, 1.0);
    o.bodies = 4;
    o.target = (chart_target){.label = "random", .kind = MECHANISM_RANDOM};
    lines_of(&o, &largest, &floor);
    assert_true(floor > 1e-14 && largest < 1.01 * floor && largest > 0.99 * floor);
    o.integrator = DRIFT_GBS8;
    lines_of(&o, &largest, &floor);
    assert_true(floor < 1e-13 && largest < 10.0 * floor + 1e-14);
}

/* aba with torques where there are none: velocity products with the wrong sign look like that */
static int wrong_sign(void *context, const double *q, const double *v, double *a)
{
    const drift_case *c = context;
    tfa_answer answer;
    double reversed[8];
    for (uint32_t k = 0; k < c->n; k++)
        reversed[k] = k == 0 ? -v[k] : v[k];
    const tfa_request request = {
        .op = TFA_OP_FORWARD_DYNAMICS, .method = TFA_METHOD_ABA, .count = 1, .q = q, .v = reversed};
    tfa_reply reply = {.qdd = a, .answers = &answer};
    return tfa_compute(c->chart.f64, &request, &reply);
}

TEST(a_wrong_sign_shows)
{
    drift_options o = options_of(DRIFT_GBS8, 1e-3, 1.0);
    drift_case c;
    o.bodies = 4;
    o.target = (chart_target){.label = "random", .kind = MECHANISM_RANDOM};
    assert_int_equal(drift_case_open(&c, &o), TFA_OK);
    drift_line line = {.choice = {.method = TFA_METHOD_ABA}, .step = 1e-3};
    assert_int_equal(drift_run(&line, &c, &o, wrong_sign, &c), TFA_OK);
    print_message("wrong sign: %.1e\n", drift_largest(&line, line.count));
    assert_true(drift_largest(&line, line.count) > 1e-3);
    drift_line_free(&line);
    drift_case_close(&c);
}

TEST(a_method_that_fails_ends_its_line)
{
    drift_options o = options_of(DRIFT_RK4, 1e-3, 0.1);
    drift_case c;
    o.bodies = 5;
    o.target = (chart_target){.label = "rank-deficient", .kind = MECHANISM_RANK_DEFICIENT};
    assert_int_equal(drift_case_open(&c, &o), TFA_OK);
    drift_line line = {.choice = {.method = TFA_METHOD_TFA}, .step = 1e-3};
    assert_int_equal(drift_run(&line, &c, &o, NULL, NULL), TFA_OK);
    assert_int_equal(line.status, TFA_E_SINGULAR);
    assert_int_equal(line.count, 0);
    drift_line_free(&line);
    drift_case_close(&c);
}
