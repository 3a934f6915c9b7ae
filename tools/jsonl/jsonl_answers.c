/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Table of the answers: which request has which, of which size.
 */
#include "jsonl_answers.h"

#include "jsonl_values.h"

#include <stdlib.h>

const jsonl_answer jsonl_answers[] = {
#define ANSWER(name, idl, key, layout, text) {key, LAYOUT_##layout, TFA_WIRE_##name},
    TFA_OUTPUT_WORD_LIST(ANSWER)
#undef ANSWER
};
const size_t jsonl_answer_count = sizeof jsonl_answers / sizeof jsonl_answers[0];

void jsonl_answer_size(const jsonl_answer *answer, const tfa_names *names,
                       const tfa_request *request, size_t *rows, size_t *columns)
{
    const tfa_extents n = tfa_extents_of(names->q_count, names->v_count, names->base_freedoms,
                                         names->frame_count, names->mode_count, request);
    *rows = tfa_extent(tfa_outputs[answer->block].rows, &n);
    *columns = tfa_extent(tfa_outputs[answer->block].columns, &n);
}

/* Memory of one answer, at least of this size */
static int reserve(jsonl_reader *r, size_t index, size_t rows, size_t columns)
{
    jsonl_array *array = &r->buffers->answers[index];
    const size_t size = tfa_outputs[jsonl_answers[index].block].size;
    if (array->items && rows * columns <= array->count)
        return TFA_OK;
    free(array->items);
    array->count = rows * columns;
    array->items = calloc(rows ? rows : 1, (columns ? columns : 1) * size);
    return array->items ? TFA_OK
                        : jsonl_fail(r->error, TFA_E_MEMORY, "%s: no memory for %zu x %zu numbers",
                                     jsonl_answers[index].key, rows, columns);
}

int jsonl_point_reply(jsonl_reader *r, tfa_reply *reply)
{
    *reply = (tfa_reply){.answers = &r->buffers->answer};
    for (size_t i = 0; i < jsonl_answer_count; i++) {
        const tfa_output *output = &tfa_outputs[jsonl_answers[i].block];
        size_t rows, columns;
        if (!tfa_is_printed(output, r->names->base_freedoms, r->names->mode_count, r->request))
            continue;
        jsonl_answer_size(&jsonl_answers[i], r->names, r->request, &rows, &columns);
        int status = reserve(r, i, rows, columns);
        if (status != TFA_OK)
            return status;
        tfa_output_set_buffer(output, reply, r->buffers->answers[i].items);
    }
    return TFA_OK;
}
