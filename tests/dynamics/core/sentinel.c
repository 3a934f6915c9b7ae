/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The sentinel under the default policy: silent on robots, and where a heavy tip or payload takes
 * the digits no answer is wrong by more than 1e-6 without a word, whichever code gives it.
 * Estimates know no scale and change no answer.
 */
#include "models.h"
#include "support/fixture.h"
#include "support/hard_robot.h"
#include "test.h"

#define STATES 8
#define WRONG 1e-6
#define OVER 30

/* ---- robots ---- */

static void never_trips(test_robot *robot)
{
    if (robot->random)
        return;
    random_states *x = fixture_states(robot, 0, STATES, 0);
    double *numbers = calloc(STATES * (6 + robot->nv), sizeof *numbers);
    tfa_answer answers[STATES];
    tfa_reply reply = {.qdd = numbers + STATES * 6, .answers = answers};
    reply.base_acceleration = robot->base == TFA_BASE_FLOATING ? numbers : NULL;
    for (uint32_t count = 1; count <= STATES; count += STATES - 1) {
        tfa_request r = fixture_request(robot, x);
        r.count = count;
        r.refine = TFA_REFINE_DEFAULT;
        compute_ok(robot, robot->f64, &r, &reply);
        for (uint32_t k = 0; k < count; k++)
            if (answers[k].flags)
                fail_msg("%s: flags %d, estimate %g", robot->name, answers[k].flags,
                         answers[k].error_estimate);
    }
    free(numbers);
    random_states_free(x);
}

EVERY_ROBOT(robots_do_not_trip_it, never_trips, false)

/* Nor does it speak of a request before: one with a payload for which it trips, then Lambda^-1. */
static void forgets(test_robot *robot)
{
    static const double payload[TFA_PAYLOAD_NUMBERS] = {1e12};
    static double lambda[36], acceleration[6];
    if (robot->random)
        return;
    random_states *x = fixture_states(robot, 0, 1, 0);
    double *qdd = calloc(robot->nv + 1, sizeof *qdd);
    tfa_answer answer;
    tfa_reply reply = {
        .qdd = qdd, .base_acceleration = acceleration, .lambda_inv = lambda, .answers = &answer};
    tfa_request r = fixture_request(robot, x);
    r.refine = TFA_REFINE_DEFAULT;
    r.tips[0] = r.payload_frames[0] = tfa_model_frame_count(robot->model) - 1;
    r.payloads = payload;
    r.payload_count = 1;
    (void)tfa_compute(robot->f64, &r, &reply);
    r.payload_count = 0;
    r.op = TFA_OP_OPERATIONAL_INERTIA;
    r.tip_count = 1;
    compute_ok(robot, robot->f64, &r, &reply);
    if (answer.flags)
        fail_msg("%s: Lambda^-1 has flags %d", robot->name, answer.flags);
    free(qdd);
    random_states_free(x);
}

EVERY_ROBOT(requests_before_do_not_trip_it, forgets, false)

/* ---- where it has to speak ---- */

struct test_case {
    hard_robot robot;
    tfa_workspace *all; /* with memory for every method */
    double *q, *v, *tau, *want, *got;
    uint32_t flagged, wrong;
};

static void open_case(struct test_case *x, uint32_t bodies, mechanism_kind kind)
{
    mechanism_options o = mechanism_defaults(kind, bodies);
    const tfa_workspace_options workspace_options = {.methods = TFA_METHODS_ALL};
    o.ratio = 1e12;
    hard_robot_mechanism(&o, TFA_BASE_FIXED, &x->robot);
    x->all = workspace_for(x->robot.model, &workspace_options);
    const size_t n = STATES * (size_t)x->robot.nv;
    x->q = calloc(3 * n + 72 * STATES + 2 * n, sizeof *x->q);
    x->v = x->q + n;
    x->tau = x->v + n;
    x->want = x->tau + n;
    x->got = x->want + n + 36 * STATES;
}

static void close_case(struct test_case *x)
{
    tfa_workspace_free(x->all);
    free(x->q);
    hard_robot_close(&x->robot);
}

