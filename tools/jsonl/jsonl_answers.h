/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Table of the answers: key, layout, row of lib/interface/fields.h. Private to the jsonl_*.c
 * files.
 */
#ifndef TOOLS_JSONL_JSONL_ANSWERS_H
#define TOOLS_JSONL_JSONL_ANSWERS_H

#include "interface/fields.h"
#include "jsonl.h"

/** One answer */
typedef struct jsonl_answer {
    const char *key;
    uint8_t layout, block; /**< enum tfa_layout; in tfa_outputs */
} jsonl_answer;

/** All answers, in the order in which they are printed. */
extern const jsonl_answer jsonl_answers[];
/** Number of rows of jsonl_answers */
extern const size_t jsonl_answer_count;

/** Sizes of an answer to this request. */
void jsonl_answer_size(const jsonl_answer *answer, const tfa_names *names,
                       const tfa_request *request, size_t *rows, size_t *columns);

#endif
