/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The memory model: C17 without reads from the future (no load buffering). Each location has its
 * stores in modification order, which is the order of execution; a load may read each store that
 * coherence, happens-before and the seq_cst order S admit.
 *
 * A view says which operations happened before: a clock for each thread, and for each location the
 * oldest store that may still be read. A release store carries the view of its thread; an acquire
 * load that reads it joins that view. Of release sequences only read-modify-writes are kept, as in
 * C++20: that admits more executions than C17.
 */
#ifndef TFA_EXPLORER_MEMORY_H
#define TFA_EXPLORER_MEMORY_H

#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>

#define MEMORY_THREADS 4
#define MEMORY_LOCATIONS 12
#define MEMORY_STORES 64
#define MEMORY_CELLS 48

/** Store 0 of each location is its initial value, 0. `weak_sc`: S need not agree with
 *  happens-before between threads, only with program order and with the reads and stores of each
 *  location. That admits more executions than C17 and C++20. */
void memory_reset(bool weak_sc);

int memory_location(const volatile void *at);
const volatile void *memory_address(int location);

/** Stores that a load may read, oldest first, from number `from` on. @return how many */
int memory_readable(int thread, int location, memory_order order, int from,
                    uint8_t readable[MEMORY_STORES]);

/** Reads that store. @return its value */
uint64_t memory_load(int thread, int location, memory_order order, int store);

/** @return number of the store in modification order; -1: too many operations */
int memory_store(int thread, int location, memory_order order, uint64_t value);

/** Reads the last store and appends another. @return number of the store that was read */
int memory_exchange(int thread, int location, memory_order order, uint64_t value);

/** Last store */
int memory_last(int location);
uint64_t memory_value(int location, int store);

/** True if threads other than `thread` have stored to the location. */
bool memory_has_other_writer(int thread, int location);

/** Oldest store that the thread may still read */
int memory_floor(int thread, int location);

/** Access of plain memory. @return false: a data race */
bool memory_data_access(int thread, const void *at, bool is_write);

#endif
