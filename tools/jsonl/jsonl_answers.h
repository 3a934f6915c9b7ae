/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Table of the answers: key, buffer in the reply, size, layout in JSON. Private to the jsonl_*.c
 * files.
 */
#ifndef TOOLS_JSONL_JSONL_ANSWERS_H
#define TOOLS_JSONL_JSONL_ANSWERS_H

#include "jsonl.h"

/** Layout of an answer in JSON */
typedef enum jsonl_layout {
    JSONL_VECTOR,   /**< [...] */
    JSONL_MATRIX,   /**< [[row],...] */
    JSONL_NUMBER,   /**< one number */
    JSONL_FREEDOMS, /**< [joints], and with a floating base "base_KEY":[6] */
    JSONL_BY_LINK,  /**< {link: row, ...}, one row for each frame */
    JSONL_ENERGY,   /**< {"kinetic":..,"potential":..} */
} jsonl_layout;

/** One answer. `rows` and `columns` are numbers or, below 0, sizes that jsonl_answer_size
 *  knows. */
typedef struct jsonl_answer {
    const char *key;
    size_t member;  /**< offset of the buffer in tfa_reply */
    uint32_t ops;   /**< ops that give it unasked: TFA_OP_BITs */
    uint32_t flags; /**< or TFA_WANT_ bits that ask for it */
    int rows, columns;
    jsonl_layout layout;
} jsonl_answer;

/** All answers, in the order in which they are printed. */
extern const jsonl_answer jsonl_answers[];
/** Number of rows of jsonl_answers */
extern const size_t jsonl_answer_count;

/** Sizes of an answer to this request. */
void jsonl_answer_size(const jsonl_answer *answer, const robot_names *names,
                       const tfa_request *request, size_t *rows, size_t *columns);

/** 1: this request has that answer. */
int jsonl_is_answered(const jsonl_answer *answer, const robot_names *names,
                      const tfa_request *request);

/** Place of an answer's buffer in a reply, and the buffer of a reply; NULL: it has none. */
double **jsonl_answer_buffer(const jsonl_answer *answer, tfa_reply *reply);
const double *jsonl_answer_numbers(const jsonl_answer *answer, const tfa_reply *reply);

#endif
