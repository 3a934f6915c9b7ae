/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Text that people write: numbers, which are read whole or refused, and mistyped names. The URDF
 * front end, the daemon's configuration and the command line read by these.
 */
#ifndef TOTALFORCE_TEXT_H
#define TOTALFORCE_TEXT_H

#include <stddef.h>
#include <stdint.h>
#include <totalforce/status.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef enum tfa_number_fault {
    TFA_NUMBER_OK,
    TFA_NUMBER_MALFORMED, /**< not a decimal number, or longer than 399 characters */
    TFA_NUMBER_UNDERFLOW, /**< not 0, but so small that double precision has only 0 for it */
    TFA_NUMBER_OVERFLOW,  /**< beyond the largest double */
} tfa_number_fault;

/**
 * Reads a decimal number: sign, digits with an optional point, optional exponent, nothing else.
 * The same in every locale. Any thread.
 *
 * @param number  is written with TFA_NUMBER_OK only
 */
TFA_API tfa_number_fault tfa_number_read(const char *text, size_t length, double *number);

/**
 * Reads a whole number: decimal digits and nothing else, no leading zero. Any thread.
 *
 * @param number  is written with TFA_NUMBER_OK only; TFA_NUMBER_OVERFLOW: beyond 2^64 - 1
 */
TFA_API tfa_number_fault tfa_whole_number_read(const char *text, size_t length, uint64_t *number);

/** Name number `index` of a list. */
typedef const char *(*tfa_list_name)(const void *list, size_t index);

/**
 * Writes the (up to) three names of a list with the smallest edit distance (letters added, left
 * out, replaced, or exchanged with a neighbour) to `wrong`, nearest first, as "'a', 'b', 'c'";
 * "none" for an empty list. Names are compared by their first 96 bytes: O(count). Any thread.
 */
TFA_API void tfa_suggest(const char *wrong, const void *list, size_t count, tfa_list_name name,
                         char *text, size_t size);

/**
 * The name of a list that `wrong` is a misspelling of: at an edit distance of at most 1, or 2 for
 * names of six letters and more, capitals counting as small letters; NULL if there is none.
 * Any thread.
 */
TFA_API const char *tfa_misspelled(const char *wrong, const void *list, size_t count,
                                   tfa_list_name name);

#ifdef __cplusplus
}
#endif

#endif
