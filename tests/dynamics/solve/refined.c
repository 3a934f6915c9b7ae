/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * One refinement step makes no answer worse: for every method of forward dynamics, with the
 * segments of a long chain in lanes and row by row, on every mechanism. Nor does it lose more
 * than the same step by a request of inverse dynamics. The truth is aba in quadruple precision.
 *
 *     test_refined [SEEDS]
 */
#include "mechanism/mechanism.h"
#include "models.h"
#include "support/fixture.h"
#include "test.h"

/* A refined error may be so many bare ones and floors (find_truth), and what rounding of one number
 * adds. */
#define WORSE 3
#define ROUNDING 1e-14
/* The same step by requests of inverse dynamics and of the method loses the same, but for luck. */
#define LUCK 20
/* A method whose error with torques of a random qdd is larger has lost a direction in its factors.
 * A step with them adds their error of what rounding leaves in the residual, whatever the residual
 * is. */
#define LOST 1e-1

/* By default the library looks for a spoilt answer above this only (dynamics/solve/answer.h). */
#define NO_BETTER 1e-13
/* A bare answer with a larger error is none. */
#define LOST_HERE 1e-1

enum { SIDE_QDD, SIDE_TAU, SIDE_GRAVITY, SIDES };
static const char *const side_names[SIDES] = {"qdd", "tau", "gravity"};
enum { BY_DEFAULT, BY_ROWS, WAYS, METHODS = 32, PARTITION_FROM = 48 };
static const char *const way_names[WAYS] = {"", ", row by row"};

typedef struct test_case {
    mechanism_options options;
    test_robot robot;
    double *q, *v, *zero, *tau, *want, *unestimated, *refined, *by_hand;
    double floor;
} test_case;

static uint64_t seeds;
static uint64_t asked, lost_answers, kept_worse;
static double worst, worst_by_hand;

static void test_case_open(test_case *x, mechanism_options options)
{
    const tfa_model_options model = {.base = TFA_BASE_FIXED};
    const tfa_workspace_options quad = {.precision = TFA_F128};
    const tfa_workspace_options all = {.methods = TFA_METHODS_ALL};
    *x = (test_case){.options = options};
    test_robot *r = &x->robot;
    r->description = mechanism_make(&options);
    assert_non_null(r->description);
    r->model = compiled(r->description, &model);
    r->f64 = workspace_for(r->model, &all);
    r->f128 = workspace_for(r->model, &quad);
    snprintf(r->name, sizeof r->name, "%s -n %u -m %.0e -s %u", mechanism_name(options.kind),
             (unsigned)options.bodies, options.ratio, (unsigned)options.seed);
    const uint32_t n = r->nv = tfa_model_v_count(r->model);
    assert_int_equal(tfa_model_q_count(r->model), n);
    x->q = calloc((size_t)8 * n, sizeof *x->q);
    assert_non_null(x->q);
    x->v = x->q + n;
    x->zero = x->v + n;
    x->tau = x->zero + n;
    x->want = x->tau + n;
    x->unestimated = x->want + n;
    x->refined = x->unestimated + n;
    x->by_hand = x->refined + n;
}

static void test_case_close(test_case *x)
{
    free(x->q);
    tfa_workspace_free(x->robot.f128);
    tfa_workspace_free(x->robot.f64);
    tfa_model_free(x->robot.model);
    mechanism_free(x->robot.description);
}

/* At q = 0 a mechanism is what its name says. */
static tfa_request draw(test_case *x, int side)
{
    tfa_request r = {.op = TFA_OP_FORWARD_DYNAMICS,
                     .estimate = TFA_ESTIMATE_NEVER,
                     .count = 1,
                     .q = x->q,
                     .v = side == SIDE_GRAVITY ? x->zero : x->v,
                     .tau = side == SIDE_GRAVITY ? x->zero : x->tau};
    uint64_t s = x->options.seed + 100;
    for (uint32_t k = 0; k < x->robot.nv; k++) {
        x->q[k] = mechanism_random_uniform(&s, -1e-3, 1e-3);
        x->v[k] = mechanism_random_normal(&s);
        x->tau[k] = mechanism_random_normal(&s);
        x->want[k] = mechanism_random_normal(&s);
    }
    if (side == SIDE_QDD) {
        tfa_request inverse = r;
        tfa_reply reply = {.tau = x->tau};
        inverse.op = TFA_OP_INVERSE_DYNAMICS;
        inverse.tau = NULL;
        inverse.qdd = x->want;
        compute_ok(&x->robot, x->robot.f128, &inverse, &reply);
    }
    return r;
}

