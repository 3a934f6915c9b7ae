/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Changes of the robot by a request: payloads and locked joints.
 */
#include "errors.h"
#include "read.h"

#include <stdio.h>

int read_load(const char *field, PyObject *value, PyObject **link,
              double numbers[TFA_PAYLOAD_NUMBERS])
{
    static const struct {
        const char *key;
        uint32_t first, count;
    } parts[] = {{"mass", 0, 1}, {"com", 1, 3}, {"inertia", 4, 6}};
    if (!PyDict_Check(value))
        return raise_type(field, "%s: %.100s, must be a dict with link, mass, com, inertia", field,
                          type_name(value));
    Py_ssize_t known = PyDict_GetItemString(value, "link") != NULL;
    memset(numbers, 0, TFA_PAYLOAD_NUMBERS * sizeof *numbers);
    for (size_t i = 0; i < 3; i++) {
        PyObject *part = PyDict_GetItemString(value, parts[i].key);
        char key[64];
        snprintf(key, sizeof key, "%s.%s", field, parts[i].key);
        if (!part && i == 0)
            return raise_status(TFA_E_ARGUMENT, field, "%s: missing", key);
        if (!part)
            continue;
        known++;
        Py_INCREF(part); /* code of the caller may run and change the dict */
        const int bad = read_numbers(key, part, parts[i].count, numbers + parts[i].first);
        Py_DECREF(part);
        if (bad)
            return -1;
    }
    *link = PyDict_GetItemString(value, "link");
    if (!*link)
        return raise_status(TFA_E_ARGUMENT, field, "%s.link: missing", field);
    return known == PyDict_Size(value)
               ? 0
               : raise_status(TFA_E_ARGUMENT, field,
                              "%s: unknown key; there are link, mass, com, inertia", field);
}

int read_payload(request_call *call, const input_row *input, PyObject *value)
{
    PyObject *list = PyDict_Check(value) ? PyTuple_Pack(1, value) : PySequence_Tuple(value);
    if (!list)
        return raise_from_current(input->name, "must be a dict, or a list of dicts");
    const Py_ssize_t count = PyTuple_Size(list);
    int bad = 0;
    if (count > TFA_MAX_PAYLOADS)
        bad = raise_status(TFA_E_SIZE, input->name, "payload: %zd loads, at most %d", count,
                           TFA_MAX_PAYLOADS);
    for (Py_ssize_t k = 0; !bad && k < count; k++) {
        PyObject *link;
        bad = read_load(input->name, PyTuple_GetItem(list, k), &link,
                        call->payloads + TFA_PAYLOAD_NUMBERS * k) ||
              robot_find_link(call->robot, input->name, link, &call->request.payload_frames[k]);
    }
    Py_DECREF(list);
    call->request.payload_count = bad ? 0 : (uint32_t)count;
    call->request.payloads = call->payloads;
    return bad ? -1 : 0;
}

int read_locked(request_call *call, const input_row *input, PyObject *value)
{
    PyObject *list = PyUnicode_Check(value) ? PyTuple_Pack(1, value) : PySequence_Tuple(value);
    if (!list)
        return raise_from_current(input->name, "must be a list of joints");
    const Py_ssize_t count = PyTuple_Size(list);
    int bad = 0;
    if (count > (Py_ssize_t)call->robot->names.joint_count)
        bad = raise_status(TFA_E_SIZE, input->name, "locked: %zd joints, the robot has %u", count,
                           call->robot->names.joint_count);
    if (!bad && !(call->locked = PyMem_Calloc((size_t)count + 1, sizeof *call->locked))) {
        PyErr_NoMemory();
        bad = -1;
    }
    for (Py_ssize_t k = 0; !bad && k < count; k++)
        bad =
            robot_find_joint(call->robot, input->name, PyTuple_GetItem(list, k), &call->locked[k]);
    Py_DECREF(list);
    call->request.locked = call->locked;
    call->request.locked_count = bad ? 0 : (uint32_t)count;
    return bad;
}
