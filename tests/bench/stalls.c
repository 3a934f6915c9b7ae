/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 */
#include "stalls.h"
#include "support/wait.h"
#include "test.h"

#include <pthread.h>
#include <sched.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <time.h>
#include <unistd.h>

#define PROCESSORS_MAX 64
#define PRIORITY 50

static struct {
    pthread_t threads[PROCESSORS_MAX];
    int processors;
    uint64_t least_ns;
    _Atomic bool stop;
    _Atomic unsigned count;
    _Atomic uint64_t last, longest_ns;
} stalls;

static void note_stall(uint64_t end, uint64_t length)
{
    uint64_t longest = atomic_load(&stalls.longest_ns);
    atomic_store(&stalls.last, end);
    atomic_fetch_add(&stalls.count, 1);
    while (length > longest)
        if (atomic_compare_exchange_weak(&stalls.longest_ns, &longest, length))
            break;
}

static void *watch(void *processor)
{
    const struct sched_param priority = {.sched_priority = PRIORITY};
    const struct timespec pause = {.tv_nsec = 1000000};
    cpu_set_t here;
    CPU_ZERO(&here);
    CPU_SET((size_t)(intptr_t)processor, &here);
    (void)pthread_setaffinity_np(pthread_self(), sizeof here, &here);
    (void)pthread_setschedparam(pthread_self(), SCHED_FIFO, &priority); /* else at its own */
    for (uint64_t last = now_ns(); !atomic_load(&stalls.stop);) {
        nanosleep(&pause, NULL);
        const uint64_t now = now_ns();
        if (now - last >= stalls.least_ns)
            note_stall(now, now - last);
        last = now;
    }
    return NULL;
}

void stalls_start(uint64_t least_ns)
{
    const long processors = sysconf(_SC_NPROCESSORS_ONLN);
    stalls.processors = processors < PROCESSORS_MAX ? (int)processors : PROCESSORS_MAX;
    stalls.least_ns = least_ns;
    for (intptr_t i = 0; i < stalls.processors; i++)
        assert_int_equal(pthread_create(&stalls.threads[i], NULL, watch, (void *)i), 0);
}

void stalls_stop(void)
{
    atomic_store(&stalls.stop, true);
    for (int i = 0; i < stalls.processors; i++)
        pthread_join(stalls.threads[i], NULL);
}

uint64_t stalls_last(void)
{
    return atomic_load(&stalls.last);
}

unsigned stalls_count(void)
{
    return atomic_load(&stalls.count);
}

uint64_t stalls_longest_ns(void)
{
    return atomic_load(&stalls.longest_ns);
}
