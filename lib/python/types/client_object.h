/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A Client and its requests under way. Private to client.c and client_pending.c.
 */
#ifndef PYTHON_CLIENT_OBJECT_H
#define PYTHON_CLIENT_OBJECT_H

#include "objects.h"

/** A request of send(), with the buffers of its reply */
typedef struct pending_call {
    struct pending_call *next;
    uint64_t id;
    request_call call;
} pending_call;

typedef struct client_object {
    solver_object head;
    tfa_client *client;
    tfa_client_options options;
    robot_names robot;
    PyObject *texts;    /**< list that keeps the texts of the options */
    PyObject *fallback; /**< workspace or None; NULL: none */
    pending_call *oldest, *newest;
} client_object;

extern PyGetSetDef client_attributes[];

PyObject *client_send(PyObject *self, PyObject *const *arguments, Py_ssize_t count,
                      PyObject *keywords);
PyObject *client_receive(PyObject *self, PyObject *args, PyObject *kwargs);

/** Forgets the requests under way. */
void pending_clear(client_object *client);

/** Raises the reason of a failed connection. @return -1 */
int client_raise(const client_object *client, int status);

#endif
