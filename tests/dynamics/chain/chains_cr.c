/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Cyclic reduction and constraint forces: every length of a chain, known hard chains; every robot
 * by these, by divide and conquer and by the block Hessenberg matrix; what they refuse.
 */
#include "models.h"
#include "support/chains_scan.h"
#include "support/fixture.h"
#include "test.h"

static const tfa_method methods[] = {TFA_METHOD_TFA_CR, TFA_METHOD_CFA, TFA_METHOD_CFA_CR};
#define METHODS (sizeof methods / sizeof *methods)

static const char *name_of(tfa_method method)
{
    return tfa_method_name((uint32_t)method);
}

/* The model, its oracle and its workspaces, for robot->description on robot->base */
static void open_model(test_robot *robot)
{
    const tfa_model_options options = {.base = robot->base};
    robot->model = compiled(robot->description, &options);
    robot->o = oracle_create(robot->description, robot->base);
    assert_non_null(robot->o);
    robot->nv = oracle_v_count(robot->o);
    robot->n = oracle_freedoms(robot->o);
    robot->f64 = fixture_workspace(robot->model, TFA_F64);
    robot->f128 = fixture_workspace(robot->model, TFA_F128);
}

static void close_model(test_robot *robot)
{
    tfa_workspace_free(robot->f128);
    tfa_workspace_free(robot->f64);
    oracle_free(robot->o);
    tfa_model_free(robot->model);
}

/* qdd, then the acceleration of a floating base, of one state */
static tfa_answer forward(const test_robot *robot, tfa_workspace *w, const tfa_request *request,
                          tfa_method method, double *qdd)
{
    tfa_answer answer;
    tfa_reply reply = {.qdd = qdd, .base_acceleration = qdd + robot->nv, .answers = &answer};
    tfa_request r = *request;
    r.method = method;
    compute_ok(robot, w, &r, &reply);
    return answer;
}

/* ---- every length: powers of two, what is between them, and joints of all types ---- */

static double left[METHODS], against_aba[METHODS], cr_against_lu;

/* In quadruple precision: |M^-1 (tau - RNEA(qdd))| / |qdd| by the method's own factors, which is
 * what is left of its 34 digits; and the same doubles as the articulated-body algorithm's. */
static void length_in_f128(const test_robot *robot, tfa_request r)
{
    double *want = calloc(2 * (size_t)robot->n, sizeof *want), *got = want + robot->n;
    (void)forward(robot, robot->f128, &r, TFA_METHOD_ABA, want);
    r.estimate = TFA_ESTIMATE_ALWAYS;
    for (size_t m = 0; m < METHODS; m++) {
        const tfa_answer answer = forward(robot, robot->f128, &r, methods[m], got);
        assert_int_equal(answer.method, methods[m]);
        assert_within(robot, name_of(methods[m]), answer.error_estimate, 1e-25, &left[m]);
        assert_within(robot, name_of(methods[m]), relative_error(got, want, robot->n), 4e-16,
                      &against_aba[m]);
    }
    free(want);
}

/* In double: cyclic reduction loses no more than serial elimination of the same system. */
static void length_in_f64(const test_robot *robot, tfa_request r)
{
    double *want = calloc(3 * (size_t)robot->n, sizeof *want);
    double *lu = want + robot->n, *cr = lu + robot->n;
    r.estimate = TFA_ESTIMATE_NEVER;
    (void)forward(robot, robot->f128, &r, TFA_METHOD_ABA, want);
    (void)forward(robot, robot->f64, &r, TFA_METHOD_TFA, lu);
    (void)forward(robot, robot->f64, &r, TFA_METHOD_TFA_CR, cr);
    assert_within(robot, "tfa-cr against tfa", relative_error(cr, lu, robot->n), 1e-9,
                  &cr_against_lu);
    assert_within(robot, "tfa-cr", relative_error(cr, want, robot->n),
                  100 * relative_error(lu, want, robot->n) + 1e-13, NULL);
    free(want);
}

