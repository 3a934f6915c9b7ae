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

/* A robot's states, asked of both kinds of workspace. */
struct both {
    random_states *x;
    struct answers wide, one;
    tfa_workspace *w; /* one at a time */
    tfa_request request;
};

static void open_both(struct both *b, const test_robot *robot)
{
    const size_t bytes = STATES * (robot->nv + 1u) * sizeof(double);
    b->x = random_states_create(robot->seed, robot->description, robot->o, STATES, 0);
    b->wide.qdd = malloc(bytes);
    b->one.qdd = malloc(bytes);
    b->w = one_at_a_time(robot->model);
    b->request = fixture_request(robot, b->x);
    b->request.wrench_count = 0;
}

static void close_both(struct both *b)
{
    tfa_workspace_free(b->w);
    free(b->one.qdd);
    free(b->wide.qdd);
    random_states_free(b->x);
}

static void every_count(test_robot *robot)
{
    struct both b;
    open_both(&b, robot);
    tfa_request r = b.request;
    for (int resting = 0; resting < 2; resting++) {
        r.v = resting ? NULL : b.x->v;
        r.base_twist = resting ? NULL : r.base_twist;
        for (r.count = 1; r.count <= STATES; r.count++) {
            ask(robot->f64, &r, &b.wide, robot->nv);
            ask(b.w, &r, &b.one, robot->nv);
            assert_memory_equal(b.wide.qdd, b.one.qdd, STATES * robot->nv * sizeof(double));
            if (robot->base == TFA_BASE_FLOATING)
                assert_memory_equal(b.wide.base, b.one.base, sizeof b.one.base);
            for (uint32_t k = 0; k < r.count; k++) {
                assert_int_equal(b.wide.each[k].status, TFA_OK);
                assert_int_equal(b.wide.each[k].method, b.one.each[k].method);
                assert_int_equal(b.wide.each[k].flags, b.one.each[k].flags);
            }
        }
    }
    close_both(&b);
}

static void same_bits_as_one_at_a_time(void **state)
{
    (void)state;
    for_every_robot(every_count, false);
}

/* Forces so large that the answer to one state is not finite. */
static void overflow(test_robot *robot)
{
    struct both b;
    open_both(&b, robot);
    tfa_request r = b.request;
    const uint32_t bad = 5;
    for (uint32_t j = 0; j < robot->nv; j++)
        b.x->tau[(size_t)bad * robot->nv + j] = j % 2 ? -1.7e308 : 1.7e308;
    ask(robot->f64, &r, &b.wide, robot->nv);
    ask(b.w, &r, &b.one, robot->nv);
    for (uint32_t k = 0; k < STATES; k++) {
        assert_int_equal(b.wide.each[k].status, b.one.each[k].status);
        assert_memory_equal(b.wide.qdd + (size_t)k * robot->nv, b.one.qdd + (size_t)k * robot->nv,
                            robot->nv * sizeof(double));
    }
    close_both(&b);
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
