/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * f128 answers for the numbers of the description, not for constants rounded on the way: it gives the
 * doubles that the oracle gives, which merges nothing. Tips of 1e12 kg amplify a constant that is off
 * by 1e-16 to an answer that is off by 1e-4; here such answers agree to the last bit, so that constants
 * are right to 1e-28.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <stdlib.h>

#include "fixture.h"

#define BOUND 0x1p-52 /* both are rounded to double at the end */
#define HEAVY 1e12

static double worst;

static void compare(const test_robot *robot, const tfa_request *request, const random_states *x)
{
    const uint32_t n = robot->n, six = n - robot->nv;
    double *want = calloc(2 * (size_t)n + 72, sizeof *want), *got = want + n;
    double *want_lambda = want + 2 * n, *got_lambda = want_lambda + 36;
    tfa_request r = *request;
    tfa_reply reply = {.qdd = got + six, .base_acceleration = got};
    oracle_set_state(robot->o, &r, 0);
    oracle_forward(robot->o, x->tau, x->base_wrench, want + six, want);
    compute_ok(robot, robot->f128, &r, &reply);
    assert_within(robot, "qdd", relative_error(got, want, n), BOUND, &worst);
    r.op = TFA_OP_INVERSE_DYNAMICS;
    r.qdd = x->qdd;
    r.base_acceleration = six ? x->base_acceleration : NULL;
    reply = (tfa_reply){.tau = got + six, .base_wrench = got};
    oracle_inverse(robot->o, x->qdd, x->base_acceleration, want + six, want);
    compute_ok(robot, robot->f128, &r, &reply);
    assert_within(robot, "tau", relative_error(got, want, n), BOUND, &worst);
    r.op = TFA_OP_OPERATIONAL_INERTIA;
    r.tip_count = 1;
    r.tips[0] = (uint32_t)robot->description->link_count - 1;
    reply = (tfa_reply){.lambda_inv = got_lambda};
    oracle_lambda_inv(robot->o, r.tips, 1, r.frame, want_lambda);
    compute_ok(robot, robot->f128, &r, &reply);
    assert_within(robot, "lambda_inv", relative_error(got_lambda, want_lambda, 36), BOUND, &worst);
    free(want);
}

static void without_payload(test_robot *robot)
{
    random_states *x = random_states_create(robot->seed, robot->description, robot->o, 1, 2);
    const tfa_request r = fixture_request(robot, x);
    compare(robot, &r, x);
    random_states_free(x);
}

static void with_payloads(test_robot *robot)
{
    random_states *x = random_states_create(robot->seed, robot->description, robot->o, 1, 2);
    random_source s = {robot->seed};
    double payload[2 * TFA_PAYLOAD_NUMBERS];
    tfa_request r = fixture_request(robot, x);
    random_payload(&s, payload);
    random_payload(&s, payload + TFA_PAYLOAD_NUMBERS);
    r.payload_count = 2;
    r.payloads = payload;
    for (int k = 0; k < 2; k++)
        r.payload_frames[k] = random_below(&s, (uint32_t)robot->description->link_count);
    compare(robot, &r, x);
    random_states_free(x);
}

static void every_robot(void **state)
{
    (void)state;
    worst = 0;
    for_every_robot(without_payload, false);
    print_message("  worst %.2g\n", worst);
}

static void every_robot_with_payloads(void **state)
{
    (void)state;
    worst = 0;
    for_every_robot(with_payloads, true);
    print_message("  worst %.2g\n", worst);
}

/* The last link on a random robot, 1e12 times what it was */
static void heavy_tips(void **state)
{
    (void)state;
    worst = 0;
    for (uint64_t seed = 1; seed <= 48; seed++) {
        const random_robot_options options = {.shape = (random_shape)(seed % 3),
                                              .joints = 4 + (uint32_t)(seed % 7),
                                              .all_types = seed % 2 == 0,
                                              .fixed_fraction = 0.3};
        const tfa_model_options base = {.base = seed % 4 < 2 ? TFA_BASE_FLOATING : TFA_BASE_FIXED};
        test_robot r = {.name = "heavy tip", .seed = seed, .random = true, .base = base.base};
        r.description = random_robot_create(seed, &options);
        tfa_link *tip = &r.description->links[r.description->link_count - 1];
        tip->mass *= HEAVY;
        for (int k = 0; k < 6; k++)
            tip->inertia[k] *= HEAVY;
        r.o = oracle_create(r.description, base.base);
        assert_int_equal(tfa_model_create(r.description, &base, NULL, &r.model), TFA_OK);
        r.f128 = fixture_workspace(r.model, TFA_F128);
        r.n = oracle_freedoms(r.o);
        r.nv = oracle_v_count(r.o);
        r.nq = oracle_q_count(r.o);
        without_payload(&r);
        tfa_workspace_free(r.f128);
        tfa_model_free(r.model);
        oracle_free(r.o);
        random_robot_free(r.description);
    }
    print_message("  worst %.2g\n", worst);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_robot),
        cmocka_unit_test(every_robot_with_payloads),
        cmocka_unit_test(heavy_tips),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