TEST(every_length)
{
    for (uint32_t joints = 1; joints <= 130; joints++) {
        const bool all_types = joints % 3 == 0;
        const random_robot_options options = {RANDOM_CHAIN, joints, all_types, 0, 0, false};
        test_robot robot = {.base = joints % 2 ? TFA_BASE_FLOATING : TFA_BASE_FIXED};
        snprintf(robot.name, sizeof robot.name, "chain of %u %s joints", (unsigned)joints,
                 all_types ? "mixed" : "revolute");
        robot.description = random_robot_create(joints, &options);
        open_model(&robot);
        random_states *x = random_states_create(joints, robot.description, robot.o, 1, 2);
        tfa_request r = fixture_request(&robot, x);
        r.refine = 0;
        length_in_f128(&robot, r);
        length_in_f64(&robot, r);
        random_states_free(x);
        close_model(&robot);
        random_robot_free(robot.description);
    }
    for (size_t m = 0; m < METHODS; m++)
        print_message("  %-8s f128: left %.1e, against aba %.1e\n", name_of(methods[m]), left[m],
                      against_aba[m]);
    print_message("  tfa-cr against tfa, f64: %.1e\n", cr_against_lu);
}

/* ---- every robot, in double, with several right-hand sides ---- */

static const struct {
    tfa_method method;
    uint32_t refine;
    double bound;
} ways[] = {
    {TFA_METHOD_TFA_CR, 0, 2e-11},     {TFA_METHOD_TFA_CR, 1, 5e-14},
    {TFA_METHOD_CFA, 0, 2e-11},        {TFA_METHOD_CFA, 1, 5e-14},
    {TFA_METHOD_CFA_CR, 0, 2e-11},     {TFA_METHOD_CFA_CR, 1, 5e-14},
    {TFA_METHOD_DCA, 0, 1e-10},        {TFA_METHOD_DCA, 1, 5e-14},
    {TFA_METHOD_HESSENBERG, 0, 1e-10}, {TFA_METHOD_HESSENBERG, 1, 5e-14},
};
#define WAYS (sizeof ways / sizeof *ways)
static double worst[WAYS], worst_lambda[WAYS];

static void check_way(const test_robot *robot, tfa_request r, size_t w)
{
    double *want = calloc(2 * (size_t)robot->n, sizeof *want), *got = want + robot->n;
    double lambda[144], want_lambda[144];
    tfa_reply reply = {.qdd = got, .base_acceleration = got + robot->nv, .lambda_inv = lambda};
    oracle_set_state(robot->o, &r, 0);
    oracle_forward(robot->o, r.tau, r.base_wrench, want, want + robot->nv);
    oracle_lambda_inv(robot->o, r.tips, 2, r.frame, want_lambda);
    r.method = ways[w].method;
    r.refine = ways[w].refine;
    compute_ok(robot, robot->f64, &r, &reply);
    assert_within(robot, name_of(r.method), relative_error(got, want, robot->n), ways[w].bound,
                  &worst[w]);
    assert_within(robot, name_of(r.method), relative_error(lambda, want_lambda, 144), ways[w].bound,
                  &worst_lambda[w]);
    free(want);
}

static void every_way(const test_robot *robot, tfa_request r, bool armature)
{
    const int32_t singular = tfa_model_summarise(robot->model).singular_body;
    for (size_t w = 0; w < WAYS; w++) {
        tfa_reply reply = {0};
        r.method = ways[w].method;
        const int status = tfa_request_check(robot->model, &r, &reply);
        const bool forces = r.method == TFA_METHOD_CFA || r.method == TFA_METHOD_CFA_CR;
        if (armature && forces && status == TFA_E_METHOD)
            continue; /* by name: refuses_armature_of_a_main_chain */
        assert_int_equal(status, TFA_OK);
        if (singular < 0) {
            check_way(robot, r, w);
            continue;
        }
        assert_int_equal(tfa_compute(robot->f64, &r, &reply), TFA_E_SINGULAR);
        assert_int_equal(reply.field, TFA_FIELD_BODY);
        assert_int_equal(reply.index, tfa_model_body_frame(robot->model, (uint32_t)singular));
    }
}

/* The robot as it is, and without armature, so that constraint forces see every robot. */
static void robot_in_double(test_robot *robot)
{
    test_robot unestimated = *robot;
    bool armature = false;
    random_states *x = fixture_states(robot, 0, 1, 3);
    tfa_request r = fixture_request(robot, x);
    r.estimate = TFA_ESTIMATE_NEVER;
    r.tip_count = 2;
    r.tips[0] = (uint32_t)robot->description->link_count - 1;
    r.tips[1] = (uint32_t)robot->description->link_count / 2;
    for (size_t j = 0; j < robot->description->joint_count; j++)
        armature |= robot->description->joints[j].armature > 0;
    every_way(robot, r, armature);
    for (size_t j = 0; j < robot->description->joint_count; j++)
        robot->description->joints[j].armature = 0;
    if (armature) {
        open_model(&unestimated);
        every_way(&unestimated, r, false);
        close_model(&unestimated);
    }
    random_states_free(x);
}

