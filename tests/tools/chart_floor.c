/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The floor of a chart, from its definition: sines and cosines rounded to double, each on its own,
 * and every input. Rows of several seeds: medians, least and largest; rows with the same answers.
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

static chart_row made_up(uint32_t method, double error, double time, uint64_t bits)
{
    return (chart_row){.choice = {.method = method, .threads = 1},
                       .answered_by = method,
                       .error = error,
                       .error_low = error,
                       .error_high = error,
                       .floor = 1e-16,
                       .time = time,
                       .time_low = time,
                       .time_high = time,
                       .aba_time = time,
                       .ratio = 1.0,
                       .samples = 3,
                       .bits = bits};
}

TEST(seeds_are_put_together)
{
    chart_row rows[6];
    const double errors[] = {1e-10, 1e-9, 1e-12}, times[] = {2.0, 1.0, 4.0};
    for (int s = 0; s < 3; s++) {
        rows[2 * s] = made_up(TFA_METHOD_ABA, errors[s], times[s], 1);
        rows[2 * s + 1] = made_up(TFA_METHOD_TFA, errors[s], times[s], 2);
    }
    rows[5].status = TFA_E_SINGULAR;
    chart_combine_seeds(rows, 2, 3);
    assert_true(rows[0].error == 1e-10 && rows[0].error_low == 1e-12 && rows[0].error_high == 1e-9);
    assert_true(rows[0].time == 2.0 && rows[0].time_low == 1.0 && rows[0].time_high == 4.0);
    assert_int_equal(rows[0].samples, 9);
    assert_false(chart_row_good(&rows[1]));
}

TEST(the_same_answers_are_one_mark)
{
    chart_row rows[] = {
        made_up(TFA_METHOD_ABA, 1e-15, 2.0, 1), made_up(TFA_METHOD_TFA_CR, 1e-12, 3.0, 2),
        made_up(TFA_METHOD_CFA_CR, 1e-12, 1.0, 2), made_up(TFA_METHOD_SCAN, 1e-15, 1.0, 1)};
    rows[3].choice.threads = 2;
    chart_find_same(rows, 4);
    assert_int_equal(rows[1].same_as, 0);
    assert_int_equal(rows[2].same_as, TFA_METHOD_TFA_CR);
    assert_int_equal(rows[3].same_as, 0); /* a batch is timed by other calls */
    assert_false(chart_row_drawn(&rows[2]));
    chart_mark_front(rows, 3);
    assert_true(rows[0].front && !rows[1].front && !rows[2].front);
}
