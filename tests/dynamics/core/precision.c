/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Float alone is as good as float can be; float with a residual in double is as good as double;
 * double with a residual in quadruple precision is as good as the data. On chains, for three right
 * sides.
 */
#include "models.h"
#include "support/chains_scan.h"
#include "support/fixture.h"
#include "test.h"

#define LONGEST 128
#define SEEDS 2

static const struct shape {
    const char *name;
    chain_mechanism mechanism;
    double bend; /* of every joint, left and right in turn; 0: the mechanism's own coordinates */
} shapes[] = {
    {"random", CHAIN_RANDOM, 0},
    {"straight", CHAIN_STRAIGHT, 0},
    {"helix", CHAIN_HELIX, 0},
    {"zigzag", CHAIN_STRAIGHT, 0.5},
};
#define SHAPES (sizeof shapes / sizeof *shapes)

/* torques of random accelerations, with velocities; random torques; gravity alone, at rest */
enum { OF_QDD, TORQUES, GRAVITY, SIDES };
static const char *const side_names[SIDES] = {"qdd", "tau", "gravity"};

/* One chain with a question, its exact answer, and how far the last bits of the question move it */
struct question {
    const struct shape *shape;
    test_robot robot;
    tfa_request r;
    double q[LONGEST], v[LONGEST], tau[LONGEST], want[LONGEST];
    double floor;
};

static const tfa_workspace_options
    f32 = {.precision = TFA_F32, .residual = TFA_RESIDUAL_SAME, .methods = TFA_METHODS_ALL},
    f32_f64 = {.precision = TFA_F32, .residual = TFA_RESIDUAL_F64, .methods = TFA_METHODS_ALL},
    f64 = {.precision = TFA_F64, .residual = TFA_RESIDUAL_SAME, .methods = TFA_METHODS_ALL},
    f64_f128 = {.precision = TFA_F64, .residual = TFA_RESIDUAL_F128, .methods = TFA_METHODS_ALL},
    f128 = {.precision = TFA_F128, .residual = TFA_RESIDUAL_SAME, .methods = TFA_METHODS_ALL};

/* The answer, and its status; TFA_E_NOT_COMPUTED where its estimate is above 1. */
static tfa_answer answer_question(struct question *x, const tfa_workspace_options *options,
                                  const tfa_request *r, double *qdd)
{
    tfa_answer a;
    tfa_reply reply = {.qdd = qdd, .answers = &a};
    tfa_workspace *w = workspace_for(x->robot.model, options);
    const int status = tfa_compute(w, r, &reply);
    tfa_workspace_free(w);
    a.status = status;
    assert_true(status == TFA_OK || (status == TFA_E_NOT_COMPUTED && a.error_estimate > 1));
    return a;
}

static void fill(random_source *s, double *x, uint32_t n, double size)
{
    for (uint32_t k = 0; k < n; k++)
        x[k] = random_uniform(s, -size, size);
}

/* Every number one unit up or down */
static void last_bits(random_source *s, double *x, const double *from, uint32_t n)
{
    for (uint32_t k = 0; k < n; k++)
        x[k] = nextafter(from[k], random_below(s, 2) ? INFINITY : -INFINITY);
}

static void find_floor(struct question *x, random_source *s)
{
    double q[LONGEST], v[LONGEST], tau[LONGEST], moved[LONGEST];
    const uint32_t n = x->robot.n;
    x->floor = 0x1p-53;
    for (int draw = 0; draw < 3; draw++) {
        tfa_request r = x->r;
        last_bits(s, q, x->q, n);
        last_bits(s, v, x->v, n);
        last_bits(s, tau, x->tau, n);
        r.q = q;
        r.v = r.v ? v : NULL;
        r.tau = r.tau ? tau : NULL;
        (void)answer_question(x, &f128, &r, moved);
        x->floor = fmax(x->floor, relative_error(moved, x->want, n));
    }
}

