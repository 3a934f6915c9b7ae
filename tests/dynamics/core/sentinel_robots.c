/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Estimates and robots: an estimate does not change which code computes an answer, and a robot
 * whose M is singular but for rounding is refused by the name of a body.
 */
#include "models.h"
#include "support/questions.h"
#include "support/small_robot.h"
#include "test.h"

#define STATES 19 /* whole vectors, and a rest */

/* ---- the same bits with an estimate as without ---- */

static void robot_has_the_same_bits(test_robot *robot)
{
    static const tfa_method methods[] = {TFA_METHOD_AUTO, TFA_METHOD_ABA, TFA_METHOD_SCAN};
    random_states *x = fixture_states(robot, 0, STATES, 0);
    answers *unestimated = answers_create(robot, STATES), *reported = answers_create(robot, STATES);
    tfa_request r = fixture_request(robot, x);
    for (size_t m = 0; m < sizeof methods / sizeof *methods; m++)
        for (r.count = 1; r.count <= STATES; r.count += STATES - 1) {
            r.method = methods[m];
            r.estimate = TFA_ESTIMATE_NEVER;
            answers_ask(unestimated, robot->f64, &r);
            r.estimate = TFA_ESTIMATE_ALWAYS;
            answers_ask(reported, robot->f64, &r);
            for (uint32_t k = 0; k < r.count; k++) {
                assert_int_equal(unestimated->each[k].status, TFA_OK);
                assert_int_equal(reported->each[k].status, TFA_OK);
                assert_int_equal(reported->each[k].flags, TFA_ANSWER_ESTIMATED);
            }
            if (memcmp(unestimated->memory, reported->memory,
                       STATES * reported->numbers * sizeof(double)) != 0)
                fail_msg("%s, %s, %u states: other bits with an estimate", robot->name,
                         tfa_method_name((uint32_t)r.method), (unsigned)r.count);
        }
    answers_free(reported);
    answers_free(unestimated);
    random_states_free(x);
}

static void files_have_the_same_bits(test_robot *robot)
{
    if (!robot->random)
        robot_has_the_same_bits(robot);
}

EVERY_ROBOT(an_estimate_changes_no_answer, files_have_the_same_bits, false)

/* ---- singular but for rounding ---- */

/* An arm behind two joints with nothing between them, whose axes are `angle` apart */
static tfa_model *two_axes(double angle)
{
    static small_robot arm;
    small_robot_begin(&arm);
    small_robot_add(&arm, 0, TFA_JOINT_REVOLUTE, 0, 0, 1);
    small_robot_add(&arm, 1, TFA_JOINT_REVOLUTE, sin(angle), 0, cos(angle));
    small_robot_load(&arm, 2, 1, 0.01, 0.01, 0.01);
    arm.link[2].com[0] = 0.3;
    return compiled(&arm.d, NULL);
}

/* At these angles D of one joint is between rounding and safe. */
TEST(nearly_parallel_axes_never_answer_in_silence)
{
    for (double angle = 1e-2; angle > 1e-11; angle /= 10) {
        tfa_model *model = two_axes(angle);
        tfa_workspace *w = workspace_for(model, NULL);
        double q[2] = {0.7, -0.4}, v[2] = {0.3, 0.2}, tau[2] = {1, -2}, qdd[2];
        tfa_answer answer;
        const tfa_request r = {.op = TFA_OP_FORWARD_DYNAMICS,
                               .count = 1,
                               .q = q,
                               .v = v,
                               .tau = tau,
                               .refine = TFA_REFINE_DEFAULT};
        tfa_reply reply = {.qdd = qdd, .answers = &answer};
        const int status = tfa_compute(w, &r, &reply);
        print_message("  axes %g rad apart: %s, estimate %.1e, flags %u\n", angle,
                      tfa_status_text(status), answer.error_estimate, answer.flags);
        if (status != TFA_OK) {
            assert_int_equal(status, TFA_E_NOT_COMPUTED);
            assert_int_equal(reply.field, TFA_FIELD_BODY);
        } else if (angle < 1e-4) {
            assert_true(answer.flags & TFA_ANSWER_SENTINEL && answer.error_estimate <= 1);
        }
        if (angle < 1e-8)
            assert_int_not_equal(status, TFA_OK);
        tfa_workspace_free(w);
        tfa_model_free(model);
    }
}

/* Torques that hold an arm still leave a qdd of the size of rounding: an answer, whatever its
 * relative error. */
TEST(balanced_forces_are_answered)
{
    tfa_model *model = two_axes(0.5);
    tfa_workspace *w = workspace_for(model, NULL);
    double q[2] = {0.7, -0.4}, tau[2], qdd[2];
    tfa_request r = {.op = TFA_OP_INVERSE_DYNAMICS, .count = 1, .q = q};
    tfa_reply reply = {.tau = tau};
    assert_int_equal(tfa_compute(w, &r, &reply), TFA_OK);
    r = (tfa_request){.op = TFA_OP_FORWARD_DYNAMICS,
                      .estimate = TFA_ESTIMATE_ALWAYS,
                      .count = 1,
                      .q = q,
                      .tau = tau,
                      .refine = TFA_REFINE_DEFAULT};
    reply = (tfa_reply){.qdd = qdd};
    assert_int_equal(tfa_compute(w, &r, &reply), TFA_OK);
    assert_true(fabs(qdd[0]) < 1e-12 && fabs(qdd[1]) < 1e-12);
    tfa_workspace_free(w);
    tfa_model_free(model);
}