/* dqdd = M^-1 (tau - RNEA(qdd)), inverse dynamics in double, the solution by `w` */
static void correct(test_case *x, tfa_request r, tfa_workspace *w, const double *qdd, double *dqdd)
{
    static const double weightless[3];
    tfa_request inverse = r;
    tfa_reply reply = {.tau = dqdd};
    inverse.op = TFA_OP_INVERSE_DYNAMICS;
    inverse.method = TFA_METHOD_AUTO;
    inverse.tau = NULL;
    inverse.qdd = qdd;
    compute_ok(&x->robot, x->robot.f64, &inverse, &reply);
    for (uint32_t k = 0; k < x->robot.nv; k++)
        dqdd[k] = r.tau[k] - dqdd[k];
    r.tau = dqdd;
    r.v = NULL;
    r.gravity = weightless;
    reply = (tfa_reply){.qdd = dqdd};
    compute_ok(&x->robot, w, &r, &reply);
}

static double error_of_sum(test_case *x, const double *qdd, double *dqdd)
{
    for (uint32_t k = 0; k < x->robot.nv; k++)
        dqdd[k] += qdd[k];
    return relative_error(dqdd, x->want, x->robot.nv);
}

/* The truth, and what the rounding of inverse dynamics in double does to it */
static void find_truth(test_case *x, tfa_request r)
{
    tfa_reply reply = {.qdd = x->want};
    r.method = TFA_METHOD_ABA;
    compute_ok(&x->robot, x->robot.f128, &r, &reply);
    correct(x, r, x->robot.f128, x->want, x->unestimated);
    x->floor = error_of_sum(x, x->want, x->unestimated);
}

static tfa_answer last_answer;

/* The error of an answer; -1: the method refuses the robot */
static double error_of(test_case *x, tfa_request r, uint32_t refine, double *qdd)
{
    tfa_reply reply = {.qdd = qdd, .answers = &last_answer};
    r.refine = refine;
    const int status = tfa_compute(x->robot.f64, &r, &reply);
    if (status == TFA_E_METHOD || status == TFA_E_SINGULAR || status == TFA_E_UNSUPPORTED)
        return -1;
    return status == TFA_OK ? relative_error(qdd, x->want, x->robot.nv) : INFINITY;
}

static void hold(const test_case *x, const tfa_request *r, int side, const char *what,
                 double unestimated, double refined, double bound)
{
    if (!(refined <= bound))
        fail_msg("%s, %s, %s%s: bare %.2g, refined %.2g, %s allows %.2g", x->robot.name,
                 side_names[side], tfa_method_name((uint32_t)r->method), way_names[r->wrench_count],
                 unestimated, refined, what, bound);
}

static int is_cyclic(tfa_method method)
{
    return method == TFA_METHOD_TFA_CR || method == TFA_METHOD_CFA_CR;
}

/* By default, and estimated after one step, an answer is no worse than the bare one, also by
 * factors that have lost a direction; after two no worse than that or its estimate. Or another
 * method answers, or it is refused. */
static void compare_estimated(test_case *x, tfa_request r, int side, double unestimated)
{
    static const struct {
        tfa_estimate estimate;
        uint32_t refine;
    } rows[] = {{TFA_ESTIMATE_DEFAULT, TFA_REFINE_DEFAULT},
                {TFA_ESTIMATE_ALWAYS, 1},
                {TFA_ESTIMATE_ALWAYS, 2}};
    const double bound = WORSE * (unestimated + x->floor) + NO_BETTER;
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
        r.estimate = rows[k].estimate;
        const double answer = error_of(x, r, rows[k].refine, x->refined);
        if (answer <= 1 && last_answer.method == r.method)
            hold(x, &r, side, "the bare answer, estimated,", unestimated, answer,
                 k < 2 ? bound : fmax(bound, last_answer.error_estimate));
    }
}

/* Is a refined answer no worse than the bare one, and by cyclic reduction as good as a step by
 * hand? *lost: no step of this method is any good; decided by torques of a random qdd, which come
 * first. */
