/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Futexes and one eventfd, as far as the threads under test use them.
 */
#ifndef TFA_EXPLORER_KERNEL_H
#define TFA_EXPLORER_KERNEL_H

#include <stdbool.h>
#include <stdint.h>

#include "thread.h"

void kernel_reset(int interruptions);

/** Oldest store that FUTEX_WAIT on this location may compare with */
int kernel_futex_floor(int location);

/** FUTEX_WAIT after its load: the thread sleeps or goes on. */
void kernel_futex_wait(int k, explorer_thread *thread, uint64_t loaded);

/** FUTEX_WAKE of one of the threads. */
void kernel_futex_wake(int k, explorer_thread threads[MEMORY_THREADS]);

void kernel_doorbell_write(int k);
void kernel_doorbell_wait(int k);

/** Whether a wait at the doorbell ends; an interruption may end a wait of either kind. */
bool kernel_doorbell_is_set(void);
bool kernel_may_interrupt(void);
void kernel_interrupt(int k);

/** Hash of the order of the calls */
uint64_t kernel_history(void);

#endif
