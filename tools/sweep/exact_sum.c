/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Exact sums of non-negative doubles.
 */
#include "exact_sum.h"

#include <math.h>
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

void exact_sum_merge(exact_sum *sum, const exact_sum *other)
{
    uint64_t carry = 0;
    for (unsigned k = 0; k < EXACT_SUM_DIGITS; k++) {
        carry += sum->digits[k] + other->digits[k];
        sum->digits[k] = carry & DIGIT_MASK;
        carry >>= 32;
    }
}

double exact_sum_value(const exact_sum *sum)
{
    int top = EXACT_SUM_DIGITS - 1;
    while (top > 0 && sum->digits[top] == 0)
        top--;
    const int lowest = top < 3 ? 0 : top - 3;
    uint128 head = 0;
    for (int k = top; k >= lowest; k--)
        head = head << 32 | sum->digits[k];
    /* what is below decides no more than whether the head is a tie */
    for (int k = 0; k < lowest; k++)
        head |= sum->digits[k] != 0;
    return ldexp((double)head, 32 * lowest - 1074);
}
