/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The floor of a chart, from its definition: sines and cosines rounded to double, each on its own,
 * and every input.
 */
#include "chart/chart.h"
#include "models.h"
#include "test.h"

#define STANDARD_GRAVITY 9.80665

/* One rod of 1 kg and 1 m on a revolute joint about x; gravity along y, so that the cosine of q
 * counts. The torque balances the weight but for rounding, so that the rounding of the cosine is
 * what is left. */
TEST(cosines_are_rounded_on_their_own)
{
    const mechanism_options rod = mechanism_defaults(MECHANISM_STRAIGHT, 1);
    tfa_description *description = mechanism_make(&rod);
    tfa_model *model = compiled(description, NULL);
    const double inertia = description->links[1].inertia[0] + 0.25;
    const double q = 1e-3, gravity[3] = {0.0, -STANDARD_GRAVITY, 0.0};
    const long double weight = 0.5L * STANDARD_GRAVITY;
    double tau = -(double)(weight * cosl(q));
    double qdd[2];
    for (int rounded = 0; rounded < 2; rounded++) {
        tfa_answer answer;
        const tfa_workspace_options options = {.precision = TFA_F128, .round_sincos = rounded};
        const tfa_request request = {.op = TFA_OP_FORWARD_DYNAMICS,
                                     .method = TFA_METHOD_ABA,
                                     .estimate = TFA_ESTIMATE_NEVER,
                                     .count = 1,
                                     .q = &q,
                                     .tau = &tau,
                                     .gravity = gravity};
        tfa_reply reply = {.qdd = &qdd[rounded], .answers = &answer};
        tfa_workspace *w = workspace_for(model, &options);
        assert_int_equal(tfa_compute(w, &request, &reply), TFA_OK);
        tfa_workspace_free(w);
    }
    const long double cosine[2] = {cosl(q), (long double)(double)cosl(q)};
    for (int rounded = 0; rounded < 2; rounded++) {
        const double expected = (double)((tau + weight * cosine[rounded]) / inertia);
        assert_true(fabs(qdd[rounded] - expected) < 1e-2 * fabs(expected) + 1e-19);
    }
    assert_true(fabs(qdd[0] - qdd[1]) > 1e-18);
    tfa_model_free(model);
    mechanism_free(description);
}

/* Median over the states of how far the exact answer moves with that workspace */
static double change_with(tfa_workspace *w, const chart_data *d)
{
    double errors[CHART_STATES], worst;
    for (uint32_t s = 0; s < d->states; s++) {
        tfa_answer answer;
        const tfa_request request = chart_request(d, s);
        tfa_reply reply = chart_reply(d, &answer);
        assert_int_equal(tfa_compute(w, &request, &reply), TFA_OK);
        errors[s] = chart_error(d, s, &worst);
    }
    return chart_median(errors, d->states);
}

/* The effect of rounded sines and cosines alone is in the floor. On a straight chain near q = 0 it
 * is larger than that of the last bits of all other numbers. */
TEST(the_floor_holds_the_rounding_of_cosines)
{
    chart_case c;
    chart_data d;
    const mechanism_options straight = mechanism_defaults(MECHANISM_STRAIGHT, 1024);
    const tfa_workspace_options rounded = {.precision = TFA_F128, .round_sincos = 1};
    assert_int_equal(chart_case_open_mechanism(&c, &straight, "straight"), TFA_OK);
    assert_int_equal(chart_data_make(&d, &c, CHART_TAU, 5), TFA_OK);
    tfa_workspace *w = workspace_for(c.model, &rounded);
    const double change = change_with(w, &d);
    print_message("cosines %.1e, floor %.1e\n", change, d.floor);
    assert_true(change > 4e-16);
    assert_true(d.floor > 0.7 * change);
    tfa_workspace_free(w);
    chart_data_free(&d);
    chart_case_close(&c);
}