static tfa_request draw(struct test_case *x, hard_rhs rhs)
{
    random_source s = {11u + x->robot.nv};
    const size_t n = x->robot.nv;
    for (uint32_t k = 0; k < STATES; k++) {
        hard_robot_draw(&x->robot, &s, rhs);
        memcpy(x->q + k * n, x->robot.q, n * sizeof *x->q);
        memcpy(x->v + k * n, x->robot.v, n * sizeof *x->v);
        memcpy(x->tau + k * n, x->robot.tau, n * sizeof *x->tau);
    }
    return (tfa_request){.op = TFA_OP_FORWARD_DYNAMICS,
                         .refine = TFA_REFINE_DEFAULT,
                         .count = STATES,
                         .q = x->q,
                         .v = x->v,
                         .tau = x->tau};
}

/* Compares count states with the truth: wrong ones have said so. */
static void check_answer(struct test_case *x, tfa_request r, uint32_t count)
{
    const int lambda = r.op == TFA_OP_OPERATIONAL_INERTIA;
    const size_t n = lambda ? 36 : x->robot.nv;
    tfa_answer answers[STATES];
    tfa_reply reply = {.answers = answers};
    r.count = count;
    *(lambda ? &reply.lambda_inv : &reply.qdd) = x->got;
    (void)tfa_compute(x->all, &r, &reply);
    for (uint32_t k = 0; k < count; k++) {
        const tfa_answer *a = &answers[k];
        const double error = relative_error(x->got + k * n, x->want + k * n, n);
        x->flagged += (a->flags & TFA_ANSWER_SENTINEL) != 0;
        if (a->status != TFA_OK || !(error > WRONG))
            continue;
        x->wrong++;
        if (a->flags & TFA_ANSWER_FALLBACK)
            continue;
        if (!(a->flags & TFA_ANSWER_ESTIMATED) || !(a->error_estimate * OVER >= error))
            fail_msg("%s by %s, state %u of %u: error %.2g, estimate %.2g, flags %d", x->robot.name,
                     tfa_method_name((uint32_t)r.method), (unsigned)k, (unsigned)count, error,
                     a->error_estimate, a->flags);
    }
}

static void truth(struct test_case *x, tfa_request r)
{
    const int lambda = r.op == TFA_OP_OPERATIONAL_INERTIA;
    tfa_reply reply = {0};
    *(lambda ? &reply.lambda_inv : &reply.qdd) = x->want;
    r.method = TFA_METHOD_AUTO;
    assert_int_equal(tfa_compute(x->robot.f128, &r, &reply), TFA_OK);
}

/* Every method of the op, one state and several */
static void every_method(struct test_case *x, tfa_request r)
{
    truth(x, r);
    for (uint32_t m = 0; tfa_method_describe(m); m++) {
        const tfa_method_info *row = tfa_method_describe(m);
        if (!(r.op == TFA_OP_FORWARD_DYNAMICS ? row->forward_dynamics : row->lambda))
            continue;
        r.method = (tfa_method)m;
        check_answer(x, r, 1);
        check_answer(x, r, STATES);
    }
}

TEST(heavy_tips_are_flagged)
{
    static const uint32_t sizes[] = {2, 5, 8, 20, 64, 128};
    static struct test_case x;
    uint32_t wrong = 0, flagged = 0;
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        x = (struct test_case){0};
        open_case(&x, sizes[i], MECHANISM_HEAVY_TIP);
        for (int rhs = 0; rhs < HARD_RHS_COUNT; rhs++)
            every_method(&x, draw(&x, (hard_rhs)rhs));
        tfa_request r = draw(&x, HARD_TAU);
        r.op = TFA_OP_OPERATIONAL_INERTIA;
        r.tip_count = 1;
        r.tips[0] = tfa_model_frame_count(x.robot.model) - 1;
        every_method(&x, r);
        print_message("  %3u bodies: %u flagged, %u wrong\n", (unsigned)sizes[i], x.flagged,
                      x.wrong);
        flagged += x.flagged;
        wrong += x.wrong;
        close_case(&x);
    }
    assert_true(wrong > 0 && flagged > 0); /* or nothing was tried */
}