static void ask(struct question *x, const struct shape *shape, uint32_t n, int side, uint64_t seed)
{
    static const double weightless[3] = {0};
    random_source s = {seed};
    *x = (struct question){.shape = shape, .robot = {.name = "chain", .n = n, .nv = n}};
    x->robot.description = chain_create(shape->mechanism, n, seed);
    x->robot.model = compiled(x->robot.description, NULL);
    chain_coordinates(shape->mechanism, x->robot.description, seed, x->q);
    for (uint32_t k = 0; shape->bend > 0 && k < n; k++)
        x->q[k] = k / 2 % 2 ? -shape->bend : shape->bend;
    fill(&s, x->v, n, 0.1);
    fill(&s, x->tau, n, 1);
    x->r = (tfa_request){.op = TFA_OP_FORWARD_DYNAMICS,
                         .method = TFA_METHOD_ABA,
                         .estimate = TFA_ESTIMATE_NEVER,
                         .count = 1,
                         .q = x->q,
                         .v = side == OF_QDD ? x->v : NULL,
                         .tau = side == GRAVITY ? NULL : x->tau,
                         .gravity = side == GRAVITY ? NULL : weightless};
    if (side == OF_QDD) {
        tfa_request inverse = x->r;
        tfa_workspace *w = fixture_workspace(x->robot.model, TFA_F128);
        tfa_reply reply = {.tau = x->tau};
        inverse.op = TFA_OP_INVERSE_DYNAMICS;
        inverse.method = TFA_METHOD_AUTO;
        fill(&s, x->want, n, 1);
        inverse.qdd = x->want;
        compute_ok(&x->robot, w, &inverse, &reply);
        tfa_workspace_free(w);
    }
    (void)answer_question(x, &f128, &x->r, x->want);
    find_floor(x, &s);
}

static void forget(struct question *x)
{
    tfa_model_free(x->robot.model);
    chain_free(x->robot.description);
}

static double error_of(struct question *x, const tfa_workspace_options *options, tfa_method method,
                       uint32_t refine, uint16_t *flags)
{
    double got[LONGEST];
    tfa_request r = x->r;
    r.method = method;
    r.refine = refine;
    if (refine ==
        TFA_REFINE_DEFAULT) /* as a service is asked: too large an estimate is no answer */
        r.estimate = TFA_ESTIMATE_DEFAULT;
    const tfa_answer a = answer_question(x, options, &r, got);
    *flags |= a.flags;
    return relative_error(got, x->want, x->robot.n);
}

/* The root mean square over seeds of the error, of aba's in double, and of the floor */
struct errors {
    double own, aba, floor;
    uint16_t flags;
};

static struct errors measure(const struct shape *shape, uint32_t n, int side,
                             const tfa_workspace_options *options, tfa_method method,
                             uint32_t refine)
{
    struct errors e = {0};
    uint16_t ignored = 0;
    for (uint64_t seed = 1; seed <= SEEDS; seed++) {
        struct question x;
        ask(&x, shape, n, side, seed);
        const double own = error_of(&x, options, method, refine, &e.flags);
        const double aba = error_of(&x, &f64, TFA_METHOD_ABA, 0, &ignored);
        e.own += own * own / SEEDS;
        e.aba += aba * aba / SEEDS;
        e.floor += x.floor * x.floor / SEEDS;
        forget(&x);
    }
    return (struct errors){sqrt(e.own), sqrt(e.aba), sqrt(e.floor), e.flags};
}

/* ---- what each precision promises ---- */

/* `within` times the error of aba in double, the floor (what no answer can be better than), or the
 * unit of a float. Lengths from `shortest` to `longest`, in powers of four. */
struct promise {
    const char *name;
    const tfa_workspace_options *options;
    tfa_method method;
    uint32_t refine, shortest, longest;
    enum { OF_ABA, OF_FLOOR, OF_FLOAT } unit;
    double within;
    uint16_t never; /* flags that no answer has */
    double worst;
};

static const char *const unit_names[] = {"aba's error in f64", "the floor", "2^-23"};