TEST(every_robot_in_double)
{
    for_every_robot(robot_in_double, false);
    for (size_t w = 0; w < WAYS; w++)
        print_message("  %-10s refine %u: qdd %.1e, lambda_inv %.1e, bound %g\n",
                      name_of(ways[w].method), (unsigned)ways[w].refine, worst[w], worst_lambda[w],
                      ways[w].bound);
}

/* ---- joints without mass between them, whose axes stand at any angle to each other ---- */

static double worst_fused;

static void fused_robot(uint64_t seed, uint32_t *fused)
{
    random_source s = {seed};
    const random_robot_options options = {RANDOM_CHAIN, 12, false, 0, 0, false};
    test_robot robot = {.base = seed % 4 < 2 ? TFA_BASE_FLOATING : TFA_BASE_FIXED};
    snprintf(robot.name, sizeof robot.name, "fused joints, seed %u", (unsigned)seed);
    robot.description = random_robot_create(seed, &options);
    random_robot_empty_links(&s, robot.description, 0.3);
    if (tfa_model_size(robot.description, NULL) == 0) { /* more than six joints in a row */
        random_robot_free(robot.description);
        return;
    }
    open_model(&robot);
    random_states *x = random_states_create(seed, robot.description, robot.o, 1, 2);
    tfa_request r = fixture_request(&robot, x);
    double *want = calloc(2 * (size_t)robot.n, sizeof *want), *got = want + robot.n;
    const tfa_model_summary summary = tfa_model_summarise(robot.model);
    r.refine = 0;
    r.estimate = TFA_ESTIMATE_ALWAYS;
    (void)forward(&robot, robot.f128, &r, TFA_METHOD_ABA, want);
    for (size_t m = 0; summary.singular_body < 0 && m < METHODS; m++) {
        const tfa_answer answer = forward(&robot, robot.f128, &r, methods[m], got);
        assert_within(&robot, name_of(methods[m]), answer.error_estimate, 1e-25, &worst_fused);
        assert_within(&robot, name_of(methods[m]), relative_error(got, want, robot.n), 4e-16, NULL);
    }
    *fused += summary.singular_body < 0 ? summary.fused : 0;
    free(want);
    random_states_free(x);
    close_model(&robot);
    random_robot_free(robot.description);
}

TEST(fused_joints)
{
    uint32_t fused = 0;
    for (uint64_t seed = 1; seed <= 60; seed++)
        fused_robot(seed, &fused);
    print_message("  %u fused joints, f128: left %.1e\n", fused, worst_fused);
    assert_true(fused > 60);
}

/* ---- known hard chains: tau from a random qdd, error against aba in quadruple precision ---- */

/* What an independent implementation lost on one seed of each. Read digits: seeds differ by 30. */
#define SEEDS_DIFFER 30
static const struct {
    chain_mechanism mechanism;
    uint32_t joints;
    double known[METHODS]; /* tfa-cr, cfa, cfa-cr */
} hard[] = {
    {CHAIN_STRAIGHT, 128, {1e-9, 2e-10, 2e-10}}, {CHAIN_HELIX, 1024, {2e-5, 8e-6, 8e-6}},
    {CHAIN_RANDOM, 8, {8e-13, 4e-13, 4e-13}},    {CHAIN_RANDOM, 128, {4e-8, 6e-8, 6e-8}},
    {CHAIN_RANDOM, 1024, {4e-5, 7e-5, 7e-5}},    {CHAIN_THIN, 128, {3e-2, 4e-2, 4e-2}},
};

