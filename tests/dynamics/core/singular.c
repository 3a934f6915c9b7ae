/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Robots at the edge of what has an answer: massless bodies, point masses, a singular M.
 */
#include "models.h"
#include "support/fixture.h"
#include "support/small_robot.h"
#include "test.h"

/* A universal joint: `a` about x carries a cross without mass, `b` about z a point mass that lies
 * at 1, 0, 0. */
static void universal_joint(small_robot *u)
{
    small_robot_begin(u);
    small_robot_add(u, 0, TFA_JOINT_REVOLUTE, 1, 0, 0);
    small_robot_add(u, 1, TFA_JOINT_REVOLUTE, 0, 0, 1);
    u->link[2].mass = 2;
    u->link[2].com[0] = 1;
}

static const double q[] = {0.3, 0.5, 0.3, 0, 0.3, -1.2}; /* M is singular where q_b = 0 */
static const double v[] = {1, -0.5, 0.2, 0.1, 0, 2};
static const double tau[] = {0.7, 0.2, 0.1, 1, -1, 0.4};

static const tfa_request three_states = {.op = TFA_OP_FORWARD_DYNAMICS,
                                         .refine = 0,
                                         .count = 3,
                                         .tip_count = 1,
                                         .tips = {2},
                                         .q = q,
                                         .v = v,
                                         .tau = tau};

/* The state in the middle has no answer; its neighbours have theirs. */
TEST(singular_state_stands_alone)
{
    static const tfa_method methods[] = {TFA_METHOD_AUTO, TFA_METHOD_ABA, TFA_METHOD_CRBA};
    small_robot u;
    test_robot robot;
    universal_joint(&u);
    fixture_open_description("universal joint", &u.d, TFA_BASE_FIXED, &robot);
    for (size_t m = 0; m < 3; m++)
        for (tfa_op op = TFA_OP_FORWARD_DYNAMICS; op <= TFA_OP_OPERATIONAL_INERTIA; op += 2) {
            double qdd[6], lambda[3 * 36], want[2], want_lambda[36];
            tfa_answer answers[3];
            tfa_reply reply = {.qdd = qdd, .lambda_inv = lambda, .answers = answers};
            tfa_request r = three_states;
            r.op = op;
            r.method = methods[m];
            assert_int_equal(tfa_compute(robot.f64, &r, &reply), TFA_E_NOT_COMPUTED);
            assert_int_equal(reply.status, TFA_E_NOT_COMPUTED);
            assert_int_equal(reply.state, 1);
            assert_int_equal(reply.field, TFA_FIELD_BODY);
            assert_int_equal(reply.index, tfa_model_body_frame(robot.model, 0));
            assert_int_equal(answers[1].status, TFA_E_NOT_COMPUTED);
            for (uint32_t k = 0; k < 3; k += 2) {
                oracle_set_state(robot.o, &r, k);
                oracle_forward(robot.o, tau + 2 * k, NULL, want, NULL);
                oracle_lambda_inv(robot.o, r.tips, 1, r.frame, want_lambda);
                assert_int_equal(answers[k].status, TFA_OK);
                if (op == TFA_OP_FORWARD_DYNAMICS)
                    assert_within(&robot, "qdd", relative_error(qdd + 2 * k, want, 2), 1e-13, NULL);
                assert_within(&robot, "lambda_inv",
                              relative_error(lambda + 36 * k, want_lambda, 36), 1e-13, NULL);
            }
        }
    fixture_close(&robot);
}

