/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Derivatives and Lambda^-1 of bodies that are light beside what they hang from: wrong answers have
 * a word. The truth is quadruple precision.
 */
#include <math.h>

#include "dynamics/derivatives/differences.h"
#include "support/fixture.h"
#include "support/hard_robot.h"
#include "test.h"

#define RIGHT 1e-6 /* unflagged answers, relative to the largest entry */
#define BODIES 20
#define NUMBERS (BODIES + 6)
#define TIPS 2

/* Chains and trees of 1 to BODIES bodies of about 1 kg; what a family draws, log-uniformly */
static const struct family {
    const char *name;
    double lever[2];  /* m, to the next joint */
    double radius[2]; /* m, of gyration */
    double ratio[2];  /* of masses: some bodies weigh so much more */
    double taper;     /* mass of the last body over that of the first */
    int flagged;      /* 1: some derivatives are, 0: none is, -1: either */
} families[] = {
    {"robots", {0.1, 1}, {0.03, 0.1}, {1, 1}, 1, 0},
    {"levers", {1e4, 1e6}, {0.05, 0.1}, {1, 1}, 1, 1},
    {"points", {0.1, 1}, {1e-15, 1e-6}, {1, 1}, 1, -1},
    {"masses", {0.1, 1}, {0.01, 0.1}, {1e6, 1e13}, 1, 1},
    {"mixed", {1, 1e5}, {1e-9, 0.1}, {1, 1e12}, 1, 1},
    {"taper", {0.1, 1}, {0.03, 0.1}, {1, 1}, 1e-13, -1},
};
#define FAMILIES (sizeof families / sizeof *families)

static uint32_t flagged[FAMILIES], answered[FAMILIES], estimated, wrong;
static double worst[FAMILIES];

static double draw(random_source *s, const double range[2])
{
    return exp(random_uniform(s, log(range[0]), log(range[1])));
}

static int add_body(char *text, size_t size, const struct family *f, random_source *s, uint32_t i,
                    uint32_t parent, double mass)
{
    const double radius = draw(s, f->radius), I = mass * radius * radius, lever = draw(s, f->lever);
    double at[3], length = 0;
    for (int k = 0; k < 3; k++) {
        at[k] = random_uniform(s, -1, 1);
        length += at[k] * at[k];
    }
    for (int k = 0; k < 3; k++)
        at[k] *= lever / sqrt(length);
    return snprintf(text, size,
                    "<link name='l%u'><inertial><origin xyz='%.17g %.17g %.17g'/><mass "
                    "value='%.17g'/><inertia ixx='%.17g' iyy='%.17g' izz='%.17g' ixy='0' ixz='0' "
                    "iyz='0'/></inertial></link><joint name='j%u' type='continuous'><parent "
                    "link='l%u'/><child link='l%u'/><axis xyz='%s'/><origin xyz='%.17g %.17g "
                    "%.17g'/></joint>",
                    (unsigned)i, random_uniform(s, -0.1, 0.1), random_uniform(s, -0.1, 0.1),
                    random_uniform(s, -0.1, 0.1), mass, I, I, I, (unsigned)i, (unsigned)parent,
                    (unsigned)i, (const char *[]){"1 0 0", "0 1 0", "0 0 1"}[random_below(s, 3)],
                    at[0], at[1], at[2]);
}

static void open_robot(const struct family *f, random_source *s, hard_robot *robot)
{
    static char text[BODIES * 800];
    const uint32_t bodies = 1 + random_below(s, BODIES), tree = random_below(s, 2);
    const double ratio = draw(s, f->ratio);
    size_t at = (size_t)snprintf(text, sizeof text,
                                 "<robot name='r'><link name='l0'><inertial><mass value='1'/>"
                                 "<inertia ixx='1' iyy='1' izz='1' ixy='0' ixz='0' iyz='0'/>"
                                 "</inertial></link>");
    for (uint32_t i = 1; i <= bodies; i++) {
        const double mass = random_uniform(s, 0.5, 2) * (random_below(s, 2) ? ratio : 1) *
                            pow(f->taper, (double)i / bodies);
        at += (size_t)add_body(text + at, sizeof text - at, f, s, i,
                               tree ? random_below(s, i) : i - 1, mass);
    }
    snprintf(text + at, sizeof text - at, "</robot>");
    hard_robot_urdf(text, random_below(s, 3) ? TFA_BASE_FIXED : TFA_BASE_FLOATING, robot);
    snprintf(robot->name, sizeof robot->name, "%s, %u bodies, %s, %s base", f->name,
             (unsigned)bodies, tree ? "tree" : "chain", robot->six ? "floating" : "fixed");
}

/* ---- derivatives ---- */

struct derivatives {
    double dq[NUMBERS * NUMBERS], dv[NUMBERS * NUMBERS], dtau[NUMBERS * NUMBERS];
};

static int differentiate(tfa_workspace *w, const tfa_request *r, struct derivatives *d,
                         tfa_answer *a)
{
    tfa_reply reply = {.dqdd_dq = d->dq, .dqdd_dv = d->dv, .dqdd_dtau = d->dtau, .answers = a};
    return tfa_compute(w, r, &reply);
}

