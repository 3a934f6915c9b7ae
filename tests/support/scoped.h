/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Variables that are released where their scope ends, the last one first, so that a test says only
 * what it opens. After a failed assertion nothing is released: the process ends soon.
 */
#ifndef TESTS_SUPPORT_SCOPED_H
#define TESTS_SUPPORT_SCOPED_H

#include <stdlib.h>

/** SCOPED(end) type name: `end` gets the address of the variable, which may have no other use. */
#define SCOPED(end) __attribute__((cleanup(end), unused))

/** SCOPED_POINTER(end, type, release): `end` for pointers, by the function that releases them. */
#define SCOPED_POINTER(end, type, release)                                                         \
    static inline void end(type *const *pointer)                                                   \
    {                                                                                              \
        release(*pointer);                                                                         \
    }

SCOPED_POINTER(scoped_free, char, free)
#define SCOPED_TEXT SCOPED(scoped_free) char

#endif
