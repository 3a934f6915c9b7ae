/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Ways to ask that must give the same answer: batches, fused requests, defaults, instruction sets,
 * and what the answer says of its own error.
 */
#include "models.h"
#include "support/questions.h"
#include "test.h"

#define STATES 5
#define TIPS 2
#define WRENCHES 2
#define LAMBDA ((size_t)36 * TIPS * TIPS)

static void ask(const test_robot *robot, tfa_workspace *w, const tfa_request *r, answers *a,
                uint32_t k)
{
    tfa_reply reply = answers_reply(a, k, TIPS);
    compute_ok(robot, w, r, &reply);
}

static tfa_request full_request(const test_robot *robot, const random_states *x)
{
    tfa_request r = fixture_request(robot, x);
    r.tip_count = TIPS;
    r.tips[0] = (uint32_t)robot->description->link_count - 1;
    r.tips[1] = (uint32_t)robot->description->link_count / 2;
    return r;
}

/* By this method, without the tips that some methods refuse */
static void choose_method(tfa_request *r, uint32_t m)
{
    r->method = (tfa_method)m;
    r->tip_count = tfa_method_describe(m)->lambda ? TIPS : 0;
}

static double qdd_error(const test_robot *robot, const answers *got, const answers *want)
{
    double error = relative_error(got->qdd, want->qdd, (size_t)STATES * robot->nv);
    if (robot->n > robot->nv)
        error = fmax(error,
                     relative_error(got->base_acceleration, want->base_acceleration, 6 * STATES));
    return error;
}

/* ---- a batch is its states, one by one, to the bit ---- */

/* The request for state k of `r` alone. */
static tfa_request single(const test_robot *robot, const tfa_request *r, uint32_t k)
{
    tfa_request one = *r;
    one.count = 1;
    one.q = r->q + (size_t)k * robot->nq;
    one.v = r->v + (size_t)k * robot->nv;
    one.tau = r->tau + (size_t)k * robot->nv;
    one.wrenches = r->wrenches + (size_t)6 * WRENCHES * k;
    if (robot->n > robot->nv) {
        one.base_pose = r->base_pose + (size_t)7 * k;
        one.base_twist = r->base_twist + (size_t)6 * k;
        one.base_wrench = r->base_wrench + (size_t)6 * k;
    }
    return one;
}

static void batch(test_robot *robot)
{
    random_states *x = fixture_states(robot, 0, STATES, WRENCHES);
    answers *all = answers_create(robot, STATES), *each = answers_create(robot, STATES);
    tfa_request r = full_request(robot, x);
    for (uint32_t m = 0; (m = fixture_method(robot, TFA_OP_FORWARD_DYNAMICS, m)) != NO_METHOD;
         m++) {
        choose_method(&r, m);
        ask(robot, robot->f64, &r, all, 0);
        for (uint32_t k = STATES; k-- > 0;) { /* backwards: no state may lean on the one before */
            tfa_request one = single(robot, &r, k);
            ask(robot, robot->f64, &one, each, k);
        }
        assert_memory_equal(all->qdd, each->qdd, STATES * robot->nv * sizeof(double));
        if (robot->n > robot->nv)
            assert_memory_equal(all->base_acceleration, each->base_acceleration,
                                6 * STATES * sizeof(double));
        assert_memory_equal(all->lambda_inv, each->lambda_inv, LAMBDA * STATES * sizeof(double));
    }
    answers_free(each);
    answers_free(all);
    random_states_free(x);
}

EVERY_ROBOT(batch_equals_single_calls, batch, false)

/* ---- one request for qdd and lambda_inv equals two ---- */

static double worst_fused;

static void fused(test_robot *robot)
{
    random_states *x = fixture_states(robot, 0, STATES, WRENCHES);
    answers *both = answers_create(robot, STATES), *apart = answers_create(robot, STATES);
    for (uint32_t m = 0; (m = fixture_method(robot, TFA_OP_FORWARD_DYNAMICS, m)) != NO_METHOD; m++)
        for (uint32_t refine = 0; refine < 2 && tfa_method_describe(m)->lambda; refine++) {
            tfa_request r = full_request(robot, x);
            r.method = (tfa_method)m;
            r.refine = refine;
            ask(robot, robot->f64, &r, both, 0);
            r.op = TFA_OP_OPERATIONAL_INERTIA;
            ask(robot, robot->f64, &r, apart, 0);
            r.op = TFA_OP_FORWARD_DYNAMICS;
            r.tip_count = 0;
            ask(robot, robot->f64, &r, apart, 0);
            const char *name = tfa_method_name(m);
            assert_within(robot, name, qdd_error(robot, both, apart), 2e-11, &worst_fused);
            assert_within(robot, name,
                          relative_error(both->lambda_inv, apart->lambda_inv, LAMBDA * STATES),
                          2e-11, &worst_fused);
        }
    answers_free(apart);
    answers_free(both);
    random_states_free(x);
}

