/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Suggests words.
 */
#include "suggest.h"

#include <stdio.h>
#include <totalforce/dynamics.h>
#include <totalforce/text.h>

/* Longer lists also name the nearest words. */
enum { WORDS_LISTED_MAX = 6 };

static const char *word_name(const void *words, size_t index)
{
    return ((const char *const *)words)[index];
}

void suggest_words(const char *wrong, const char *const *words, size_t count, char *text,
                   size_t size)
{
    char suggestions[160];
    size_t used = 0;
    tfa_suggest(wrong, words, count, word_name, suggestions, sizeof suggestions);
    if (count > WORDS_LISTED_MAX)
        used = (size_t)snprintf(text, size, "nearest: %s; ", suggestions);
    for (size_t i = 0; i < count && used < size; i++)
        used +=
            (size_t)snprintf(text + used, size - used, "%s %s", i ? "," : "there are", words[i]);
}

void suggest_methods(const char *wrong, char *text, size_t size)
{
    static const char *const words[] = {
#define METHOD_NAME(name, number, word, ops, factors, cost, refuses, what) word,
        TFA_METHOD_LIST(METHOD_NAME)
#undef METHOD_NAME
    };
    suggest_words(wrong, words, sizeof words / sizeof words[0], text, size);
}

const char *suggest_method(size_t index)
{
    const tfa_method_info *method = tfa_method_describe((uint32_t)index);
    return method ? method->name : NULL;
}

const char *suggest_forward_method(size_t index)
{
    const tfa_method_info *method;
    for (uint32_t m = TFA_METHOD_AUTO + 1; (method = tfa_method_describe(m)); m++)
        if (method->forward_dynamics && index-- == 0)
            return method->name;
    return NULL;
}
