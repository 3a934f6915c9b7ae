/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Batches of states in SIMD lanes: the same answers as one after the other, to
 * the bit, to every question, in double and in float, for any number of states; and a state without
 * an answer spoils no other.
 */
#include "models.h"
#include "support/questions.h"
#include "test.h"

#define STATES 19 /* two vectors of eight and a rest */

static tfa_workspace *workspace_of(const test_robot *robot, tfa_precision precision,
                                   tfa_states states)
{
    const tfa_workspace_options o = {.precision = precision, .states = states};
    tfa_workspace *w = workspace_for(robot->model, &o);
    return w;
}

/* A robot's states, asked of both kinds of workspace. */
struct both {
    random_states *x;
    answers *batched, *one;
    tfa_workspace *batch, *w; /* several at a time; one */
};

static void open_both(struct both *b, const test_robot *robot, tfa_precision precision)
{
    b->x = fixture_states(robot, 0, STATES, 2);
    b->batched = answers_create(robot, STATES);
    b->one = answers_create(robot, STATES);
    b->batch = workspace_of(robot, precision, TFA_STATES_AUTO);
    b->w = workspace_of(robot, precision, TFA_STATES_ONE);
}

static void close_both(struct both *b)
{
    tfa_workspace_free(b->w);
    tfa_workspace_free(b->batch);
    answers_free(b->one);
    answers_free(b->batched);
    random_states_free(b->x);
}

static void ask_both(struct both *b, const test_robot *robot, const question *q, uint32_t count)
{
    const tfa_request r = question_request(robot, q, b->x, count);
    answers_ask(b->batched, b->batch, &r);
    answers_ask(b->one, b->w, &r);
    assert_same_answers(robot, q, "in lanes and one by one", b->batched, b->one);
}

static void every_question(test_robot *robot)
{
    const tfa_precision precisions[] = {TFA_F64, TFA_F32};
    for (int p = 0; p < 2; p++) {
        struct both b;
        open_both(&b, robot, precisions[p]);
        for (size_t k = 0; k < question_count; k++)
            if (question_fits(robot, &questions[k]))
                ask_both(&b, robot, &questions[k], STATES);
        close_both(&b);
    }
}

/* The same bits as one at a time, whatever is asked. */
EVERY_ROBOT(same_bits_as_one_at_a_time, every_question, false)

static void every_constrained_question(test_robot *robot)
{
    fixture_constrained(robot, every_question);
}

EVERY_ROBOT(the_same_with_constraints, every_constrained_question, false)

static const question derivatives = {
    "derivatives", .op = TFA_OP_DERIVATIVES, .refine = TFA_REFINE_DEFAULT};

static void every_count(test_robot *robot)
{
    struct both b;
    open_both(&b, robot, TFA_F64);
    for (uint32_t count = 1; count <= STATES; count++) {
        ask_both(&b, robot, &questions[0], count);
        ask_both(&b, robot, &derivatives, count);
    }
    close_both(&b);
}

EVERY_ROBOT(any_number_of_states, every_count, true)

/* Forces so large that the answer to one state is not finite. */
static void overflow(test_robot *robot)
{
    struct both b;
    open_both(&b, robot, TFA_F64);
    const uint32_t bad = 5;
    for (uint32_t j = 0; j < robot->nv; j++)
        b.x->tau[(size_t)bad * robot->nv + j] = j % 2 ? -1.7e308 : 1.7e308;
    ask_both(&b, robot, &questions[0], STATES);
    ask_both(&b, robot, &derivatives, STATES);
    close_both(&b);
}

EVERY_ROBOT(a_failed_state_changes_no_other, overflow, true)

/* Where some states move and others do not, these have the same numbers as at rest. */
static void some_rest(test_robot *robot)
{
    struct both b;
    open_both(&b, robot, TFA_F64);
    for (uint32_t k = 0; k < STATES; k += 3) {
        memset(b.x->v + (size_t)k * robot->nv, 0, robot->nv * sizeof(double));
        memset(b.x->base_twist + (size_t)k * 6, 0, 6 * sizeof(double));
    }
    const tfa_request r = question_request(robot, &questions[0], b.x, STATES);
    answers_ask(b.batched, b.batch, &r);
    answers_ask(b.one, b.w, &r);
    for (size_t j = 0; j < (size_t)STATES * robot->nv; j++)
        assert_true(b.batched->qdd[j] == b.one->qdd[j]); /* zeros may differ in sign */
    close_both(&b);
}

EVERY_ROBOT(some_move_and_others_rest, some_rest, true)

/* A robot that is nothing but its base has no freedom, and an answer all the same. */
TEST(nothing_moves)
{
    tfa_link link = {
        .name = "base", .mass = 1, .quat = {0, 0, 0, 1}, .inertia = {1, 0, 0, 1, 0, 1}};
    const tfa_description d = {.name = "rock", .links = &link, .link_count = 1};
    double none[1];
    tfa_answer each[3];
    tfa_model *model = compiled(&d, NULL);
    tfa_workspace *w = workspace_for(model, NULL);
    const tfa_request r = {.op = TFA_OP_FORWARD_DYNAMICS, .count = 3, .q = none};
    tfa_reply reply = {.qdd = none, .answers = each};
    assert_int_equal(tfa_compute(w, &r, &reply), TFA_OK);
    tfa_workspace_free(w);
    tfa_model_free(model);
}
