/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Reads the answers that a request wants besides those of its op.
 */
#include "interface/want_words.h"
#include "jsonl_values.h"

#include <string.h>

static int read_word(jsonl_reader *r, const json_t *word, size_t entry)
{
    if (!json_is_string(word))
        return jsonl_fail(r->error, TFA_E_ARGUMENT, "want[%zu]: %s, must be a string", entry,
                          jsonl_type(word));
    const char *text = json_string_value(word);
    for (size_t i = 0; i < TFA_WANT_WORD_COUNT; i++)
        if (strcmp(tfa_want_words[i], text) == 0) {
            r->request->flags |= tfa_want_flags[i];
            return TFA_OK;
        }
    char list[512];
    tfa_suggest_words(text, tfa_want_words, TFA_WANT_WORD_COUNT, list, sizeof list);
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
