/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Thread pools: numbered tasks in phases. The caller works as well and returns when all tasks are
 * done. No knowledge of dynamics.
 */
#ifndef TFA_THREAD_POOL_THREAD_POOL_H
#define TFA_THREAD_POOL_THREAD_POOL_H

#include <stdint.h>

struct tfa_thread_pool;

#define THREAD_POOL_TASKS_MAX ((1u << 20) - 1)

/* One task; `worker` is 0 for the caller of thread_pool_run, below the number of threads
 * otherwise. */
typedef void thread_pool_task(void *context, uint32_t task, uint32_t worker);

struct thread_pool_options {
    uint32_t threads; /* the caller included */
    uint32_t spin_ns; /* time that an idle thread spins before it sleeps, ns */
    const int *cpus;  /* NULL, or a processor for each thread, the caller's first (unused) */
    int priority;     /* SCHED_FIFO; 0: as the thread that starts them */
    void (*thread_init)(void); /* first call of each thread, or NULL */
};

/* Starts threads - 1 threads. Returns 0 or an errno. */
int thread_pool_start(struct tfa_thread_pool **thread_pool,
                      const struct thread_pool_options *options);

/* Number of threads, the caller included. */
uint32_t thread_pool_threads(const struct tfa_thread_pool *thread_pool);

/* Gives the caller exclusive use of the threads. Returns 0 at once if they are in use. */
int thread_pool_acquire(struct tfa_thread_pool *thread_pool);
/* Ends the exclusive use. */
void thread_pool_release(struct tfa_thread_pool *thread_pool);

/* Runs tasks 0..tasks-1, each once, and returns when all are done. One caller at a time: the only
 * user, or the one that acquired the thread pool. tasks <= THREAD_POOL_TASKS_MAX. */
void thread_pool_run(struct tfa_thread_pool *thread_pool, thread_pool_task *task, void *context,
                     uint32_t tasks);

/* Ends and joins the threads. */
void thread_pool_stop(struct tfa_thread_pool *thread_pool);

#endif
