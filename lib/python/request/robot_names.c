/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Tables of names; look-up by name or index.
 */
#include "robot_names.h"

#include "errors.h"

#include <stddef.h>
#include <stdio.h>

/* Sets name k of a tuple. @return its UTF-8, which lives as long as the tuple; NULL with an
 * exception */
static const char *set_name(PyObject *list, uint32_t k, const char *name)
{
    PyObject *text = PyUnicode_DecodeUTF8(name, (Py_ssize_t)strlen(name), "replace");
    if (!text)
        return NULL;
    PyUnicode_InternInPlace(&text);
    PyTuple_SetItem(list, k, text);
    return PyUnicode_AsUTF8AndSize(text, NULL);
}

static int set_names(robot_names *robot)
{
    tfa_names *names = &robot->names;
    int bad = !robot->joints || !robot->links || !robot->modes || !robot->constraints;
    for (uint32_t k = 0; !bad && k < names->joint_count; k++)
        bad = !(names->joints[k].name = set_name(robot->joints, k, names->joints[k].name));
    for (uint32_t k = 0; !bad && k < names->frame_count; k++)
        bad = !(names->frames[k] = set_name(robot->links, k, names->frames[k]));
    for (uint32_t k = 0; !bad && k < names->mode_count; k++)
        bad = !set_name(robot->modes, k, tfa_names_frame(names, names->mode_frames[k]));
    for (uint32_t k = 0; !bad && k < names->constraint_count; k++)
        bad = !(names->constraints[k] = set_name(robot->constraints, k, names->constraints[k]));
    return bad;
}

static int fill(robot_names *robot, const tfa_names *names)
{
    *robot = (struct robot_names){.names = *names,
                                  .joints = PyTuple_New(names->joint_count),
                                  .links = PyTuple_New(names->frame_count),
                                  .modes = PyTuple_New(names->mode_count),
                                  .constraints = PyTuple_New(names->constraint_count)};
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
    Py_CLEAR(robot->constraints);
    tfa_names_free(&robot->names);
}

static int unknown(const char *field, PyObject *value, char *name, size_t size)
{
    PyObject *text = PyObject_Str(value);
    const char *utf8 = text ? PyUnicode_AsUTF8AndSize(text, NULL) : NULL;
    snprintf(name, size, "%.200s", utf8 ? utf8 : "?");
    Py_XDECREF(text);
    return utf8 ? 0 : raise_type(field, "%s: a name that cannot be encoded", field);
}

/* What may be looked up by name or index */
typedef struct named {
    const char *noun;
    int status;   /* of an unknown one */
    size_t count; /* offset in tfa_names */
    int32_t (*find)(const tfa_names *, const char *);
    void (*unknown)(const tfa_names *, const char *, char *, size_t);
} named;

static int find(const tfa_names *names, const named *kind, const char *field, PyObject *value,
                uint32_t *found)
{
    const char *noun = kind->noun;
    uint32_t count;
    memcpy(&count, (const char *)names + kind->count, sizeof count);
    Py_ssize_t k = -1, size = 0;
    if (PyUnicode_Check(value)) {
        const char *utf8 = PyUnicode_AsUTF8AndSize(value, &size);
        if (utf8 && strlen(utf8) == (size_t)size)
            k = kind->find(names, utf8);
        PyErr_Clear();
    } else if (!PyIndex_Check(value) || PyBool_Check(value)) {
        return raise_type(field, "%s: %.100s, must be the name or the index of a %s", field,
                          type_name(value), noun);
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
    kind->unknown(names, name, text, sizeof text);
    return raise_named(kind->status, field, noun, name, "%s: %s", field, text);
}

#define FINDER(kind, error)                                                                        \
    int robot_find_##kind(const robot_names *robot, const char *field, PyObject *value,            \
                          uint32_t *found)                                                         \
    {                                                                                              \
        static const named row = {#kind, error, COUNT_OF_##kind, tfa_names_##kind,                 \
                                  tfa_names_unknown_##kind};                                       \
        return find(&robot->names, &row, field, value, found);                                     \
    }
#define COUNT_OF_link offsetof(tfa_names, frame_count)
#define COUNT_OF_joint offsetof(tfa_names, joint_count)
#define COUNT_OF_constraint offsetof(tfa_names, constraint_count)
FINDER(link, TFA_E_LINK)
FINDER(joint, TFA_E_JOINT)
FINDER(constraint, TFA_E_ARGUMENT)
