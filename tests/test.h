/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Frame of a cmocka program: every TEST of the file runs, in the order of its lines. A file without
 * a main gets one.
 */
#ifndef TFA_TESTS_TEST_H
#define TFA_TESTS_TEST_H

/* cmocka wants the first four before it */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "support/scoped.h"

void test_register(const char *name, CMUnitTestFunction run, int line);
/** What a main of a file's own returns. @return how many tests failed */
int test_run(CMFixtureFunction setup, CMFixtureFunction teardown);

/** How many seeds a law takes: `many` where TEST_LONG is set, in the ctest entry NAME_long. */
static inline uint32_t test_extent(uint32_t few, uint32_t many)
{
    return getenv("TEST_LONG") ? many : few;
}

/** A constant number of rounds, fewer where the code is instrumented and up to ten times slower. */
#ifdef TFA_INSTRUMENTED
#define TEST_ROUNDS(rounds) (((rounds) + 3) / 4)
#else
#define TEST_ROUNDS(rounds) (rounds)
#endif

/** TEST(name) { ... }: registered before main; `state` is cmocka's. */
#define TEST(name)                                                                                 \
    static void name(void **state);                                                                \
    __attribute__((constructor)) static void register_##name(void)                                 \
    {                                                                                              \
        test_register(#name, name, __LINE__);                                                      \
    }                                                                                              \
    static void name(__attribute__((unused)) void **state)

#endif
