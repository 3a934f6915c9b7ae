/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Stateless exploration of a small concurrent program: every execution that the memory model admits
 * (memory.h), each from its beginning along a trail of choices.
 *
 * The threads are coroutines. Only operations that read are points of choice: a store, executed as
 * early as possible, only adds to the stores that others may read. A load reads one of the stores
 * that are there or is postponed until there is a newer one. Interleavings with the same operations
 * and the same reads-from relation have the same future, so a state that was met before ends its
 * execution.
 *
 * A finding is a data race, a failed check, a second writer of a location, or a state in which no
 * thread can go on and one has not ended (a lost wake-up).
 */
#ifndef TFA_EXPLORER_H
#define TFA_EXPLORER_H

#include <stdatomic.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/** A program under test; the functions get `argument`. */
typedef struct explorer_program {
    const char *name;
    void (*reset)(void *argument); /**< before each execution; may be NULL */
    void (*body[4])(void *argument);
    void (*finish)(void *argument); /**< after each complete execution; may be NULL */
    void *argument;
    bool many_writers; /**< locations with several writers: stores are points of choice as well */
    int interruptions; /**< futex waits and doorbell waits that end early, in one execution */
    bool weak_sc;      /**< memory_reset */
} explorer_program;

typedef struct explorer_result {
    const char *finding;       /**< NULL: none */
    uint64_t executions;       /**< complete ones */
    uint64_t states, branches; /**< distinct states; executions, with those cut short */
    double seconds;
} explorer_result;

/** Explores until the first finding or the end. */
explorer_result explorer_run(const explorer_program *program);

/** Prints the operations of the last execution. */
void explorer_print_trace(void);

/* ---- of the threads under test ---- */

/** Plain memory. */
uint64_t explorer_data_read(const uint64_t *at);
void explorer_data_write(uint64_t *at, uint64_t value);

/** A turn of a loop that only repeats its last load: the next load of that location reads a newer
 *  store; the thread blocks until there is one. */
void explorer_spin(void);

/** FUTEX_WAIT and FUTEX_WAKE (1). The kernel compares with a store that is no older than those that
 *  earlier wakers of the word had seen; it orders nothing else. Timeouts are interruptions only. */
void explorer_futex_wait(const volatile void *word, uint32_t value);
void explorer_futex_wake(const volatile void *word);

/** An eventfd in edge-triggered epoll: a wait ends once for any number of earlier writes. */
void explorer_doorbell_write(void);
void explorer_doorbell_wait(void);

/** Ends the thread: its process was killed. */
void explorer_die(void);

/** Ends the execution with a finding unless `condition`. */
void explorer_check(bool condition, const char *finding);

#endif
