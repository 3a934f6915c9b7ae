/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Memory of the answers: arrays of the caller, arrays of a reply that is used again, new arrays.
 */
#include "errors.h"
#include "read.h"
#include "reply.h"

#include <stdio.h>

/* Shape of an answer. @return number of axes */
static int shape_of(const request_call *call, int k, npy_intp shape[3])
{
    const tfa_output *output = &tfa_outputs[outputs[k].block];
    int axes = 0;
    if (call->is_batch)
        shape[axes++] = call->request.count;
    if (output->rows != EXTENT_NONE)
        shape[axes++] = extent_size(output->rows, call->robot, &call->request);
    if (output->columns != EXTENT_NONE)
        shape[axes++] = extent_size(output->columns, call->robot, &call->request);
    return axes;
}

static int has_shape(PyArrayObject *array, int axes, const npy_intp *shape)
{
    int same = PyArray_NDIM(array) == axes;
    for (int k = 0; same && k < axes; k++)
        same = PyArray_DIM(array, k) == shape[k];
    return same;
}

/* Of an array of float64 or uint64 */
static size_t bytes_of(PyArrayObject *array)
{
    return sizeof(double) * (size_t)PyArray_SIZE(array);
}

/* 1: the bytes of an array overlap with [from, from + size) */
static int overlaps(PyArrayObject *array, const void *from, size_t size)
{
    const char *a = PyArray_DATA(array), *b = from;
    const size_t own = bytes_of(array);
    return size && own && a < b + size && b < a + own;
}

/* Checks that an output shares no memory with inputs or other outputs. */
static int check_overlap(request_call *call, int k, PyArrayObject *array)
{
    for (uint32_t i = 0; i < call->piece_count; i++)
        if (overlaps(array, call->pieces[i].numbers, bytes_of(call->pieces[i].array)))
            return raise_status(TFA_E_ARGUMENT, "out", "out: %s shares memory with an input",
                                outputs[k].name);
    for (int i = 0; i < OUTPUT_COUNT; i++) {
        PyArrayObject *other = (PyArrayObject *)call->outputs[i];
        if (i != k && other && overlaps(array, PyArray_DATA(other), bytes_of(other)))
            return raise_status(TFA_E_ARGUMENT, "out", "out: %s shares memory with %s",
                                outputs[k].name, outputs[i].name);
    }
    return 0;
}

/* Takes an array of the caller for output k. */
static int take_array(request_call *call, int k, PyObject *value)
{
    npy_intp shape[3];
    char wanted[80];
    const int axes = shape_of(call, k, shape);
    size_t used = 0;
    wanted[0] = '\0';
    for (int i = 0; i < axes; i++)
        used += (size_t)snprintf(wanted + used, sizeof wanted - used, "%s%td", i ? ", " : "",
                                 (ptrdiff_t)shape[i]);
    if (!PyArray_Check(value))
        return raise_type("out", "out: %s: %.100s, must be an array", outputs[k].name,
                          type_name(value));
    PyArrayObject *array = (PyArrayObject *)value;
    if (PyArray_TYPE(array) != NPY_DOUBLE || !PyArray_ISNOTSWAPPED(array))
        return raise_type("out", "out: %s must be of dtype float64", outputs[k].name);
    if (!PyArray_ISCARRAY(array))
        return raise_status(TFA_E_ARGUMENT, "out",
                            "out: %s must be C-contiguous, aligned and writeable", outputs[k].name);
    if (!has_shape(array, axes, shape))
        return raise_status(TFA_E_SIZE, "out", "out: %s must have the shape (%s%s", outputs[k].name,
                            wanted, axes == 1 ? ",)" : ")");
    if (!output_is_answered(k, call->robot, &call->request))
        return raise_status(TFA_E_ARGUMENT, "out", "out: this request does not answer %s",
                            outputs[k].name);
    if (call->outputs[k])
        return raise_status(TFA_E_ARGUMENT, "out", "out: %s is given twice", outputs[k].name);
    if (check_overlap(call, k, array))
        return -1;
    call->outputs[k] = Py_NewRef(value);
    return 0;
}

/* Takes the arrays of a reply, as far as this request answers them. */
static int take_reply(request_call *call, PyObject *value)
{
    call->reused = Py_NewRef(value);
    uint64_t left = output_candidates(call->request.op, call->request.flags);
    for (; left; left &= left - 1) {
        const int k = __builtin_ctzll(left);
        PyObject *array = reply_output(value, k);
        if (array && output_has_numbers(k) && output_is_answered(k, call->robot, &call->request) &&
            take_array(call, k, array))
            return -1;
    }
    return 0;
}

static int take_dict(request_call *call, PyObject *value)
{
    PyObject *name, *array;
    Py_ssize_t at = 0;
    while (PyDict_Next(value, &at, &name, &array)) {
        const char *key = PyUnicode_Check(name) ? PyUnicode_AsUTF8AndSize(name, NULL) : NULL;
        const int k = key ? output_find(key) : -1;
        if (k < 0) {
            PyErr_Clear();
            return raise_status(TFA_E_ARGUMENT, "out", "out: no answer '%.200s'", key ? key : "?");
        }
        if (take_array(call, k, array))
            return -1;
    }
    return 0;
}

int read_out(request_call *call, const input_row *input, PyObject *value)
{
    (void)input;
    if (reply_check(value))
        return take_reply(call, value);
    if (PyDict_Check(value))
        return take_dict(call, value);
    for (int k = 0; k < OUTPUT_COUNT; k++)
        if (output_is_answered(k, call->robot, &call->request))
            return take_array(call, k, value);
    return raise_status(TFA_E_ARGUMENT, "out", "out: this request has no answers");
}

static PyObject *new_array(const request_call *call, int k)
{
    npy_intp shape[3];
    const int axes = shape_of(call, k, shape);
    if (output_has_numbers(k))
        return PyArray_SimpleNew(axes, shape, NPY_DOUBLE);
    return PyArray_NewFromDescr(&PyArray_Type,
                                (PyArray_Descr *)Py_NewRef(outputs[k].layout == LAYOUT_RANK
                                                               ? reply_rank_type
                                                               : reply_spectrum_type),
                                axes, shape, NULL, NULL, 0, NULL);
}

int call_allocate(request_call *call)
{
    uint64_t left = output_candidates(call->request.op, call->request.flags);
    for (; left; left &= left - 1) {
        const int k = __builtin_ctzll(left);
        if (!output_is_answered(k, call->robot, &call->request))
            continue;
        if (!call->outputs[k] && call->only && !(call->only >> k & 1))
            continue;
        if (!call->outputs[k] && !(call->outputs[k] = new_array(call, k)))
            return -1;
        tfa_output_set_buffer(&tfa_outputs[outputs[k].block], &call->reply,
                              PyArray_DATA((PyArrayObject *)call->outputs[k]));
    }
    call->reply.answers = &call->answer;
    if (!call->is_batch)
        return 0;
    npy_intp count = call->request.count;
    call->answers =
        PyArray_NewFromDescr(&PyArray_Type, (PyArray_Descr *)Py_NewRef(reply_answer_type), 1,
                             &count, NULL, NULL, 0, NULL);
    if (!call->answers)
        return -1;
    call->reply.answers = PyArray_DATA((PyArrayObject *)call->answers);
    return 0;
}
