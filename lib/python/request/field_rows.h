/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The tables of ops, of request fields (inputs) and of reply fields (outputs). Conversion, shape
 * checks, allocation of outputs, error messages, signatures and docstrings follow from them.
 */
#ifndef PYTHON_FIELD_ROWS_H
#define PYTHON_FIELD_ROWS_H

#include "python_api.h"

#include "interface/fields.h"

struct request_call;
struct robot_names;

/** Name of an extent in docstrings: "n_q", "6", ... */
const char *extent_name(int extent, char *text, size_t size);
/** 0 of EXTENT_NONE */
uint32_t extent_size(int extent, const struct robot_names *robot, const tfa_request *request);

/* ---- ops ---- */

typedef struct op_row {
    tfa_op op;
    const char *positional; /**< arguments that may be given by position: "q, v=None, tau=None" */
    const char *text;       /**< of the docstring: summary, equation */
} op_row;

extern const op_row op_rows[];
enum { OP_COUNT = TFA_OP_LAST };

/** "forward_dynamics"; "unknown" for any other number */
const char *op_name(tfa_op op);

/** Reads an op's name. @return 0; -1 with an exception */
int read_op(PyObject *value, tfa_op *op);

/* ---- inputs ---- */

/** Order of reading: later phases need values of earlier ones. */
enum phase { PHASE_CHOICES, PHASE_ARRAYS, PHASE_LAST };

typedef struct input_row input_row;
struct input_row {
    const char *name;
    int (*read)(struct request_call *, const input_row *,
                PyObject *); /**< 0; -1 with an exception */
    enum phase phase;
    int width;            /**< extent of one state; EXTENT_NONE: no array of states */
    size_t member;        /**< offset of the array in tfa_request */
    uint32_t ops;         /**< TFA_OP_BITs that use it */
    uint32_t flags;       /**< or TFA_WANT_ bits that let every op use it */
    const char *shape;    /**< type or shape, in docstrings */
    const char *text;     /**< meaning, unit, frame, default */
    unsigned only_client; /**< 1: the client's calls only */
};

extern const input_row inputs[];
extern const size_t input_count;
enum { INPUTS_MAX = 40 };

/** Row of a keyword, or -1 */
int input_find(PyObject *name);
/** 1: the op uses the input with these flags */
int input_is_used(const input_row *input, tfa_op op, uint32_t flags);

/* ---- outputs ---- */

typedef struct output_row {
    const char *name;      /**< key; the attribute of `lambda` is `lambda_` */
    uint8_t layout, block; /**< enum tfa_layout; in tfa_outputs */
    const char *text;      /**< meaning, unit, frame */
} output_row;

enum { OUTPUT_COUNT = TFA_WIRE_REPLY_BLOCKS - 1 };
extern const output_row outputs[OUTPUT_COUNT];

/** 1: an array of numbers, not of tfa_spectrum or tfa_rank */
static inline int output_has_numbers(int k)
{
    return outputs[k].layout < LAYOUT_SPECTRUM;
}

/** Bits of the outputs that an op with these flags may answer: output_is_answered decides. */
uint64_t output_candidates(tfa_op op, uint32_t flags);
/** 1: this request has that answer */
int output_is_answered(int k, const struct robot_names *robot, const tfa_request *request);
/** Row of a name, "base_" before it or not where base and joints are one array; or -1 */
int output_find(const char *name);

/** Fills the masks of output_candidates. */
void outputs_init(void);

/** Interns the names. @return 0; -1 with an exception */
int fields_init(void);

#endif
