/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Where TFA loses its digits (thin links of alternating mass: its loss sits in the inverse
 * inertias) the estimate notices, the answer comes from ABA, and the reply says so.
 */
#include "models.h"
#include "support/fixture.h"
#include "support/small_robot.h"
#include "test.h"

enum { LINKS = 24 };

/* Unit rods of radius `radius` along x, masses 1, ratio, 1, ratio, ..., axes z, y, z, y, ... */
static void thin_chain(small_robot *c, double radius, double ratio)
{
    small_robot_begin(c);
    for (uint32_t i = 0; i < LINKS; i++)
        small_robot_add(c, i, TFA_JOINT_CONTINUOUS, 0, i % 2, 1 - i % 2)->xyz[0] = i ? 1 : 0;
    for (uint32_t i = 0; i <= LINKS; i++) {
        const double m = i % 2 ? 1 : ratio, across = m * (3 * radius * radius + 1) / 12;
        small_robot_load(c, i, m, m * radius * radius / 2, across, across);
        c->link[i].com[0] = 0.5;
    }
}

struct setup {
    tfa_model *model;
    tfa_workspace *f64, *f128;
    double q[LINKS], v[LINKS], tau[LINKS];
};

/* Torques that give every joint the acceleration 1 or -1: the right-hand side that is hardest. */
static void open_chain(struct setup *s, const small_robot *c)
{
    const tfa_workspace_options quad = {.precision = TFA_F128};
    double qdd[LINKS];
    s->model = compiled(&c->d, NULL);
    s->f64 = workspace_for(s->model, NULL);
    s->f128 = workspace_for(s->model, &quad);
    for (int i = 0; i < LINKS; i++) {
        s->q[i] = sin(1.7 * i + 0.3);
        s->v[i] = cos(2.9 * i);
        qdd[i] = i % 3 ? 1 : -1;
    }
    tfa_request r = {.op = TFA_OP_INVERSE_DYNAMICS, .count = 1, .q = s->q, .v = s->v, .qdd = qdd};
    tfa_reply reply = {.tau = s->tau};
    assert_int_equal(tfa_compute(s->f128, &r, &reply), TFA_OK);
}

static void close_chain(struct setup *s)
{
    tfa_workspace_free(s->f64);
    tfa_workspace_free(s->f128);
    tfa_model_free(s->model);
}

TEST(forward_dynamics_falls_back)
{
    small_robot c;
    struct setup s;
    double want[LINKS], qdd[LINKS];
    tfa_answer answer;
    thin_chain(&c, 1e-5, 1e8);
    open_chain(&s, &c);
    tfa_request r = {.op = TFA_OP_FORWARD_DYNAMICS, .count = 1, .q = s.q, .v = s.v, .tau = s.tau};
    tfa_reply reply = {.qdd = want, .answers = &answer};
    r.method = TFA_METHOD_ABA;
    assert_int_equal(tfa_compute(s.f128, &r, &reply), TFA_OK);
    reply.qdd = qdd;

    /* the theory's prediction: without the estimate TFA is wrong in every digit that counts */
    r.method = TFA_METHOD_TFA;
    r.estimate = TFA_ESTIMATE_NEVER;
    assert_int_equal(tfa_compute(s.f64, &r, &reply), TFA_OK);
    assert_int_equal(answer.flags, 0);
    const double unguarded = relative_error(qdd, want, LINKS);
    print_message("  tfa alone: error %.1e\n", unguarded);
    assert_true(!(unguarded < 1e-4));

    /* its twin: the service notices and answers by ABA */
    r.estimate = TFA_ESTIMATE_DEFAULT;
    for (uint32_t refine = 0; refine <= 2; refine++) {
        r.refine = refine;
        assert_int_equal(tfa_compute(s.f64, &r, &reply), TFA_OK);
        const double error = relative_error(qdd, want, LINKS);
        print_message("  refine %u: method %s, error %.1e, estimate %.1e\n", (unsigned)refine,
                      tfa_method_name(answer.method), error, answer.error_estimate);
        assert_true(answer.flags & TFA_ANSWER_ESTIMATED);
        if (answer.flags & TFA_ANSWER_FALLBACK)
            assert_int_equal(answer.method, TFA_METHOD_ABA);
        else
            assert_int_equal(answer.method, TFA_METHOD_TFA);
        assert_true(error < 1e-4);
        assert_true(answer.error_estimate > error / 30);
    }
    r.refine = 0;
    assert_int_equal(tfa_compute(s.f64, &r, &reply), TFA_OK);
    assert_true(answer.flags & TFA_ANSWER_FALLBACK);
    close_chain(&s);
}

TEST(lambda_falls_back)
{
    small_robot c;
    struct setup s;
    double want[36], got[36];
    tfa_answer answer;
    thin_chain(&c, 1e-6, 1e9);
    open_chain(&s, &c);
    tfa_request r = {.op = TFA_OP_OPERATIONAL_INERTIA, .count = 1, .q = s.q, .tip_count = 1};
    r.tips[0] = LINKS;
    tfa_reply reply = {.lambda_inv = want, .answers = &answer};
    assert_int_equal(tfa_compute(s.f128, &r, &reply), TFA_OK);
    reply.lambda_inv = got;
    static const tfa_method methods[] = {TFA_METHOD_TFA, TFA_METHOD_TFA_ONE_SIDED};
    for (int m = 0; m < 2; m++) {
        r.method = methods[m];
        assert_int_equal(tfa_compute(s.f64, &r, &reply), TFA_OK);
        const double error = relative_error(got, want, 36);
        print_message("  %s: answered by %s, error %.1e, estimate %.1e\n",
                      tfa_method_name((uint32_t)methods[m]), tfa_method_name(answer.method), error,
                      answer.error_estimate);
        assert_true(answer.flags & TFA_ANSWER_ESTIMATED);
        if (answer.flags & TFA_ANSWER_FALLBACK)
            assert_int_equal(answer.method, TFA_METHOD_PROPAGATION);
        assert_true(error < 1e-4);
    }
    close_chain(&s);
}
