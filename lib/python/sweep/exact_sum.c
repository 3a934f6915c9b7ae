/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Exact sums of non-negative doubles.
 */
#include "exact_sum.h"

#include <string.h>

enum { MANTISSA = 52 };
#define DIGIT_MASK UINT64_C(0xffffffff)
__extension__ typedef unsigned __int128 uint128;

/* Adds `part` at a digit; the carry moves up until a digit has room. */
static void add_at(exact_sum *sum, unsigned digit, uint64_t part)
{
    for (; part && digit < EXACT_SUM_DIGITS; digit++) {
        part += sum->digits[digit];
        sum->digits[digit] = part & DIGIT_MASK;
        part >>= 32;
    }
}

void exact_sum_add(exact_sum *sum, double value)
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    const unsigned exponent = (unsigned)(bits >> MANTISSA);
    const uint64_t fraction = bits & ((UINT64_C(1) << MANTISSA) - 1);
    const uint64_t mantissa = exponent ? fraction | UINT64_C(1) << MANTISSA : fraction;
    const unsigned shift = exponent ? exponent - 1 : 0; /* value = mantissa 2^(shift - 1074) */
    const uint128 wide = (uint128)mantissa << shift % 32;
    add_at(sum, shift / 32, (uint64_t)wide & DIGIT_MASK);
    add_at(sum, shift / 32 + 1, (uint64_t)(wide >> 32));
}
