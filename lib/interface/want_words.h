/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Words of `want`, and what they ask for.
 */
#ifndef TFA_INTERFACE_WANT_WORDS_H
#define TFA_INTERFACE_WANT_WORDS_H

#include <stdio.h>

#include "interface/fields.h"

static const char *const tfa_want_words[] = {
#define WORD(word, flag) word,
    TFA_WANT_LIST(WORD)
#undef WORD
};
enum { TFA_WANT_WORD_COUNT = sizeof tfa_want_words / sizeof tfa_want_words[0] };

/** TFA_WANT_ bit of each word */
static const uint32_t tfa_want_flags[TFA_WANT_WORD_COUNT] = {
#define FLAG(word, flag) TFA_WANT_##flag,
    TFA_WANT_LIST(FLAG)
#undef FLAG
};

/** Writes the words of TFA_WANT_ bits: "lambda, mu or p"; "" for none. size > 0 */
static inline void tfa_want_write(uint32_t flags, char *text, size_t size)
{
    size_t used = 0;
    uint32_t left = 0;
    for (size_t k = 0; k < TFA_WANT_WORD_COUNT; k++)
        left += (flags & tfa_want_flags[k]) != 0;
    text[0] = '\0';
    for (size_t k = 0; k < TFA_WANT_WORD_COUNT && used < size; k++)
        if (flags & tfa_want_flags[k]) {
            left--;
            used += (size_t)snprintf(text + used, size - used, "%s%s", tfa_want_words[k],
                                     left > 1    ? ", "
                                     : left == 1 ? " or "
                                                 : "");
        }
}

/** Writes what an op of that name does not answer, and which do: "" if it answers all flags. */
static inline void tfa_want_refuse(uint32_t flags, uint32_t op_bit, const char *name, char *text,
                                   size_t size)
{
    char words[200];
    text[0] = '\0';
    tfa_want_write(op_bit & TFA_OPS_SOLVE ? 0 : flags & TFA_WANT_OF_SOLVE, words, sizeof words);
    if (words[0])
        snprintf(text, size,
                 "%s does not answer %s; forward_dynamics, operational_inertia and task_torques do",
                 name, words);
    else if (flags & TFA_WANT_JOINT_FORCES && !(op_bit & TFA_OPS_MOTION))
        snprintf(text, size,
                 "%s does not answer joint_forces; forward_dynamics and inverse_dynamics do", name);
    else if (flags & TFA_WANT_DELASSUS && !(op_bit & TFA_OPS_CONSTRAINED_SOLVE))
        snprintf(text, size, "%s does not answer delassus; constrained_dynamics and impact do",
                 name);
}

#endif
