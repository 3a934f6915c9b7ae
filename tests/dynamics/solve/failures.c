/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Every method is driven into the failure that theory predicts and seen to fail; its twin asks
 * the same and leaves it to the defaults.
 */
#include "models.h"
#include "support/failures_table.h"
#include "support/fixture.h"
#include "test.h"

static tfa_workspace *workspace_of(const failure *row, const tfa_model *model,
                                   tfa_residual residual)
{
    const tfa_workspace_options options = {.precision = row->precision, .residual = residual};
    tfa_workspace *w = workspace_for(model, &options);
    return w;
}

static void unestimated(const failure *row, hard_robot *robot, const double *want, uint32_t count)
{
    double got[HARD_ROBOT_FREEDOMS];
    tfa_answer answer;
    tfa_reply reply = failure_reply(row, got, &answer);
    const tfa_request r = failure_unestimated(row, robot);
    tfa_workspace *w = workspace_of(row, robot->model, TFA_RESIDUAL_SAME);
    assert_int_equal(tfa_compute(w, &r, &reply), TFA_OK);
    const double error = relative_error(got, want, count);
    print_message("%s on %s: error %.1e\n", tfa_method_name(row->method), robot->name, error);
    assert_true(!(error < row->least)); /* NaN is a failure, too */
    tfa_workspace_free(w);
}

static void guarded(const failure *row, hard_robot *robot, const double *want, uint32_t count)
{
    double got[HARD_ROBOT_FREEDOMS];
    tfa_answer answer;
    tfa_reply reply = failure_reply(row, got, &answer);
    const tfa_request r = failure_by_default(row, robot);
    tfa_workspace *w = workspace_of(row, robot->model, row->residual);
    assert_int_equal(tfa_compute(w, &r, &reply), TFA_OK);
    failure_check(row, &reply, got, want, count, "guarded");
    tfa_workspace_free(w);
}

TEST(every_method_fails_and_the_service_does_not)
{
    static hard_robot robot;
    for (uint32_t k = 0; k < failure_count; k++) {
        double want[HARD_ROBOT_FREEDOMS];
        failure_open(&failures[k], &robot);
        const uint32_t count = failure_truth(&failures[k], &robot, want);
        unestimated(&failures[k], &robot, want, count);
        guarded(&failures[k], &robot, want, count);
        hard_robot_close(&robot);
    }
}

static bool has_row(tfa_op op, uint32_t method)
{
    for (uint32_t k = 0; k < failure_count; k++)
        if (failures[k].op == op && (uint32_t)failures[k].method == method &&
            failures[k].precision == TFA_F64)
            return true;
    return false;
}

/* auto is the method it chooses, and rnea solves nothing that could fail. */
TEST(every_method_has_a_row)
{
    for (uint32_t m = 0; tfa_method_describe(m); m++) {
        const tfa_method_info *row = tfa_method_describe(m);
        if (m == TFA_METHOD_AUTO || m == TFA_METHOD_RNEA)
            continue;
        if (row->forward_dynamics && !has_row(TFA_OP_FORWARD_DYNAMICS, m))
            fail_msg("%s: no failure of its accelerations", row->name);
        if (row->lambda && !has_row(TFA_OP_OPERATIONAL_INERTIA, m))
            fail_msg("%s: no failure of its lambda_inv", row->name);
    }
}

/* ABA's failure: a tip that weighs nothing has no equation of motion, and is refused by name. One
 * that weighs next to nothing is answered. */
TEST(a_massless_tip_is_refused)
{
    mechanism_options o = mechanism_defaults(MECHANISM_RANDOM, 8);
    tfa_description *d = mechanism_make(&o);
    tfa_report report = {0};
    tfa_model *model;
    char text[400] = "";
    assert_non_null(d);
    tfa_link *tip = &d->links[d->link_count - 1];
    tip->mass = 0;
    memset(tip->inertia, 0, sizeof tip->inertia);
    assert_int_equal(tfa_model_create(d, NULL, &report, &model), TFA_E_NO_MASS);
    for (size_t k = 0; k < report.count; k++)
        if (strcmp(report.messages[k].code, "massless-leaf") == 0)
            tfa_report_format(&report, k, text, sizeof text);
    print_message("  %s\n", text);
    assert_non_null(strstr(text, "joint8"));
    tfa_report_free(&report);
    mechanism_free(d);
}

TEST(a_tip_of_next_to_nothing_is_answered)
{
    static hard_robot robot;
    mechanism_options o = mechanism_defaults(MECHANISM_TAPER, 2);
    o.taper = 1e-15;
    random_source s = {7};
    double want[2], got[2];
    tfa_answer answer;
    tfa_reply reply = {.qdd = want, .answers = &answer};
    hard_robot_mechanism(&o, TFA_BASE_FIXED, &robot);
    hard_robot_draw(&robot, &s, HARD_QDD);
    tfa_request r = hard_robot_request(&robot, HARD_QDD);
    assert_int_equal(tfa_compute(robot.f128, &r, &reply), TFA_OK);
    reply.qdd = got;
    assert_int_equal(tfa_compute(robot.f64, &r, &reply), TFA_OK);
    const double error = relative_error(got, want, 2);
    print_message("  a tip of 1e-15 kg: error %.1e\n", error);
    assert_true(error < 1e-9);
    hard_robot_close(&robot);
}
