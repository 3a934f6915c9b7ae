/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Readers of the request fields: each turns one Python value into its part of a request.
 */
#ifndef PYTHON_READ_H
#define PYTHON_READ_H

#include "call.h"
#include "field_rows.h"

/* Each returns 0, or -1 with an exception that names the field. */

/* read_arrays.c: arrays of states */
int read_joints(request_call *call, const input_row *input, PyObject *value);
int read_states(request_call *call, const input_row *input, PyObject *value);
int read_gravity(request_call *call, const input_row *input, PyObject *value);
int read_wrench(request_call *call, const input_row *input, PyObject *value);
int read_acceleration(request_call *call, const input_row *input, PyObject *value);
int read_constraint_acceleration(request_call *call, const input_row *input, PyObject *value);
int read_torque_weights(request_call *call, const input_row *input, PyObject *value);
/** Lets the request point to the arrays, once the number of states is known. */
int finish_arrays(request_call *call);

/* read_choices.c: words and numbers */
int read_tips(request_call *call, const input_row *input, PyObject *value);
int read_rows(request_call *call, const input_row *input, PyObject *value);
int read_frame(request_call *call, const input_row *input, PyObject *value);
int read_constraints(request_call *call, const input_row *input, PyObject *value);
int read_stabilisation(request_call *call, const input_row *input, PyObject *value);
int read_rank_loss(request_call *call, const input_row *input, PyObject *value);
int read_rank_threshold(request_call *call, const input_row *input, PyObject *value);
int read_characteristic_length(request_call *call, const input_row *input, PyObject *value);
int read_method(request_call *call, const input_row *input, PyObject *value);
int read_refine(request_call *call, const input_row *input, PyObject *value);
int read_estimate(request_call *call, const input_row *input, PyObject *value);
int read_want(request_call *call, const input_row *input, PyObject *value);
int read_only(request_call *call, const input_row *input, PyObject *value);
int read_timeout(request_call *call, const input_row *input, PyObject *value);

/* read_changes.c: changes of the robot by a request */
int read_payload(request_call *call, const input_row *input, PyObject *value);
int read_locked(request_call *call, const input_row *input, PyObject *value);

/* outputs.c: memory of the answers */
int read_out(request_call *call, const input_row *input, PyObject *value);

/* Shared by readers */

/** Converter of PyArg_Parse ("O&"): a whole number from 0 to 2^32 - 1. @return 1; 0 with an
 *  exception */
int convert_u32(PyObject *value, void *number);

/** Value of a word of an enum; 0 of NULL and None. @return as choose */
int choose_word(const char *field, PyObject *value, tfa_words of, unsigned *choice);
/** Index of a word among `count`. @return 0; -1 with an exception that lists the words */
int choose(const char *field, PyObject *value, const char *const *list, size_t count,
           unsigned *choice);
/** `count` numbers of any array-like. @return 0; -1 with an exception */
int read_numbers(const char *field, PyObject *value, uint32_t count, double *numbers);
/** A payload's dict: link, mass, com, inertia. `link` gets a borrowed reference. */
int read_load(const char *field, PyObject *value, PyObject **link,
              double numbers[TFA_PAYLOAD_NUMBERS]);

#endif
