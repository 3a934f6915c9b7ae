/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Tables of names; look-up by name or index.
 */
#include "robot.h"

#include "errors.h"

#include <stdio.h>
#include <totalforce/text.h>

/* Joints named in a message before it says "..." */
enum { NAMES_LISTED_MAX = 8 };

static PyObject *text_of(const char *name)
{
    PyObject *text = PyUnicode_DecodeUTF8(name, (Py_ssize_t)strlen(name), "replace");
    if (text)
        PyUnicode_InternInPlace(&text);
    return text;
}

static int add_name(PyObject *names, PyObject *index, uint32_t k, const char *name)
{
    PyObject *text = text_of(name), *number = PyLong_FromUnsignedLong(k);
    int bad = !text || !number || PyDict_SetItem(index, text, number) < 0;
    if (!bad)
        PyTuple_SET_ITEM(names, k, Py_NewRef(text));
    Py_XDECREF(text);
    Py_XDECREF(number);
    return bad;
}

static int allocate(robot_names *robot)
{
    robot->joints = PyTuple_New(robot->joint_count);
    robot->links = PyTuple_New(robot->frame_count);
    robot->joint_index = PyDict_New();
    robot->link_index = PyDict_New();
    robot->spans = PyMem_Calloc(robot->joint_count + 1u, sizeof *robot->spans);
    if (!robot->spans)
        PyErr_NoMemory();
    return !robot->joints || !robot->links || !robot->joint_index || !robot->link_index ||
           !robot->spans;
}

int robot_from_model(robot_names *robot, const tfa_model *model)
{
    *robot = (struct robot_names){.q_count = tfa_model_q_count(model),
                                  .v_count = tfa_model_v_count(model),
                                  .base_freedoms = tfa_model_base_freedoms(model),
                                  .joint_count = tfa_model_joint_count(model),
                                  .frame_count = tfa_model_frame_count(model)};
    int bad = allocate(robot);
    for (uint32_t k = 0; !bad && k < robot->joint_count; k++) {
        const tfa_joint_info joint = tfa_model_joint(model, k);
        robot->spans[k] = (joint_span){joint.q_index, joint.q_count, joint.v_index, joint.v_count,
                                       tfa_joint_type_describe(joint.type).quaternion};
        bad = add_name(robot->joints, robot->joint_index, k, joint.name);
    }
    for (uint32_t k = 0; !bad && k < robot->frame_count; k++)
        bad = add_name(robot->links, robot->link_index, k, tfa_model_frame(model, k).name);
    if (bad)
        robot_clear(robot);
    return bad ? -1 : 0;
}

static int fill_from_info(robot_names *robot, const tfa_client_info *info)
{
    uint32_t q = 0, v = 0;
    int bad = allocate(robot);
    for (uint32_t k = 0; !bad && k < robot->joint_count; k++) {
        const tfa_joint_type_info type =
            tfa_joint_type_describe(info->joint_types ? info->joint_types[k] : TFA_JOINT_REVOLUTE);
        robot->spans[k] = (joint_span){q, type.coordinates, v, type.freedoms, type.quaternion};
        q += type.coordinates;
        v += type.freedoms;
        bad = add_name(robot->joints, robot->joint_index, k, info->joint_names[k]);
    }
    for (uint32_t k = 0; !bad && k < robot->frame_count; k++)
        bad = add_name(robot->links, robot->link_index, k, info->frame_names[k]);
    if (!bad && (q != robot->q_count || v != robot->v_count))
        bad = raise_status(TFA_E_PROTOCOL, NULL, "the joints of the daemon's robot do not add up");
    return bad;
}

int robot_from_info(robot_names *robot, const tfa_client_info *info)
{
    *robot = (struct robot_names){.q_count = info->q_count,
                                  .v_count = info->v_count,
                                  .base_freedoms = info->base_freedoms,
                                  .joint_count = info->joint_count,
                                  .frame_count = info->frame_count};
    if (!fill_from_info(robot, info))
        return 0;
    robot_clear(robot);
    return -1;
}

void robot_clear(robot_names *robot)
{
    Py_CLEAR(robot->joints);
    Py_CLEAR(robot->links);
    Py_CLEAR(robot->joint_index);
    Py_CLEAR(robot->link_index);
    PyMem_Free(robot->spans);
    robot->spans = NULL;
}

static const char *name_at(const void *names, size_t index)
{
    const char *text = PyUnicode_AsUTF8(PyTuple_GET_ITEM((PyObject *)names, (Py_ssize_t)index));
    return text ? text : "?";
}

const char *robot_link_name(const robot_names *robot, uint32_t frame)
{
    return frame < robot->frame_count ? name_at(robot->links, frame) : "?";
}

const char *robot_owner(const robot_names *robot, int of_q, uint32_t index)
{
    for (uint32_t k = 0; k < robot->joint_count; k++) {
        const joint_span *span = &robot->spans[k];
        const uint32_t first = of_q ? span->q_index : span->v_index;
        const uint32_t count = of_q ? span->q_count : span->v_count;
        if (index >= first && index - first < count)
            return name_at(robot->joints, k);
    }
    return NULL;
}

void robot_describe(const robot_names *robot, int of_q, char *text, size_t size)
{
    const uint32_t numbers = of_q ? robot->q_count : robot->v_count;
    size_t used = 0;
    text[0] = '\0';
    if (numbers != robot->joint_count)
        used +=
            (size_t)snprintf(text, size, "%u %s in ", numbers, of_q ? "coordinates" : "freedoms");
    used += (size_t)snprintf(text + used, size - used, "%u joint%s", robot->joint_count,
                             robot->joint_count == 1 ? "" : "s");
    for (uint32_t k = 0; k < robot->joint_count && k < NAMES_LISTED_MAX && used < size; k++)
        used += (size_t)snprintf(text + used, size - used, "%s%.60s", k ? ", " : " (",
                                 name_at(robot->joints, k));
    if (robot->joint_count && used < size)
        snprintf(text + used, size - used, "%s",
                 robot->joint_count > NAMES_LISTED_MAX ? ", ...)" : ")");
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
    tfa_suggest(name, robot->links, robot->frame_count, name_at, nearest, sizeof nearest);
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
    tfa_suggest(name, robot->joints, robot->joint_count, name_at, nearest, sizeof nearest);
    robot_describe(robot, 0, joints, sizeof joints);
    return raise_named(TFA_E_JOINT, field, "joint", name,
                       "%s: no moving joint '%s'; nearest: %s; the robot has %s", field, name,
                       nearest, joints);
}
