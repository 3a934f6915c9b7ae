/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The scheduler: one execution after another, depth first.
 */
#include "explorer.h"

#include <stdio.h>
#include <string.h>
#include <time.h>

#include "coroutine.h"
#include "kernel.h"
#include "sites.h"
#include "state.h"
#include "thread.h"

#define TRACE_MAX 512
/* Bound of memory and time of one exploration */
#define STATES_MAX 30000000u

typedef struct choice {
    int thread, store; /* store to read; -1: none */
    bool postponed;
} choice;

static struct {
    int thread, store;
    const char *what;
    const explorer_site *site;
    const volatile void *at;
    uint64_t value;
} trace[TRACE_MAX];
static int trace_length;

static explorer_thread threads[MEMORY_THREADS];
static const explorer_program *program;
static const char *finding;
static bool in_thread;

/* ---- threads ---- */

explorer_thread *thread_current(void)
{
    return &threads[coroutine_current()];
}

int thread_number(void)
{
    return coroutine_current();
}

void thread_stop(thread_state state)
{
    thread_current()->state = state;
    coroutine_yield();
}

void thread_fail(const char *what)
{
    if (!finding)
        finding = what;
    if (in_thread)
        coroutine_yield();
}

bool thread_many_writers(void)
{
    return program->many_writers;
}

void thread_record(int k, const char *what, const volatile void *at, int store, uint64_t value)
{
    explorer_thread *t = &threads[k];
    const uint64_t site = t->site ? (uint64_t)t->site->id : 0;
    t->history = state_mix(state_mix(t->history, (uintptr_t)at + site), (uint64_t)store);
    t->history = state_mix(t->history, value);
    if (trace_length == TRACE_MAX)
        return;
    trace[trace_length].thread = k;
    trace[trace_length].store = store;
    trace[trace_length].what = what;
    trace[trace_length].site = t->site;
    trace[trace_length].at = at;
    trace[trace_length++].value = value;
}

void explorer_print_trace(void)
{
    for (int i = 0; i < trace_length; i++) {
        printf("  T%d %-18s %p %6llu (store %d)", trace[i].thread, trace[i].what,
               (const void *)(uintptr_t)trace[i].at, (unsigned long long)trace[i].value,
               trace[i].store);
        if (trace[i].site)
            printf("  %s %s", site_text(trace[i].site), order_text(trace[i].site->order));
        printf("\n");
    }
}

/* ---- one execution ---- */

static void start(void)
{
    finding = NULL;
    trace_length = 0;
    memory_reset(program->weak_sc);
    kernel_reset(program->interruptions);
    if (program->reset)
        program->reset(program->argument);
    for (int k = 0; k < MEMORY_THREADS; k++) {
        threads[k] = (explorer_thread){.spun_location = -1};
        if (!program->body[k])
            continue;
        threads[k].state = THREAD_RUNS;
        coroutine_start(k, program->body[k], program->argument);
    }
}

/* Every thread runs to its next point of choice. */
static void run_to_choices(void)
{
    for (int k = 0; k < MEMORY_THREADS && !finding; k++) {
        in_thread = true;
        if (threads[k].state == THREAD_RUNS && !coroutine_resume(k))
            threads[k].state = THREAD_ENDED;
        in_thread = false;
    }
}

/* A load reads one of the stores that are there, or is postponed until there is a newer one: so no
 * order of independent loads is explored twice. */
static int list_loads(int k, int from, choice *choices)
{
    uint8_t readable[MEMORY_STORES];
    const explorer_thread *t = &threads[k];
    from = t->awaited > from ? t->awaited : from;
    const int count = memory_readable(k, t->location, t->order, from, readable);
    for (int i = 0; i < count; i++)
        choices[i] = (choice){.thread = k, .store = readable[i]};
    return count;
}

