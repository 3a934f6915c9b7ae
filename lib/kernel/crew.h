/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Who works on the independent parts of one solve: the threads of a pool, or the caller alone. The
 * kernels know nothing else of threads.
 */
#ifndef TFA_KERNEL_CREW_H
#define TFA_KERNEL_CREW_H

#include <stddef.h>
#include <stdint.h>

/* Part `part` of a step, done by thread `worker` of the crew, 0 for the caller. */
typedef void tfa_crew_task(void *context, uint32_t part, uint32_t worker);

struct tfa_crew {
    uint32_t threads; /* the caller included */
    /* task(context, part, worker) for part 0 .. parts - 1, each once, in any order and at the same
     * time; returns when all are done, and sees what they wrote. No allocation, no lock. How a step
     * is cut into parts must not depend on `threads`: the answer is the same bits for any crew. */
    void (*run)(struct tfa_crew *crew, tfa_crew_task *task, void *context, uint32_t parts);
};

/* The same for a crew that may be NULL: the caller alone, in order. A task must not run a step of
 * its own. */
static inline void crew_run(struct tfa_crew *crew, tfa_crew_task *task, void *context,
                            uint32_t parts)
{
    if (crew && parts > 1) {
        crew->run(crew, task, context, parts);
        return;
    }
    for (uint32_t part = 0; part < parts; part++)
        task(context, part, 0);
}

#endif
