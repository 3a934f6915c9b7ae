/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The names that a mistyped one may have meant.
 */
#ifndef TFA_SERVICE_NEAREST_H
#define TFA_SERVICE_NEAREST_H

#include <stddef.h>
#include <stdint.h>

/** Name number `index` of a list. */
typedef const char *(*nearest_name)(const void *list, size_t index);

/** Writes the (up to) three names with the smallest edit distance to `wrong`, nearest first, as
 *  "'a', 'b', 'c'"; "none" for an empty list. */
void tfa_nearest(const char *wrong, const void *list, size_t count, nearest_name name, char *text,
                 size_t size);

#endif
