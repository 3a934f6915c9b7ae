/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Stalls of the machine: times in which a processor runs nothing at all, because the host of a
 * virtual machine took it away. A thread on each processor sleeps for a millisecond at a time, by
 * SCHED_FIFO where this process may; a stall is a sleep that lasted much longer.
 */
#ifndef TFA_TESTS_STALLS_H
#define TFA_TESTS_STALLS_H

#include <stdint.h>

/* Stalls shorter than `least_ns` do not count. */
void stalls_start(uint64_t least_ns);

void stalls_stop(void);

/* CLOCK_MONOTONIC, ns, of the end of the last stall; 0: none */
uint64_t stalls_last(void);

/* Of all processors, since stalls_start */
unsigned stalls_count(void);
uint64_t stalls_longest_ns(void);

#endif
