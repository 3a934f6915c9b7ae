/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * How deep requests go down a thread's stack: never below TFA_STACK_BYTES, which tfa_stack_prepare
 * makes sure are there.
 */
#include "kernels.h"
#include "models.h"
#include "support/questions.h"
#include "support/sanitized.h"
#include "test.h"

#include <pthread.h>
#include <sys/mman.h>
#include <unistd.h>

#define STACK ((size_t)4 << 20)
#define STATES 9
#define F128_STATES 2 /* slow, and no lanes: more states are the same again */
#define PAINT 0xa5

/* A robot's questions, asked in a thread whose stack is painted. */
struct course {
    const test_robot *robot;
    tfa_workspace *w;
    random_states *x;
    answers *a;
    uint32_t states;
};

static void *stack_thread(void *context)
{
    const struct course *c = context;
    for (size_t k = 0; k < question_count; k++) {
        if (!question_fits(c->robot, &questions[k]))
            continue;
        for (uint32_t count = 1; count <= c->states; count += c->states - 1) {
            const tfa_request r = question_request(c->robot, &questions[k], c->x, count);
            answers_ask(c->a, c->w, &r);
        }
    }
    return NULL;
}

static void *prepare(void *context)
{
    (void)context;
    tfa_stack_prepare();
    return NULL;
}

/* Bytes of its stack that a thread has written to. */
static size_t depth_of(void *(*thread)(void *), void *context)
{
    unsigned char *stack = mmap(NULL, STACK, PROT_READ | PROT_WRITE,
                                MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    pthread_attr_t attributes;
    pthread_t id;
    size_t untouched = 0;
    assert_ptr_not_equal(stack, MAP_FAILED);
    memset(stack, PAINT, STACK);
    assert_int_equal(pthread_attr_init(&attributes), 0);
    assert_int_equal(pthread_attr_setstack(&attributes, stack, STACK), 0);
    assert_int_equal(pthread_create(&id, &attributes, thread, context), 0);
    assert_int_equal(pthread_join(id, NULL), 0);
    pthread_attr_destroy(&attributes);
    while (untouched < STACK && stack[untouched] == PAINT)
        untouched++;
    munmap(stack, STACK);
    return STACK - untouched;
}

static size_t deepest;

static void ask_robot(test_robot *robot)
{
    static const tfa_workspace_options ways[] = {
        {.precision = TFA_F64},
        {.precision = TFA_F64, .states = TFA_STATES_ONE},
        {.precision = TFA_F64, .residual = TFA_RESIDUAL_F128},
        {.precision = TFA_F32},
        {.precision = TFA_F128},
    };
    for (size_t k = 0; k < sizeof ways / sizeof *ways; k++) {
        tfa_workspace_options o = ways[k];
        struct course c = {.robot = robot,
                           .states = o.precision == TFA_F128 ? F128_STATES : STATES};
        o.specialised = k == 0 ? kernels_find(robot->model) : NULL;
        c.w = workspace_for(robot->model, &o);
        c.x = fixture_states(robot, 0, STATES, 2);
        c.a = answers_create(robot, STATES);
        const size_t depth = depth_of(stack_thread, &c);
        deepest = depth > deepest ? depth : deepest;
        if (depth > TFA_STACK_BYTES)
            fail_msg("%s, workspace %zu: %zu bytes of stack", robot->name, k, depth);
        answers_free(c.a);
        random_states_free(c.x);
        tfa_workspace_free(c.w);
    }
}

static void ask_constrained(test_robot *robot)
{
    ask_robot(robot);
    fixture_constrained(robot, ask_robot);
}

TEST(no_request_goes_deeper)
{
#ifdef SANITIZED
    skip(); /* frames with borders around every variable are larger */
#endif
    for_every_robot(ask_constrained, false);
    print_message("deepest: %zu of %zu bytes\n", deepest, TFA_STACK_BYTES);
    assert_true(deepest > 4096); /* a stack that was not painted would pass, too */
}

TEST(all_of_it_is_there)
{
    assert_true(depth_of(prepare, NULL) >= TFA_STACK_BYTES);
}
