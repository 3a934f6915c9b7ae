/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Type Reply: the answers of one request, as numpy arrays.
 */
#ifndef PYTHON_REPLY_H
#define PYTHON_REPLY_H

#include "python_api.h"

extern PyTypeObject *reply_type;

/** dtypes of tfa_spectrum, tfa_rank and tfa_answer */
extern PyObject *reply_spectrum_type, *reply_rank_type, *reply_answer_type;

/** Prepares type and dtypes. @return 0; -1 with an exception */
int reply_init(PyObject *module);

int reply_check(PyObject *object);

/** Function of the module that makes a pickled reply again */
PyObject *reply_restore(PyObject *module, PyObject *args);

/** Array of output k, borrowed; NULL: the reply has none. */
PyObject *reply_output(PyObject *reply, int k);

#endif
