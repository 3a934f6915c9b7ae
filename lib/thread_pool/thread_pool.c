/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The thread pool. Each thread has a fixed range of the tasks of a phase, so that data of a part
 * stay in one cache from step to step; a thread without work takes tasks of a thread that is late.
 *
 *   ticket = phase (44 bits) | tasks (20): the running phase
 *   taken  = phase (44 bits) | next (20), one a thread: the next task of its range; of an older
 *            phase: none is taken yet
 *
 * Concurrent access: the caller stores a new ticket only when no task of the last phase is
 * under way (`tasks_left` is 0); any thread takes a task by compare-and-exchange on the `taken` of
 * its range. A thread that was stopped for milliseconds holds an old ticket: all tasks of that
 * phase are taken, and it takes none. The job is read only after a task was taken, when the caller
 * cannot have begun another phase.
 *
 * Atomics and their partners:
 *   T1 ticket store (release, caller: the job is written)   -> T2 ticket load (acquire, worker)
 *   R1 taken exchange (relaxed): decides which thread has the task. It orders no data: the job
 *      came with T2, and what tasks wrote comes with the next T1.
 *   L1 tasks_left decrement (release, worker: its tasks are done)   -> L2 tasks_left load (acquire,
 *   caller)
 *   E1 epoch increment (seq_cst, caller: ticket is stored)  -> E2 epoch load, futex wait (worker)
 *   S1 sleepers increment (seq_cst, worker about to sleep)  -> S2 sleepers load (seq_cst, caller):
 *      of E1;S2 and S1;E2 at least one sees the other's store, so no wake is lost.
 *   B1 busy store 0 (release, the caller that leaves)       -> B2 busy exchange (acquire, the
 *   next):
 *      the holder of the thread pool has exclusive access to the members that callers write.
 */
#include "thread_pool/thread_pool.h"

#include <errno.h>
#include <linux/futex.h>
#include <pthread.h>
#include <sched.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

#define CACHE_LINE 64
#define TASK_BITS 20
#define TASK_MASK (((uint64_t)1 << TASK_BITS) - 1)

/* A thread that has done its range waits this long for the others before it takes their tasks: more
 * than a spinning thread needs to see a ticket (0.2 us, bench_thread_pool, Intel Xeon). */
#define PATIENCE_NS 2000

/* Spins of a caller before it yields, and yields before it sleeps: a thread that lost its processor
 * to a real-time caller gets it back only then. A spin takes 15 ns: the 60th and the 500th
 * microsecond. */
#define SPINS_PER_YIELD 4096
#define YIELDS_PER_SLEEP 8
#define SLEEP_NS 50000

struct pool_worker {
    _Alignas(CACHE_LINE) _Atomic uint64_t taken;
    struct tfa_thread_pool *thread_pool;
    pthread_t thread;
    uint32_t worker;
};

struct tfa_thread_pool {
    _Alignas(CACHE_LINE) _Atomic uint64_t ticket;
    _Alignas(CACHE_LINE) _Atomic uint32_t tasks_left;
    _Alignas(CACHE_LINE) _Atomic uint32_t epoch; /* futex word */
    _Atomic uint32_t sleepers;
    _Atomic uint32_t stop;
    _Alignas(CACHE_LINE) _Atomic uint32_t busy;
    _Alignas(CACHE_LINE) thread_pool_task *task; /* the job of the phase */
    void *context;
    void (*thread_init)(void);
    uint64_t phase;
    uint32_t spin_ns;
    uint32_t threads; /* the caller included; constant from before the first one starts */
    uint32_t started; /* of them, the caller included: for the thread that stops them */
    struct pool_worker *workers; /* the caller's first */
};

static uint64_t phase_of(uint64_t word)
{
    return word >> TASK_BITS;
}

static void cpu_relax(void)
{
#if defined(__x86_64__)
    __builtin_ia32_pause();
#elif defined(__aarch64__)
    __asm__ volatile("yield");
#endif
}

static uint64_t now_ns(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (uint64_t)t.tv_sec * 1000000000u + (uint64_t)t.tv_nsec;
}

/* First task of a thread's range; a phase of one task is the caller's. */
static uint64_t range_start(const struct tfa_thread_pool *t, uint64_t tasks, uint32_t worker)
{
    return (tasks * worker + t->threads - 1) / t->threads;
}

