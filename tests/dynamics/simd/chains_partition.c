/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Cyclic reduction of long revolute chains with their partitions in lanes: the answers of the same
 * methods row by row, the same bits on any number of threads, refinement, estimates, and what is
 * left to the other way.
 */
#include "models.h"
#include "support/chains_scan.h"
#include "support/fixture.h"
#include "test.h"

#define STATES 3

/* A chain, `STATES` states, and storage for answers */
struct bench {
    test_robot robot;
    size_t n;
    double *q, *v, *tau, *want, *lu, *row, *got;
};

static void open_bench(struct bench *b, chain_mechanism mechanism, uint32_t n, double damping)
{
    random_source s = {n};
    *b = (struct bench){.robot = {.description = chain_create(mechanism, n, n)}, .n = n};
    snprintf(b->robot.name, sizeof b->robot.name, "%s %u", chain_mechanism_names[mechanism],
             (unsigned)n);
    for (uint32_t k = 0; k < n; k++)
        b->robot.description->joints[k].damping = damping;
    const tfa_model_options options = {.damping = damping > 0};
    b->robot.model = compiled(b->robot.description, &options);
    b->robot.n = b->robot.nv = tfa_model_v_count(b->robot.model);
    b->robot.f64 = fixture_workspace(b->robot.model, TFA_F64);
    b->robot.f128 = fixture_workspace(b->robot.model, TFA_F128);
    b->q = calloc((3 * STATES + 4) * b->n, sizeof *b->q);
    b->v = b->q + STATES * b->n;
    b->tau = b->v + STATES * b->n;
    b->want = b->tau + STATES * b->n;
    b->lu = b->want + b->n;
    b->row = b->lu + b->n;
    b->got = b->row + b->n;
    for (size_t k = 0; k < 3 * STATES * b->n; k++)
        b->q[k] = random_uniform(&s, -1, 1);
}

static void close_bench(struct bench *b)
{
    tfa_workspace_free(b->robot.f128);
    tfa_workspace_free(b->robot.f64);
    tfa_model_free(b->robot.model);
    chain_free(b->robot.description);
    free(b->q);
}

static tfa_request request_of(const struct bench *b, size_t state, int moving)
{
    return (tfa_request){.op = TFA_OP_FORWARD_DYNAMICS,
                         .estimate = TFA_ESTIMATE_NEVER,
                         .count = 1,
                         .q = b->q + state * b->n,
                         .v = moving ? b->v + state * b->n : NULL,
                         .tau = b->tau + state * b->n};
}

static tfa_answer ask(struct bench *b, tfa_workspace *w, tfa_request r, tfa_method method,
                      double *qdd)
{
    tfa_answer answer;
    tfa_reply reply = {.qdd = qdd, .answers = &answer};
    r.method = method;
    compute_ok(&b->robot, w, &r, &reply);
    return answer;
}

/* The same request with a wrench that is zero goes row by row. */
static void ask_by_rows(struct bench *b, tfa_request r, tfa_method method, double *qdd)
{
    static const double none[6];
    r.wrench_count = 1;
    r.wrench_frames[0] = 0;
    r.wrenches = none;
    (void)ask(b, b->robot.f64, r, method, qdd);
}

/* ---- against rows, quadruple precision and the sister method ---- */

static double against_rows, worst, worst_refined;

