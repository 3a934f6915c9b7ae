/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Background load.
 */
#include "background_load.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stddef.h>
#include <stdlib.h>

enum { MEMORY_BYTES = 64 << 20, LINE = 64, STEP = 4096 };

struct background_load {
    _Atomic int stop;
    uint32_t count;
    _Atomic unsigned char *memory;
    pthread_t threads[];
};

/* The clients' threads may have a real-time priority; the load that they meet has none. */
static void leave_priority(void)
{
    (void)!sched_setscheduler(0, SCHED_OTHER, &(struct sched_param){0});
}

static void *compute(void *arg)
{
    leave_priority();
    background_load *load = arg;
    volatile double sink = 0;
    double x = 1.0;
    while (!atomic_load_explicit(&load->stop, memory_order_relaxed)) {
        for (int i = 0; i < STEP; i++)
            x = x * 0.9999999 + 1e-7;
        sink = x;
    }
    (void)sink;
    return NULL;
}

static void *thrash(void *arg)
{
    leave_priority();
    background_load *load = arg;
    size_t at = 0;
    while (!atomic_load_explicit(&load->stop, memory_order_relaxed))
        for (int i = 0; i < STEP; i++, at = (at + LINE) % MEMORY_BYTES)
            atomic_store_explicit(&load->memory[at], (unsigned char)at, memory_order_relaxed);
    return NULL;
}

background_load *background_load_start(uint32_t compute_threads, uint32_t memory_threads)
{
    const uint32_t count = compute_threads + memory_threads;
    background_load *load = calloc(1, sizeof *load + count * sizeof load->threads[0]);
    if (load && memory_threads)
        load->memory = calloc(1, MEMORY_BYTES);
    if (!load || (memory_threads && !load->memory)) {
        free(load);
        return NULL;
    }
    for (; load->count < count; load->count++)
        if (pthread_create(&load->threads[load->count], NULL,
                           load->count < compute_threads ? compute : thrash, load) != 0) {
            background_load_stop(load);
            return NULL;
        }
    return load;
}

void background_load_stop(background_load *load)
{
    if (!load)
        return;
    atomic_store_explicit(&load->stop, 1, memory_order_relaxed);
    for (uint32_t i = 0; i < load->count; i++)
        pthread_join(load->threads[i], NULL);
    free((void *)load->memory);
    free(load);
}
