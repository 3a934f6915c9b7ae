/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Suggests words.
 */
#include "suggest.h"

#include <totalforce/dynamics.h>
#include <totalforce/text.h>

void suggest_methods(const char *wrong, char *text, size_t size)
{
    static const char *const words[] = {
#define METHOD_NAME(name, number, word, ops, factors, cost, refuses, what) word,
        TFA_METHOD_LIST(METHOD_NAME)
#undef METHOD_NAME
    };
    tfa_suggest_words(wrong, words, sizeof words / sizeof words[0], text, size);
}

const char *suggest_method(size_t index)
{
    const tfa_method_info *method = tfa_method_describe((uint32_t)index);
    return method ? method->name : NULL;
}
