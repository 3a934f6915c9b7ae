/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The machine beside the round trips: latency of timers, time taken from a spinning thread, load.
 */
#ifndef TOOLS_LATENCY_MACHINE_MACHINE_H
#define TOOLS_LATENCY_MACHINE_MACHINE_H

#include "latency/loop/tally.h"

/** Wake-ups by clock_nanosleep to absolute times, as cyclictest measures them. */
typedef struct machine_timer {
    latency_times late; /**< wake-up after its time, ns */
    uint64_t interval_ns;
} machine_timer;

/** A thread that reads the clock without pause, and misses some of it. */
typedef struct machine_gaps {
    latency_times gaps; /**< between two readings, those above MACHINE_GAP_NS, ns */
    uint64_t lost_ns;   /**< their sum */
    uint64_t elapsed_ns;
} machine_gaps;

/** Interrupts and hosts take longer, reading the clock does not. */
#define MACHINE_GAP_NS 5000

/** How busy the machine is besides this program. */
typedef struct machine_busy {
    int busy;         /**< one of the figures is above its limit */
    double gap_share; /**< of a spinning thread's time, lost in gaps; -1: not measured */
    double steal;     /**< share of the processors' time that the host took; -1: not measured */
    double load;      /**< runnable threads in the last minute; -1: not measured */
    int processors;   /**< that this process may use */
    char text[160];   /**< the figures above their limits; "" if none */
} machine_busy;

/** Limits of the figures; of the load: the number of processors. Ticks of an idle virtual machine
 *  take up to 5 % of a thread, another thread half of it. */
#define MACHINE_BUSY_GAPS 0.1
#define MACHINE_BUSY_STEAL 0.02

/** Measures for `duration` ns each. */
void machine_measure_timer(machine_timer *timer, uint64_t interval_ns, uint64_t duration_ns);
void machine_measure_gaps(machine_gaps *gaps, uint64_t duration_ns);

/** This thread, and those that it starts, run by SCHED_FIFO; 0: as others. @return 0, or -1 after a
 *  message */
int machine_set_priority(int priority);

/** Locks the memory of this process, now and later. @return as machine_set_priority */
int machine_lock_memory(void);

/** Number of processors this process may use. */
int machine_processors(void);

/** 1-minute load average; -1: unknown. */
double machine_load(void);

/** Sets busy and text by the figures. */
void machine_judge(machine_busy *busy);

#endif
