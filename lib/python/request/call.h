/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * One request on its way: the arguments of a Python call, the request and reply in C, and
 * references to every array that they point to. The call owns these references, so that no other
 * thread can free an array while the GIL is released.
 */
#ifndef PYTHON_CALL_H
#define PYTHON_CALL_H

#include "field_rows.h"
#include "python_api.h"
#include "robot_names.h"

#include <totalforce/client.h>
#include <totalforce/request.h>

enum {
    STAGED_MAX = 16,                                           /**< arrays of states of a request */
    PIECES_MAX = STAGED_MAX + TFA_MAX_WRENCHES + TFA_MAX_TIPS, /**< Python arrays of these */
};

/** An array of a request, made of one Python array or of several side by side. */
typedef struct staged_array {
    size_t member;  /**< offset in tfa_request */
    uint32_t width; /**< numbers of each piece and state */
    uint32_t first, pieces;
} staged_array;

/** A Python array, with shape and data as they were when it was read */
typedef struct array_piece {
    PyArrayObject *array; /**< owned */
    const double *numbers;
    int is_batch; /**< it has an axis of states */
} array_piece;

typedef struct request_call {
    const robot_names *robot;
    int for_client;
    tfa_request request;
    tfa_reply reply;
    tfa_answer answer; /**< of a single state */
    uint64_t timeout_ns;
    double rank_threshold, characteristic_length, stabilisation[2];
    int is_batch;   /**< an input has an axis of states */
    int rows_given; /**< the request has `rows` */
    uint64_t only;  /**< bits of outputs to compute; 0: all */
    PyObject *outputs[OUTPUT_COUNT];
    PyObject *answers; /**< structured array, of a batch */
    PyObject *reused;  /**< reply given as `out`; NULL: none */
    uint32_t *locked;  /**< allocated */
    uint32_t staged_count, piece_count, buffer_count;
    uint32_t given_count;
    uint64_t given_rows; /**< bits of the rows, those with None included */
    /* Not cleared at start: */
    struct {
        const input_row *input;
        PyObject *value; /**< borrowed; not None */
    } given[INPUTS_MAX];
    double gravity[3];
    double payloads[TFA_MAX_PAYLOADS * TFA_PAYLOAD_NUMBERS];
    staged_array staged[STAGED_MAX];
    array_piece pieces[PIECES_MAX];
    double *buffers[STAGED_MAX]; /**< allocated */
} request_call;

/** Reads the arguments of a call and allocates its outputs. @return 0; -1 with an exception.
 *  call_clear in either case. */
int call_read(request_call *call, const robot_names *robot, int for_client, tfa_op op,
              PyObject *const *arguments, Py_ssize_t count, PyObject *keywords);

/** Releases all references and memory. */
void call_clear(request_call *call);

/** Allocates what `out` did not give and lets the reply point to it (outputs.c). */
int call_allocate(request_call *call);

/** A Reply with the outputs of the call; NULL with an exception (reply.c). `exchange` may be NULL.
 */
PyObject *call_reply(request_call *call, const tfa_exchange *exchange);

/** Numbers that decide whether the GIL is released: about the count of body steps. */
size_t call_cost(const request_call *call);

#endif