#define FLAGGED (TFA_ANSWER_FALLBACK | TFA_ANSWER_RESIDUAL_PRECISION)
#define BY_DEFAULT TFA_REFINE_DEFAULT

/* The bounds of float alone are ten times the worst seen. */
static struct promise promises[] = {
    {"aba, f32", &f32, TFA_METHOD_ABA, 0, 8, 8, OF_FLOAT, 8e3, FLAGGED, 0},
    {"crba, f32", &f32, TFA_METHOD_CRBA, 0, 8, 8, OF_FLOAT, 9e3, FLAGGED, 0},
    {"tfa, f32", &f32, TFA_METHOD_TFA, 0, 8, 8, OF_FLOAT, 1.2e5, FLAGGED, 0},
    {"tfa-cr, f32", &f32, TFA_METHOD_TFA_CR, 0, 8, 8, OF_FLOAT, 9e4, FLAGGED, 0},
    {"cfa, f32", &f32, TFA_METHOD_CFA, 0, 8, 8, OF_FLOAT, 6e4, FLAGGED, 0},
    {"cfa-cr, f32", &f32, TFA_METHOD_CFA_CR, 0, 8, 8, OF_FLOAT, 8e4, FLAGGED, 0},
    {"dca, f32", &f32, TFA_METHOD_DCA, 0, 8, 8, OF_FLOAT, 1.1e5, FLAGGED, 0},
    /* without kernels in float: doubles answer, and the flags say so */
    {"hessenberg, f32", &f32, TFA_METHOD_HESSENBERG, 0, 8, 8, OF_ABA, 1e4, TFA_ANSWER_FALLBACK, 0},
    {"scan, f32", &f32, TFA_METHOD_SCAN, 0, 8, 8, OF_ABA, 5, TFA_ANSWER_FALLBACK, 0},
    {"aba, f32+f64", &f32_f64, TFA_METHOD_ABA, BY_DEFAULT, 8, 8, OF_ABA, 5, FLAGGED, 0},
    /* four steps of float factors may not be enough there: the residual kernel then answers,
     * and says so */
    {"aba, f32+f64, long", &f32_f64, TFA_METHOD_ABA, BY_DEFAULT, 32, 128, OF_ABA, 5, 0, 0},
    {"scan, f32+f64", &f32_f64, TFA_METHOD_SCAN, BY_DEFAULT, 8, 128, OF_ABA, 10, 0, 0},
    {"tfa, f32+f64", &f32_f64, TFA_METHOD_TFA, BY_DEFAULT, 8, 128, OF_ABA, 5, 0, 0},
    {"aba, f64+f128", &f64_f128, TFA_METHOD_ABA, BY_DEFAULT, 8, 128, OF_FLOOR, 3, FLAGGED, 0},
    {"tfa, f64+f128", &f64_f128, TFA_METHOD_TFA, BY_DEFAULT, 8, 128, OF_FLOOR, 3, FLAGGED, 0},
    {"cfa, f64+f128", &f64_f128, TFA_METHOD_CFA, BY_DEFAULT, 8, 128, OF_FLOOR, 3, FLAGGED, 0},
    {"dca, f64+f128", &f64_f128, TFA_METHOD_DCA, BY_DEFAULT, 8, 128, OF_FLOOR, 3, FLAGGED, 0},
    {"crba, f64+f128", &f64_f128, TFA_METHOD_CRBA, BY_DEFAULT, 8, 128, OF_FLOOR, 3, FLAGGED, 0},
};
#define PROMISES (sizeof promises / sizeof *promises)