/* tau = RNEA(random qdd) at rest without gravity, so that the joints' forces are all there is */
static void torques_of_random_accelerations(const test_robot *robot, tfa_request *r, double *tau)
{
    random_source s = {7};
    double *qdd = calloc(robot->nv, sizeof *qdd);
    for (uint32_t k = 0; k < robot->nv; k++)
        qdd[k] = random_uniform(&s, -1, 1);
    tfa_reply reply = {.tau = tau};
    r->op = TFA_OP_INVERSE_DYNAMICS;
    r->qdd = qdd;
    compute_ok(robot, robot->f128, r, &reply);
    r->op = TFA_OP_FORWARD_DYNAMICS;
    r->qdd = NULL;
    r->tau = tau;
    free(qdd);
}

static void hard_chain(size_t h)
{
    static const double weightless[3] = {0, 0, 0};
    test_robot robot = {.description = chain_create(hard[h].mechanism, hard[h].joints, 1)};
    const size_t n = hard[h].joints;
    double *q = calloc(11 * n, sizeof *q), *tau = q + 7 * n;
    double *want = tau + n, *got = want + n;
    snprintf(robot.name, sizeof robot.name, "%s %zu", chain_mechanism_names[hard[h].mechanism], n);
    robot.model = compiled(robot.description, NULL);
    robot.n = robot.nv = tfa_model_v_count(robot.model);
    robot.f64 = fixture_workspace(robot.model, TFA_F64);
    robot.f128 = fixture_workspace(robot.model, TFA_F128);
    chain_coordinates(hard[h].mechanism, robot.description, 3, q);
    tfa_request r = {.count = 1, .q = q, .gravity = weightless};
    torques_of_random_accelerations(&robot, &r, tau);
    (void)forward(&robot, robot.f128, &r, TFA_METHOD_ABA, want);
    r.estimate = TFA_ESTIMATE_NEVER;
    print_message("  %-14s", robot.name);
    (void)forward(&robot, robot.f64, &r, TFA_METHOD_ABA, got);
    print_message(" aba %.0e", relative_error(got, want, n));
    (void)forward(&robot, robot.f64, &r, TFA_METHOD_TFA, got);
    const double lu = relative_error(got, want, n);
    print_message(" tfa %.0e", lu);
    for (size_t m = 0; m < METHODS; m++) {
        (void)forward(&robot, robot.f64, &r, methods[m], got);
        print_message(" %s %.0e", name_of(methods[m]), relative_error(got, want, n));
        assert_within(&robot, name_of(methods[m]), relative_error(got, want, n),
                      SEEDS_DIFFER * fmin(hard[h].known[m], lu), NULL);
    }
    print_message("\n");
    close_model(&robot);
    chain_free(robot.description);
    free(q);
}

TEST(hard_chains_lose_the_known_digits)
{
    for (size_t h = 0; h < sizeof hard / sizeof *hard; h++)
        hard_chain(h);
}

/* ---- refusals ---- */

/* A long branch and a short one: armature on the long one is refused, on the short one answered. */
TEST(refuses_armature_of_a_main_chain)
{
    for (uint32_t joint = 0; joint < 4; joint++) {
        const random_robot_options options = {RANDOM_CHAIN, 4, false, 0, 0, false};
        test_robot robot = {.name = "two limbs", .base = TFA_BASE_FLOATING};
        robot.description = random_robot_create(5, &options);
        robot.description->joints[3].parent = 0; /* joints 0 1 2 in a row, 3 on the root */
        robot.description->joints[joint].armature = 0.3;
        open_model(&robot);
        random_states *x = random_states_create(5, robot.description, robot.o, 1, 1);
        tfa_request r = fixture_request(&robot, x);
        double want[10], got[10];
        (void)forward(&robot, robot.f128, &r, TFA_METHOD_ABA, want);
        for (size_t m = 1; m < METHODS; m++) {
            tfa_reply reply = {.qdd = got, .base_acceleration = got + 4};
            r.method = methods[m];
            const int status = tfa_compute(robot.f64, &r, &reply);
            assert_int_equal(status, joint < 3 ? TFA_E_METHOD : TFA_OK);
            assert_int_equal(reply.field, joint < 3 ? TFA_FIELD_METHOD : TFA_FIELD_NONE);
            assert_int_equal(reply.index, joint < 3 ? (uint32_t)methods[m] : 0);
            if (status == TFA_OK)
                assert_within(&robot, name_of(r.method), relative_error(got, want, 10), 1e-13,
                              NULL);
        }
        random_states_free(x);
        close_model(&robot);
        random_robot_free(robot.description);
    }
}
