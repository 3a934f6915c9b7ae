/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Words of enums, from the lists below them in the public headers.
 */
#include <string.h>
#include <totalforce/specialised.h>
#include <totalforce/text.h>

#define WORD(value, word) [value] = word,
#define LIST(words)                                                                                \
    {                                                                                              \
        (const char *const[]){words(WORD)},                                                        \
            sizeof((const char *const[]){words(WORD)}) / sizeof(const char *)                      \
    }

static const struct {
    const char *const *words;
    uint32_t count;
} lists[] = {
    [TFA_WORDS_SEVERITY] = LIST(TFA_SEVERITY_WORDS),
    [TFA_WORDS_JOINT_TYPE] = LIST(TFA_JOINT_TYPE_WORDS),
    [TFA_WORDS_BASE] = LIST(TFA_BASE_WORDS),
    [TFA_WORDS_INERTIA] = LIST(TFA_INERTIA_WORDS),
    [TFA_WORDS_MIMIC] = LIST(TFA_MIMIC_WORDS),
    [TFA_WORDS_FATE] = LIST(TFA_FATE_WORDS),
    [TFA_WORDS_OP] = LIST(TFA_OP_WORDS),
    [TFA_WORDS_ESTIMATE] = LIST(TFA_ESTIMATE_WORDS),
    [TFA_WORDS_FRAME] = LIST(TFA_FRAME_WORDS),
    [TFA_WORDS_ROWS] = LIST(TFA_ROWS_WORDS),
    [TFA_WORDS_RANK_LOSS] = LIST(TFA_RANK_LOSS_WORDS),
    [TFA_WORDS_PRECISION] = LIST(TFA_PRECISION_WORDS),
    [TFA_WORDS_RESIDUAL] = LIST(TFA_RESIDUAL_WORDS),
    [TFA_WORDS_WAIT] = LIST(TFA_WAIT_WORDS),
    [TFA_WORDS_ALGORITHM] = LIST(TFA_ALGORITHM_WORDS),
};

const char *const *tfa_word_list(tfa_words of, uint32_t *count)
{
    *count = lists[of].count;
    return lists[of].words;
}

const char *tfa_word(tfa_words of, uint32_t value)
{
    const char *word = value < lists[of].count ? lists[of].words[value] : NULL;
    return word ? word : "unknown";
}

int32_t tfa_word_find(tfa_words of, const char *word)
{
    for (uint32_t k = 0; k < lists[of].count; k++)
        if (lists[of].words[k] && strcmp(lists[of].words[k], word) == 0)
            return (int32_t)k;
    return -1;
}
