/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * For the tools: test mechanisms, and suggestions for their command lines.
 */
#include "mechanism/mechanism.h"
#include "objects.h"
#include "python/request/errors.h"

#include <math.h>
#include <stdio.h>
#include <totalforce/text.h>

PyObject *list_mechanisms(PyObject *module, PyObject *unused)
{
    PyObject *list = PyTuple_New(MECHANISM_COUNT);
    (void)module;
    (void)unused;
    for (int k = 0; list && k < MECHANISM_COUNT; k++) {
        PyObject *name = PyUnicode_FromString(mechanism_name((mechanism_kind)k));
        if (name)
            PyTuple_SetItem(list, k, name);
        else
            Py_CLEAR(list);
    }
    return list;
}

/* Its URDF: what Model and the peers read */
static PyObject *write_mechanism(const mechanism_options *options)
{
    char *text = NULL;
    size_t length = 0;
    FILE *out = open_memstream(&text, &length);
    if (!out)
        return PyErr_NoMemory();
    mechanism_write(options, out);
    const int broken = ferror(out);
    PyObject *made = fclose(out) != 0 || broken
                         ? PyErr_NoMemory()
                         : PyBytes_FromStringAndSize(text, (Py_ssize_t)length);
    free(text);
    return made;
}

PyObject *make_mechanism(PyObject *module, PyObject *args, PyObject *kwargs)
{
    static char *names[] = {"", "", "radius", "ratio", "taper", "curl", "seed", NULL};
    char why[128];
    const char *name;
    unsigned bodies;
    unsigned long long seed = 1;
    double given[4] = {NAN, NAN, NAN, NAN};
    (void)module;
    if (!PyArg_ParseTupleAndKeywords(args, kwargs, "sI|$ddddK:_mechanism", names, &name, &bodies,
                                     &given[0], &given[1], &given[2], &given[3], &seed))
        return NULL;
    const int kind = mechanism_find(name);
    if (kind < 0) {
        raise_status(TFA_E_ARGUMENT, "name", "no mechanism '%.100s'", name);
        return NULL;
    }
    mechanism_options o = mechanism_defaults((mechanism_kind)kind, bodies);
    double *const numbers[4] = {&o.radius, &o.ratio, &o.taper, &o.curl};
    for (int k = 0; k < 4; k++)
        *numbers[k] = isnan(given[k]) ? *numbers[k] : given[k];
    o.seed = seed;
    if (mechanism_check(&o, why, sizeof why) == 0)
        return write_mechanism(&o);
    raise_status(TFA_E_ARGUMENT, NULL, "%s", why);
    return NULL;
}

PyObject *suggest(PyObject *module, PyObject *args)
{
    PyObject *words, *made = NULL;
    const char *wrong;
    char text[4096];
    int bad = 0;
    (void)module;
    if (!PyArg_ParseTuple(args, "sO!:_suggest", &wrong, &PyTuple_Type, &words))
        return NULL;
    const Py_ssize_t count = PyTuple_Size(words);
    const char **list = PyMem_Calloc((size_t)count + 1, sizeof *list);
    if (!list)
        return PyErr_NoMemory();
    for (Py_ssize_t k = 0; !bad && k < count; k++)
        bad = !(list[k] = PyUnicode_AsUTF8AndSize(PyTuple_GetItem(words, k), NULL));
    if (!bad) {
        tfa_suggest_words(wrong, list, (size_t)count, text, sizeof text);
        made = PyUnicode_FromString(text);
    }
    PyMem_Free(list);
    return made;
}
