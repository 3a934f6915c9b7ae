/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * What must hold of everything that the loader hands out, whatever it was given.
 */
#ifndef TESTS_FUZZ_INVARIANTS_H
#define TESTS_FUZZ_INVARIANTS_H

#include <stdio.h>
#include <stdlib.h>
#include <totalforce/description.h>

#ifdef __cplusplus
extern "C" {
#endif

#define REQUIRE(condition)                                                                         \
    do {                                                                                           \
        if (!(condition)) {                                                                        \
            fprintf(stderr, "%s:%d: not true: %s\n", __FILE__, __LINE__, #condition);              \
            abort();                                                                               \
        }                                                                                          \
    } while (0)

/* Parses, and aborts unless the outcome is sound. NULL if the text was refused. */
tfa_description *check_parse(const char *text, size_t length);

/* Every message can be printed on one line, and there are errors if and only if it was refused. */
void check_report(const tfa_report *report, int status);

#ifdef __cplusplus
}
#endif
#endif
