/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Tables of names; look-up by name or index.
 */
#include "robot_names.h"

#include "errors.h"

#include <stdio.h>

/* Sets name k of a tuple. @return its UTF-8, which lives as long as the tuple; NULL with an
 * exception */
static const char *set_name(PyObject *list, uint32_t k, const char *name)
{
    PyObject *text = PyUnicode_DecodeUTF8(name, (Py_ssize_t)strlen(name), "replace");
    if (!text)
        return NULL;
    PyUnicode_InternInPlace(&text);
    PyTuple_SET_ITEM(list, k, text);
    return PyUnicode_AsUTF8(text);
}

static int set_names(robot_names *robot)
{
    tfa_names *names = &robot->names;
    int bad = !robot->joints || !robot->links || !robot->modes;
    for (uint32_t k = 0; !bad && k < names->joint_count; k++)
        bad = !(names->joints[k].name = set_name(robot->joints, k, names->joints[k].name));
    for (uint32_t k = 0; !bad && k < names->frame_count; k++)
        bad = !(names->frames[k] = set_name(robot->links, k, names->frames[k]));
    for (uint32_t k = 0; !bad && k < names->mode_count; k++)
        bad = !set_name(robot->modes, k, tfa_names_frame(names, names->mode_frames[k]));
    return bad;
}

static int fill(robot_names *robot, const tfa_names *names)
{
    *robot = (struct robot_names){.names = *names,
                                  .joints = PyTuple_New(names->joint_count),
                                  .links = PyTuple_New(names->frame_count),
                                  .modes = PyTuple_New(names->mode_count)};
    if (!set_names(robot))
        return 0;
    robot_clear(robot);
    return -1;
}

int robot_from_model(robot_names *robot, const tfa_model *model)
{
    tfa_names names;
    *robot = (struct robot_names){0};
    if (tfa_names_of_model(&names, model) == TFA_OK)
        return fill(robot, &names);
    PyErr_NoMemory();
    return -1;
}

int robot_from_info(robot_names *robot, const char *name, const tfa_client_info *info)
{
    tfa_names names;
    *robot = (struct robot_names){0};
    const int status = tfa_names_of_info(&names, name, info);
    if (status == TFA_OK)
        return fill(robot, &names);
    if (status != TFA_E_MEMORY)
        return raise_status(status, NULL, "the joints of the daemon's robot do not add up");
    PyErr_NoMemory();
    return -1;
}

void robot_clear(robot_names *robot)
{
    Py_CLEAR(robot->joints);
    Py_CLEAR(robot->links);
    Py_CLEAR(robot->modes);
    tfa_names_free(&robot->names);
}

static int unknown(const char *field, PyObject *value, char *name, size_t size)
{
    PyObject *text = PyObject_Str(value);
    const char *utf8 = text ? PyUnicode_AsUTF8(text) : NULL;
    snprintf(name, size, "%.200s", utf8 ? utf8 : "?");
    Py_XDECREF(text);
    return utf8 ? 0 : raise_type(field, "%s: a name that cannot be encoded", field);
}

static int find(const tfa_names *names, int joints, const char *field, PyObject *value,
                uint32_t *found)
{
    const char *noun = joints ? "joint" : "link";
    const uint32_t count = joints ? names->joint_count : names->frame_count;
    Py_ssize_t k = -1, size = 0;
    if (PyUnicode_Check(value)) {
        const char *utf8 = PyUnicode_AsUTF8AndSize(value, &size);
        if (utf8 && strlen(utf8) == (size_t)size)
            k = joints ? tfa_names_joint(names, utf8) : tfa_names_link(names, utf8);
        PyErr_Clear();
    } else if (!PyIndex_Check(value) || PyBool_Check(value)) {
        return raise_type(field, "%s: %.100s, must be the name or the index of a %s", field,
                          Py_TYPE(value)->tp_name, noun);
    } else {
        k = PyNumber_AsSsize_t(value, NULL);
    }
    if (k == -1 && PyErr_Occurred())
        return -1;
    *found = (uint32_t)k;
    if (k >= 0 && k < (Py_ssize_t)count)
        return 0;
    char name[204], text[900];
    if (unknown(field, value, name, sizeof name))
        return -1;
    (joints ? tfa_names_unknown_joint : tfa_names_unknown_link)(names, name, text, sizeof text);
    return raise_named(joints ? TFA_E_JOINT : TFA_E_LINK, field, noun, name, "%s: %s", field, text);
}

int robot_find_link(const robot_names *robot, const char *field, PyObject *value, uint32_t *frame)
{
    return find(&robot->names, 0, field, value, frame);
}

int robot_find_joint(const robot_names *robot, const char *field, PyObject *value, uint32_t *joint)
{
    return find(&robot->names, 1, field, value, joint);
}
