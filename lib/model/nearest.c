/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The names that a mistyped one may have meant: by edit distance (Levenshtein).
 */
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <totalforce/text.h>

#define NEAREST 3
#define LENGTH 96 /* of names, for comparing */

static uint32_t smallest(uint32_t a, uint32_t b, uint32_t c)
{
    const uint32_t least = a < b ? a : b;
    return least < c ? least : c;
}

/* Insertions, deletions and replacements that make b of a: one row of the table at a time. */
static uint32_t distance(const char *a, const char *b)
{
    const size_t rows = strnlen(a, LENGTH), columns = strnlen(b, LENGTH);
    uint32_t row[LENGTH + 1];
    for (size_t k = 0; k <= columns; k++)
        row[k] = (uint32_t)k;
    for (size_t i = 1; i <= rows; i++) {
        uint32_t diagonal = row[0];
        row[0] = (uint32_t)i;
        for (size_t k = 1; k <= columns; k++) {
            const uint32_t above = row[k];
            row[k] = smallest(above + 1, row[k - 1] + 1, diagonal + (a[i - 1] != b[k - 1]));
            diagonal = above;
        }
    }
    return row[columns];
}

void tfa_nearest(const char *wrong, const void *list, size_t count, tfa_list_name name, char *text,
                 size_t size)
{
    const char *best[NEAREST] = {NULL};
    uint32_t far[NEAREST] = {UINT32_MAX, UINT32_MAX, UINT32_MAX};
    for (size_t i = 0; i < count; i++) {
        const char *candidate = name(list, i);
        const uint32_t d = distance(wrong, candidate);
        if (d >= far[NEAREST - 1])
            continue;
        int k = NEAREST - 1;
        for (; k > 0 && d < far[k - 1]; k--) {
            far[k] = far[k - 1];
            best[k] = best[k - 1];
        }
        far[k] = d;
        best[k] = candidate;
    }
    snprintf(text, size, "none");
    size_t used = 0;
    for (int k = 0; k < NEAREST && best[k] && used < size; k++)
        used += (size_t)snprintf(text + used, size - used, "%s'%s'", k ? ", " : "", best[k]);
}
