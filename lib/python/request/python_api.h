/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Python.h and numpy's C API, so that one compiled module serves CPython 3.11 and later (limited
 * API; before 3.11 it has no buffers, and the module serves the version it is compiled for) and
 * NumPy 1.22 to 2.x.
 */
#ifndef PYTHON_PYTHON_API_H
#define PYTHON_PYTHON_API_H

#include <patchlevel.h>
#if PY_VERSION_HEX >= 0x030B0000
#define Py_LIMITED_API 0x030B0000
#endif
#define PY_SSIZE_T_CLEAN
#include <Python.h>

#define NPY_NO_DEPRECATED_API NPY_1_22_API_VERSION
#define PY_ARRAY_UNIQUE_SYMBOL totalforce_numpy_api
#ifndef IMPORTS_NUMPY_API
#define NO_IMPORT_ARRAY
#endif
#include <numpy/arrayobject.h>

#include <stdlib.h>
#include <string.h>

/** Finds numpy's table of functions for all files. @return 0; -1 with an ImportError */
int import_numpy(void);

/** What makes a type. Absent members are NULL; without `make` Python code makes no instances. */
typedef struct type_members {
    const char *name; /**< with its module: what pickle stores */
    const char *doc;
    size_t size; /**< of an instance, bytes */
    newfunc make;
    destructor dealloc; /**< ends with object_free */
    reprfunc repr;
    getiterfunc iter;
    lenfunc length;
    binaryfunc item;
    objobjproc contains;
    PyMethodDef *methods;
    PyGetSetDef *attributes;
} type_members;

/** Makes a type and adds it to the module under its name. @return 0; -1 with an exception */
int add_type(PyObject *module, const type_members *members, PyTypeObject **type);

/** Frees the memory of an instance, and its reference to its type. */
void object_free(PyObject *self);

/** Name of the type of a value, valid until the thread's next call. */
const char *type_name(PyObject *value);

#endif
