/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The thread pool runs every task once in every phase, with any number of threads, also when
 * threads are stopped for milliseconds; meant to run under ThreadSanitizer too.
 */
#include "thread_pool/thread_pool.h"
#include "support/wait.h"
#include "test.h"

#include <dirent.h>
#include <stdatomic.h>

#define TASKS 67

struct count {
    uint32_t done[TASKS]; /* plain on purpose: two threads in one task would be a data race */
    uint32_t tasks;
    uint32_t threads;
    int slow;
};

static void count_task(void *context, uint32_t task, uint32_t worker)
{
    struct count *c = context;
    assert_true(task < c->tasks);
    assert_true(worker < c->threads);
    if (c->slow && worker > 0 && task % 16 == 3)
        sleep_ms(2); /* as if the host had taken the processor away */
    c->done[task]++;
}

static void run_phases(uint32_t threads, uint32_t spin_ns, int phases, int slow)
{
    struct tfa_thread_pool *thread_pool = NULL;
    assert_int_equal(thread_pool_start(&thread_pool, &(struct thread_pool_options){threads, spin_ns,
                                                                                   NULL, 0, NULL}),
                     0);
    struct count c = {.threads = threads, .slow = slow};
    uint32_t expected[TASKS] = {0};
    for (int p = 0; p < phases; p++) {
        c.tasks = (uint32_t)(p % TASKS) + 1;
        thread_pool_run(thread_pool, count_task, &c, c.tasks);
        for (uint32_t k = 0; k < c.tasks; k++)
            expected[k]++;
        assert_memory_equal(c.done, expected, sizeof expected);
    }
    thread_pool_stop(thread_pool);
}

TEST(test_every_task_once)
{
    static const uint32_t threads[] = {1, 2, 3, 5, 16};
    for (size_t k = 0; k < sizeof threads / sizeof *threads; k++)
        run_phases(threads[k], 20000, 2000, 0);
}

/* Threads of the pools of this process, besides callers, that sleep now. */
static uint32_t count_sleeping(void)
{
    uint32_t count = 0;
    DIR *d = opendir("/proc/self/task");
    assert_non_null(d);
    for (const struct dirent *e; (e = readdir(d)) != NULL;) {
        char path[300], state = 0;
        int named = 0; /* the name is that of a pool */
        snprintf(path, sizeof path, "/proc/self/task/%s/stat", e->d_name);
        FILE *in = fopen(path, "r");
        if (in && fscanf(in, "%*d (tfa-pool%n%*[^)]) %c", &named, &state) == 1 && named)
            count += state == 'S';
        if (in)
            fclose(in);
    }
    closedir(d);
    return count;
}

TEST(test_sleeping_threads)
{
    struct tfa_thread_pool *thread_pool = NULL;
    assert_int_equal(
        thread_pool_start(&thread_pool, &(struct thread_pool_options){4, 1, NULL, 0, NULL}), 0);
    struct count c = {.threads = 4, .tasks = TASKS};
    for (uint32_t p = 1; p <= 50; p++) {
        assert_true(WAIT_FOR(count_sleeping() == 3));
        thread_pool_run(thread_pool, count_task, &c, TASKS);
        for (uint32_t k = 0; k < TASKS; k++)
            assert_int_equal(c.done[k], p);
    }
    thread_pool_stop(thread_pool);
}

TEST(test_stopped_threads)
{
    run_phases(4, 1000, 100, 1);
}

/* Tasks that are counted */
struct assignment {
    uint32_t tasks;
    _Atomic uint32_t counted; /* see the task */
    _Atomic uint32_t begun[2];
};

/* Two threads in step, so that neither is late: each goes on when the other one has begun as many
 * tasks. Counts tasks of the thread's own range. */
static void own_task(void *context, uint32_t task, uint32_t worker)
{
    struct assignment *a = context;
    const uint32_t mine = atomic_fetch_add(&a->begun[worker], 1) + 1;
    const bool both = WAIT_FOR(atomic_load(&a->begun[1 - worker]) >= mine);
    atomic_fetch_add(&a->counted, both && task * 2 / a->tasks == worker);
}

TEST(test_fixed_assignment)
{
    struct tfa_thread_pool *thread_pool = NULL;
    assert_int_equal(
        thread_pool_start(&thread_pool, &(struct thread_pool_options){2, 1000000, NULL, 0, NULL}),
        0);
    for (int p = 0; p < 50; p++) {
        struct assignment a = {.tasks = 8};
        thread_pool_run(thread_pool, own_task, &a, a.tasks);
        assert_int_equal(atomic_load(&a.counted), a.tasks);
    }
    thread_pool_stop(thread_pool);
}

/* The first task of the last thread's range waits until all others are done, which are counted. */
static void late_task(void *context, uint32_t task, uint32_t worker)
{
    struct assignment *a = context;
    (void)worker;
    if (task != a->tasks - a->tasks / 4)
        atomic_fetch_add(&a->counted, 1);
    else
        assert_true(WAIT_FOR(atomic_load(&a->counted) == a->tasks - 1));
}

TEST(test_late_threads)
{
    struct tfa_thread_pool *thread_pool = NULL;
    assert_int_equal(
        thread_pool_start(&thread_pool, &(struct thread_pool_options){4, 20000, NULL, 0, NULL}), 0);
    for (int p = 0; p < 50; p++) {
        struct assignment a = {.tasks = 64};
        thread_pool_run(thread_pool, late_task, &a, a.tasks);
        assert_int_equal(atomic_load(&a.counted), a.tasks - 1);
    }
    thread_pool_stop(thread_pool);
}

TEST(test_stop_without_work)
{
    for (int k = 0; k < 50; k++) {
        struct tfa_thread_pool *thread_pool = NULL;
        assert_int_equal(
            thread_pool_start(&thread_pool, &(struct thread_pool_options){3, 100, NULL, 0, NULL}),
            0);
        thread_pool_stop(thread_pool);
    }
}