/* The choices of one thread. @return how many */
static int list_choices(int k, choice *choices)
{
    const explorer_thread *t = &threads[k];
    choices[0] = (choice){.thread = k, .store = -1};
    switch (t->state) {
    case THREAD_LOADS:
        return list_loads(k, t->spun_location == t->location ? t->spun_store + 1 : 0, choices);
    case THREAD_FUTEX_WAITS:
        return list_loads(k, kernel_futex_floor(t->location), choices);
    case THREAD_FUTEX_SLEEPS:
        return kernel_may_interrupt();
    case THREAD_DOORBELL_WAITS:
        return kernel_doorbell_is_set() || kernel_may_interrupt();
    case THREAD_STORES:
    case THREAD_EXCHANGES:
    case THREAD_FUTEX_WAKES:
    case THREAD_DOORBELL_WRITES:
        return 1;
    default:
        return 0;
    }
}

/* The choices of this state. One thread that can load has them all: its load commutes with every
 * operation of the others but stores to its location, for which it is postponed.
 * @return how many */
static int list_all_choices(choice *choices)
{
    int count = 0;
    for (int k = 0; k < MEMORY_THREADS; k++) {
        const int own = list_choices(k, choices);
        if (threads[k].state == THREAD_LOADS && own) {
            choices[own] = (choice){.thread = k, .postponed = true};
            return own + 1;
        }
    }
    for (int k = 0; k < MEMORY_THREADS; k++)
        count += list_choices(k, choices + count);
    return count;
}

/* A postponed load that nothing newer follows: other choices cover this state. */
static bool is_dead_end(void)
{
    for (int k = 0; k < MEMORY_THREADS; k++)
        if (threads[k].awaited)
            return true;
    return false;
}

static void take_choice(choice c)
{
    explorer_thread *t = &threads[c.thread];
    const thread_state state = t->state;
    if (c.postponed) {
        t->awaited = memory_last(t->location) + 1;
        return;
    }
    t->state = THREAD_RUNS;
    t->awaited = 0;
    if (c.store >= 0) {
        const uint64_t loaded = memory_load(c.thread, t->location, t->order, c.store);
        t->last_location = t->location;
        t->last_store = c.store;
        t->spun_location = -1;
        if (state == THREAD_FUTEX_WAITS)
            kernel_futex_wait(c.thread, t, loaded);
        else
            t->value = loaded;
    } else if (state == THREAD_FUTEX_WAKES) {
        kernel_futex_wake(c.thread, threads);
    } else if (state == THREAD_DOORBELL_WRITES) {
        kernel_doorbell_write(c.thread);
    } else if (state == THREAD_FUTEX_SLEEPS) {
        kernel_interrupt(c.thread);
    } else if (state == THREAD_DOORBELL_WAITS) {
        if (kernel_doorbell_is_set())
            kernel_doorbell_wait(c.thread);
        else
            kernel_interrupt(c.thread);
    }
}

static uint64_t state_hash(void)
{
    uint64_t hash = kernel_history();
    for (int k = 0; k < MEMORY_THREADS; k++)
        hash = state_mix(hash,
                         threads[k].history + 16 * (uint64_t)threads[k].awaited + threads[k].state);
    return hash;
}

static bool all_ended(void)
{
    for (int k = 0; k < MEMORY_THREADS; k++)
        if (threads[k].state != THREAD_ABSENT && threads[k].state != THREAD_ENDED)
            return false;
    return true;
}

/* @return true: complete; false: cut short, or a finding */
static bool execute(void)
{
    choice choices[MEMORY_THREADS * MEMORY_STORES];
    trail_rewind();
    start();
    for (;;) {
        run_to_choices();
        if (finding)
            return false;
        const int count = list_all_choices(choices);
        if (!trail_replays() && !states_insert(state_hash()))
            return false;
        if (count == 0)
            break;
        take_choice(choices[trail_choose(count)]);
    }
    if (is_dead_end())
        return false;
    if (!all_ended())
        finding = "lost wake-up";
    else if (program->finish)
        program->finish(program->argument);
    return !finding;
}

static double seconds_now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

explorer_result explorer_run(const explorer_program *p)
{
    explorer_result result = {0};
    const double begin = seconds_now();
    program = p;
    states_clear();
    trail_clear();
    do {
        result.executions += execute();
        result.branches++;
        if (!finding && states_count() > STATES_MAX)
            finding = "too many states";
    } while (!finding && trail_advance());
    result.finding = finding;
    result.states = states_count();
    result.seconds = seconds_now() - begin;
    return result;
}
