/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Every method against real robots' answers in quadruple precision: relative 2-norm error of qdd
 * (with the base's acceleration when it floats), of the bias force and of lambda_inv (Frobenius).
 * The answers lie outside the repository; without them the test says so and is skipped.
 */
#include "reference_robot.h"
#include "test.h"

#include <glob.h>

#define BOUND 1e-12
#define SKIPPED 77

static const char references[] = TFA_SOURCE_DIR "/../shared/reference";
static const char robots[] = TFA_SOURCE_DIR "/../shared/robots";

/* Two parts of a vector: joints and base. */
typedef struct norm {
    double difference, size;
} norm;

static void add(norm *n, const double *found, const double *want, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        n->difference += (found[i] - want[i]) * (found[i] - want[i]);
        n->size += want[i] * want[i];
    }
}

static double relative(const norm *n)
{
    return n->size > 0 ? sqrt(n->difference / n->size) : sqrt(n->difference);
}

/* What one method did over all states of a robot. */
typedef struct outcome {
    double worst;
    uint32_t answered, fallbacks, refused;
    char invalid_field[256]; /* the body that made it refuse */
} outcome;

static void note(outcome *o, int status, const reference_robot *robot, const tfa_reply *reply,
                 const norm *error)
{
    if (status == TFA_E_SINGULAR) {
        o->refused++;
        snprintf(o->invalid_field, sizeof o->invalid_field, "%s",
                 tfa_model_frame(robot->model, reply->index).name);
        return;
    }
    double e = status == TFA_OK ? relative(error) : INFINITY;
    /* NaN counts as the worst there is */
    if (!(e <= o->worst))
        o->worst = isnan(e) ? INFINITY : e;
    o->answered++;
    o->fallbacks += (reply->answers->flags & TFA_ANSWER_FALLBACK) != 0;
}

static tfa_request base_request(const reference_robot *robot, const reference_state *state,
                                tfa_op op)
{
    tfa_request request = {
        .op = op, .refine = TFA_REFINE_DEFAULT, .count = 1, .q = state->q, .v = state->v};
    if (robot->floating) {
        request.base_pose = state->base_pose;
        request.base_twist = state->base_twist;
    }
    return request;
}

static outcome forward(const reference_robot *robot, tfa_method method, uint32_t refine)
{
    outcome o = {0};
    double *qdd = calloc(robot->joints + 1, sizeof *qdd), base[6] = {0};
    assert_non_null(qdd);
    for (uint32_t k = 0; k < robot->count; k++) {
        const reference_state *state = &robot->states[k];
        tfa_request request = base_request(robot, state, TFA_OP_FORWARD_DYNAMICS);
        tfa_answer answer = {0};
        tfa_reply reply = {.qdd = qdd, .base_acceleration = base, .answers = &answer};
        norm error = {0};
        request.method = method;
        request.refine = refine;
        request.tau = state->tau;
        request.base_wrench = robot->floating ? state->base_wrench : NULL;
        int status = tfa_compute(robot->workspace, &request, &reply);
        add(&error, qdd, state->qdd, robot->joints);
        add(&error, base, state->base_acc, robot->floating ? 6 : 0);
        note(&o, status, robot, &reply, &error);
    }
    free(qdd);
    return o;
}

/* nle is what RNEA answers for qdd = 0. */
static outcome inverse(const reference_robot *robot)
{
    outcome o = {0};
    double *tau = calloc(robot->joints + 1, sizeof *tau), base[6] = {0};
    assert_non_null(tau);
    for (uint32_t k = 0; k < robot->count; k++) {
        const reference_state *state = &robot->states[k];
        tfa_request request = base_request(robot, state, TFA_OP_INVERSE_DYNAMICS);
        tfa_answer answer = {0};
        tfa_reply reply = {.tau = tau, .base_wrench = base, .answers = &answer};
        norm error = {0};
        int status = tfa_compute(robot->workspace, &request, &reply);
        add(&error, tau, state->nle, robot->joints);
        add(&error, base, state->base_nle, robot->floating ? 6 : 0);
        note(&o, status, robot, &reply, &error);
    }
    free(tau);
    return o;
}

