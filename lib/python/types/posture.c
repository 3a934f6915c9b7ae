/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Workspace.close_loops.
 */
#include "objects.h"
#include "python/request/errors.h"
#include "python/request/read.h"
#include "python/request/records.h"

#include <totalforce/close_loops.h>

/* Most arguments of a call: more are not among those of a request */
enum { ARGUMENTS_MAX = 64 };

/* Options of the search, taken out of the keywords: `values` keeps the rest. A new tuple of their
 * names; NULL with an exception. */
static PyObject *take_options(PyObject *const *arguments, Py_ssize_t count, PyObject *keywords,
                              tfa_loop_options *o, PyObject **values)
{
    const Py_ssize_t named = keywords ? PyTuple_Size(keywords) : 0;
    PyObject *rest = PyList_New(0), *tuple = NULL;
    int bad = !rest || count + named > ARGUMENTS_MAX;
    if (rest && bad)
        raise_type(NULL, "close_loops: %zd arguments are too many", count + named);
    for (Py_ssize_t k = 0; !bad && k < count; k++)
        values[k] = arguments[k];
    for (Py_ssize_t k = 0; !bad && k < named; k++) {
        PyObject *name = PyTuple_GetItem(keywords, k), *value = arguments[count + k];
        if (PyUnicode_CompareWithASCIIString(name, "base_is_free") == 0) {
            const int is_free = PyObject_IsTrue(value);
            bad = is_free < 0;
            o->base_is_free = is_free > 0;
        } else if (PyUnicode_CompareWithASCIIString(name, "iterations") == 0) {
            bad = !convert_u32(value, &o->iterations);
        } else if (PyUnicode_CompareWithASCIIString(name, "tolerance") == 0) {
            bad = read_numbers("tolerance", value, 1, &o->tolerance);
        } else {
            values[count + PyList_Size(rest)] = value;
            bad = PyList_Append(rest, name);
        }
    }
    if (!bad)
        tuple = PyList_AsTuple(rest);
    Py_XDECREF(rest);
    return tuple;
}

static PyObject *vector(uint32_t count, double **numbers)
{
    npy_intp size = count;
    PyObject *array = PyArray_SimpleNew(1, &size, NPY_DOUBLE);
    *numbers = array ? PyArray_DATA((PyArrayObject *)array) : NULL;
    return array;
}

/* The arrays of a posture, which become its record */
typedef struct found {
    tfa_posture posture;
    PyObject *q, *v, *base_pose, *base_twist;
} found;

static int found_init(found *f, const robot_names *robot)
{
    const int floats = robot->names.base_freedoms != 0;
    f->q = vector(robot->names.q_count, &f->posture.q);
    f->v = vector(robot->names.v_count, &f->posture.v);
    f->base_pose = floats ? vector(7, &f->posture.base_pose) : Py_NewRef(Py_None);
    f->base_twist = floats ? vector(6, &f->posture.base_twist) : Py_NewRef(Py_None);
    return f->q && f->v && f->base_pose && f->base_twist ? 0 : -1;
}

static PyObject *found_record(const found *f)
{
    const tfa_posture *p = &f->posture;
    return record_posture(Py_BuildValue("(OOOOIddII)", f->q, f->v, f->base_pose, f->base_twist,
                                        p->iterations, p->position, p->velocity, p->rank, p->lost));
}

static void found_clear(found *f)
{
    Py_XDECREF(f->q);
    Py_XDECREF(f->v);
    Py_XDECREF(f->base_pose);
    Py_XDECREF(f->base_twist);
}

static PyObject *search(workspace_object *w, request_call *call, const tfa_loop_options *o)
{
    found f = {0};
    PyObject *made = NULL;
    if (call->is_batch) {
        raise_status(TFA_E_SIZE, "q", "close_loops: one state at a time, %u are given",
                     call->request.count);
    } else if (o->base_is_free && !call->robot->names.base_freedoms) {
        raise_status(TFA_E_ARGUMENT, "base_is_free", "base_is_free: the base is fixed");
    } else if (found_init(&f, call->robot) == 0) {
        int status;
        Py_BEGIN_ALLOW_THREADS status =
            tfa_close_loops(w->workspace, &call->request, o, &f.posture);
        Py_END_ALLOW_THREADS if (status == TFA_OK || status == TFA_E_OPEN) made = found_record(&f);
        call->reply.status = status;
        call->reply.field = f.posture.field;
        call->reply.index = f.posture.index;
        if (status != TFA_OK && (made || status != TFA_E_OPEN)) {
            raise_reply(call->robot, &call->request, &call->reply, made);
            Py_CLEAR(made);
        }
    }
    found_clear(&f);
    return made;
}

PyObject *workspace_close_loops(PyObject *self, PyObject *const *arguments, Py_ssize_t count,
                                PyObject *keywords)
{
    workspace_object *w = (workspace_object *)self;
    PyObject *values[ARGUMENTS_MAX], *made = NULL;
    tfa_loop_options options = {0};
    PyObject *names = take_options(arguments, count, keywords, &options, values);
    if (names && solver_enter(&w->head) == 0) {
        request_call call;
        if (call_read(&call, w->head.robot, 0, TFA_OP_IMPACT, values, count, names) == 0)
            made = search(w, &call, &options);
        call_clear(&call);
        solver_leave(&w->head);
    }
    Py_XDECREF(names);
    return made;
}
