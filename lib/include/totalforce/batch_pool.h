/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A pool answers one request on several cores: the states of a batch are spread over its threads;
 * fewer states than threads are answered one after the other by all threads together, where the
 * method is parallel (scan, scan-two-pass, tfa-cr, cfa-cr) and the robot has a long chain.
 */
#ifndef TOTALFORCE_BATCH_POOL_H
#define TOTALFORCE_BATCH_POOL_H

#include <totalforce/dynamics.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Worker threads and the calling thread; batch pools of several models may share them. */
typedef struct tfa_thread_pool tfa_thread_pool;

typedef struct tfa_thread_pool_options {
    uint32_t threads;  /**< the calling thread included; 0: one for each online processor */
    uint32_t spin_ns;  /**< how long an idle thread spins before it sleeps; 0: 50000 */
    const int *cpus;   /**< `threads` processors to pin to, the caller's first; NULL: no pinning.
                               The caller's own is not changed. */
    uint32_t priority; /**< SCHED_FIFO priority of the threads, 1 to 99; 0: that of the thread that
                            makes them */
} tfa_thread_pool_options;

/**
 * Starts the threads. They are called tfa-pool1, tfa-pool2, ...
 * @return TFA_OK; TFA_E_ARGUMENT (more than 256 threads, a priority above 99); TFA_E_MEMORY;
 *         TFA_E_SYSTEM (errno: EPERM, the priority needs CAP_SYS_NICE or an rtprio limit; EINVAL, a
 *         processor does not exist; EAGAIN, no more threads).
 */
TFA_API TFA_CHECKED int tfa_thread_pool_create(const tfa_thread_pool_options *options,
                                               tfa_thread_pool **thread_pool);

/** Ends the threads. Every pool that shares them must be gone. NULL is allowed. */
TFA_API void tfa_thread_pool_free(tfa_thread_pool *thread_pool);

/** Workspaces of one model for each thread of a thread pool. Any number of threads may use it: one
 *  is served, the others are told that it is busy. */
typedef struct tfa_batch_pool tfa_batch_pool;

typedef struct tfa_batch_pool_options {
    uint32_t threads; /**< as in tfa_thread_pool_options, like spin_ns, cpus and priority */
    uint32_t spin_ns;
    const int *cpus;
    tfa_precision precision; /**< as in tfa_workspace_options, like residual and methods */
    tfa_residual residual;
    uint32_t methods;
    uint32_t priority;
    tfa_thread_pool *
        /** shared thread pool, which outlives the batch pool; NULL: threads of its own */
        thread_pool;
    /** as in tfa_workspace_options; outlives the pool */
    const struct tfa_specialised *specialised;
} tfa_batch_pool_options;

/**
 * Starts the threads, unless a thread pool is given, and makes each a workspace of this model.
 * @return TFA_OK; what tfa_thread_pool_create and tfa_workspace_create refuse. The model must
 *  outlive the
 *         pool.
 */
TFA_API TFA_CHECKED int tfa_batch_pool_create(const tfa_model *model,
                                              const tfa_batch_pool_options *options,
                                              tfa_batch_pool **pool);

/** Ends its own threads and releases everything. NULL is allowed. */
TFA_API void tfa_batch_pool_free(tfa_batch_pool *pool);

/** Threads of the pool, the calling one included. */
TFA_API uint32_t tfa_batch_pool_threads(const tfa_batch_pool *pool);

/**
 * As tfa_compute, with the states or the parts of a long chain spread over the threads; the same
 * bits whatever their number.
 * No allocation and no lock; a system call only to wake threads that sleep, and while a thread that
 * has work lost its processor for more than 60 us.
 * @return as tfa_compute; TFA_E_BUSY, at once and with nothing done: the threads work on a request
 *  of
 *         another thread, of this pool or one that shares them
 */
TFA_API int tfa_batch_pool_compute(tfa_batch_pool *pool, const tfa_request *request,
                                   tfa_reply *reply);

/** As tfa_compute_states. @return as that; TFA_E_BUSY, which is not in the reply: compute these
 *  states in another way, or again. */
TFA_API int tfa_batch_pool_compute_states(tfa_batch_pool *pool, const tfa_request *request,
                                          uint32_t first, uint32_t count, tfa_reply *reply);

#ifdef __cplusplus
}
#endif
#endif
