/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * States side by side in the lanes of vector registers: the same answers as one after the other, to
 * the bit, for any number of states; and a state without an answer spoils no other.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "fixture.h"

#define STATES 19 /* two vectors of eight and a rest */

struct answers {
    double *qdd, base[6 * STATES];
    tfa_answer each[STATES];
};

static void ask(tfa_workspace *w, const tfa_request *r, struct answers *a, size_t nv)
{
    memset(a->qdd, 0xff, STATES * nv * sizeof *a->qdd);
    memset(a->base, 0xff, sizeof a->base);
    tfa_reply reply = {.qdd = a->qdd, .base_acceleration = a->base, .answers = a->each};
    (void)tfa_compute(w, r, &reply);
}

static tfa_workspace *one_at_a_time(const tfa_model *model)
{
    tfa_workspace *w;
    assert_int_equal(
        tfa_workspace_create(model, &(tfa_workspace_options){.states = TFA_STATES_ONE}, &w),
        TFA_OK);
    return w;
}

static void every_count(test_robot *robot)
{
    random_states *x = random_states_create(robot->seed, robot->description, robot->o, STATES, 0);
    struct answers wide = {.qdd = malloc(STATES * (robot->nv + 1u) * sizeof(double))};
    struct answers one = {.qdd = malloc(STATES * (robot->nv + 1u) * sizeof(double))};
    tfa_workspace *w = one_at_a_time(robot->model);
    tfa_request r = fixture_request(robot, x);
    r.wrench_count = 0;
    for (int resting = 0; resting < 2; resting++) {
        r.v = resting ? NULL : x->v;
        r.base_twist = resting ? NULL : r.base_twist;
        for (r.count = 1; r.count <= STATES; r.count++) {
            ask(robot->f64, &r, &wide, robot->nv);
            ask(w, &r, &one, robot->nv);
            assert_memory_equal(wide.qdd, one.qdd, STATES * robot->nv * sizeof(double));
            if (robot->base == TFA_BASE_FLOATING)
                assert_memory_equal(wide.base, one.base, sizeof one.base);
            for (uint32_t k = 0; k < r.count; k++) {
                assert_int_equal(wide.each[k].status, TFA_OK);
                assert_int_equal(wide.each[k].method, one.each[k].method);
                assert_int_equal(wide.each[k].flags, one.each[k].flags);
            }
        }
    }
    tfa_workspace_free(w);
    free(one.qdd);
    free(wide.qdd);
    random_states_free(x);
}

static void same_bits_as_one_at_a_time(void **state)
{
    (void)state;
    for_every_robot(every_count, false);
}

/* Forces so large that the answer to one state is not finite. */
static void overflow(test_robot *robot)
{
    random_states *x = random_states_create(robot->seed, robot->description, robot->o, STATES, 0);
    struct answers wide = {.qdd = malloc(STATES * (robot->nv + 1u) * sizeof(double))};
    struct answers one = {.qdd = malloc(STATES * (robot->nv + 1u) * sizeof(double))};
    tfa_workspace *w = one_at_a_time(robot->model);
    tfa_request r = fixture_request(robot, x);
    const uint32_t bad = 5;
    r.wrench_count = 0;
    for (uint32_t j = 0; j < robot->nv; j++)
        x->tau[(size_t)bad * robot->nv + j] = j % 2 ? -1.7e308 : 1.7e308;
    ask(robot->f64, &r, &wide, robot->nv);
    ask(w, &r, &one, robot->nv);
    for (uint32_t k = 0; k < STATES; k++) {
        assert_int_equal(wide.each[k].status, one.each[k].status);
        assert_memory_equal(wide.qdd + (size_t)k * robot->nv, one.qdd + (size_t)k * robot->nv,
                            robot->nv * sizeof(double));
    }
    tfa_workspace_free(w);
    free(one.qdd);
    free(wide.qdd);
    random_states_free(x);
}

static void a_state_without_answer_spoils_no_other(void **state)
{
    (void)state;
    for_every_robot(overflow, true);
}

/* A robot that is nothing but its base has no freedom, and an answer all the same. */
static void nothing_moves(void **state)
{
    (void)state;
    tfa_link link = {
        .name = "base", .mass = 1, .quat = {0, 0, 0, 1}, .inertia = {1, 0, 0, 1, 0, 1}};
    const tfa_description d = {.name = "rock", .links = &link, .link_count = 1};
    tfa_model *model;
    tfa_workspace *w;
    double none[1];
    tfa_answer each[3];
    assert_int_equal(tfa_model_create(&d, NULL, NULL, &model), TFA_OK);
    assert_int_equal(tfa_workspace_create(model, NULL, &w), TFA_OK);
    const tfa_request r = {.op = TFA_OP_FORWARD_DYNAMICS, .count = 3, .q = none};
    tfa_reply reply = {.qdd = none, .answers = each};
    assert_int_equal(tfa_compute(w, &r, &reply), TFA_OK);
    tfa_workspace_free(w);
    tfa_model_free(model);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(same_bits_as_one_at_a_time),
        cmocka_unit_test(a_state_without_answer_spoils_no_other),
        cmocka_unit_test(nothing_moves),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