/* TFA and CFA invert the inertias on the main chain: they name the body that has none. */
TEST(tfa_names_the_body)
{
    for (int solid = 0; solid < 2; solid++) {
        small_robot u;
        test_robot robot;
        double qdd[6], lambda[3 * 36];
        tfa_answer answers[3];
        tfa_reply reply = {.qdd = qdd, .lambda_inv = lambda, .answers = answers};
        universal_joint(&u);
        /* solid: the cross is regular, the point mass is not */
        small_robot_load(&u, 1, solid, 0.1 * solid, 0.1 * solid, 0.1 * solid);
        fixture_open_description("universal joint", &u.d, TFA_BASE_FIXED, &robot);
        assert_int_equal(tfa_model_summarise(robot.model).singular_body, solid);
        static const tfa_method methods[] = {TFA_METHOD_TFA, TFA_METHOD_TFA_CR, TFA_METHOD_CFA,
                                             TFA_METHOD_CFA_CR, TFA_METHOD_TFA_ONE_SIDED};
        for (size_t m = 0; m < sizeof methods / sizeof *methods; m++) {
            tfa_request r = three_states;
            r.method = methods[m];
            r.op = r.method == TFA_METHOD_TFA_ONE_SIDED ? TFA_OP_OPERATIONAL_INERTIA
                                                        : TFA_OP_FORWARD_DYNAMICS;
            assert_int_equal(tfa_compute(robot.f64, &r, &reply), TFA_E_SINGULAR);
            assert_int_equal(reply.field, TFA_FIELD_BODY);
            assert_int_equal(reply.index, tfa_model_body_frame(robot.model, (uint32_t)solid));
            assert_int_equal(reply.state, 0);
            for (int k = 0; k < 3; k++)
                assert_int_equal(answers[k].status, TFA_E_SINGULAR);
        }
        fixture_close(&robot);
    }
}

/* A leaf without mass has no equation of motion, unless its rotor has inertia. */
TEST(massless_leaf_needs_armature)
{
    small_robot u;
    tfa_model *model = NULL;
    tfa_report report = {0};
    universal_joint(&u);
    small_robot_load(&u, 1, 1, 0.1, 0.1, 0.1);
    u.link[2].mass = 0;
    assert_int_equal(tfa_model_create(&u.d, NULL, &report, &model), TFA_E_NO_MASS);
    assert_null(model);
    assert_int_equal(report.errors, 1);
    tfa_report_free(&report);

    test_robot robot;
    double qdd[6], want[2];
    tfa_reply reply = {.qdd = qdd};
    tfa_request r = three_states;
    u.joint[1].armature = 0.05;
    fixture_open_description("universal joint", &u.d, TFA_BASE_FIXED, &robot);
    r.tip_count = 0;
    compute_ok(&robot, robot.f64, &r, &reply);
    for (uint32_t k = 0; k < 3; k++) {
        oracle_set_state(robot.o, &r, k);
        oracle_forward(robot.o, tau + 2 * k, NULL, want, NULL);
        assert_within(&robot, "qdd", relative_error(qdd + 2 * k, want, 2), 1e-13, NULL);
    }
    fixture_close(&robot);
}

/* A free brick: Lambda^-1 at its centre is diag(1/m, 1/I), whatever its pose. One revolute
 * joint: rank 1. */
TEST(spectrum_of_closed_forms)
{
    static const double pose[7] = {1, 2, 3, 0.5, -0.5, 0.5, 0.5}, angle[1] = {0.4};
    small_robot brick; /* rank 6 all the same */
    double lambda[36];
    tfa_spectrum s;
    tfa_reply reply = {.lambda_inv = lambda, .spectrum = &s};
    tfa_request r = {.op = TFA_OP_OPERATIONAL_INERTIA,
                     .flags = TFA_WANT_SPECTRUM,
                     .refine = TFA_REFINE_DEFAULT,
                     .count = 1,
                     .tip_count = 1,
                     .q = angle,
                     .base_pose = pose};
    for (int leaf = 0; leaf < 2; leaf++) {
        const tfa_model_options options = {.base = leaf ? TFA_BASE_FIXED : TFA_BASE_FLOATING};
        small_robot_begin(&brick);
        if (leaf)
            small_robot_add(&brick, 0, TFA_JOINT_REVOLUTE, 0, 0, 1);
        small_robot_load(&brick, (uint32_t)leaf, leaf ? 1 : 4, 2e-7, 1.5e-7, 1e-7);
        tfa_model *model = compiled(&brick.d, &options);
        tfa_workspace *w = fixture_workspace(model, TFA_F64);
        r.tips[0] = (uint32_t)leaf;
        assert_int_equal(tfa_compute(w, &r, &reply), TFA_OK);
        assert_int_equal(s.rank, leaf ? 1 : 6);
        assert_true(fabs(s.eig_max - 1e7) < 1e-6);
        assert_true(fabs(s.eig_min - (leaf ? 0 : 0.25)) < 1e-6);
        tfa_workspace_free(w);
        tfa_model_free(model);
    }
}