static void hold_to(struct promise *p, const struct shape *shape, uint32_t n, int side)
{
    const struct errors e = measure(shape, n, side, p->options, p->method, p->refine);
    const double unit = p->unit == OF_ABA     ? fmax(e.aba, 0x1p-51)
                        : p->unit == OF_FLOOR ? e.floor
                                              : 0x1p-23;
    if (!(e.own <= p->within * unit))
        fail_msg("%s, %u links %s, %s: error %.1e is %.1f times %s", p->name, (unsigned)n,
                 shape->name, side_names[side], e.own, e.own / unit, unit_names[p->unit]);
    if (e.flags & p->never)
        fail_msg("%s, %u links %s, %s: flags %#x", p->name, (unsigned)n, shape->name,
                 side_names[side], (unsigned)e.flags);
    p->worst = fmax(p->worst, e.own / unit);
}

TEST(promises_are_kept)
{
    for (size_t k = 0; k < PROMISES; k++) {
        struct promise *p = &promises[k];
        for (size_t s = 0; s < SHAPES; s++)
            for (uint32_t n = p->shortest; n <= p->longest; n *= 4)
                for (int side = 0; side < SIDES; side++)
                    hold_to(p, &shapes[s], n, side);
        print_message("  %-20s at most %.2g times %s, bound %g\n", p->name, p->worst,
                      unit_names[p->unit], p->within);
    }
}

/* ---- where float is not enough ---- */

/* tfa in float alone is far off; asked for without an estimate it is given as it is. By default,
 * aba answers in float, as good as float can be, or tfa in double, and the flags say so; in a mixed
 * workspace the answer is right. */
TEST(tfa_in_float_is_not_for_long_chains)
{
    for (size_t k = 0; k < SHAPES; k++) {
        const struct errors unestimated = measure(&shapes[k], 128, OF_QDD, &f32, TFA_METHOD_TFA, 0);
        const struct errors mixed =
            measure(&shapes[k], 128, OF_QDD, &f32_f64, TFA_METHOD_TFA, BY_DEFAULT);
        struct question x;
        double own[LONGEST], abas[LONGEST];
        ask(&x, &shapes[k], 128, OF_QDD, 1);
        tfa_request r = x.r;
        r.estimate = TFA_ESTIMATE_DEFAULT;
        r.refine = TFA_REFINE_DEFAULT;
        r.method = TFA_METHOD_TFA;
        const tfa_answer a = answer_question(&x, &f32, &r, own);
        r.method = TFA_METHOD_ABA;
        r.estimate = TFA_ESTIMATE_NEVER;
        (void)answer_question(&x, &f32, &r, abas);
        const double error = relative_error(own, x.want, 128),
                     of_aba = relative_error(abas, x.want, 128);
        print_message("  %-8s tfa in float %.1e; by default %s, %.1e (aba %.1e); mixed %.1e\n",
                      shapes[k].name, unestimated.own, tfa_method_name(a.method), error, of_aba,
                      mixed.own);
        assert_true(unestimated.own > 0.1 && !(unestimated.flags & FLAGGED));
        assert_true(a.flags & TFA_ANSWER_RESIDUAL_PRECISION ||
                    (a.flags & TFA_ANSWER_FALLBACK && a.method != TFA_METHOD_TFA));
        assert_true(a.status != TFA_OK || error <= 5 * of_aba);
        assert_true(mixed.flags & TFA_ANSWER_FALLBACK && mixed.own <= 5 * mixed.aba);
        forget(&x);
    }
}

/* A chain that aba in float cannot answer: the last link weighs 1e6. */
TEST(the_residual_kernel_is_the_last_fallback)
{
    static const struct shape heavy = {"heavy tip", CHAIN_HEAVY_TIP, 0};
    const struct errors e = measure(&heavy, 32, OF_QDD, &f32_f64, TFA_METHOD_ABA, BY_DEFAULT);
    print_message("  error %.1e, aba in f64 %.1e\n", e.own, e.aba);
    assert_true(e.flags & TFA_ANSWER_RESIDUAL_PRECISION && e.flags & TFA_ANSWER_FALLBACK);
    assert_true(e.own <= 1.1 * e.aba);
}

