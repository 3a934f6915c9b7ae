/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Divide and conquer, and the block Hessenberg matrix: every length of a chain, fused joints, and
 * what they refuse.
 */
#include "model/model.h"
#include "models.h"
#include "support/fixture.h"
#include "test.h"

/* A random chain of so many moving joints, of all types or revolute ones. */
static void open_chain(test_robot *robot, uint32_t joints, bool all_types, tfa_precision precision)
{
    const random_robot_options options = {RANDOM_CHAIN, joints, all_types, 0, 0.3, false};
    *robot = (test_robot){
        .base = joints % 2 ? TFA_BASE_FLOATING : TFA_BASE_FIXED, .seed = joints, .random = true};
    const tfa_model_options model = {.base = robot->base};
    snprintf(robot->name, sizeof robot->name, "chain of %u %s joints", (unsigned)joints,
             all_types ? "mixed" : "revolute");
    robot->description = random_robot_create(joints, &options);
    robot->model = compiled(robot->description, &model);
    robot->nv = tfa_model_v_count(robot->model);
    robot->n = robot->nv + tfa_model_base_freedoms(robot->model);
    robot->o = oracle_create(robot->description, robot->base);
    assert_non_null(robot->o);
    *(precision == TFA_F128 ? &robot->f128 : &robot->f64) =
        fixture_workspace(robot->model, precision);
}

static double worst_estimate, worst_difference;

/* In quadruple precision: |M^-1 (tau - RNEA(qdd))| / |qdd| by the method's own factors, which is
 * what is left of its 34 digits; and the same doubles as the articulated-body algorithm's. */
static void length_in_f128(uint32_t joints, bool all_types, tfa_method method)
{
    test_robot robot;
    open_chain(&robot, joints, all_types, TFA_F128);
    random_states *x = random_states_create(joints, robot.description, robot.o, 1, 2);
    tfa_request r = fixture_request(&robot, x);
    double *got = calloc(robot.nv + 6, sizeof *got), *want = calloc(robot.nv + 6, sizeof *want);
    tfa_answer answer;
    tfa_reply reply = {.qdd = want, .base_acceleration = want + robot.nv, .answers = &answer};
    r.refine = 0;
    r.method = TFA_METHOD_ABA;
    compute_ok(&robot, robot.f128, &r, &reply);
    r.method = method;
    r.estimate = TFA_ESTIMATE_ALWAYS;
    reply.qdd = got;
    reply.base_acceleration = got + robot.nv;
    compute_ok(&robot, robot.f128, &r, &reply);
    assert_int_equal(answer.method, method);
    assert_int_equal(answer.flags, TFA_ANSWER_ESTIMATED);
    assert_within(&robot, tfa_method_name(method), answer.error_estimate, 1e-20, &worst_estimate);
    const size_t n = robot.nv + (robot.base == TFA_BASE_FLOATING ? 6 : 0);
    assert_within(&robot, tfa_method_name(method), relative_error(got, want, n), 1e-15,
                  &worst_difference);
    free(want);
    free(got);
    random_states_free(x);
    fixture_close(&robot);
}

TEST(every_length_of_dca)
{
    for (uint32_t n = 1; n <= 130; n++)
        length_in_f128(n, n % 3 == 0, TFA_METHOD_DCA);
    print_message("  dca: left %.1e, against aba %.1e\n", worst_estimate, worst_difference);
}

TEST(every_length_of_hessenberg)
{
    worst_estimate = worst_difference = 0;
    for (uint32_t n = 1; n <= 130; n += n < 40 ? 1 : 9)
        length_in_f128(n, n % 3 == 0, TFA_METHOD_HESSENBERG);
    print_message("  hessenberg: left %.1e, against aba %.1e\n", worst_estimate, worst_difference);
}

/* ---- joints with several axes that are not at right angles ---- */

/* Links without mass between joints fuse these into one joint; its axes turn with q. */
TEST(fused_joints)
{
    double largest[2] = {0};
    uint32_t fused = 0;
    for (uint64_t seed = 1; seed <= 60; seed++) {
        const random_robot_options options = {RANDOM_CHAIN,       12,   false, 0,
                                              seed % 2 ? 0.4 : 0, false};
        test_robot robot = {.name = "chain with massless links", .seed = seed};
        random_source s = {seed};
        robot.description = random_robot_create(seed, &options);
        random_robot_empty_links(&s, robot.description, 0.4);
        if (tfa_model_create(robot.description, NULL, NULL, &robot.model) != TFA_OK) {
            random_robot_free(robot.description); /* two of its joints move the same mass alike */
            continue;
        }
        robot.f64 = fixture_workspace(robot.model, TFA_F64);
        robot.o = oracle_create(robot.description, TFA_BASE_FIXED);
        random_states *x = random_states_create(seed, robot.description, robot.o, 1, 2);
        tfa_request r = fixture_request(&robot, x);
        double got[12], want[12];
        tfa_reply reply = {.qdd = got};
        oracle_set_state(robot.o, &r, 0);
        oracle_forward(robot.o, x->tau, NULL, want, NULL);
        const bool answers = tfa_model_summarise(robot.model).singular_body < 0;
        fused += answers && robot.model->joints_nd > 0;
        for (int m = 0; answers && m < 2; m++) {
            r.method = m ? TFA_METHOD_HESSENBERG : TFA_METHOD_DCA;
            r.refine = 1;
            r.estimate = TFA_ESTIMATE_NEVER;
            compute_ok(&robot, robot.f64, &r, &reply);
            assert_within(&robot, tfa_method_name(r.method), relative_error(got, want, 12), 1e-11,
                          &largest[m]);
        }
        random_states_free(x);
        random_robot_free(robot.description);
        oracle_free(robot.o);
        tfa_workspace_free(robot.f64);
        tfa_model_free(robot.model);
    }
    assert_true(fused >= 20);
    print_message("  %u robots; dca %.1e, hessenberg %.1e\n", (unsigned)fused, largest[0],
                  largest[1]);
}

/* ---- refusals ---- */

/* A chain longer than what hessenberg reserves memory for; dca answers it. */
TEST(hessenberg_refuses_long_chains)
{
    for (uint32_t more = 0; more < 2; more++) {
        test_robot robot;
        /* 255 joints on a floating base: as long as may be; 257 of them are not */
        open_chain(&robot, TFA_HESSENBERG_LONGEST - 1 + 2 * more, false, TFA_F64);
        double *qdd = calloc(robot.nv, sizeof *qdd);
        tfa_reply reply = {.qdd = qdd};
        random_states *x = random_states_create(1, robot.description, robot.o, 1, 0);
        tfa_request r = fixture_request(&robot, x);
        r.method = TFA_METHOD_HESSENBERG;
        assert_int_equal(tfa_compute(robot.f64, &r, &reply), more ? TFA_E_UNSUPPORTED : TFA_OK);
        assert_int_equal(reply.field, more ? TFA_FIELD_METHOD : TFA_FIELD_NONE);
        assert_int_equal(reply.index, more ? TFA_HESSENBERG_LONGEST : 0);
        r.method = TFA_METHOD_DCA;
        assert_int_equal(tfa_compute(robot.f64, &r, &reply), TFA_OK);
        random_states_free(x);
        free(qdd);
        fixture_close(&robot);
    }
}
