/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * What divide and conquer and the block Hessenberg matrix lose on chains that are hard for them,
 * against what theory and an independent prototype say they lose: neither more nor much less.
 */
#include "models.h"
#include "support/chains_scan.h"
#include "support/fixture.h"
#include "test.h"

#define SEEDS 5 /* the median of so many */

/* Errors of qdd as tables give them, one seed each: read digits. The chains are not the prototype's
 * to the last link, so that what counts is how many times the articulated-body algorithm's error
 * they are. */
static const struct cell {
    chain_mechanism mechanism;
    uint32_t n;
    double dca, aba;   /* the prototype's (relative 2-norm) */
    double hessenberg; /* times aba's error, as seen here; 0: too long for it */
} cells[] = {
    {CHAIN_RANDOM, 8, 2e-12, 6e-14, 10},      {CHAIN_RANDOM, 128, 9e-8, 2e-10, 10},
    {CHAIN_RANDOM, 1024, 7e-5, 2e-7, 0},      {CHAIN_STRAIGHT, 128, 4e-10, 1e-10, 20},
    {CHAIN_HELIX, 1024, 2e-5, 2e-7, 0},       {CHAIN_HEAVY_TIP, 8, 1e-5, 7e-9, 5e5},
    {CHAIN_ALTERNATING, 128, 15, 2e-10, 7e6}, {CHAIN_THIN, 128, 2e-1, 1e-10, 14},
};
#define CELLS (sizeof cells / sizeof *cells)

static void open_chain(test_robot *robot, const struct cell *c, uint64_t seed)
{
    *robot = (test_robot){.name = "chain"};
    robot->description = chain_create(c->mechanism, c->n, seed);
    robot->model = compiled(robot->description, NULL);
    robot->nv = robot->n = tfa_model_v_count(robot->model);
    robot->f64 = fixture_workspace(robot->model, TFA_F64);
    robot->f128 = fixture_workspace(robot->model, TFA_F128);
}

static void close_chain(test_robot *robot)
{
    tfa_workspace_free(robot->f128);
    tfa_workspace_free(robot->f64);
    tfa_model_free(robot->model);
    chain_free(robot->description);
}

static const tfa_method methods[] = {TFA_METHOD_DCA, TFA_METHOD_HESSENBERG, TFA_METHOD_TFA,
                                     TFA_METHOD_ABA};
enum { DCA, HESSENBERG, TFA, ABA, METHODS };

/* Errors of the methods at rest, the torques those of a random qdd; `service` is the error of the
 * answer when dca is refined once, which may fall back. */
static void measure(const struct cell *c, uint64_t seed, double error[METHODS], double *service)
{
    test_robot robot;
    open_chain(&robot, c, seed);
    double *q = calloc(7 * (size_t)c->n, sizeof *q), *x = calloc(4 * (size_t)c->n, sizeof *x);
    double *tau = x + c->n, *want = tau + c->n, *got = want + c->n;
    random_source s = {seed};
    tfa_request r = {.op = TFA_OP_INVERSE_DYNAMICS, .count = 1, .q = q, .qdd = x, .tau = tau};
    tfa_reply reply = {.tau = tau, .qdd = want};
    chain_coordinates(c->mechanism, robot.description, seed, q);
    for (uint32_t k = 0; k < c->n; k++)
        x[k] = random_uniform(&s, -1, 1);
    compute_ok(&robot, robot.f128, &r, &reply);
    r.op = TFA_OP_FORWARD_DYNAMICS;
    r.method = TFA_METHOD_ABA;
    compute_ok(&robot, robot.f128, &r, &reply);
    reply.qdd = got;
    r.estimate = TFA_ESTIMATE_NEVER;
    for (int m = 0; m < METHODS; m++) {
        r.method = methods[m];
        error[m] = NAN;
        if (m == HESSENBERG && !(c->hessenberg > 0))
            continue;
        compute_ok(&robot, robot.f64, &r, &reply);
        error[m] = relative_error(got, want, c->n);
    }
    r.method = TFA_METHOD_DCA;
    r.refine = 1;
    r.estimate = TFA_ESTIMATE_DEFAULT;
    compute_ok(&robot, robot.f64, &r, &reply);
    *service = relative_error(got, want, c->n);
    free(x);
    free(q);
    close_chain(&robot);
}

static int ascending(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double median(double *x)
{
    qsort(x, SEEDS, sizeof *x, ascending);
    return x[SEEDS / 2];
}

/* Within a factor of 30 of what is known, both ways: a loss that theory predicts is there. */
static void within_digits(const struct cell *c, const char *method, double times, double known)
{
    if (!(times <= 30 * known && times >= known / 30))
        fail_msg("%s %u: %s loses %.1e times what aba loses, %.1e is known",
                 chain_mechanism_names[c->mechanism], (unsigned)c->n, method, times, known);
}

TEST(losses_are_the_known_ones)
{
    print_message("  %-12s %5s %9s %9s %9s %9s %9s\n", "chain", "n", "dca", "hessenb.", "tfa",
                  "aba", "dca, 1x");
    for (size_t k = 0; k < CELLS; k++) {
        const struct cell *c = &cells[k];
        double error[METHODS][SEEDS], refined[SEEDS], each[METHODS], typical[METHODS];
        for (uint32_t seed = 0; seed < SEEDS; seed++) {
            measure(c, seed + 1, each, &refined[seed]);
            for (int m = 0; m < METHODS; m++)
                error[m][seed] = each[m];
        }
        for (int m = 0; m < METHODS; m++)
            typical[m] = median(error[m]);
        const double service = median(refined);
        print_message("  %-12s %5u %9.1e %9.1e %9.1e %9.1e %9.1e\n",
                      chain_mechanism_names[c->mechanism], (unsigned)c->n, typical[DCA],
                      typical[HESSENBERG], typical[TFA], typical[ABA], service);
        within_digits(c, "dca", typical[DCA] / typical[ABA], c->dca / c->aba);
        if (c->hessenberg > 0)
            within_digits(c, "hessenberg", typical[HESSENBERG] / typical[ABA], c->hessenberg);
        /* one step, or the articulated-body algorithm where a step does not converge */
        assert_true(service <= 10 * typical[ABA] + 1e-13);
    }
}