static void state_by_partition(struct bench *b, tfa_request r)
{
    const size_t bytes = b->n * sizeof(double);
    (void)ask(b, b->robot.f128, r, TFA_METHOD_ABA, b->want);
    (void)ask(b, b->robot.f64, r, TFA_METHOD_TFA, b->lu);
    (void)ask(b, b->robot.f64, r, TFA_METHOD_TFA_CR, b->got);
    ask_by_rows(b, r, TFA_METHOD_TFA_CR, b->row);
    assert_within(&b->robot, "tfa-cr by pieces against rows", relative_error(b->got, b->row, b->n),
                  1e-10, &against_rows);
    assert_within(&b->robot, "tfa-cr by pieces", relative_error(b->got, b->want, b->n),
                  30 * relative_error(b->lu, b->want, b->n) + 1e-13, &worst);
    assert_memory_not_equal(b->got, b->row, bytes); /* or it was not by partitions */
    (void)ask(b, b->robot.f64, r, TFA_METHOD_CFA_CR, b->row);
    assert_memory_equal(b->got, b->row, bytes);
    r.refine = 1;
    (void)ask(b, b->robot.f64, r, TFA_METHOD_TFA_CR, b->got);
    (void)ask(b, b->robot.f64, r, TFA_METHOD_ABA, b->row);
    assert_within(&b->robot, "tfa-cr by pieces, refined", relative_error(b->got, b->want, b->n),
                  30 * relative_error(b->row, b->want, b->n) + 1e-13, &worst_refined);
}

/* Every way to fill the last partitions up, at rest and moving */
TEST(every_length)
{
    for (uint32_t n = 48; n <= 300; n += n < 82 ? 1 : 31) {
        struct bench b;
        open_bench(&b, CHAIN_RANDOM, n, n % 2 ? 0.1 : 0);
        for (size_t k = 0; k < STATES; k++)
            state_by_partition(&b, request_of(&b, k, k > 0));
        close_bench(&b);
    }
    print_message("  against rows %.1e, error %.1e, refined %.1e\n", against_rows, worst,
                  worst_refined);
}

/* ---- threads ---- */

TEST(same_bits_on_any_number_of_threads)
{
    static const uint32_t threads[] = {1, 2, 3, 7};
    struct bench b;
    open_bench(&b, CHAIN_RANDOM, 333, 0);
    for (size_t t = 0; t < sizeof threads / sizeof *threads; t++) {
        tfa_batch_pool *pool;
        const tfa_batch_pool_options options = {.threads = threads[t], .methods = TFA_METHODS_ALL};
        assert_int_equal(tfa_batch_pool_create(b.robot.model, &options, &pool), TFA_OK);
        for (size_t k = 0; k < 20 * STATES; k++) {
            tfa_answer want, got;
            tfa_reply reply = {.qdd = b.got, .answers = &got};
            tfa_request r = request_of(&b, k % STATES, 1);
            r.refine = k % 2;
            r.estimate = k % 4 ? TFA_ESTIMATE_ALWAYS : TFA_ESTIMATE_NEVER;
            r.method = TFA_METHOD_TFA_CR;
            want = ask(&b, b.robot.f64, r, r.method, b.want);
            assert_int_equal(tfa_batch_pool_compute(pool, &r, &reply), TFA_OK);
            assert_memory_equal(b.got, b.want, b.n * sizeof *b.got);
            assert_memory_equal(&got.error_estimate, &want.error_estimate, sizeof(double));
        }
        tfa_batch_pool_free(pool);
    }
    close_bench(&b);
}

/* ---- Lambda^-1 ---- */

static double worst_lambda;

/* Of a tip on the last body in all frames, against quadruple precision; of one before it, too,
 * which goes row by row. */
static void lambda_of(struct bench *b, size_t state)
{
    double want[36], got[36];
    tfa_request r = {.op = TFA_OP_OPERATIONAL_INERTIA,
                     .estimate = TFA_ESTIMATE_NEVER,
                     .count = 1,
                     .tip_count = 1,
                     .q = b->q + state * b->n};
    for (uint32_t back = 0; back < 2; back++)
        for (int frame = 0; frame <= TFA_FRAME_WORLD; frame++) {
            tfa_reply reply = {.lambda_inv = want};
            r.frame = (tfa_reference_frame)frame;
            r.tips[0] = (uint32_t)b->robot.description->link_count - 1 - back;
            r.method = TFA_METHOD_PROPAGATION;
            compute_ok(&b->robot, b->robot.f128, &r, &reply);
            reply.lambda_inv = got;
            r.method = TFA_METHOD_TFA_CR;
            compute_ok(&b->robot, b->robot.f64, &r, &reply);
            assert_within(&b->robot, "lambda_inv", relative_error(got, want, 36), 1e-9,
                          back ? NULL : &worst_lambda);
        }
}

