/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Reading of numbers: one grammar, independent of the locale, the whole text or nothing.
 */
#include <locale.h>
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <totalforce/text.h>

/* isdigit() depends on the locale. */
static bool is_digit(char c)
{
    return c >= '0' && c <= '9';
}

static size_t count_digits(const char *text, size_t at, size_t length)
{
    size_t start = at;
    while (at < length && is_digit(text[at]))
        at++;
    return at - start;
}

static bool is_decimal(const char *text, size_t length)
{
    size_t at = length > 0 && (text[0] == '+' || text[0] == '-');
    size_t whole = count_digits(text, at, length);
    at += whole;
    size_t fraction = 0;
    if (at < length && text[at] == '.') {
        fraction = count_digits(text, at + 1, length);
        at += 1 + fraction;
    }
    if (whole + fraction == 0)
        return false;
    if (at < length && (text[at] == 'e' || text[at] == 'E')) {
        at++;
        at += at < length && (text[at] == '+' || text[at] == '-');
        size_t exponent = count_digits(text, at, length);
        if (exponent == 0)
            return false;
        at += exponent;
    }
    return at == length;
}

static bool is_written_as_zero(const char *text, size_t length)
{
    for (size_t i = 0; i < length && text[i] != 'e' && text[i] != 'E'; i++)
        if (is_digit(text[i]) && text[i] != '0')
            return false;
    return true;
}

tfa_number_fault tfa_number_read(const char *text, size_t length, double *number)
{
    /* a double needs fewer digits than that to be exact */
    char copy[400];
    if (length >= sizeof copy || !is_decimal(text, length))
        return TFA_NUMBER_MALFORMED;
    memcpy(copy, text, length);
    copy[length] = '\0';
    locale_t classic = newlocale(LC_ALL_MASK, "C", (locale_t)0); /* static in glibc: no malloc */
    if (classic == (locale_t)0)
        return TFA_NUMBER_MALFORMED;
    double value = strtod_l(copy, NULL, classic);
    freelocale(classic);
    if (!isfinite(value))
        return TFA_NUMBER_OVERFLOW;
    if (value == 0.0 && !is_written_as_zero(text, length))
        return TFA_NUMBER_UNDERFLOW;
    *number = value;
    return TFA_NUMBER_OK;
}

tfa_number_fault tfa_whole_number_read(const char *text, size_t length, uint64_t *number)
{
    uint64_t value = 0;
    tfa_number_fault fault = TFA_NUMBER_OK;
    if (length == 0 || (text[0] == '0' && length > 1))
        return TFA_NUMBER_MALFORMED;
    for (size_t i = 0; i < length; i++) {
        if (text[i] < '0' || text[i] > '9')
            return TFA_NUMBER_MALFORMED;
        const uint64_t digit = (uint64_t)(text[i] - '0');
        if (value > (UINT64_MAX - digit) / 10)
            fault = TFA_NUMBER_OVERFLOW;
        value = 10 * value + digit;
    }
    if (fault == TFA_NUMBER_OK)
        *number = value;
    return fault;
}
