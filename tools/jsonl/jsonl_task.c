/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Reads tips and what belongs to them: rows, desired accelerations, the treatment of lost rank.
 */
#include "interface/traits.h"
#include "jsonl_values.h"

#include <string.h>

/* Index of a word in `list`. Sets the error that names the words. */
static int read_choice(jsonl_reader *r, const json_t *value, tfa_words of, unsigned *choice)
{
    uint32_t count;
    const char *const *list = tfa_word_list(of, &count);
    char text[256];
    if (!json_is_string(value))
        return jsonl_fail(r->error, TFA_E_ARGUMENT, "%s: %s, must be a string", r->key,
                          jsonl_type(value));
    const char *word = json_string_value(value);
    for (unsigned i = 0; i < count; i++)
        if (strcmp(list[i], word) == 0) {
            *choice = i;
            return TFA_OK;
        }
    tfa_suggest_words(word, list, count, text, sizeof text);
    return jsonl_fail(r->error, TFA_E_ARGUMENT, "%s: no '%.200s'; %s", r->key, word, text);
}

int jsonl_read_tips(jsonl_reader *r, const json_t *value)
{
    if (!json_is_array(value))
        return jsonl_fail(r->error, TFA_E_ARGUMENT, "tips: %s, must be an array of link names",
                          jsonl_type(value));
    size_t count = json_array_size(value);
    if (count < 1 || count > TFA_MAX_TIPS)
        return jsonl_fail(r->error, TFA_E_SIZE, "tips: %zu links, must be 1 to %d", count,
                          TFA_MAX_TIPS);
    for (size_t i = 0; i < count; i++) {
        const json_t *link = json_array_get(value, i);
        char key[32];
        snprintf(key, sizeof key, "tips[%zu]", i);
        if (!json_is_string(link))
            return jsonl_fail(r->error, TFA_E_ARGUMENT, "%s: %s, must be a link name", key,
                              jsonl_type(link));
        int status = jsonl_find_frame(r, key, json_string_value(link), &r->request->tips[i]);
        if (status != TFA_OK)
            return status;
    }
    r->request->tip_count = (uint32_t)count;
    return TFA_OK;
}

int jsonl_read_rows(jsonl_reader *r, const json_t *value)
{
    unsigned rows = 0;
    int status = read_choice(r, value, TFA_WORDS_ROWS, &rows);
    r->request->rows = (tfa_rows)rows;
    r->rows_given = 1;
    return status;
}

int jsonl_read_rank_loss(jsonl_reader *r, const json_t *value)
{
    unsigned policy = 0;
    int status = read_choice(r, value, TFA_WORDS_RANK_LOSS, &policy);
    r->request->rank_loss = (tfa_rank_loss)policy;
    return status;
}

int jsonl_read_rank_threshold(jsonl_reader *r, const json_t *value)
{
    double x = json_number_value(value);
    if (!json_is_number(value))
        return jsonl_fail(r->error, TFA_E_ARGUMENT, "rank_threshold: %s, must be a number",
                          jsonl_type(value));
    if (!(x > 0 && x < 1))
        return jsonl_fail(r->error, TFA_E_ARGUMENT,
                          "rank_threshold: %g, must be above 0 and below 1: relative to the "
                          "sum of the eigenvalues of lambda_inv",
                          x);
    r->buffers->rank_threshold = x;
    r->request->rank_threshold = &r->buffers->rank_threshold;
    return TFA_OK;
}

int jsonl_read_characteristic_length(jsonl_reader *r, const json_t *value)
{
    const double x = json_number_value(value);
    if (!json_is_number(value) || !(x > 0))
        return jsonl_fail(r->error, TFA_E_ARGUMENT,
                          "characteristic_length: must be a number of metres above 0");
    r->buffers->characteristic_length = x;
    r->request->characteristic_length = &r->buffers->characteristic_length;
    return TFA_OK;
}

int jsonl_read_acceleration(jsonl_reader *r, const json_t *value)
{
    if (!json_is_object(value))
        return jsonl_fail(r->error, TFA_E_ARGUMENT,
                          "acceleration: %s, must be an object {tip: [6 or 3 numbers]}",
                          jsonl_type(value));
    r->acceleration = value;
    return TFA_OK;
}

/* The links that `acceleration` names become the tips. */
static int tips_of_acceleration(jsonl_reader *r)
{
    const char *link;
    json_t *numbers;
    size_t count = json_object_size(r->acceleration), t = 0;
    if (count < 1 || count > TFA_MAX_TIPS)
        return jsonl_fail(r->error, TFA_E_SIZE, "acceleration: %zu tips, must be 1 to %d", count,
                          TFA_MAX_TIPS);
    json_object_foreach((json_t *)r->acceleration, link, numbers)
    {
        (void)numbers;
        int status = jsonl_find_frame(r, "acceleration", link, &r->request->tips[t++]);
        if (status != TFA_OK)
            return status;
    }
    r->request->tip_count = (uint32_t)count;
    return TFA_OK;
}

/* As many links as tips, each of them a tip: the same set */
static int agree_on_tips(jsonl_reader *r)
{
    const tfa_request *request = r->request;
    const char *link;
    json_t *numbers;
    json_object_foreach((json_t *)r->acceleration, link, numbers)
    {
        uint32_t frame = 0, t = 0;
        (void)numbers;
        int status = jsonl_find_frame(r, "acceleration", link, &frame);
        if (status != TFA_OK)
            return status;
        while (t < request->tip_count && request->tips[t] != frame)
            t++;
        if (t == request->tip_count)
            return jsonl_fail(r->error, TFA_E_LINK,
                              "acceleration: '%.200s' is not in tips; leave tips out, or name the "
                              "same links in both",
                              link);
    }
    if (json_object_size(r->acceleration) != request->tip_count)
        return jsonl_fail(r->error, TFA_E_SIZE,
                          "acceleration: %zu links for %u tips; leave tips out, or name the same "
                          "links in both, each once",
                          json_object_size(r->acceleration), request->tip_count);
    return TFA_OK;
}

/* Without the key "rows", the length of the first acceleration says how many rows a tip has. */
static void guess_rows(jsonl_reader *r)
{
    const json_t *first = json_object_iter_value(json_object_iter((json_t *)r->acceleration));
    if (!r->rows_given && json_array_size(first) == 3)
        r->request->rows = TFA_ROWS_POINT;
}

int jsonl_finish_acceleration(jsonl_reader *r)
{
    tfa_request *request = r->request;
    if (!r->acceleration)
        return jsonl_fail(r->error, TFA_E_ARGUMENT,
                          "acceleration: missing; an object {tip: [6 numbers, of a point 3]}");
    int status = request->tip_count ? agree_on_tips(r) : tips_of_acceleration(r);
    guess_rows(r);
    const size_t rows = rows_of(request);
    for (uint32_t t = 0; status == TFA_OK && t < request->tip_count; t++) {
        const char *link = tfa_names_frame(r->names, request->tips[t]);
        char key[320];
        snprintf(key, sizeof key, "acceleration.%.200s", link);
        jsonl_reader inner = *r;
        inner.key = key;
        status = jsonl_numbers(&inner, json_object_get(r->acceleration, link), rows,
                               r->buffers->task_acceleration + rows * t);
    }
    request->task_acceleration = r->buffers->task_acceleration;
    return status;
}