TEST(fused_equals_separate)
{
    for_every_robot(fused, false);
    print_message("  worst difference %.2g\n", worst_fused);
}

/* ---- what is left out is zero, or the model's ---- */

static void assert_same(const test_robot *robot, const answers *a, const answers *b)
{
    for (size_t k = 0; k < (size_t)STATES * robot->nv; k++)
        assert_true(a->qdd[k] == b->qdd[k]); /* 0 and -0 are the same */
    for (size_t k = 0; robot->n > robot->nv && k < 6 * STATES; k++)
        assert_true(a->base_acceleration[k] == b->base_acceleration[k]);
    assert_memory_equal(a->lambda_inv, b->lambda_inv, LAMBDA * STATES * sizeof(double));
}

static void left_out(test_robot *robot)
{
    random_states *x = fixture_states(robot, 0, STATES, WRENCHES);
    answers *a = answers_create(robot, STATES), *b = answers_create(robot, STATES);
    double *zeros = calloc((size_t)STATES * (robot->nv + 6 * WRENCHES), sizeof *zeros);
    tfa_request r = full_request(robot, x);
    const double standard[3] = {0, 0, -9.80665};
    r.v = r.tau = zeros;
    r.gravity = standard;
    if (robot->n > robot->nv)
        r.base_twist = r.base_wrench = zeros;
    ask(robot, robot->f64, &r, a, 0);
    r.v = r.tau = r.base_twist = r.base_wrench = r.gravity = NULL;
    ask(robot, robot->f64, &r, b, 0);
    assert_same(robot, a, b);
    r.wrenches = zeros; /* and none is as good as zero, also after a request that had some */
    ask(robot, robot->f64, &r, a, 0);
    r.wrenches = x->wrenches;
    ask(robot, robot->f64, &r, b, 0);
    r.wrench_count = 0;
    ask(robot, robot->f64, &r, b, 0);
    assert_same(robot, a, b);
    free(zeros);
    answers_free(b);
    answers_free(a);
    random_states_free(x);
}

EVERY_ROBOT(null_means_zero, left_out, true)

/* ---- rotor inertia of the file counts when the model is asked for it ---- */

static void rotor(test_robot *robot)
{
    random_states *x = fixture_states(robot, 0, STATES, WRENCHES);
    answers *a = answers_create(robot, STATES), *b = answers_create(robot, STATES);
    tfa_request r = full_request(robot, x);
    for (int asked = 0; asked < 2; asked++) {
        const tfa_model_options options = {.base = robot->base, .rotor_inertia = asked == 0};
        for (size_t j = 0; asked && j < robot->description->joint_count; j++)
            robot->description->joints[j].armature += robot->description->joints[j].rotor;
        tfa_model *model = compiled(robot->description, &options);
        tfa_workspace *w = fixture_workspace(model, TFA_F64);
        ask(robot, w, &r, asked ? b : a, 0);
        tfa_workspace_free(w);
        tfa_model_free(model);
    }
    assert_same(robot, a, b);
    answers_free(b);
    answers_free(a);
    random_states_free(x);
}

EVERY_ROBOT(rotor_inertia_is_armature, rotor, true)

/* ---- every instruction set gives the same, up to rounding ---- */

static void isa(test_robot *robot)
{
    static const char *const names[] = {"base", "avx2", "avx512"};
    random_states *x = fixture_states(robot, 0, STATES, WRENCHES);
    answers *a = answers_create(robot, STATES), *reference = answers_create(robot, STATES);
    tfa_request r = full_request(robot, x);
    ask(robot, robot->f128, &r, reference, 0);
    for (size_t k = 0; k < 3; k++) {
        tfa_workspace *w = NULL;
        assert_int_equal(setenv("TFA_ISA", names[k], 1), 0);
        bool here = strcmp(tfa_isa_name(), names[k]) == 0;
        if (here)
            w = fixture_workspace(robot->model, TFA_F64);
        else if (robot->seed == 1)
            print_message("SKIP: %s: not on this processor\n", names[k]);
        for (uint32_t m = 0;
             here && (m = fixture_method(robot, TFA_OP_FORWARD_DYNAMICS, m)) != NO_METHOD; m++) {
            choose_method(&r, m);
            ask(robot, w, &r, a, 0);
            assert_within(robot, names[k], qdd_error(robot, a, reference), 3e-11, NULL);
            assert_within(robot, names[k],
                          relative_error(a->lambda_inv, reference->lambda_inv, LAMBDA * STATES),
                          3e-11, NULL);
        }
        tfa_workspace_free(w);
    }
    assert_int_equal(setenv("TFA_ISA", "vax", 1), 0);
    tfa_workspace *none = NULL;
    assert_string_equal(tfa_isa_name(), "none");
    assert_int_equal(tfa_workspace_create(robot->model, NULL, &none), TFA_E_UNSUPPORTED);
    unsetenv("TFA_ISA");
    answers_free(reference);
    answers_free(a);
    random_states_free(x);
}

