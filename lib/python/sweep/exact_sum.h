/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Exact sums of non-negative doubles (Kulisch's long accumulator, in digits of 32 bits): the same
 * bits in any order and with any split.
 */
#ifndef PYTHON_EXACT_SUM_H
#define PYTHON_EXACT_SUM_H

#include <stdint.h>

/* 2^-1074 is the unit of digit 0. 2^53 doubles below 2^1024 are 2151 bits, which 68 digits hold. */
enum { EXACT_SUM_DIGITS = 68 };

/** Zero-initialise. Every digit is below 2^32, so that equal sums have equal bits. */
typedef struct exact_sum {
    uint64_t digits[EXACT_SUM_DIGITS];
} exact_sum;

/** Adds a finite number that is not negative. */
void exact_sum_add(exact_sum *sum, double value);

#endif