static outcome lambda(const reference_robot *robot, tfa_method method)
{
    outcome o = {0};
    for (uint32_t k = 0; k < robot->count; k++) {
        const reference_state *state = &robot->states[k];
        tfa_request request = base_request(robot, state, TFA_OP_OPERATIONAL_INERTIA);
        double found[36] = {0};
        tfa_answer answer = {0};
        tfa_reply reply = {.lambda_inv = found, .answers = &answer};
        norm error = {0};
        request.method = method;
        request.tip_count = 1;
        request.tips[0] = robot->tip;
        int status = tfa_compute(robot->workspace, &request, &reply);
        add(&error, found, state->lambda_inv, 36);
        note(&o, status, robot, &reply, &error);
    }
    return o;
}

static const char *base_of(const char *path)
{
    return strrchr(path, '/') + 1;
}

/* Prints one figure of the table; counts it when it is beyond the bound. */
static int show(const char *what, const outcome *o)
{
    int bad = o->answered > 0 && !(o->worst <= BOUND);
    if (o->answered)
        printf("  %-22s %8.1e%s", what, o->worst, bad ? "  BEYOND" : "");
    else
        printf("  %-22s %8s", what, "-");
    if (o->refused)
        printf("  refused %u states: inertia of body '%s'", o->refused, o->invalid_field);
    if (o->fallbacks)
        printf("  %u fell back", o->fallbacks);
    putchar('\n');
    return bad;
}

static void test_robot(void **state)
{
    const char *path = *state;
    reference_robot robot;
    int bad = 0;
    assert_int_equal(reference_load(&robot, path, robots), 0);
    outcome aba = forward(&robot, TFA_METHOD_ABA, TFA_REFINE_DEFAULT);
    outcome crba = forward(&robot, TFA_METHOD_CRBA, TFA_REFINE_DEFAULT);
    outcome tfa = forward(&robot, TFA_METHOD_TFA, 1);
    outcome rnea = inverse(&robot);
    outcome propagation = lambda(&robot, TFA_METHOD_PROPAGATION);
    printf("%s: %u joints%s, worst of %u states\n", base_of(path), robot.joints,
           robot.floating ? " and a floating base" : "", robot.count);
    bad += show("qdd aba", &aba);
    bad += show("qdd crba", &crba);
    bad += show("qdd tfa refine 1", &tfa);
    bad += show("bias force rnea", &rnea);
    bad += show("lambda_inv propagation", &propagation);
    /* only tfa may refuse, and then always or never: a body's inertia does not change */
    assert_int_equal(aba.refused + crba.refused + rnea.refused + propagation.refused, 0);
    assert_true(tfa.refused == 0 || tfa.refused == robot.count);
    assert_int_equal(aba.answered, robot.count);
    assert_true(robot.count > 0);
    assert_int_equal(bad, 0);
    reference_free(&robot);
}

int main(void)
{
    char pattern[1024];
    glob_t files = {0};
    snprintf(pattern, sizeof pattern, "%s/*.json", references);
    if (glob(pattern, 0, NULL, &files) != 0 || files.gl_pathc == 0) {
        printf("skipped: no reference answers at %s\n", references);
        globfree(&files);
        return SKIPPED;
    }
    struct CMUnitTest *tests = calloc(files.gl_pathc, sizeof *tests);
    if (!tests)
        return 1;
    for (size_t i = 0; i < files.gl_pathc; i++)
        tests[i] = (struct CMUnitTest){.name = base_of(files.gl_pathv[i]),
                                       .test_func = test_robot,
                                       .initial_state = files.gl_pathv[i]};
    int failed = _cmocka_run_group_tests("reference", tests, files.gl_pathc, NULL, NULL);
    free(tests);
    globfree(&files);
    return failed;
}
