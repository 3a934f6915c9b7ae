/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Thread pools, and batch pools that answer one request on several cores. The states of a batch are
 * spread over the threads. If there are fewer states than threads, the method is parallel (scan,
 * scan-two-pass, tfa-cr, cfa-cr, hybrid) and the robot has a chain of 48 bodies or more, all
 * threads work on one state after the other.
 */
#ifndef TOTALFORCE_BATCH_POOL_H
#define TOTALFORCE_BATCH_POOL_H

#include <totalforce/dynamics.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Worker threads and the calling thread. Batch pools of several models may share one. */
typedef struct tfa_thread_pool tfa_thread_pool;

/** Zero-initialise for the defaults. */
typedef struct tfa_thread_pool_options {
    uint32_t threads;  /**< the calling thread included; 0: one for each online processor */
    uint32_t spin_ns;  /**< time that an idle thread spins before it sleeps, ns; 0: 50000 */
    const int *cpus;   /**< `threads` processors to pin to, the caller's first (the caller itself
                            is not pinned); NULL: no pinning */
    uint32_t priority; /**< SCHED_FIFO priority of the threads, 1 to 99; 0: that of the creator */
} tfa_thread_pool_options;

/**
 * Starts the threads, named tfa-pool1, tfa-pool2, ... Each prepares its stack (tfa_stack_prepare).
 * Any thread. Allocates.
 *
 * @param options      NULL: all defaults
 * @param thread_pool  the new pool
 * @return TFA_OK; TFA_E_ARGUMENT (thread_pool NULL, more than 256 threads, a priority above 99);
 *         TFA_E_MEMORY; TFA_E_SYSTEM with errno: EPERM (the priority needs CAP_SYS_NICE or an
 *         rtprio limit), EINVAL (a processor does not exist), EAGAIN (too many threads).
 *         On error *thread_pool is NULL.
 */
TFA_API TFA_CHECKED int tfa_thread_pool_create(const tfa_thread_pool_options *options,
                                               tfa_thread_pool **thread_pool);

/** Ends and joins the threads. Free every batch pool that shares them first. NULL is allowed. */
TFA_API void tfa_thread_pool_free(tfa_thread_pool *thread_pool);

/** One workspace of a model for each thread of a thread pool. Any number of threads may call it at
 *  once: one is served, the others get TFA_E_BUSY. */
typedef struct tfa_batch_pool tfa_batch_pool;

/** Zero-initialise for the defaults. */
typedef struct tfa_batch_pool_options {
    uint32_t threads;             /**< as in tfa_thread_pool_options; unused with a `thread_pool` */
    uint32_t spin_ns;             /**< the same */
    const int *cpus;              /**< the same */
    tfa_precision precision;      /**< as in tfa_workspace_options */
    tfa_residual residual;        /**< the same */
    uint32_t methods;             /**< the same */
    uint32_t max_tips;            /**< the same */
    uint32_t priority;            /**< as in tfa_thread_pool_options */
    tfa_thread_pool *thread_pool; /**< shared, outlives the batch pool; NULL: its own threads */
    const struct tfa_specialised *specialised; /**< outlives the pool; NULL: none */
} tfa_batch_pool_options;

/**
 * Creates one workspace of the model for each thread; starts the threads unless a thread pool is
 * given. The model must outlive the pool. Any thread. Allocates all memory that the pool ever uses.
 *
 * @param model    outlives the pool
 * @param options  NULL: all defaults
 * @param pool     the new pool
 * @return TFA_OK; TFA_E_ARGUMENT (a NULL); TFA_E_MEMORY; the statuses of tfa_thread_pool_create and
 *         tfa_workspace_create. On error *pool is NULL.
 */
TFA_API TFA_CHECKED int tfa_batch_pool_create(const tfa_model *model,
                                              const tfa_batch_pool_options *options,
                                              tfa_batch_pool **pool);

/** Ends the pool's own threads and releases its memory. No request may be under way. NULL is
 *  allowed. */
TFA_API void tfa_batch_pool_free(tfa_batch_pool *pool);

/** Number of threads, the calling one included. Any thread. */
TFA_API uint32_t tfa_batch_pool_threads(const tfa_batch_pool *pool);

/**
 * As tfa_compute, with the states (or the parts of a long chain) spread over the threads. The bits
 * of the answer do not depend on the number of threads. Any thread.
 *
 * No allocation, no lock. System calls only to wake sleeping threads, and while a thread that holds
 * a task has lost its processor for more than 60 us.
 *
 * @return as tfa_compute; TFA_E_BUSY at once, with nothing computed, if the threads work on a
 *         request of another caller, of this pool or of one that shares them.
 */
TFA_API int tfa_batch_pool_compute(tfa_batch_pool *pool, const tfa_request *request,
                                   tfa_reply *reply);

/**
 * As tfa_compute_states, on the threads of the pool. Any thread.
 * @return as tfa_compute_states; TFA_E_BUSY as tfa_batch_pool_compute, but the reply is unchanged:
 *         compute these states in a workspace, or call again.
 */
TFA_API int tfa_batch_pool_compute_states(tfa_batch_pool *pool, const tfa_request *request,
                                          uint32_t first, uint32_t count, tfa_reply *reply);

#ifdef __cplusplus
}
#endif
#endif
