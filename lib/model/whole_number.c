/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Whole numbers that people write: digits and nothing else.
 */
#include <totalforce/text.h>

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
