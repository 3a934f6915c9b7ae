/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Counts the allocations of each thread: a program that calls allocations_count replaces malloc,
 * calloc, realloc and aligned_alloc by functions that count and pass on to the C library's.
 */
#ifndef TOOLS_COMMON_ALLOCATIONS_H
#define TOOLS_COMMON_ALLOCATIONS_H

#include <stdint.h>

/** Allocations of the calling thread since it began; -1: not counted (built with a sanitizer). */
int64_t allocations_count(void);

#endif
