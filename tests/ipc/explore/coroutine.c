/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * ucontext makes the stacks; the switches are _setjmp and _longjmp, which make no system call.
 */
#undef _FORTIFY_SOURCE /* its longjmp forbids jumps between stacks */
#include "coroutine.h"

#include <setjmp.h>
#include <stdlib.h>
#include <ucontext.h>

#define STACK_BYTES 65536

typedef struct coroutine {
    ucontext_t context;
    jmp_buf base, here; /* the beginning of a body; where it yielded */
    void (*body)(void *);
    void *argument;
    bool made, started, ended;
} coroutine;

static coroutine all[COROUTINES];
static coroutine *current;
static jmp_buf scheduler;

static void run_bodies(void)
{
    if (_setjmp(current->base) == 0)
        _longjmp(scheduler, 1);
    current->body(current->argument);
    current->ended = true;
    _longjmp(scheduler, 1);
}

static void make(coroutine *c)
{
    getcontext(&c->context);
    c->context.uc_stack.ss_size = STACK_BYTES;
    c->context.uc_stack.ss_sp = malloc(STACK_BYTES);
    if (!c->context.uc_stack.ss_sp)
        abort();
    makecontext(&c->context, run_bodies, 0);
    c->made = true;
    current = c;
    if (_setjmp(scheduler) == 0)
        setcontext(&c->context);
}

void coroutine_start(int k, void (*body)(void *), void *argument)
{
    coroutine *c = &all[k];
    if (!c->made)
        make(c);
    c->body = body;
    c->argument = argument;
    c->started = c->ended = false;
}

bool coroutine_resume(int k)
{
    current = &all[k];
    if (_setjmp(scheduler) == 0) {
        if (current->started)
            _longjmp(current->here, 1);
        current->started = true;
        _longjmp(current->base, 1);
    }
    return !current->ended;
}

void coroutine_yield(void)
{
    if (_setjmp(current->here) == 0)
        _longjmp(scheduler, 1);
}

int coroutine_current(void)
{
    return (int)(current - all);
}
