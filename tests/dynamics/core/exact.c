/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Without fused multiplications and additions (TFA_EXACT) every instruction set gives the same
 * bits, one state at a time or in batches: what makes them differ in other builds is rounding
 * only. Says so and does nothing in other builds.
 */
#include "models.h"
#include "support/questions.h"
#include "test.h"

#define STATES 17 /* a vector of sixteen, two of eight, and a rest */

static const char *const isas[] = {"base", "avx2", "avx512"};
#define ISAS (sizeof isas / sizeof *isas)

static tfa_precision precision; /* of the workspaces under test */

/* A workspace of that instruction set; NULL where this processor does not have it. */
static tfa_workspace *workspace_of(const test_robot *robot, const char *isa, tfa_states states)
{
    tfa_workspace *w = NULL;
    const tfa_workspace_options o = {.precision = precision, .states = states};
    assert_int_equal(setenv("TFA_ISA", isa, 1), 0);
    if (strcmp(tfa_isa_name(), isa) == 0)
        w = workspace_for(robot->model, &o);
    assert_int_equal(unsetenv("TFA_ISA"), 0);
    return w;
}

/* All questions to one instruction set, compared with what the first one said one by one. */
static void compare(const test_robot *robot, const random_states *x, const answers *first,
                    answers *other, const question *q, tfa_workspace *w[ISAS][2])
{
    const tfa_request r = question_request(robot, q, x, STATES);
    for (size_t k = 0; k < ISAS; k++)
        for (int wide = k == 0; wide < 2; wide++)
            if (w[k][wide]) {
                answers_ask(other, w[k][wide], &r);
                assert_same_answers(robot, q, isas[k], first, other);
            }
}

static void same_bits(test_robot *robot)
{
    random_states *x = fixture_states(robot, 0, STATES, 2);
    answers *first = answers_create(robot, STATES), *other = answers_create(robot, STATES);
    tfa_workspace *w[ISAS][2];
    for (size_t k = 0; k < ISAS; k++)
        for (int wide = 0; wide < 2; wide++)
            w[k][wide] = workspace_of(robot, isas[k], wide ? TFA_STATES_AUTO : TFA_STATES_ONE);
    for (size_t k = 0; k < question_count; k++) {
        const question *q = &questions[k];
        if (!question_fits(robot, q))
            continue;
        const tfa_request r = question_request(robot, q, x, STATES);
        answers_ask(first, w[0][0], &r);
        compare(robot, x, first, other, q, w);
    }
    for (size_t k = 0; k < ISAS; k++)
        for (int wide = 0; wide < 2; wide++)
            tfa_workspace_free(w[k][wide]);
    answers_free(other);
    answers_free(first);
    random_states_free(x);
}

#ifdef TFA_EXACT
TEST(doubles)
{
    precision = TFA_F64;
    for_every_robot(same_bits, false);
}

TEST(floats)
{
    precision = TFA_F32;
    for_every_robot(same_bits, false);
}
#else
int main(void)
{
    (void)same_bits;
    (void)precision;
    print_message("fused multiplications and additions: the preset `exact` has none\n");
    return 77;
}
#endif
