/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Calls totalforce.errors.make, which chooses the class and sets the attributes.
 */
#include "errors.h"
#include "records.h"
#include "robot_names.h"

#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

/* Name of a function in totalforce/errors.py, called with keywords only; sets its exception. */
static int raise_with(const char *function, PyObject *attributes)
{
    PyObject *module = attributes ? PyImport_ImportModule("totalforce.errors") : NULL;
    PyObject *make = module ? PyObject_GetAttrString(module, function) : NULL;
    PyObject *none = make ? PyTuple_New(0) : NULL;
    PyObject *error = none ? PyObject_Call(make, none, attributes) : NULL;
    if (error)
        PyErr_SetObject((PyObject *)Py_TYPE(error), error);
    Py_XDECREF(error);
    Py_XDECREF(none);
    Py_XDECREF(make);
    Py_XDECREF(module);
    Py_XDECREF(attributes);
    return -1;
}

static PyObject *attributes_of(int status, const char *field, const char *text)
{
    return Py_BuildValue("{s:i,s:s,s:s,s:s,s:s,s:N}", "code", status, "status",
                         tfa_status_name(status), "cause", tfa_status_cause(status), "field", field,
                         "summary", tfa_status_text(status), "text",
                         PyUnicode_DecodeUTF8(text, (Py_ssize_t)strlen(text), "replace"));
}

#define FORMAT_TEXT(text, format)                                                                  \
    do {                                                                                           \
        va_list list;                                                                              \
        va_start(list, format);                                                                    \
        vsnprintf(text, sizeof text, format, list);                                                \
        va_end(list);                                                                              \
    } while (0)

int raise_status(int status, const char *field, const char *format, ...)
{
    char text[ERROR_TEXT];
    const int error = errno;
    FORMAT_TEXT(text, format);
    PyObject *attributes = attributes_of(status, field, text);
    if (attributes && (status == TFA_E_FILE || status == TFA_E_SYSTEM) &&
        set_entry(attributes, "errno", PyLong_FromLong(error)))
        Py_CLEAR(attributes);
    return raise_with("make", attributes);
}

static int add_text(PyObject *attributes, const char *key, const char *text)
{
    return set_entry(attributes, key,
                     PyUnicode_DecodeUTF8(text, (Py_ssize_t)strlen(text), "replace"));
}

int raise_named(int status, const char *field, const char *attribute, const char *name,
                const char *format, ...)
{
    char text[ERROR_TEXT];
    FORMAT_TEXT(text, format);
    PyObject *attributes = attributes_of(status, field, text);
    if (attributes && add_text(attributes, attribute, name))
        Py_CLEAR(attributes);
    return raise_with("make", attributes);
}

int raise_type(const char *field, const char *format, ...)
{
    char text[ERROR_TEXT];
    FORMAT_TEXT(text, format);
    return raise_with("make_type_error", attributes_of(TFA_E_ARGUMENT, field, text));
}

int raise_from_current(const char *field, const char *what)
{
    const int is_type = PyErr_ExceptionMatches(PyExc_TypeError);
    if (!is_type && !PyErr_ExceptionMatches(PyExc_ValueError))
        return -1;
    PyObject *type, *value, *trace;
    PyErr_Fetch(&type, &value, &trace);
    PyErr_NormalizeException(&type, &value, &trace);
    PyObject *reason = value ? PyObject_Str(value) : NULL;
    const char *text = reason ? PyUnicode_AsUTF8AndSize(reason, NULL) : NULL;
    PyErr_Clear();
    if (is_type)
        raise_type(field, "%s: %s: %s", field, what, text ? text : "?");
    else
        raise_status(TFA_E_ARGUMENT, field, "%s: %s: %s", field, what, text ? text : "?");
    Py_XDECREF(reason);
    Py_XDECREF(type);
    Py_XDECREF(value);
    Py_XDECREF(trace);
    return -1;
}

static PyObject *optional_text(const char *text)
{
    return text ? PyUnicode_FromString(text) : Py_NewRef(Py_None);
}

int raise_reply(const robot_names *robot, const tfa_request *request, const tfa_reply *answer,
                PyObject *reply)
{
    char text[ERROR_TEXT];
    const tfa_place at = tfa_refused_place(&robot->names, request, answer);
    (void)tfa_explain(&robot->names, request, answer, TFA_SYNTAX_PYTHON, text, sizeof text);
    raise_status(answer->status, at.field[0] ? at.field : NULL, "%s", text);
    PyObject *type, *value, *trace;
    PyErr_Fetch(&type, &value, &trace);
    PyErr_NormalizeException(&type, &value, &trace);
    const struct {
        const char *name;
        PyObject *value;
    } attributes[] = {
        {"index", PyLong_FromUnsignedLong(answer->index)},
        {"state", PyLong_FromUnsignedLong(answer->state)},
        {"joint", optional_text(at.joint)},
        {"link", optional_text(at.link)},
        {"constraint", optional_text(at.constraint)},
        {"reply", Py_NewRef(reply ? reply : Py_None)},
    };
    for (size_t i = 0; i < sizeof attributes / sizeof *attributes; i++) {
        if (attributes[i].value && value)
            PyObject_SetAttrString(value, attributes[i].name, attributes[i].value);
        Py_XDECREF(attributes[i].value);
    }
    PyErr_Clear();
    PyErr_Restore(type, value, trace);
    return -1;
}

int raise_report(int status, const char *path, const tfa_report *report, PyObject *messages)
{
    char text[ERROR_TEXT];
    size_t used = 0;
    text[0] = '\0';
    for (size_t i = report->first; i < report->count && used < sizeof text - 1; i++) {
        const tfa_message *message = &report->messages[i];
        if (message->severity != TFA_ERROR || strcmp(message->code, "refused") == 0)
            continue; /* the number of errors */
        used += (size_t)snprintf(text + used, sizeof text - used, "%s", used ? "\n" : "");
        if (used < sizeof text)
            used += tfa_report_format(report, i, text + used, sizeof text - used);
    }
    if (!used)
        snprintf(text, sizeof text, "%s%s%s: %s", path ? path : "", path ? ": " : "",
                 tfa_status_text(status),
                 status == TFA_E_FILE ? strerror(errno) : tfa_status_cause(status));
    const int error = status == TFA_E_FILE ? errno : 0;
    PyObject *attributes = attributes_of(status, NULL, text);
    if (attributes && (set_entry(attributes, "messages", Py_XNewRef(messages)) ||
                       set_entry(attributes, "errno", PyLong_FromLong(error)) ||
                       (path && add_text(attributes, "file", path))))
        Py_CLEAR(attributes);
    return raise_with("make", attributes);
}