EVERY_ROBOT(instruction_sets_agree, isa, true)

/* ---- the error estimate does not flatter ---- */

static void estimate(test_robot *robot)
{
    random_states *x = fixture_states(robot, 0, STATES, WRENCHES);
    answers *a = answers_create(robot, STATES), *exact = answers_create(robot, STATES);
    tfa_request r = full_request(robot, x);
    ask(robot, robot->f128, &r, exact, 0);
    r.estimate = TFA_ESTIMATE_ALWAYS;
    r.refine = 0;
    for (uint32_t m = 0; (m = fixture_method(robot, TFA_OP_FORWARD_DYNAMICS, m)) != NO_METHOD;
         m++) {
        choose_method(&r, m);
        ask(robot, robot->f64, &r, a, 0);
        for (uint32_t k = 0; k < STATES; k++) {
            double error = relative_error(a->qdd + (size_t)k * robot->nv,
                                          exact->qdd + (size_t)k * robot->nv, robot->nv);
            assert_true(a->each[k].flags & TFA_ANSWER_ESTIMATED);
            /* rounding of the model's constants is no error of the method: 1e-13 */
            assert_within(robot, tfa_method_name(m), error, 30 * a->each[k].error_estimate + 1e-13,
                          NULL);
        }
    }
    r.estimate = TFA_ESTIMATE_NEVER;
    r.method = TFA_METHOD_ABA;
    ask(robot, robot->f64, &r, a, 0);
    assert_false(a->each[0].flags & TFA_ANSWER_ESTIMATED);
    assert_true(isnan(a->each[0].error_estimate));
    answers_free(exact);
    answers_free(a);
    random_states_free(x);
}

EVERY_ROBOT(estimate_covers_the_error, estimate, false)

/* ---- the spectrum is that of lambda_inv ---- */

static void spectrum(test_robot *robot)
{
    const uint32_t n = 6 * TIPS;
    random_source s = {robot->seed};
    random_states *x = fixture_states(robot, 0, STATES, 0);
    answers *a = answers_create(robot, STATES);
    tfa_spectrum found[STATES];
    tfa_request r = full_request(robot, x);
    tfa_reply reply = {.lambda_inv = a->lambda_inv, .spectrum = found};
    r.op = TFA_OP_OPERATIONAL_INERTIA;
    r.flags = TFA_WANT_SPECTRUM;
    compute_ok(robot, robot->f64, &r, &reply);
    for (uint32_t k = 0; k < STATES; k++) {
        const double *L = a->lambda_inv + LAMBDA * k;
        double trace = 0, slack = 1e-13 * fabs(found[k].eig_max);
        for (uint32_t i = 0; i < n; i++)
            trace += L[i * n + i];
        assert_true(found[k].rank <= robot->n && found[k].rank <= n);
        assert_true(found[k].eig_max * n >= trace - slack && found[k].eig_max <= trace + slack);
        assert_true(found[k].eig_min * n <= trace + slack && found[k].eig_min >= -slack);
        double y[6 * TIPS], quotient = 0;
        for (uint32_t i = 0; i < n; i++)
            y[i] = random_uniform(&s, -1, 1);
        for (int step = 0; step < 300; step++) { /* power iteration climbs to the largest */
            double Ly[6 * TIPS] = {0}, size = 0, form = 0, length;
            for (uint32_t i = 0; i < n; i++) {
                for (uint32_t j = 0; j < n; j++)
                    Ly[i] += L[i * n + j] * y[j];
                size += y[i] * y[i];
                form += y[i] * Ly[i];
            }
            quotient = form / size;
            assert_true(quotient <= found[k].eig_max + slack);
            assert_true(quotient >= found[k].eig_min - slack);
            length = relative_error(Ly, (const double[6 * TIPS]){0}, n);
            for (uint32_t i = 0; i < n && length > 0; i++)
                y[i] = Ly[i] / length;
        }
        assert_true(quotient >= 0.97 * found[k].eig_max); /* log(n) / steps is its error */
    }
    answers_free(a);
    random_states_free(x);
}

EVERY_ROBOT(spectrum_bounds_lambda_inv, spectrum, false)
