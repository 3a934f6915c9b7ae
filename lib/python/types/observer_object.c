/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Type _Observer: the filter of an Observer (observer.py), without its questions.
 */
#include "objects.h"
#include "python/request/errors.h"

#include <totalforce/observer.h>

typedef struct observer_object {
    PyObject_HEAD tfa_observer *observer;
    uint32_t base, v_count;
} observer_object;

static void observer_dealloc(PyObject *self)
{
    tfa_observer_free(((observer_object *)self)->observer);
    object_free(self);
}

static PyObject *observer_new(PyTypeObject *type, PyObject *args, PyObject *kwargs)
{
    static char *names[] = {"base_freedoms", "v_count", "gain", "max_gap", NULL};
    unsigned base, v_count;
    tfa_observer_options options;
    if (!PyArg_ParseTupleAndKeywords(args, kwargs, "IIdd:_Observer", names, &base, &v_count,
                                     &options.gain, &options.max_gap))
        return NULL;
    observer_object *o = (observer_object *)PyType_GenericAlloc(type, 0);
    const int status = o ? tfa_observer_create(base, v_count, &options, &o->observer) : TFA_OK;
    if (status == TFA_E_VALUE)
        raise_status(status, "gain", "gain: %g, max_gap: %g: must be finite, gain above 0",
                     options.gain, options.max_gap);
    else if (status != TFA_OK)
        raise_status(status, NULL, "Observer: %s", tfa_status_text(status));
    if (status != TFA_OK)
        Py_CLEAR(o);
    if (o) {
        o->base = base;
        o->v_count = v_count;
    }
    return (PyObject *)o;
}

/* An array of so many numbers as doubles, or NULL for None. @return 0; -1 with an exception */
static int vector_of(PyObject *value, const char *name, uint32_t count, PyObject **array,
                     const double **numbers)
{
    *numbers = NULL;
    if (value == Py_None)
        return 0;
    *array = PyArray_FROMANY(value, NPY_DOUBLE, 1, 1, NPY_ARRAY_CARRAY_RO);
    if (!*array)
        return -1;
    if (PyArray_SIZE((PyArrayObject *)*array) != (npy_intp)count) {
        raise_status(TFA_E_SIZE, name, "%s: %zd numbers, must be %u", name,
                     (Py_ssize_t)PyArray_SIZE((PyArrayObject *)*array), count);
        return -1;
    }
    *numbers = PyArray_DATA((PyArrayObject *)*array);
    return 0;
}

static PyObject *observer_step(PyObject *self, PyObject *args)
{
    enum { MOMENTUM, RATE, TAU, BASE, ARRAYS };
    static const char *const names[ARRAYS] = {"generalised_momentum", "momentum_rate", "tau",
                                              "base_wrench"};
    static const char *const events[] = {
#define EVENT(value, word) [value] = word,
        TFA_OBSERVER_WORDS(EVENT)
#undef EVENT
    };
    observer_object *o = (observer_object *)self;
    PyObject *values[ARRAYS], *arrays[ARRAYS] = {NULL}, *made = NULL;
    const double *numbers[ARRAYS];
    double time;
    unsigned long long model;
    if (!PyArg_ParseTuple(args, "dKOOOO:step", &time, &model, values, values + 1, values + 2,
                          values + 3))
        return NULL;
    int bad = 0;
    for (int k = 0; !bad && k < ARRAYS; k++) {
        const uint32_t n = k == BASE ? o->base : k == TAU ? o->v_count : o->base + o->v_count;
        bad = vector_of(values[k], names[k], n, &arrays[k], &numbers[k]);
    }
    if (!bad) {
        tfa_request request;
        tfa_reply reply;
        tfa_observer_request(o->observer, &request, &reply);
        const size_t size = (o->base + o->v_count) * sizeof(double);
        memcpy(reply.generalised_momentum, numbers[MOMENTUM], size);
        memcpy(reply.momentum_rate, numbers[RATE], size);
        reply.model = model;
        made = PyUnicode_FromString(
            events[tfa_observer_update(o->observer, time, numbers[TAU], numbers[BASE], &reply)]);
    }
    for (int k = 0; k < ARRAYS; k++)
        Py_XDECREF(arrays[k]);
    return made;
}

static PyObject *observer_restart(PyObject *self, PyObject *unused)
{
    (void)unused;
    tfa_observer_restart(((observer_object *)self)->observer);
    Py_RETURN_NONE;
}

static PyObject *get_torques(PyObject *self, void *unused)
{
    const observer_object *o = (observer_object *)self;
    (void)unused;
    return array_of(tfa_observer_torques(o->observer), o->base + o->v_count);
}

static PyMethodDef methods[] = {
    {"step", observer_step, METH_VARARGS,
     "step($self, time, model, momentum, rate, tau, base_wrench, /)\n--\n\n"},
    {"restart", observer_restart, METH_NOARGS, "restart($self, /)\n--\n\n"},
    {0}};
static PyGetSetDef attributes[] = {{"torques", get_torques, NULL, NULL, NULL}, {0}};

static PyTypeObject *observer_type;

static const type_members observer_members = {
    .name = "totalforce._totalforce._Observer",
    .doc = "_Observer(base_freedoms, v_count, gain, max_gap)\n--\n\n",
    .size = sizeof(observer_object),
    .make = observer_new,
    .dealloc = observer_dealloc,
    .methods = methods,
    .attributes = attributes};

int observer_init(PyObject *module)
{
    return add_type(module, &observer_members, &observer_type);
}
