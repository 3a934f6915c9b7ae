/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A pool answers one request on several cores: the states of a batch are spread over its threads.
 */
#ifndef TOTALFORCE_POOL_H
#define TOTALFORCE_POOL_H

#include <totalforce/dynamics.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Threads that wait for work. One request at a time: one thread uses a pool at a time. */
typedef struct tfa_pool tfa_pool;

typedef struct tfa_pool_options {
    uint32_t threads; /**< the calling thread included; 0: one for each online processor */
    uint32_t spin_ns; /**< how long an idle thread spins before it sleeps; 0: 50000 */
    const int *cpus;  /**< `threads` processors to pin to, the caller's first; NULL: no pinning.
                               The caller's own is not changed. */
    tfa_precision precision; /**< as in tfa_workspace_options */
    tfa_residual residual;   /**< as in tfa_workspace_options */
} tfa_pool_options;

/**
 * Starts the threads and gives each a workspace of this model.
 * @return TFA_OK; TFA_E_ARGUMENT; TFA_E_MEMORY; TFA_E_SYSTEM (a thread could not be started or
 *         pinned; see errno); TFA_E_UNSUPPORTED. The model must outlive the pool.
 */
TFA_API TFA_CHECKED int tfa_pool_create(const tfa_model *model, const tfa_pool_options *options,
                                        tfa_pool **pool);

/** Ends the threads and releases everything. NULL is allowed. */
TFA_API void tfa_pool_free(tfa_pool *pool);

/** Threads of the pool, the calling one included. */
TFA_API uint32_t tfa_pool_threads(const tfa_pool *pool);

/**
 * As tfa_compute, with the states spread over the threads; the same bits whatever their number.
 * No allocation and no lock; a system call only where a thread had gone to sleep.
 */
TFA_API int tfa_pool_compute(tfa_pool *pool, const tfa_request *request, tfa_reply *reply);

#ifdef __cplusplus
}
#endif
#endif