/* Steps that are asked for are made, each for some digits more; without any it is float alone. */
TEST(steps_are_counted)
{
    double before = 1;
    uint16_t ignored = 0;
    struct question x;
    ask(&x, &shapes[0], 32, TORQUES, 1);
    assert_true(error_of(&x, &f32_f64, TFA_METHOD_ABA, 0, &ignored) ==
                error_of(&x, &f32, TFA_METHOD_ABA, 0, &ignored));
    for (uint32_t steps = 0; steps <= TFA_MAX_REFINE; steps++) {
        const double error = error_of(&x, &f32_f64, TFA_METHOD_CRBA, steps, &ignored);
        print_message("  crba, f32+f64, %u steps: %.1e\n", (unsigned)steps, error);
        assert_true(error < before / 5 || error < 1e-15);
        before = error;
    }
    forget(&x);
}

TEST(narrower_residuals_are_refused)
{
    static const struct {
        tfa_workspace_options options;
        int status;
    } cases[] = {
        {{.precision = TFA_F32, .residual = TFA_RESIDUAL_F128, .methods = TFA_METHODS_ALL}, TFA_OK},
        {{.precision = TFA_F64, .residual = TFA_RESIDUAL_F64, .methods = TFA_METHODS_ALL}, TFA_OK},
        {{.precision = TFA_F128, .residual = TFA_RESIDUAL_F128, .methods = TFA_METHODS_ALL},
         TFA_OK},
        {{.precision = TFA_F128, .residual = TFA_RESIDUAL_F64, .methods = TFA_METHODS_ALL},
         TFA_E_UNSUPPORTED},
        {{.precision = TFA_F64, .residual = (tfa_residual)9, .methods = TFA_METHODS_ALL},
         TFA_E_UNSUPPORTED},
        {{.precision = (tfa_precision)9, .residual = TFA_RESIDUAL_SAME, .methods = TFA_METHODS_ALL},
         TFA_E_UNSUPPORTED},
    };
    struct question x;
    ask(&x, &shapes[0], 8, TORQUES, 1);
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        tfa_workspace *w = NULL;
        assert_int_equal(tfa_workspace_create(x.robot.model, &cases[k].options, &w),
                         cases[k].status);
        tfa_workspace_free(w);
    }
    forget(&x);
}

/* ---- what is no solve is the residual kernel's own answer, to the bit ---- */

struct other_answers {
    double tau[LONGEST], M[64 * 64], lambda[12 * 12], poses[14];
    tfa_answer answer[3];
};

static void answer_others(struct question *x, const tfa_workspace_options *options,
                          struct other_answers *out)
{
    tfa_workspace *w = fixture_mixed(x->robot.model, options->precision, options->residual);
    tfa_reply reply = {
        .tau = out->tau, .mass_matrix = out->M, .lambda_inv = out->lambda, .poses = out->poses};
    tfa_request r = x->r;
    memset(out, 0, sizeof *out);
    r.method = TFA_METHOD_AUTO;
    r.qdd = x->want;
    for (int op = TFA_OP_INVERSE_DYNAMICS; op <= TFA_OP_MASS_MATRIX; op++) {
        reply.answers = &out->answer[op - TFA_OP_INVERSE_DYNAMICS];
        r.op = (tfa_op)op;
        r.tip_count = op == TFA_OP_OPERATIONAL_INERTIA ? 2 : 0;
        r.tips[0] = x->robot.n;
        r.tips[1] = x->robot.n / 2;
        r.flags = r.tip_count ? TFA_WANT_POSES : 0;
        compute_ok(&x->robot, w, &r, &reply);
    }
    tfa_workspace_free(w);
}

TEST(the_residual_kernel_answers_all_else)
{
    static struct other_answers mixed, own;
    struct question x;
    ask(&x, &shapes[0], 20, OF_QDD, 1);
    answer_others(&x, &f32_f64, &mixed);
    answer_others(&x, &f64, &own);
    assert_memory_equal(&mixed, &own, sizeof own);
    answer_others(&x, &f64_f128, &mixed);
    answer_others(&x, &f128, &own);
    assert_memory_equal(&mixed, &own, sizeof own);
    forget(&x);
}
