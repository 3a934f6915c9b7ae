/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Cost of a phase of the thread pool: as many tasks as threads, tasks of nothing, and tasks of 2 us
 * each against the same work alone.
 *
 *     bench_thread_pool [TURNS [THREADS]]
 *
 * Wall time of the caller, ns a phase: best, median, 99th percentile. On a busy machine: below
 * `chrt -f 1`, with at most as many threads as cores.
 */
#include <stdio.h>
#include <stdlib.h>

#include "thread_pool/thread_pool.h"
#include "timing.h"

#define TURNS_MAX 1000000
#define WORK 650 /* dependent additions through memory: about 2 us (AMD Zen 5) */

static double times[TURNS_MAX];

static void nothing(void *context, uint32_t task, uint32_t worker)
{
    (void)context;
    (void)task;
    (void)worker;
}

static void work(void *context, uint32_t task, uint32_t worker)
{
    double *sums = context;
    volatile double x = sums[8 * worker];
    for (int k = 0; k < WORK; k++)
        x += 1.0 + task;
    sums[8 * worker] = x;
}

static void measure(struct tfa_thread_pool *thread_pool, thread_pool_task *task, uint32_t tasks,
                    int turns, const char *what, uint32_t threads)
{
    static double sums[8 * 256];
    for (int k = -1000; k < turns; k++) {
        const double start = wall_ns();
        thread_pool_run(thread_pool, task, sums, tasks);
        if (k >= 0)
            times[k] = wall_ns() - start;
    }
    qsort(times, (size_t)turns, sizeof *times, by_value);
    printf("%7u %-12s %8.0f %8.0f %8.0f\n", threads, what, times[0], times[turns / 2],
           times[turns - 1 - turns / 100]);
}

int main(int argc, char **argv)
{
    static const uint32_t threads[] = {1, 2, 3, 4, 8};
    const int turns = argc > 1 ? atoi(argv[1]) : 20000;
    if (turns < 1 || turns > TURNS_MAX) {
        fprintf(stderr, "turns: 1 to %d\n", TURNS_MAX);
        return 3;
    }
    const uint32_t most = argc > 2 ? (uint32_t)atoi(argv[2]) : 8;
    printf("threads task             best   median      p99\n");
    for (size_t k = 0; k < sizeof threads / sizeof *threads && threads[k] <= most; k++) {
        struct tfa_thread_pool *thread_pool;
        const struct thread_pool_options options = {.threads = threads[k], .spin_ns = 100000};
        if (thread_pool_start(&thread_pool, &options))
            return 2;
        measure(thread_pool, nothing, threads[k], turns, "nothing", threads[k]);
        measure(thread_pool, work, threads[k], turns, "2 us each", threads[k]);
        measure(thread_pool, work, 8, turns, "8 of 2 us", threads[k]);
        thread_pool_stop(thread_pool);
    }
    return 0;
}
