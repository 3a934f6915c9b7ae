/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Signatures and docstrings from the tables of fields.
 */
#ifndef PYTHON_DOCS_H
#define PYTHON_DOCS_H

#include "field_rows.h"

/** Docstring of an op's method, with its signature; allocated, lives as long as the module. NULL
 *  with an exception. */
const char *docs_op(const op_row *op, int for_client);

/** Docstring of `compute` */
const char *docs_compute(int for_client);

#endif
