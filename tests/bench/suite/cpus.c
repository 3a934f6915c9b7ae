/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Every thread on a processor of its own, the same for every contestant.
 */
#include "suite.h"

#include <sched.h>

enum { CPUS = 64 };

/* Those that were allowed at the start, the last one first: the first has the interrupts. */
static int cpus[CPUS];
static uint32_t count;

void cpus_pin(void)
{
    cpu_set_t set;
    if (sched_getaffinity(0, sizeof set, &set) != 0)
        return;
    for (size_t k = CPU_SETSIZE; k-- > 0 && count < CPUS;)
        if (CPU_ISSET(k, &set))
            cpus[count++] = (int)k;
    CPU_ZERO(&set);
    CPU_SET((size_t)cpus[0], &set);
    (void)sched_setaffinity(0, sizeof set, &set);
}

const int *cpus_for(uint32_t threads)
{
    return threads <= count ? cpus : NULL;
}
