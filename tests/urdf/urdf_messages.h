/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * What URDF files do wrong, case by case, and the tests that show what is done about it.
 */
#ifndef TESTS_URDF_MESSAGES_H
#define TESTS_URDF_MESSAGES_H

/*
 * A case is spelled as in the first column of the tables of urdf.md. `tests` lists, separated by
 * semicolons, names of rows (rows_*.c) and, with a colon, FILE:TEXT for a test elsewhere that has
 * this text. test_urdf_messages.c checks that all of them exist and that no case is missing.
 */
typedef struct urdf_case {
    const char *text;
    const char *tests;
} urdf_case;

extern const urdf_case urdf_messages[];

#endif