static void compare(test_case *x, tfa_request r, int side, int *lost)
{
    const double unestimated = error_of(x, r, 0, x->unestimated);
    if (unestimated < 0)
        return;
    const double refined = error_of(x, r, 1, x->refined);
    kept_worse += isfinite(unestimated) && refined > 100 * unestimated + NO_BETTER;
    correct(x, r, x->robot.f64, x->unestimated, x->by_hand); /* by the same segments or rows */
    const double by_hand = error_of_sum(x, x->unestimated, x->by_hand);
    const double bound = WORSE * (unestimated + x->floor) + ROUNDING,
                 other = LUCK * (by_hand + x->floor) + ROUNDING;
    asked++;
    if (unestimated <= LOST_HERE)
        compare_estimated(x, r, side, unestimated);
    if (side == SIDE_QDD)
        *lost = !(unestimated <= LOST);
    lost_answers += (uint64_t)*lost;
    if (!*lost) {
        worst = fmax(worst, refined / bound);
        hold(x, &r, side, "the bare answer", unestimated, refined, bound);
    }
    if (is_cyclic(r.method) && isfinite(by_hand)) {
        worst_by_hand = fmax(worst_by_hand, refined / other);
        hold(x, &r, side, "inverse dynamics", unestimated, refined,
             *lost ? other : fmax(other, bound));
    }
}

/* Methods that are there for long chains, and quick there */
static int is_long(uint32_t method)
{
    return method == TFA_METHOD_ABA || method == TFA_METHOD_TFA || method == TFA_METHOD_SCAN ||
           is_cyclic((tfa_method)method);
}

static void every_method(mechanism_options options)
{
    static const double none[6];
    int lost[METHODS][WAYS] = {0};
    test_case x;
    test_case_open(&x, options);
    for (int side = 0; side < SIDES; side++) {
        const tfa_request asked_for = draw(&x, side);
        find_truth(&x, asked_for);
        for (uint32_t m = TFA_METHOD_AUTO + 1; tfa_method_describe(m); m++) {
            if (!tfa_method_describe(m)->forward_dynamics || (options.bodies > 128 && !is_long(m)))
                continue;
            tfa_request r = asked_for;
            r.method = (tfa_method)m;
            compare(&x, r, side, &lost[m][BY_DEFAULT]);
            r.wrench_count = 1; /* one that is zero leaves a long chain to the rows */
            r.wrenches = none;
            if (options.bodies >= PARTITION_FROM)
                compare(&x, r, side, &lost[m][BY_ROWS]);
        }
    }
    test_case_close(&x);
}

/* What the atlas varies, beside its defaults */
static void harder(mechanism_options o)
{
    static const double ratios[] = {1e3, 1e10, 1e12};
    for (size_t k = 0; k < 3; k++) {
        o.ratio = ratios[k];
        o.taper = o.kind == MECHANISM_TAPER ? 1 / ratios[k] : o.taper;
        o.radius = o.kind == MECHANISM_THIN ? pow(ratios[k], -0.5) : o.radius;
        o.curl = o.kind == MECHANISM_HELIX ? 0.5 * (double)k : o.curl;
        every_method(o);
    }
}

static int is_varied(int kind)
{
    return kind == MECHANISM_ALTERNATING || kind == MECHANISM_HEAVY_TIP ||
           kind == MECHANISM_LIGHT_HEAVY || kind == MECHANISM_THIN || kind == MECHANISM_TAPER ||
           kind == MECHANISM_HELIX;
}

TEST(refined_is_no_worse)
{
    static const uint32_t sizes[] = {8, 47, 48, 64, 128, 1000};
    for (uint64_t seed = 1; seed <= seeds; seed++)
        for (int kind = 0; kind < MECHANISM_COUNT; kind++)
            for (size_t n = 0; n < sizeof sizes / sizeof *sizes; n++) {
                if (test_extent(1, 0) && (n + (size_t)kind) % 2)
                    continue;
                mechanism_options o = mechanism_defaults((mechanism_kind)kind, sizes[n]);
                o.seed = 100 + seed;
                every_method(o);
                if (is_varied(kind))
                    harder(o);
            }
    print_message(
        "  %llu answers, %llu by lost factors; worst %.2g of the bound, %.2g of that by inverse "
        "dynamics; %llu a hundred times worse, without estimate\n",
        (unsigned long long)asked, (unsigned long long)lost_answers, worst, worst_by_hand,
        (unsigned long long)kept_worse);
    assert_true(kept_worse > 0); /* as docs/methods.md says of `never` */
}

int main(int argc, char **argv)
{
    seeds = argc > 1 ? strtoull(argv[1], NULL, 10) : test_extent(1, 2);
    return test_run(NULL, NULL);
}
