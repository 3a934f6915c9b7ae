/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Tables of names; look-up by name or index.
 */
#include "robot.h"

#include "errors.h"

#include <stdio.h>

/* Adds name k to a tuple and to its index. @return its UTF-8, which lives as long as the tuple;
 * NULL with an exception */
static const char *add_name(PyObject *list, PyObject *index, uint32_t k, const char *name)
{
    PyObject *text = PyUnicode_DecodeUTF8(name, (Py_ssize_t)strlen(name), "replace");
    PyObject *number = PyLong_FromUnsignedLong(k);
    if (text)
        PyUnicode_InternInPlace(&text);
    const int bad = !text || !number || PyDict_SetItem(index, text, number) < 0;
    if (!bad)
        PyTuple_SET_ITEM(list, k, Py_NewRef(text));
    const char *utf8 = bad ? NULL : PyUnicode_AsUTF8(text);
    Py_XDECREF(text);
    Py_XDECREF(number);
    return utf8;
}

static int add_names(robot_names *robot)
{
    tfa_names *names = &robot->names;
    int bad = !robot->joints || !robot->links || !robot->joint_index || !robot->link_index;
    for (uint32_t k = 0; !bad && k < names->joint_count; k++) {
        names->joints[k].name =
            add_name(robot->joints, robot->joint_index, k, names->joints[k].name);
        bad = !names->joints[k].name;
    }
    for (uint32_t k = 0; !bad && k < names->frame_count; k++) {
        names->frames[k] = add_name(robot->links, robot->link_index, k, names->frames[k]);
        bad = !names->frames[k];
    }
    return bad;
}

static int fill(robot_names *robot, const tfa_names *names)
{
    *robot = (struct robot_names){.names = *names,
                                  .q_count = names->q_count,
                                  .v_count = names->v_count,
                                  .base_freedoms = names->base_freedoms,
                                  .joint_count = names->joint_count,
                                  .frame_count = names->frame_count,
                                  .joints = PyTuple_New(names->joint_count),
                                  .links = PyTuple_New(names->frame_count),
                                  .joint_index = PyDict_New(),
                                  .link_index = PyDict_New()};
    if (!add_names(robot))
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
    Py_CLEAR(robot->joint_index);
    Py_CLEAR(robot->link_index);
    tfa_names_free(&robot->names);
}

/* Looks a name or an index up. @return 0; 1: there is none; -1 with an exception */
static int look_up(PyObject *index, uint32_t count, const char *field, PyObject *value,
                   const char *noun, uint32_t *found)
{
    if (PyUnicode_Check(value)) {
        PyObject *number = PyDict_GetItemWithError(index, value);
        if (number)
            *found = (uint32_t)PyLong_AsUnsignedLong(number);
        return number ? 0 : PyErr_Occurred() ? -1 : 1;
    }
    if (!PyIndex_Check(value) || PyBool_Check(value))
        return raise_type(field, "%s: %.100s, must be the name or the index of a %s", field,
                          Py_TYPE(value)->tp_name, noun);
    const Py_ssize_t k = PyNumber_AsSsize_t(value, NULL);
    *found = (uint32_t)k;
    return k == -1 && PyErr_Occurred() ? -1 : k < 0 || k >= (Py_ssize_t)count;
}

static int unknown(const char *field, PyObject *value, char *name, size_t size)
{
    PyObject *text = PyObject_Str(value);
    const char *utf8 = text ? PyUnicode_AsUTF8(text) : NULL;
    snprintf(name, size, "%.200s", utf8 ? utf8 : "?");
    Py_XDECREF(text);
    return utf8 ? 0 : raise_type(field, "%s: a name that cannot be encoded", field);
}

int robot_find_link(const robot_names *robot, const char *field, PyObject *value, uint32_t *frame)
{
    char name[204], nearest[200];
    const int missing = look_up(robot->link_index, robot->frame_count, field, value, "link", frame);
    if (missing <= 0)
        return missing;
    if (unknown(field, value, name, sizeof name))
        return -1;
    tfa_names_suggest_links(&robot->names, name, nearest, sizeof nearest);
    return raise_named(TFA_E_LINK, field, "link", name,
                       "%s: no link '%s' in the robot; nearest: %s", field, name, nearest);
}

int robot_find_joint(const robot_names *robot, const char *field, PyObject *value, uint32_t *joint)
{
    char name[204], nearest[200], joints[600];
    const int missing =
        look_up(robot->joint_index, robot->joint_count, field, value, "joint", joint);
    if (missing <= 0)
        return missing;
    if (unknown(field, value, name, sizeof name))
        return -1;
    tfa_names_suggest_joints(&robot->names, name, nearest, sizeof nearest);
    (void)tfa_names_describe(&robot->names, 0, joints, sizeof joints);
    return raise_named(TFA_E_JOINT, field, "joint", name,
                       "%s: no moving joint '%s'; nearest: %s; the robot has %s", field, name,
                       nearest, joints);
}
