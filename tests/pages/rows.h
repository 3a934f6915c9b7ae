/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Rows of a CSV file that a tool wrote, for pages of fixed numbers. What is wrong ends the program.
 */
#ifndef TESTS_PAGES_ROWS_H
#define TESTS_PAGES_ROWS_H

#include <stdint.h>
#include <stdio.h>

enum { ROWS_COLUMNS = 32, ROWS_LINE = 2048 };

typedef struct rows {
    FILE *in;
    char command[ROWS_LINE]; /**< of the head; "" before the first row */
    char head[ROWS_LINE], line[ROWS_LINE];
    char *names[ROWS_COLUMNS], *fields[ROWS_COLUMNS];
    int count; /**< of columns */
} rows;

void rows_open(rows *r, const char *path);
/** The next row into fields. @return 0: there is none, and the file is closed */
int rows_next(rows *r);

/** Field of the row in that column */
const char *rows_text(const rows *r, const char *name);
/** Its number; `empty` where there is none */
double rows_number(const rows *r, const char *name, double empty);
uint32_t rows_whole(const rows *r, const char *name);
/** Index of the field among words */
uint32_t rows_word(const rows *r, const char *name, const char *const *words, uint32_t count);
/** tfa_status of the name, or 1 */
int rows_status(const rows *r, const char *name);

#endif