/* Takes the next task of the range of `owner` in the phase of `ticket`. */
static int claim_task(struct tfa_thread_pool *t, uint64_t ticket, uint32_t owner, uint64_t *task)
{
    _Atomic uint64_t *taken = &t->workers[owner].taken;
    const uint64_t tasks = ticket & TASK_MASK, end = range_start(t, tasks, owner + 1);
    uint64_t seen = atomic_load_explicit(taken, memory_order_relaxed);
    do {
        if (phase_of(seen) > phase_of(ticket))
            return 0;
        *task =
            phase_of(seen) == phase_of(ticket) ? seen & TASK_MASK : range_start(t, tasks, owner);
        if (*task >= end)
            return 0;
    } while (!atomic_compare_exchange_weak_explicit(
        taken, &seen, phase_of(ticket) << TASK_BITS | (*task + 1), memory_order_relaxed,
        memory_order_relaxed)); /* R1 */
    return 1;
}

/* Runs what is left of the range of `owner`. */
static void run_range(struct tfa_thread_pool *t, uint64_t ticket, uint32_t owner, uint32_t worker)
{
    uint32_t done = 0;
    uint64_t task;
    for (; claim_task(t, ticket, owner, &task); done++)
        t->task(t->context, (uint32_t)task, worker);
    if (done)
        atomic_fetch_sub_explicit(&t->tasks_left, done, memory_order_release); /* L1 */
}

/* Waits for the end of the phase; returns 0 when it is over, 1 when a thread is late. */
static int wait_for_others(struct tfa_thread_pool *t, uint64_t ticket)
{
    const uint64_t deadline = now_ns() + PATIENCE_NS;
    while (atomic_load_explicit(&t->ticket, memory_order_relaxed) == ticket &&
           atomic_load_explicit(&t->tasks_left, memory_order_relaxed)) {
        if (now_ns() > deadline)
            return 1;
        cpu_relax();
    }
    return 0;
}

/* Runs the range of this thread, and the rest of others that are late. */
static void run_tasks(struct tfa_thread_pool *t, uint64_t ticket, uint32_t worker)
{
    run_range(t, ticket, worker, worker);
    if (!wait_for_others(t, ticket))
        return;
    for (uint32_t k = 1; k < t->threads; k++)
        run_range(t, ticket, (worker + k) % t->threads, worker);
}

/* Sleeps until the epoch moves on from `seen`. */
static void sleep_until_woken(struct tfa_thread_pool *t, uint32_t seen)
{
    atomic_fetch_add(&t->sleepers, 1);     /* S1 */
    while (atomic_load(&t->epoch) == seen) /* E2 */
        syscall(SYS_futex, &t->epoch, FUTEX_WAIT_PRIVATE, seen, NULL, NULL, 0);
    atomic_fetch_sub(&t->sleepers, 1);
}

/* Waits for a phase other than `phase`: spins, then sleeps. Returns its ticket. */
static uint64_t wait_for_phase(struct tfa_thread_pool *t, uint64_t phase)
{
    uint64_t deadline = 0;
    for (uint32_t spin = 0;; spin++) {
        uint32_t seen = atomic_load(&t->epoch); /* before the ticket: see S1 */
        uint64_t ticket = atomic_load_explicit(&t->ticket, memory_order_acquire); /* T2 */
        if (phase_of(ticket) != phase || atomic_load_explicit(&t->stop, memory_order_relaxed))
            return ticket;
        cpu_relax();
        if (spin % 64 != 63)
            continue;
        uint64_t now = now_ns();
        if (!deadline)
            deadline = now + t->spin_ns;
        else if (now > deadline)
            sleep_until_woken(t, seen);
    }
}

static void *worker_main(void *argument)
{
    struct pool_worker *m = argument;
    struct tfa_thread_pool *t = m->thread_pool;
    uint64_t phase = 0;
    if (t->thread_init)
        t->thread_init();
    while (!atomic_load_explicit(&t->stop, memory_order_acquire)) {
        uint64_t ticket = wait_for_phase(t, phase);
        phase = phase_of(ticket);
        run_tasks(t, ticket, m->worker);
    }
    return NULL;
}

static void wake_sleepers(struct tfa_thread_pool *t)
{
    atomic_fetch_add(&t->epoch, 1); /* E1 */
    if (atomic_load(&t->sleepers))  /* S2 */
        syscall(SYS_futex, &t->epoch, FUTEX_WAKE_PRIVATE, INT32_MAX, NULL, NULL, 0);
}

/* Waits for the tasks under way, whose threads may have lost their processor: must not spin for
 * ever. */
