/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Reads the answers that a request wants besides those of its op.
 */
#include "common/suggest.h"
#include "interface/fields.h"
#include "jsonl_values.h"

#include <string.h>

static const char *const words[] = {
#define WORD(word, flag) word,
    TFA_WANT_LIST(WORD)
#undef WORD
};
enum { WORD_COUNT = sizeof words / sizeof words[0] };

static const uint32_t flags[WORD_COUNT] = {
#define FLAG(word, flag) TFA_WANT_##flag,
    TFA_WANT_LIST(FLAG)
#undef FLAG
};

static int read_word(jsonl_reader *r, const json_t *word, size_t entry)
{
    if (!json_is_string(word))
        return jsonl_fail(r->error, TFA_E_ARGUMENT, "want[%zu]: %s, must be a string", entry,
                          jsonl_type(word));
    const char *text = json_string_value(word);
    for (size_t i = 0; i < WORD_COUNT; i++)
        if (strcmp(words[i], text) == 0) {
            r->request->flags |= flags[i];
            return TFA_OK;
        }
    char list[512];
    suggest_words(text, words, WORD_COUNT, list, sizeof list);
    return jsonl_fail(r->error, TFA_E_ARGUMENT, "want[%zu]: no '%.200s'; %s", entry, text, list);
}

int jsonl_read_want(jsonl_reader *r, const json_t *value)
{
    if (!json_is_array(value))
        return jsonl_fail(r->error, TFA_E_ARGUMENT,
                          "want: %s, must be an array of words, for instance [\"jacobian\"]",
                          jsonl_type(value));
    int status = TFA_OK;
    for (size_t i = 0; status == TFA_OK && i < json_array_size(value); i++)
        status = read_word(r, json_array_get(value, i), i);
    return status;
}

int jsonl_read_poses(jsonl_reader *r, const json_t *value)
{
    if (!json_is_boolean(value))
        return jsonl_fail(r->error, TFA_E_ARGUMENT, "poses: %s, must be true or false",
                          jsonl_type(value));
    if (!json_is_true(value))
        return TFA_OK;
    if (r->request->flags & (TFA_WANT_POSES | TFA_WANT_FRAME_POSES))
        return jsonl_fail(r->error, TFA_E_ARGUMENT,
                          "poses: leave it out: want has \"pose\" for the tips and \"poses\" for "
                          "all links");
    r->request->flags |= TFA_WANT_POSES;
    r->buffers->tip_poses_key = "poses";
    return TFA_OK;
}

void jsonl_want_words(uint32_t wanted, char *text, size_t size)
{
    size_t used = 0;
    uint32_t left = 0;
    for (size_t i = 0; i < WORD_COUNT; i++)
        left += (wanted & flags[i]) != 0;
    if (size)
        text[0] = '\0';
    for (size_t i = 0; i < WORD_COUNT && used < size; i++)
        if (wanted & flags[i]) {
            left--;
            used += (size_t)snprintf(text + used, size - used, "%s%s", words[i],
                                     left > 1    ? ", "
                                     : left == 1 ? " or "
                                                 : "");
        }
}