static double derivative_error(const hard_robot *robot, const tfa_request *r, difference_by by,
                               double *got, const double *want)
{
    const uint32_t n = robot->nv + robot->six;
    const difference_robot quad = {robot->name, robot->model, robot->f128,
                                   n,           robot->six,   tfa_model_q_count(robot->model),
                                   robot->nv};
    const double size = difference_size(&quad, r, by, want);
    for (uint32_t e = 0; e < n * n; e++)
        got[e] -= want[e];
    return difference_largest(got, (size_t)n * n) / size;
}

static void check_derivatives(const hard_robot *robot, size_t family)
{
    static struct derivatives want, got;
    tfa_request r = hard_robot_request(robot, HARD_TAU);
    tfa_answer a;
    r.op = TFA_OP_DERIVATIVES;
    if (differentiate(robot->f128, &r, &want, &a) != TFA_OK ||
        differentiate(robot->f64, &r, &got, &a) != TFA_OK)
        return;
    answered[family]++;
    if (a.flags & TFA_ANSWER_SENTINEL) {
        flagged[family]++;
        assert_true(isnan(a.error_estimate) && !(a.flags & TFA_ANSWER_ESTIMATED));
        return;
    }
    const double error = fmax(derivative_error(robot, &r, BY_Q, got.dq, want.dq),
                              fmax(derivative_error(robot, &r, BY_V, got.dv, want.dv),
                                   derivative_error(robot, &r, BY_TAU, got.dtau, want.dtau)));
    worst[family] = fmax(worst[family], error);
    if (error <= RIGHT)
        return;
    wrong++;
    print_message("  %s: derivatives wrong by %.2g without a word\n", robot->name, error);
}

/* ---- Lambda^-1 ---- */

static void check_lambda(const hard_robot *robot, random_source *s)
{
    static const tfa_method methods[] = {TFA_METHOD_AUTO, TFA_METHOD_PV_OSIMR, TFA_METHOD_CRBA,
                                         TFA_METHOD_TFA, TFA_METHOD_DCA};
    static double want[36 * TIPS * TIPS], got[36 * TIPS * TIPS];
    tfa_request r = hard_robot_request(robot, HARD_GRAVITY);
    tfa_answer a;
    tfa_reply reply = {.lambda_inv = want, .answers = &a};
    r.op = TFA_OP_OPERATIONAL_INERTIA;
    r.tip_count = 1 + random_below(s, TIPS);
    r.tips[0] = tfa_model_frame_count(robot->model) - 1;
    r.tips[1] = random_below(s, r.tips[0]);
    if (tfa_compute(robot->f128, &r, &reply) != TFA_OK)
        return;
    reply.lambda_inv = got;
    for (size_t k = 0; k < 2 * sizeof methods / sizeof *methods; k++) {
        r.method = methods[k / 2];
        r.estimate = k % 2 ? TFA_ESTIMATE_ALWAYS : TFA_ESTIMATE_DEFAULT;
        if (tfa_compute(robot->f64, &r, &reply) != TFA_OK)
            continue;
        const double error = relative_error(got, want, (size_t)36 * r.tip_count * r.tip_count);
        const int has_estimate = a.flags & TFA_ANSWER_ESTIMATED;
        estimated += has_estimate != 0;
        if (error <= (has_estimate ? fmax(1e-14, 30 * a.error_estimate) : RIGHT))
            continue;
        wrong++;
        print_message("  %s: lambda_inv by %s wrong by %.2g, estimate %.2g\n", robot->name,
                      tfa_method_name((uint32_t)r.method), error, a.error_estimate);
    }
}

TEST(light_bodies_have_a_word)
{
    static hard_robot robot;
    for (size_t f = 0; f < FAMILIES; f++) {
        random_source s = {f};
        for (uint32_t k = 0; k < test_extent(100, 3000); k++) {
            open_robot(&families[f], &s, &robot);
            hard_robot_draw(&robot, &s, HARD_TAU);
            check_derivatives(&robot, f);
            check_lambda(&robot, &s);
            hard_robot_close(&robot);
        }
        print_message("  %s: derivatives of %u robots, %u flagged, others wrong by %.1e at most\n",
                      families[f].name, answered[f], flagged[f], worst[f]);
        if (families[f].flagged >= 0)
            assert_int_equal(flagged[f] > 0, families[f].flagged);
    }
    print_message("  %u estimates of lambda_inv\n", estimated);
    assert_int_equal(wrong, 0);
}

TEST(requests_without_estimates_have_no_flag)
{
    static hard_robot robot;
    static struct derivatives d;
    random_source s = {1};
    tfa_answer a;
    open_robot(&families[1], &s, &robot);
    hard_robot_draw(&robot, &s, HARD_TAU);
    tfa_request r = hard_robot_request(&robot, HARD_TAU);
    r.op = TFA_OP_DERIVATIVES;
    r.estimate = TFA_ESTIMATE_NEVER;
    assert_int_equal(differentiate(robot.f64, &r, &d, &a), TFA_OK);
    assert_int_equal(a.flags, 0);
    hard_robot_close(&robot);
}
