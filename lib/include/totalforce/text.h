/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Parsing of hand-written text: numbers, which are accepted as a whole or refused, and suggestions
 * for mistyped names. Used by the URDF front end, the daemon's configuration and the command line.
 * No function allocates or keeps state: any thread.
 */
#ifndef TOTALFORCE_TEXT_H
#define TOTALFORCE_TEXT_H

#include <stddef.h>
#include <stdint.h>
#include <totalforce/status.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Result of reading a number. */
typedef enum tfa_number_fault {
    TFA_NUMBER_OK,
    TFA_NUMBER_MALFORMED, /**< not a decimal number, or longer than 399 characters */
    TFA_NUMBER_UNDERFLOW, /**< not 0, but rounded to 0 in double precision */
    TFA_NUMBER_OVERFLOW,  /**< larger than any double, or than 2^64 - 1 */
} tfa_number_fault;

/**
 * Reads a decimal number: sign, digits with an optional point, optional exponent. No blanks, no
 * hexadecimal, no "nan" or "inf". The same in every locale, correctly rounded.
 *
 * @param text    `length` bytes; needs no terminator
 * @param length  of text, bytes
 * @param number  written with TFA_NUMBER_OK only
 */
TFA_API tfa_number_fault tfa_number_read(const char *text, size_t length, double *number);

/**
 * Reads a whole number: decimal digits without sign and leading zero.
 *
 * @param text    `length` bytes; needs no terminator
 * @param length  of text, bytes
 * @param number  written with TFA_NUMBER_OK only
 */
TFA_API tfa_number_fault tfa_whole_number_read(const char *text, size_t length, uint64_t *number);

/** Returns name number `index` of a list. */
typedef const char *(*tfa_list_name)(const void *list, size_t index);

/**
 * Writes the names of a list that are most similar to `wrong`, at most three, the nearest first:
 * "'a', 'b', 'c'", or "none" for an empty list; of a word that other libraries or ROS have for
 * names of the list (qd, effort, ddq) those names alone. Distance: insertions, deletions,
 * replacements and exchanges of neighbours (Damerau, Comm. ACM 7(3), 1964; restricted form), on the
 * first 96 bytes. Cost: O(count).
 *
 * @param wrong  the name that was not found
 * @param list   handed to name
 * @param count  names in the list
 * @param name   reads a name of `list`
 * @param text   gets as much as fits of it, terminated; size > 0
 * @param size   of text, bytes
 */
TFA_API void tfa_suggest(const char *wrong, const void *list, size_t count, tfa_list_name name,
                         char *text, size_t size);

/**
 * Returns the name of a list that `wrong` misspells: the nearest within distance 1, or 2 for names
 * of six letters or more, without regard to case (ASCII); NULL if there is none. Distance and cost
 * as tfa_suggest.
 */
TFA_API const char *tfa_misspelled(const char *wrong, const void *list, size_t count,
                                   tfa_list_name name);

#ifdef __cplusplus
}
#endif

#endif
