/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Import of numpy, types made of members, names of types.
 */
#define IMPORTS_NUMPY_API
#include "python_api.h"

#include <stdint.h>
#include <stdio.h>

/* numpy/__init__.py of every release from 1.22 on has one of them. */
static PyObject *import_table(void)
{
    static const char *const modules[] = {"numpy._core._multiarray_umath",
                                          "numpy.core._multiarray_umath"};
    PyObject *module = PyImport_ImportModule("numpy");
    Py_XDECREF(module);
    for (int k = 0; module && k < 2; k++) {
        PyErr_Clear();
        PyObject *inner = PyImport_ImportModule(modules[k]);
        PyObject *table = inner ? PyObject_GetAttrString(inner, "_ARRAY_API") : NULL;
        Py_XDECREF(inner);
        if (table)
            return table;
    }
    return NULL;
}

/* numpy's own import_array() of version 1 refuses version 2. Both have the functions in use here at
 * the same places of the table, and arrays and dtypes that begin with the same members; nothing
 * here reads a dtype's elsize, or what follows it, which moved (numpy 2.0, npy_2_compat.h). */
int import_numpy(void)
{
    enum { ABI_1 = 0x01000009, ABI_2 = 0x02000000, API_1_22 = 0x0F };
    PyObject *table = import_table();
    PyArray_API = table ? PyCapsule_GetPointer(table, NULL) : NULL;
    Py_XDECREF(table);
    if (!PyArray_API)
        return -1;
    const unsigned abi = PyArray_GetNDArrayCVersion();
    const unsigned api = PyArray_GetNDArrayCFeatureVersion();
    if ((abi == ABI_1 || abi == ABI_2) && api >= API_1_22)
        return 0;
    PyErr_Format(PyExc_ImportError, "numpy has ABI %x and API %x, must be 1.22 to 2.x", abi, api);
    return -1;
}

/* ISO C has no conversion of functions to objects; POSIX has. */
#define SLOT(number, member)                                                                       \
    if (member)                                                                                    \
        slots[count++] = (PyType_Slot)                                                             \
        {                                                                                          \
            number, (void *)(uintptr_t)(member)                                                    \
        }

int add_type(PyObject *module, const type_members *members, PyTypeObject **type)
{
    PyType_Slot slots[12];
    int count = 0;
    SLOT(Py_tp_doc, members->doc);
    SLOT(Py_tp_new, members->make);
    SLOT(Py_tp_dealloc, members->dealloc);
    SLOT(Py_tp_repr, members->repr);
    SLOT(Py_tp_iter, members->iter);
    SLOT(Py_mp_length, members->length);
    SLOT(Py_mp_subscript, members->item);
    SLOT(Py_sq_contains, members->contains);
    SLOT(Py_tp_methods, members->methods);
    SLOT(Py_tp_getset, members->attributes);
    slots[count] = (PyType_Slot){0};
    PyType_Spec spec = {
        .name = members->name,
        .basicsize = (int)members->size,
        .flags = Py_TPFLAGS_DEFAULT | Py_TPFLAGS_IMMUTABLETYPE |
                 (members->make ? 0 : Py_TPFLAGS_DISALLOW_INSTANTIATION),
        .slots = slots,
    };
    PyObject *made = PyType_FromSpec(&spec);
    *type = (PyTypeObject *)made;
    return made ? PyModule_AddObjectRef(module, strrchr(members->name, '.') + 1, made) : -1;
}

void object_free(PyObject *self)
{
    PyTypeObject *type = Py_TYPE(self);
    PyObject_Free(self);
    Py_DECREF(type);
}

const char *type_name(PyObject *value)
{
    static _Thread_local char text[100];
    PyObject *name = PyObject_GetAttrString((PyObject *)Py_TYPE(value), "__name__");
    const char *utf8 = name ? PyUnicode_AsUTF8AndSize(name, NULL) : NULL;
    PyErr_Clear();
    snprintf(text, sizeof text, "%s", utf8 ? utf8 : "?");
    Py_XDECREF(name);
    return text;
}