static void wait_for_completion(struct tfa_thread_pool *t)
{
    static const struct timespec pause = {.tv_nsec = SLEEP_NS};
    for (uint32_t spin = 1; atomic_load_explicit(&t->tasks_left, memory_order_acquire);
         spin++) { /* L2 */
        cpu_relax();
        if (spin % SPINS_PER_YIELD != 0)
            continue;
        if (spin < SPINS_PER_YIELD * YIELDS_PER_SLEEP)
            sched_yield(); /* more threads than cores: lets another thread run */
        else
            nanosleep(&pause, NULL);
    }
}

uint32_t thread_pool_threads(const struct tfa_thread_pool *t)
{
    return t->threads;
}

int thread_pool_acquire(struct tfa_thread_pool *t)
{
    return atomic_exchange_explicit(&t->busy, 1, memory_order_acquire) == 0; /* B2 */
}

void thread_pool_release(struct tfa_thread_pool *t)
{
    atomic_store_explicit(&t->busy, 0, memory_order_release); /* B1 */
}

void thread_pool_run(struct tfa_thread_pool *t, thread_pool_task *task, void *context,
                     uint32_t tasks)
{
    if (tasks == 0)
        return;
    t->task = task;
    t->context = context;
    t->phase++;
    atomic_store_explicit(&t->tasks_left, tasks, memory_order_relaxed); /* published by T1 */
    const uint64_t ticket = t->phase << TASK_BITS | tasks;
    atomic_store_explicit(&t->ticket, ticket, memory_order_release); /* T1 */
    wake_sleepers(t);
    run_tasks(t, ticket, 0);
    wait_for_completion(t);
}

/* Processor and priority of one thread */
static int set_thread_attributes(pthread_attr_t *attributes, const struct thread_pool_options *o,
                                 uint32_t worker)
{
    const struct sched_param parameter = {.sched_priority = o->priority};
    int error = 0;
    if (o->cpus) {
        cpu_set_t set;
        CPU_ZERO(&set);
        CPU_SET((size_t)o->cpus[worker], &set);
        error = pthread_attr_setaffinity_np(attributes, sizeof set, &set);
    }
    if (!error && o->priority)
        error = pthread_attr_setinheritsched(attributes, PTHREAD_EXPLICIT_SCHED);
    if (!error && o->priority)
        error = pthread_attr_setschedpolicy(attributes, SCHED_FIFO);
    if (!error && o->priority)
        error = pthread_attr_setschedparam(attributes, &parameter);
    return error;
}

static int start_worker(struct tfa_thread_pool *t, uint32_t worker,
                        const struct thread_pool_options *o)
{
    struct pool_worker *m = &t->workers[worker];
    char name[16];
    m->thread_pool = t;
    m->worker = worker;
    pthread_attr_t attributes;
    int error = pthread_attr_init(&attributes);
    if (error)
        return error;
    error = set_thread_attributes(&attributes, o, worker);
    if (!error)
        error = pthread_create(&m->thread, &attributes, worker_main, m);
    pthread_attr_destroy(&attributes);
    if (error)
        return error;
    snprintf(name, sizeof name, "tfa-pool%u", (unsigned)worker & 0xffff);
    pthread_setname_np(m->thread, name);
    return 0;
}

int thread_pool_start(struct tfa_thread_pool **thread_pool, const struct thread_pool_options *o)
{
    struct tfa_thread_pool *t = aligned_alloc(CACHE_LINE, sizeof *t);
    if (!t)
        return ENOMEM;
    *t = (struct tfa_thread_pool){
        .spin_ns = o->spin_ns, .thread_init = o->thread_init, .threads = o->threads, .started = 1};
    t->workers = aligned_alloc(CACHE_LINE, o->threads * sizeof *t->workers);
    int error = t->workers ? 0 : ENOMEM;
    if (t->workers)
        memset(t->workers, 0, o->threads * sizeof *t->workers);
    while (!error && t->started < t->threads) {
        error = start_worker(t, t->started, o);
        t->started += !error;
    }
    if (error) {
        thread_pool_stop(t);
        return error;
    }
    *thread_pool = t;
    return 0;
}

void thread_pool_stop(struct tfa_thread_pool *t)
{
    atomic_store_explicit(&t->stop, 1, memory_order_release);
    wake_sleepers(t);
    for (uint32_t k = 1; k < t->started; k++)
        pthread_join(t->workers[k].thread, NULL);
    free(t->workers);
    free(t);
}
