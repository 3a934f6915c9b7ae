/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The chart's exact Lambda^-1 is J M^-1 J^T of the oracle, which is dense and shares no source with
 * the library; and single states and batches of it are measured against that.
 */
#include "chart/chart.h"
#include "models.h"
#include "oracle.h"
#include "test.h"

#include <math.h>
#include <string.h>

static uint32_t link_named(const tfa_description *d, const char *name)
{
    for (uint32_t k = 0; k < d->link_count; k++)
        if (strcmp(d->links[k].name, name) == 0)
            return k;
    fail_msg("no link %s", name);
    return 0;
}

/* Relative Frobenius norm */
static double difference(const double *a, const double *b)
{
    double error = 0.0, size = 0.0;
    for (int i = 0; i < CHART_LAMBDA_NUMBERS; i++) {
        error += (a[i] - b[i]) * (a[i] - b[i]);
        size += b[i] * b[i];
    }
    return sqrt(error / size);
}

/* Worst difference of the chart's exact answers from the oracle's for the named link */
static double worst_against_oracle(const chart_data *d, const tfa_description *description,
                                   tfa_base base, const char *link)
{
    oracle *o = oracle_create(description, base);
    const uint32_t tip = link_named(description, link);
    double worst = 0.0;
    for (uint32_t s = 0; s < d->states; s++) {
        double dense[CHART_LAMBDA_NUMBERS];
        const tfa_request request = chart_request(d, s);
        oracle_set_state(o, &request, 0);
        oracle_lambda_inv(o, &tip, 1, TFA_FRAME_LOCAL_WORLD_ALIGNED, dense);
        worst = fmax(worst, difference(d->exact + (size_t)s * d->answer, dense));
    }
    oracle_free(o);
    return worst;
}

static const char *const robots[] = {"arm7.urdf", "quadruped.urdf", "humanoid.urdf"};

static void check_robot(const char *file, tfa_base base)
{
    char path[512];
    chart_case c;
    chart_data d;
    const chart_options options = {
        .seed = 7, .base = base, .precisions = {CHART_F64}, .precision_count = 1};
    tfa_description *description = bundled_description(file);
    snprintf(path, sizeof path, "%s/config/robots/%s", TFA_SOURCE_DIR, file);
    const chart_target target = {.label = path, .file = path};
    assert_int_equal(chart_case_open(&c, &options, &target, 0), TFA_OK);
    c.op = CHART_LAMBDA;
    assert_int_equal(chart_data_make(&d, &c, CHART_QDD, 3), TFA_OK);
    const char *tip = tfa_model_frame(c.model, d.tip).name;
    const double error = worst_against_oracle(&d, description, base, tip);
    print_message("%s, %s: %.1e\n", file, tip, error);
    assert_true(error < 5e-16);
    /* another link is seen */
    const char *other = description->joints[0].child ? description->links[1].name : tip;
    assert_true(worst_against_oracle(&d, description, base, other) > 1e-3);
    chart_data_free(&d);
    chart_case_close(&c);
    tfa_description_free(description);
}

TEST(the_exact_answer_is_dense)
{
    for (size_t k = 0; k < sizeof robots / sizeof *robots; k++) {
        check_robot(robots[k], TFA_BASE_FIXED);
        check_robot(robots[k], TFA_BASE_FLOATING);
    }
}

/* The reference of more bodies is propagation: at the border it equals the dense one. */
TEST(references_agree_at_the_border)
{
    assert_int_equal(chart_exact_method(CHART_LAMBDA, 128), TFA_METHOD_CRBA);
    assert_int_equal(chart_exact_method(CHART_LAMBDA, 129), TFA_METHOD_PROPAGATION);
    assert_int_equal(chart_exact_method(CHART_FORWARD, 129), TFA_METHOD_ABA);
    chart_case c;
    chart_data d;
    const mechanism_options random = mechanism_defaults(MECHANISM_RANDOM, 128);
    assert_int_equal(chart_case_open_mechanism(&c, &random, "random"), TFA_OK);
    c.op = CHART_LAMBDA;
    assert_int_equal(chart_data_make(&d, &c, CHART_QDD, 2), TFA_OK);
    for (uint32_t s = 0; s < d.states; s++) {
        tfa_answer answer;
        tfa_request request = chart_request(&d, s);
        tfa_reply reply = chart_reply(&d, &answer);
        request.method = TFA_METHOD_PROPAGATION;
        assert_int_equal(tfa_compute(c.f128, &request, &reply), TFA_OK);
        assert_true(difference(d.found, d.exact + (size_t)s * d.answer) < 1e-20);
    }
    assert_true(d.floor >= 0x1p-53 && d.floor < 1e-13);
    chart_data_free(&d);
    chart_case_close(&c);
}
