/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Parallel loop over the independent parts of one solve, on the threads of a pool or on the caller
 * alone. The kernels know nothing else of threads.
 */
#ifndef TFA_INTERFACE_PARALLEL_FOR_H
#define TFA_INTERFACE_PARALLEL_FOR_H

#include <stddef.h>
#include <stdint.h>

/* Part `part` of a step, done by thread `worker` of the executor, 0 for the caller. */
typedef void tfa_parallel_task(void *context, uint32_t part, uint32_t worker);

struct tfa_executor {
    uint32_t threads; /* the caller included */
    /* task(context, part, worker) for part 0 .. parts - 1, each once, in any order and at the same
     * time; returns when all are done, and sees what they wrote. No allocation, no lock. How a step
     * is cut into parts must not depend on `threads`: the answer is the same bits for any
     * executor. */
    void (*run)(struct tfa_executor *executor, tfa_parallel_task *task, void *context,
                uint32_t parts);
};

/* The same for an executor that may be NULL: the caller alone, in order. A task must not run a step
 * of its own. */
static inline void parallel_for(struct tfa_executor *executor, tfa_parallel_task *task,
                                void *context, uint32_t parts)
{
    if (executor && parts > 1) {
        executor->run(executor, task, context, parts);
        return;
    }
    for (uint32_t part = 0; part < parts; part++)
        task(context, part, 0);
}

#endif
