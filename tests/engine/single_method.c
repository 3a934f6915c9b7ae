/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A method that only the kernel of one state has (SINGLE in solve/method.c) answers batches one
 * state at a time, with the same bits. Here the batch kernels are made to lack each method in turn.
 */
#include "engine/workspace.h"
#include "models.h"
#include "random_robot.h"
#include "test.h"

#include <totalforce/totalforce.h>

enum { BODIES = 9, STATES = 11 };

static const struct tfa_kernel *whole;
static tfa_method lacking;

static int solves(tfa_method method)
{
    return method != lacking && whole->solves(method);
}

static int answer_states(struct state *s, const tfa_request *r, struct tfa_resolved by, uint32_t k,
                         uint32_t count, tfa_reply *reply, tfa_answer *answers)
{
    assert_int_not_equal(by.method, lacking);
    return whole->answer(s, r, by, k, count, reply, answers);
}

struct answers {
    double qdd[STATES * BODIES];
    tfa_answer each[STATES];
};

static void ask(tfa_workspace *w, tfa_method method, uint32_t first, uint32_t count,
                struct answers *a)
{
    double q[STATES * BODIES], tau[STATES * BODIES];
    random_source random = {7};
    for (size_t k = 0; k < STATES * BODIES; k++) {
        q[k] = random_uniform(&random, -2, 2);
        tau[k] = random_uniform(&random, -5, 5);
    }
    const tfa_request r = {.op = TFA_OP_FORWARD_DYNAMICS,
                           .method = method,
                           .refine = TFA_REFINE_DEFAULT,
                           .count = count,
                           .q = q + BODIES * first,
                           .tau = tau + BODIES * first};
    tfa_reply reply = {.qdd = a->qdd + BODIES * first, .answers = a->each + first};
    assert_int_equal(tfa_compute(w, &r, &reply), TFA_OK);
}

static void compare(const tfa_model *model, const tfa_workspace_options *options, tfa_method method)
{
    static struct answers batch, alone;
    tfa_workspace *w = workspace_for(model, options);
    whole = w->batch;
    lacking = method;
    struct tfa_kernel part = *whole;
    part.solves = solves;
    part.answer = answer_states;
    w->batch = &part;
    ask(w, method, 0, STATES, &batch);
    for (uint32_t k = 0; k < STATES; k++) {
        ask(w, method, k, 1, &alone);
        assert_int_equal(batch.each[k].method, method);
    }
    assert_memory_equal(batch.qdd, alone.qdd, sizeof batch.qdd);
    tfa_workspace_free(w);
}

TEST(batch_by_the_kernel_of_one_state)
{
    static const tfa_workspace_options options[] = {
        {.precision = TFA_F64},
        {.precision = TFA_F32},
        {.precision = TFA_F32, .residual = TFA_RESIDUAL_F64}};
    tfa_description *d =
        random_robot_create(3, &(random_robot_options){.joints = BODIES, .shape = RANDOM_CHAIN});
    tfa_model *model = compiled(d, NULL);
    const tfa_method_info *row;
    for (size_t o = 0; o < sizeof options / sizeof *options; o++)
        for (uint32_t m = TFA_METHOD_AUTO + 1; (row = tfa_method_describe(m)); m++)
            if (row->forward_dynamics)
                compare(model, &options[o], row->method);
    tfa_model_free(model);
    random_robot_free(d);
}