/* 1e12 kg on the last link of rods that weigh 1 kg */
TEST(heavy_payloads_are_flagged)
{
    static const double payload[TFA_PAYLOAD_NUMBERS] = {1e12, 0, 0, 0.5, 1e10, 0, 0, 1e10, 0, 1e10};
    static struct test_case x;
    open_case(&x, 7, MECHANISM_RANDOM);
    for (int rhs = HARD_TAU; rhs < HARD_RHS_COUNT; rhs++) {
        tfa_request r = draw(&x, (hard_rhs)rhs);
        every_method(&x, r);
        assert_int_equal(x.flagged, 0);
        r.payload_count = 1;
        r.payloads = payload;
        r.payload_frames[0] = tfa_model_frame_count(x.robot.model) - 1;
        every_method(&x, r);
        assert_true(x.flagged > 0);
        x.flagged = 0;
    }
    close_case(&x);
}

/* ---- estimates ---- */

/* Scaled by a power of two every number of the answer keeps its bits, and so does the estimate. */
static void scaled(struct test_case *x, tfa_request r, double scale)
{
    static const double weightless[3];
    tfa_answer plain, large;
    double *tau = calloc(x->robot.nv, sizeof *tau);
    tfa_reply reply = {.qdd = x->got, .answers = &plain};
    r.count = 1;
    r.v = NULL;
    r.gravity = weightless;
    r.estimate = TFA_ESTIMATE_ALWAYS;
    assert_int_equal(tfa_compute(x->all, &r, &reply), TFA_OK);
    for (uint32_t j = 0; j < x->robot.nv; j++)
        tau[j] = scale * x->tau[j];
    r.tau = tau;
    reply.answers = &large;
    assert_int_equal(tfa_compute(x->all, &r, &reply), TFA_OK);
    free(tau);
    if (!(large.error_estimate > plain.error_estimate / 10 &&
          large.error_estimate < plain.error_estimate * 10))
        fail_msg("%s, forces x %g: estimate %g, not %g", tfa_method_name((uint32_t)r.method), scale,
                 large.error_estimate, plain.error_estimate);
}

TEST(estimates_know_no_scale)
{
    static const uint32_t sizes[] = {6, 64};
    static struct test_case x;
    for (size_t i = 0; i < 2; i++) {
        open_case(&x, sizes[i], MECHANISM_RANDOM);
        tfa_request r = draw(&x, HARD_TAU);
        for (uint32_t m = 0; tfa_method_describe(m); m++) {
            r.method = (tfa_method)m;
            if (!tfa_method_describe(m)->forward_dynamics)
                continue;
            scaled(&x, r, 0x1p-664);
            scaled(&x, r, 0x1p664);
        }
        close_case(&x);
    }
}

/* An estimate is a number where the flag says so, and none otherwise; it changes no answer. */
TEST(estimates_change_no_answer)
{
    static const uint32_t sizes[] = {6, 64};
    static struct test_case x;
    for (size_t i = 0; i < 2; i++) {
        open_case(&x, sizes[i], MECHANISM_SIDE_BRANCHES);
        tfa_request r = draw(&x, HARD_TAU);
        for (uint32_t m = 0; tfa_method_describe(m); m++) {
            r.method = (tfa_method)m;
            if (!tfa_method_describe(m)->forward_dynamics)
                continue;
            for (r.count = 1; r.count <= STATES; r.count += STATES - 1)
                for (r.refine = 0; r.refine <= 2; r.refine++) {
                    tfa_answer unestimated[STATES], reported[STATES];
                    tfa_reply reply = {.qdd = x.want, .answers = unestimated};
                    r.estimate = TFA_ESTIMATE_NEVER;
                    if (tfa_compute(x.all, &r, &reply) != TFA_OK)
                        continue;
                    reply = (tfa_reply){.qdd = x.got, .answers = reported};
                    r.estimate = TFA_ESTIMATE_ALWAYS;
                    assert_int_equal(tfa_compute(x.all, &r, &reply), TFA_OK);
                    for (uint32_t k = 0; k < r.count; k++) {
                        assert_true(isnan(unestimated[k].error_estimate) &&
                                    unestimated[k].flags == 0);
                        assert_true(reported[k].error_estimate >= 0);
                        assert_true(reported[k].flags & TFA_ANSWER_ESTIMATED);
                    }
                    if (reported[0].flags == TFA_ANSWER_ESTIMATED &&
                        (m == TFA_METHOD_ABA || r.refine == 0))
                        assert_memory_equal(x.got, x.want, x.robot.nv * sizeof *x.got);
                }
        }
        close_case(&x);
    }
}
