/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Option values, shared by the subcommands.
 */
#include "commands.h"
#include "suggest.h"

#include <stdlib.h>
#include <string.h>
#include <totalforce/text.h>

uint64_t option_unsigned(struct argp_state *state, const char *name, const char *text,
                         uint64_t lowest, uint64_t highest)
{
    uint64_t value = 0;
    const tfa_number_fault fault = tfa_whole_number_read(text, strlen(text), &value);
    if (fault != TFA_NUMBER_OK || value < lowest || value > highest)
        argp_error(state, "--%s: '%s' is not a whole number from %llu to %llu%s", name, text,
                   (unsigned long long)lowest, (unsigned long long)highest,
                   fault == TFA_NUMBER_MALFORMED ? ", in decimal digits" : "");
    return value;
}

/* @return it is a number that double precision can hold */
static int read_number(const char *text, size_t length, double *value)
{
    return tfa_number_read(text, length, value) == TFA_NUMBER_OK;
}

double option_double(struct argp_state *state, const char *name, const char *text)
{
    double value = 0;
    if (!read_number(text, strlen(text), &value))
        argp_error(state, "--%s: '%s' is not a finite number, such as 2.5 or -1e-3", name, text);
    return value;
}

double option_positive(struct argp_state *state, const char *name, const char *text, double most)
{
    const double value = option_double(state, name, text);
    if (!(value > 0))
        argp_error(state, "--%s: %s, must be above 0", name, text);
    if (value > most)
        argp_error(state, "--%s: %s, must be at most %g", name, text, most);
    return value;
}

uint32_t option_numbers(struct argp_state *state, const char *name, const char *text, double *out,
                        uint32_t most)
{
    const char *at = text;
    for (uint32_t count = 1;; count++) {
        const size_t length = strcspn(at, ",");
        if (count > most || !read_number(at, length, &out[count - 1]))
            argp_error(state, "--%s: '%s' is not 1 to %u finite numbers with commas between", name,
                       text, most);
        if (at[length] == '\0')
            return count;
        at += length + 1;
    }
}

void option_vector3(struct argp_state *state, const char *name, const char *text, double out[3])
{
    if (option_numbers(state, name, text, out, 3) != 3)
        argp_error(state, "--%s: '%s' is not three finite numbers x,y,z", name, text);
}

int option_word(struct argp_state *state, const char *name, const char *text,
                const char *const *words, int count)
{
    char list[512];
    for (int i = 0; i < count; i++)
        if (strcmp(words[i], text) == 0)
            return i;
    tfa_suggest_words(text, words, (size_t)count, list, sizeof list);
    argp_error(state, "--%s: no '%s'; %s", name, text, list);
    return 0;
}

int option_enum(struct argp_state *state, const char *name, const char *text, tfa_words of)
{
    uint32_t count;
    const char *const *words = tfa_word_list(of, &count);
    return option_word(state, name, text, words, (int)count);
}

tfa_method option_method(struct argp_state *state, const char *text)
{
    char list[512];
    const int32_t method = tfa_method_find(text);
    if (method < 0) {
        suggest_methods(text, list, sizeof list);
        argp_error(state, "--method: no '%s'; %s", text, list);
    }
    return (tfa_method)method;
}

void option_argument(struct argp_state *state, const char **slot, const char *text)
{
    if (*slot)
        argp_error(state, "one argument too many: '%s'", text);
    *slot = text;
}

void for_each_word(struct argp_state *state, char *text,
                   void (*take)(struct argp_state *state, char *word))
{
    for (char *word = strsep(&text, ","); word; word = strsep(&text, ","))
        take(state, word);
}

char *join_arguments(int argc, char **argv)
{
    size_t size = 1;
    for (int i = 0; i < argc; i++)
        size += strlen(argv[i]) + 1;
    char *line = calloc(size, 1);
    for (int i = 0; line && i < argc; i++)
        stpcpy(stpcpy(line + strlen(line), i ? " " : ""), argv[i]);
    return line;
}
