/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Facts without which a latency figure means nothing: the machine, its kernel, its threads.
 */
#ifndef TOOLS_COMMON_ENVIRONMENT_H
#define TOOLS_COMMON_ENVIRONMENT_H

#include <jansson.h>
#include <stdint.h>
#include <sys/types.h>
#include <time.h>

/** Kernel, processor, hypervisor, governor, clock source, versions: a flat
 *  JSON object of strings and numbers; null where the system does not say. */
json_t *environment_read(void);

/** Time that the host took from this machine since boot, in clock ticks, over all processors. */
uint64_t environment_steal_ticks(void);

/** Scheduling statistics of one thread */
typedef struct thread_usage {
    pid_t tid; /**< 0: this thread */
    char name[32];
    int policy, priority;           /**< SCHED_*; of FIFO and RR */
    int64_t voluntary, involuntary; /**< context switches */
    int64_t minor_faults, major_faults;
    int64_t cpu_ns;      /**< processor time; -1: unknown */
    int64_t allocations; /**< of this program's threads; -1: not counted */
} thread_usage;

enum { THREADS_MAX = 64 };

/** "SCHED_OTHER", "SCHED_FIFO", ... */
const char *environment_policy(int policy);

/** All threads of a process (at most THREADS_MAX), from /proc. @return how many; 0 if
 * unreadable. */
int environment_threads(pid_t process, thread_usage threads[THREADS_MAX]);

/** The calling thread, by getrusage, its own clock and allocations_count. */
thread_usage environment_this_thread(void);

/** Their difference between two readings of the same thread */
thread_usage environment_difference(const thread_usage *before, const thread_usage *after);

/** CLOCK_MONOTONIC in ns. */
static inline uint64_t clock_ns(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (uint64_t)t.tv_sec * 1000000000u + (uint64_t)t.tv_nsec;
}

/** In a loop that spins: leaves the core's other thread more of it. */
static inline void cpu_relax(void)
{
#if defined(__x86_64__) || defined(__i386__)
    __builtin_ia32_pause();
#elif defined(__aarch64__)
    __asm__ volatile("yield");
#endif
}

#endif
