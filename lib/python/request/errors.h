/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Raises the exceptions of totalforce/errors.py.
 */
#ifndef PYTHON_ERRORS_H
#define PYTHON_ERRORS_H

#include "python_api.h"

#include <totalforce/report.h>
#include <totalforce/request.h>

struct robot_names;

/** Longest message */
enum { ERROR_TEXT = 2048 };

/* Each raises and returns -1, so that a caller can return the call. `field` names the argument that
 * the error is about; NULL: none. */

/** An exception of the class that belongs to `status`. */
int raise_status(int status, const char *field, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/** As raise_status with the name of a link or a joint as an attribute: `attribute` is "link" or
 *  "joint". */
int raise_named(int status, const char *field, const char *attribute, const char *name,
                const char *format, ...) __attribute__((format(printf, 5, 6)));

/** totalforce.InputTypeError: a value of a type that cannot be read. */
int raise_type(const char *field, const char *format, ...) __attribute__((format(printf, 2, 3)));

/** Turns the TypeError or ValueError that is set into one of this module that names `field`; other
 *  exceptions stay. */
int raise_from_current(const char *field, const char *what);

/** A failed request. `reply` becomes an attribute; NULL: nothing was computed. */
int raise_reply(const struct robot_names *robot, const tfa_request *request,
                const tfa_reply *answer, PyObject *reply);

/** A robot that could not be loaded, with the messages of the report. */
int raise_report(int status, const char *path, const tfa_report *report, PyObject *messages);

#endif
