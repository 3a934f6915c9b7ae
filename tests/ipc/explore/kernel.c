/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Waiting calls. They order no other memory: Linux does more, so that the orders of ring.h have to
 * suffice alone.
 */
#include "kernel.h"

#include <string.h>

#include "state.h"

static int floors[MEMORY_LOCATIONS];
static uint64_t futex_calls[MEMORY_LOCATIONS], doorbell_calls;
static const volatile void *words[MEMORY_LOCATIONS];
static int interruptions_left;
static bool doorbell;

void kernel_reset(int interruptions)
{
    memset(floors, 0, sizeof floors);
    memset(futex_calls, 0, sizeof futex_calls);
    memset(words, 0, sizeof words);
    doorbell_calls = 0;
    doorbell = false;
    interruptions_left = interruptions;
}

static void note_futex_call(int k, int location, int call)
{
    words[location] = memory_address(location);
    futex_calls[location] = state_mix(futex_calls[location], (uint64_t)(4 * k + call + 1));
}

int kernel_futex_floor(int location)
{
    return floors[location];
}

void kernel_futex_wait(int k, explorer_thread *t, uint64_t loaded)
{
    note_futex_call(k, t->location, 0);
    const bool sleeps = (uint32_t)loaded == (uint32_t)t->value;
    thread_record(k, sleeps ? "futex sleeps" : "futex has changed", memory_address(t->location),
                  t->last_store, loaded);
    t->state = sleeps ? THREAD_FUTEX_SLEEPS : THREAD_RUNS;
}

void kernel_futex_wake(int k, explorer_thread threads[MEMORY_THREADS])
{
    explorer_thread *waker = &threads[k];
    const int floor = memory_floor(k, waker->location);
    if (floors[waker->location] < floor)
        floors[waker->location] = floor;
    note_futex_call(k, waker->location, 1);
    waker->state = THREAD_RUNS;
    int woken = 0;
    for (int i = 0; i < MEMORY_THREADS && !woken; i++)
        if (threads[i].state == THREAD_FUTEX_SLEEPS && threads[i].location == waker->location) {
            threads[i].state = THREAD_RUNS;
            woken = 1;
        }
    thread_record(k, "futex wakes", memory_address(waker->location), 0, (uint64_t)woken);
}

void kernel_doorbell_write(int k)
{
    doorbell = true;
    doorbell_calls = state_mix(doorbell_calls, (uint64_t)(2 * k + 1));
    thread_record(k, "doorbell write", NULL, 0, 0);
}

void kernel_doorbell_wait(int k)
{
    doorbell = false;
    doorbell_calls = state_mix(doorbell_calls, (uint64_t)(2 * k + 2));
    thread_record(k, "doorbell wait ends", NULL, 0, 0);
}

bool kernel_doorbell_is_set(void)
{
    return doorbell;
}

bool kernel_may_interrupt(void)
{
    return interruptions_left > 0;
}

void kernel_interrupt(int k)
{
    interruptions_left--;
    thread_record(k, "interrupted", NULL, 0, 0);
}

uint64_t kernel_history(void)
{
    uint64_t hash = state_mix(doorbell_calls, doorbell);
    for (int i = 0; i < MEMORY_LOCATIONS; i++)
        if (words[i]) /* locations are numbered by first use: the order of a sum does not matter */
            hash += state_mix((uintptr_t)words[i], futex_calls[i]);
    return state_mix(hash, (uint64_t)interruptions_left);
}
