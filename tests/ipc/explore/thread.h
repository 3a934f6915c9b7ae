/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The threads of an execution: the next operation of each, and its history as a hash.
 */
#ifndef TFA_EXPLORER_THREAD_H
#define TFA_EXPLORER_THREAD_H

#include "memory.h"

typedef enum thread_state {
    THREAD_ABSENT,
    THREAD_RUNS, /* until its next point of choice */
    THREAD_LOADS,
    THREAD_STORES, /* where locations have several writers */
    THREAD_EXCHANGES,
    THREAD_FUTEX_WAITS, /* about to compare */
    THREAD_FUTEX_SLEEPS,
    THREAD_FUTEX_WAKES,
    THREAD_DOORBELL_WRITES,
    THREAD_DOORBELL_WAITS,
    THREAD_ENDED
} thread_state;

typedef struct explorer_thread {
    thread_state state;
    const explorer_site *site;
    int location;
    memory_order order;
    uint64_t value;    /* to compare; the value that was read */
    int spun_location; /* after explorer_spin its next load reads a store after spun_store; or -1 */
    int spun_store;
    int last_location, last_store; /* of its last load */
    int awaited; /* postponed: its load reads this store or a newer one; 0: not postponed */
    uint64_t history;
} explorer_thread;

/** Thread that runs, and its number */
explorer_thread *thread_current(void);
int thread_number(void);

/** The thread stops at this point of choice and returns once the scheduler has taken it. */
void thread_stop(thread_state state);

/** Ends the execution with a finding. Does not return within a thread. */
void thread_fail(const char *finding);

/** Adds an operation of thread k to its history and to the trace. `store`: number in modification
 *  order; `at`: address of the location, or NULL */
void thread_record(int k, const char *what, const volatile void *at, int store, uint64_t value);

/** True where locations may have several writers. */
bool thread_many_writers(void);

#endif
