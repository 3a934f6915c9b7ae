/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The registered tests, see test.h.
 */
#include "test.h"

#include <errno.h>

enum { TESTS_MAX = 64 };

static struct CMUnitTest tests[TESTS_MAX];
static int lines[TESTS_MAX];
static size_t count;

/* Inserted by line: constructors may run in any order. */
void test_register(const char *name, CMUnitTestFunction run, int line)
{
    size_t at = count++;
    if (count > TESTS_MAX)
        abort();
    for (; at > 0 && lines[at - 1] > line; at--) {
        tests[at] = tests[at - 1];
        lines[at] = lines[at - 1];
    }
    tests[at] = (struct CMUnitTest){.name = name, .test_func = run};
    lines[at] = line;
}

int test_run(CMFixtureFunction setup, CMFixtureFunction teardown)
{
    if (count == 0) {
        fputs("no test is registered\n", stderr);
        return 1;
    }
    return _cmocka_run_group_tests(program_invocation_short_name, tests, count, setup, teardown);
}