TEST(lambda_of_the_last_body)
{
    for (uint32_t n = 48; n <= 300; n += n < 66 ? 1 : 47) {
        struct bench b;
        open_bench(&b, CHAIN_RANDOM, n, 0);
        lambda_of(&b, n % STATES);
        close_bench(&b);
    }
    print_message("  lambda_inv: %.1e\n", worst_lambda);
}

/* ---- estimates and fallback ---- */

/* The error is below 30 estimates, and the estimate is not beyond all measure. */
TEST(estimates_hold)
{
    static const chain_mechanism mechanisms[] = {CHAIN_STRAIGHT, CHAIN_HELIX,    CHAIN_RANDOM,
                                                 CHAIN_TAPER,    CHAIN_PLANAR,   CHAIN_ZIGZAG,
                                                 CHAIN_SWELLING, CHAIN_HEAVY_TIP};
    for (size_t m = 0; m < sizeof mechanisms / sizeof *mechanisms; m++)
        for (uint32_t n = 50; n <= 200; n += 75) {
            struct bench b;
            open_bench(&b, mechanisms[m], n, 0);
            for (size_t k = 0; k < 2 * STATES; k++) {
                tfa_request r = request_of(&b, k % STATES, 1);
                (void)ask(&b, b.robot.f128, r, TFA_METHOD_ABA, b.want);
                r.estimate = TFA_ESTIMATE_DEFAULT;
                r.refine = k < STATES ? TFA_REFINE_DEFAULT : 0;
                const tfa_answer a = ask(&b, b.robot.f64, r, TFA_METHOD_TFA_CR, b.got);
                const double error = relative_error(b.got, b.want, b.n);
                assert_true(a.flags & TFA_ANSWER_ESTIMATED);
                assert_within(&b.robot, "estimate", error, 30 * a.error_estimate, NULL);
                assert_true(a.error_estimate <= 1e-4);
                assert_true(a.error_estimate < 1e5 * error + 1e-13);
            }
            close_bench(&b);
        }
}

/* Thin links, and torques that give every joint the acceleration 1 or -1: partitions lose what rows
 * do, and the answer is another method's, which says why. */
TEST(large_estimates_fall_back)
{
    struct bench b;
    open_bench(&b, CHAIN_THIN, 256, 0);
    tfa_request r = request_of(&b, 0, 0);
    tfa_reply reply = {.tau = b.tau};
    for (size_t k = 0; k < b.n; k++)
        b.row[k] = k % 3 ? 1 : -1;
    r.op = TFA_OP_INVERSE_DYNAMICS;
    r.qdd = b.row;
    compute_ok(&b.robot, b.robot.f128, &r, &reply);
    r.op = TFA_OP_FORWARD_DYNAMICS;
    (void)ask(&b, b.robot.f128, r, TFA_METHOD_ABA, b.want);
    tfa_answer a = ask(&b, b.robot.f64, r, TFA_METHOD_TFA_CR, b.got);
    assert_int_equal(a.flags, 0);
    assert_true(relative_error(b.got, b.want, b.n) > 1e-3);
    r.estimate = TFA_ESTIMATE_DEFAULT;
    a = ask(&b, b.robot.f64, r, TFA_METHOD_TFA_CR, b.got);
    assert_int_equal(a.flags & (TFA_ANSWER_FALLBACK | TFA_ANSWER_INACCURATE),
                     TFA_ANSWER_FALLBACK | TFA_ANSWER_INACCURATE);
    assert_int_not_equal(a.method, TFA_METHOD_TFA_CR);
    assert_within(&b.robot, "fallback", relative_error(b.got, b.want, b.n), 1e-4, NULL);
    close_bench(&b);
}
