/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Answers of robots with flexible links do not depend on the way: batches, threads and kept
 * factors give the same bits. Refined and estimated answers keep what they promise.
 */
#include "models.h"
#include "support/flexible_robot.h"
#include "test.h"

#include <totalforce/batch_pool.h>

#define STATES 19 /* two vectors of eight and a rest */
#define TIPS 2

static const tfa_method methods[] = {TFA_METHOD_AUTO, TFA_METHOD_ABA, TFA_METHOD_SCAN,
                                     TFA_METHOD_SCAN_TWO_PASS, TFA_METHOD_DCA};
#define METHODS (sizeof methods / sizeof *methods)

/* All that forward dynamics with tips answers */
typedef struct all_answers {
    double *numbers;
    size_t count;
    tfa_reply reply;
} all_answers;

static all_answers answers_make(const flexible_robot *f)
{
    const size_t each[] = {(size_t)f->robot.nv, 6, f->mode_count, 36 * TIPS * TIPS, 2};
    all_answers a = {.count = 0};
    for (int k = 0; k < 5; k++)
        a.count += STATES * each[k];
    a.numbers = calloc(a.count, sizeof *a.numbers);
    double *x = a.numbers, **to[] = {&a.reply.qdd, &a.reply.base_acceleration, &a.reply.modes,
                                     &a.reply.lambda_inv, &a.reply.energy};
    for (int k = 0; k < 5; k++) {
        *to[k] = x;
        x += STATES * each[k];
    }
    return a;
}

static void assert_bits(const flexible_robot *f, const char *what, const all_answers *a,
                        const all_answers *b)
{
    if (memcmp(a->numbers, b->numbers, a->count * sizeof *a->numbers) != 0)
        fail_msg("%s: %s: other bits", f->robot.name, what);
}

static void same_bits(flexible_robot *f)
{
    flexible_states s = flexible_states_make(f, 51, STATES, 2);
    tfa_request r = flexible_request(f, &s);
    all_answers a = answers_make(f), b = answers_make(f);
    const tfa_workspace_options one = {.states = TFA_STATES_ONE};
    SCOPED_WORKSPACE *w = workspace_for(f->robot.model, NULL);
    SCOPED_WORKSPACE *alone = workspace_for(f->robot.model, &one);
    r.flags = TFA_WANT_ENERGY;
    for (uint32_t tips = 0; tips <= TIPS; tips += TIPS)
        for (size_t m = 0; m < 2 * METHODS; m++) {
            r.method = methods[m / 2];
            if (fixture_refuses(&f->robot, r.method))
                continue;
            r.count = m % 2 ? STATES : 1;
            r.tip_count = tips;
            for (uint32_t t = 0; t < tips; t++)
                r.tips[t] = (uint32_t)f->robot.description->link_count - 1 - t;
            compute_ok(&f->robot, w, &r, &a.reply);
            compute_ok(&f->robot, alone, &r, &b.reply);
            assert_bits(f, "one by one", &a, &b);
            compute_ok(&f->robot, w, &r, &b.reply); /* of the last state the factors are kept */
            assert_bits(f, "again", &a, &b);
            for (uint32_t threads = 1; threads <= 3; threads++) {
                const tfa_batch_pool_options options = {.threads = threads};
                tfa_batch_pool *pool = NULL;
                assert_int_equal(tfa_batch_pool_create(f->robot.model, &options, &pool), TFA_OK);
                assert_int_equal(tfa_batch_pool_compute(pool, &r, &b.reply), TFA_OK);
                tfa_batch_pool_free(pool);
                assert_bits(f, "by threads", &a, &b);
            }
        }
    free(b.numbers);
    free(a.numbers);
    flexible_states_free(&s);
}

EVERY_FLEXIBLE_ROBOT(batches_and_threads_give_the_same_bits, same_bits)

/* Of a chain that is long enough for segments */
TEST(threads_give_the_same_bits_of_a_long_chain)
{
    flexible_robot f;
    flexible_open_chain(&f, 200, 2, false);
    same_bits(&f);
    flexible_close(&f);
}

/* The same q and modes again, other velocities and forces: factors are kept. */
static void kept(flexible_robot *f)
{
    flexible_states s = flexible_states_make(f, 61, 2, 0);
    tfa_request r = flexible_request(f, &s);
    double *x = calloc(f->n, sizeof *x), *y = calloc(f->n, sizeof *y);
    r.count = 1;
    for (size_t m = 0; m < METHODS; m++) {
        if (fixture_refuses(&f->robot, methods[m]))
            continue;
        SCOPED_WORKSPACE *fresh = workspace_for(f->robot.model, NULL);
        SCOPED_WORKSPACE *used = workspace_for(f->robot.model, NULL);
        tfa_request other = r;
        other.v = s.x->v + f->robot.nv;
        other.tau = s.x->tau + f->robot.nv;
        other.mode_velocities = s.rates + f->mode_count;
        r.method = other.method = methods[m];
        flexible_forward(f, used, &other, y, NULL);
        flexible_forward(f, used, &r, y, NULL);
        flexible_forward(f, fresh, &r, x, NULL);
        assert_memory_equal(x, y, f->n * sizeof *x);
        other = r; /* other modes: other factors */
        other.modes = s.modes + f->mode_count;
        flexible_forward(f, used, &other, y, NULL);
        SCOPED_WORKSPACE *third = workspace_for(f->robot.model, NULL);
        flexible_forward(f, third, &other, x, NULL);
        assert_memory_equal(x, y, f->n * sizeof *x);
    }
    free(y);
    free(x);
    flexible_states_free(&s);
}

EVERY_FLEXIBLE_ROBOT(kept_factors_give_the_same_bits, kept)

/* ---- refinement and estimates ---- */

#define FLOOR 2e-15 /* what rounding of the numbers themselves may do */

static void promises(flexible_robot *f)
{
    flexible_states s = flexible_states_make(f, 71, 1, 1);
    tfa_request r = flexible_request(f, &s);
    double *want = calloc(f->n, sizeof *want), *x = calloc(f->n, sizeof *x), of_aba = 0;
    tfa_answer answer;
    oracle_modes_set_state(f->o, &r, 0);
    oracle_modes_forward(f->o, r.tau, r.base_wrench, want);
    for (size_t m = 1; m < METHODS; m++)
        for (uint32_t refine = 0; refine < 2; refine++) {
            if (fixture_refuses(&f->robot, methods[m]))
                continue;
            r.method = methods[m];
            r.refine = refine;
            r.estimate = TFA_ESTIMATE_NEVER;
            flexible_forward(f, f->robot.f64, &r, x, NULL);
            const double bare = relative_error(x, want, f->n);
            if (m == 1 && refine == 0)
                of_aba = bare;
            if (refine)
                assert_within(&f->robot, "refined", bare, 3 * fmax(of_aba, FLOOR), NULL);
            r.estimate = TFA_ESTIMATE_ALWAYS;
            flexible_forward(f, f->robot.f64, &r, x, &answer);
            const double error = relative_error(x, want, f->n);
            assert_true(answer.flags & TFA_ANSWER_ESTIMATED);
            if (!(error <= 1e-14 || error <= 30 * answer.error_estimate))
                fail_msg("%s: %s: error %.2g, estimate %.2g", f->robot.name,
                         tfa_method_name(methods[m]), error, answer.error_estimate);
        }
    free(x);
    free(want);
    flexible_states_free(&s);
}

EVERY_FLEXIBLE_ROBOT(refinement_and_estimates_keep_their_promise, promises)
