/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Compares a recorded answer with a replayed one.
 */
#ifndef TOOLS_RECORD_COMPARE_H
#define TOOLS_RECORD_COMPARE_H

#include "ipc/wire.h"

/** Where two answers differ. */
typedef struct difference {
    const char *field;      /**< "qdd", "answers.method", "status", ... */
    uint32_t state, index;  /**< index: of the number within the state */
    double recorded, other; /**< values */
    uint64_t bits[2];       /**< theirs, where they are doubles */
    double relative;        /**< to the largest number of the array in this state */
} difference;

/** Two answers to a request. */
typedef struct compared {
    uint64_t differences; /**< numbers that do not agree: bits, or more than the tolerance */
    difference first;     /**< of them */
    difference largest;   /**< relative difference of any two numbers, agreeing or not */
} compared;

/**
 * Compares lines and arrays of two replies in wire form.
 *
 * @param shape        of the request
 * @param reply_shape  of both replies; `want` may be 0
 * @param tolerance    0: the same bits. Else a number may differ by so much of the largest one of
 *                     its array and state; estimates, and flags that tell of rounding, may differ
 * @param any_model    the tag of the model is not compared
 */
compared compare_replies(const tfa_wire_shape *shape, const tfa_wire_reply_shape *reply_shape,
                         const void *recorded, const void *other, double tolerance, int any_model);

#endif
