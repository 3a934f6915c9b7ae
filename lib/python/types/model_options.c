/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Options of a model: base, gravity, policies, scene.
 */
#include "objects.h"
#include "python/request/errors.h"
#include "python/request/read.h"

/* UTF-8 of a name, which `keep` keeps alive; NULL with an exception */
static const char *name_of(const char *field, PyObject *value, PyObject *keep)
{
    const char *text = PyUnicode_Check(value) ? PyUnicode_AsUTF8AndSize(value, NULL) : NULL;
    if (!text) {
        if (!PyErr_Occurred())
            raise_type(field, "%s: %.100s, must be a name", field, type_name(value));
        return NULL;
    }
    return PyList_Append(keep, value) < 0 ? NULL : text;
}

int read_payloads(PyObject *value, PyObject *keep, tfa_payload **payloads, size_t *count)
{
    PyObject *list = PyDict_Check(value) ? PyTuple_Pack(1, value) : PySequence_Tuple(value);
    if (!list)
        return raise_from_current("payload", "must be a dict, or a list of dicts");
    *count = (size_t)PyTuple_Size(list);
    *payloads = PyMem_Calloc(*count + 1, sizeof **payloads);
    int bad = *payloads ? 0 : (PyErr_NoMemory(), -1);
    for (size_t k = 0; !bad && k < *count; k++) {
        double numbers[TFA_PAYLOAD_NUMBERS];
        PyObject *link;
        tfa_payload *payload = &(*payloads)[k];
        bad = read_load("payload", PyTuple_GetItem(list, (Py_ssize_t)k), &link, numbers) ||
              !(payload->link = name_of("payload", link, keep));
        if (bad)
            break;
        payload->mass = numbers[0];
        memcpy(payload->com, numbers + 1, sizeof payload->com);
        memcpy(payload->inertia, numbers + 4, sizeof payload->inertia);
    }
    Py_DECREF(list);
    return bad ? -1 : 0;
}

/* {joint: number or coordinates}, or a list of joints that stand at 0 */
static int read_locks(model_options *o)
{
    PyObject *items = PyDict_Check(o->locked) ? PyDict_Items(o->locked) : Py_NewRef(o->locked);
    PyObject *list = items ? PySequence_Tuple(items) : NULL;
    Py_XDECREF(items);
    if (!list)
        return raise_from_current("locked", "must be {joint: position} or a list of joints");
    const Py_ssize_t count = PyTuple_Size(list);
    o->locks = PyMem_Calloc((size_t)count + 1, sizeof *o->locks);
    int bad = o->locks ? 0 : (PyErr_NoMemory(), -1);
    for (Py_ssize_t k = 0; !bad && k < count; k++) {
        PyObject *entry = PyTuple_GetItem(list, k);
        const int is_pair = PyTuple_Check(entry) && PyTuple_Size(entry) == 2;
        PyObject *value = is_pair ? PyTuple_GetItem(entry, 1) : NULL;
        o->locks[k].joint =
            name_of("locked", is_pair ? PyTuple_GetItem(entry, 0) : entry, o->names);
        bad = !o->locks[k].joint;
        if (!bad && value) {
            const Py_ssize_t size = PySequence_Check(value) ? PySequence_Size(value) : 1;
            const uint32_t numbers = size == 3 || size == 7 ? (uint32_t)size : 1;
            PyErr_Clear(); /* an array without axes has no size */
            bad = read_numbers("locked", value, numbers, o->locks[k].q);
        }
    }
    Py_DECREF(list);
    o->scene.locks = o->locks;
    o->scene.lock_count = (size_t)count;
    return bad ? -1 : 0;
}

/* {joint: inertia} */
static int read_rotors(model_options *o)
{
    PyObject *joint, *value;
    Py_ssize_t at = 0;
    if (!PyDict_Check(o->rotors))
        return raise_type("rotors", "rotors: %.100s, must be {joint: inertia}",
                          type_name(o->rotors));
    o->rotor_list = PyMem_Calloc((size_t)PyDict_Size(o->rotors) + 1, sizeof *o->rotor_list);
    if (!o->rotor_list)
        return PyErr_NoMemory(), -1;
    o->scene.rotors = o->rotor_list;
    while (PyDict_Next(o->rotors, &at, &joint, &value)) {
        tfa_rotor *rotor = &o->rotor_list[o->scene.rotor_count++];
        rotor->joint = name_of("rotors", joint, o->names);
        if (!rotor->joint || read_numbers("rotors", value, 1, &rotor->inertia))
            return -1;
    }
    return 0;
}

/* A name or a list of names, allocated by PyMem; `what` in messages */
static int read_names(model_options *o, const char *field, const char *what, PyObject *value,
                      const char ***names, size_t *count)
{
    PyObject *list = PyUnicode_Check(value) ? PyTuple_Pack(1, value) : PySequence_Tuple(value);
    if (!list)
        return raise_from_current(field, what);
    *count = (size_t)PyTuple_Size(list);
    *names = PyMem_Calloc(*count + 1, sizeof **names);
    int bad = *names ? 0 : (PyErr_NoMemory(), -1);
    for (size_t k = 0; !bad && k < *count; k++)
        bad = !((*names)[k] = name_of(field, PyTuple_GetItem(list, (Py_ssize_t)k), o->names));
    Py_DECREF(list);
    return bad ? -1 : 0;
}

/* A member of the joints of a dict. @return 0; -1 with an exception */
static int set_member(const char *field, PyObject *values, size_t member,
                      tfa_description *description)
{
    PyObject *joint, *value;
    Py_ssize_t at = 0;
    while (PyDict_Next(values, &at, &joint, &value)) {
        const char *name = PyUnicode_Check(joint) ? PyUnicode_AsUTF8AndSize(joint, NULL) : NULL;
        size_t k = 0;
        while (name && k < description->joint_count &&
               strcmp(description->joints[k].name, name) != 0)
            k++;
        if (!name || k == description->joint_count)
            return raise_status(TFA_E_JOINT, field, "%s: the file has no joint '%.200s'", field,
                                name ? name : "?");
        double number;
        if (read_numbers(field, value, 1, &number))
            return -1;
        if (!(number >= 0))
            return raise_status(TFA_E_VALUE, field, "%s: %g of joint '%.200s' must not be negative",
                                field, number, name);
        memcpy((char *)&description->joints[k] + member, &number, sizeof number);
    }
    return 0;
}

int set_joint_values(const model_options *o, tfa_description *description)
{
    const struct {
        const char *field;
        PyObject *values;
        size_t member;
    } rows[] = {{"armature", o->armature, offsetof(tfa_joint, armature)},
                {"damping", o->damping, offsetof(tfa_joint, damping)},
                {"friction", o->friction, offsetof(tfa_joint, friction)}};
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++)
        if (rows[k].values && PyDict_Check(rows[k].values) &&
            set_member(rows[k].field, rows[k].values, rows[k].member, description))
            return -1;
    return 0;
}

static int is_given(PyObject *value)
{
    return value && value != Py_None;
}

/* ---- side files ---- */

static int parse_modes(const char *text, size_t length, const char *file, void *out,
                       tfa_report *report)
{
    return tfa_modes_parse(text, length, file, out, report);
}

static int parse_constraints(const char *text, size_t length, const char *file, void *out,
                             tfa_report *report)
{
    return tfa_constraints_parse(text, length, file, out, report);
}

/* Files, or bytes of them, whose texts `*texts` gets */
static int read_side_files(const char *field, PyObject *value,
                           int (*parse)(const char *, size_t, const char *, void *, tfa_report *),
                           void *out, PyObject **texts)
{
    PyObject *list = PyList_Check(value) || PyTuple_Check(value) ? PySequence_Tuple(value)
                                                                 : PyTuple_Pack(1, value);
    *texts = PyList_New(0);
    int bad = list && *texts ? 0 : -1;
    for (Py_ssize_t k = 0; !bad && k < PyTuple_Size(list); k++) {
        PyObject *entry = PyTuple_GetItem(list, k);
        tfa_report report = {0};
        char *file = NULL;
        PyObject *text = PyBytes_Check(entry) ? Py_NewRef(entry) : read_source(entry, &file);
        const int status =
            !text ? TFA_E_ARGUMENT
                  : parse(PyBytes_AsString(text), (size_t)PyBytes_Size(text), file, out, &report);
        bad = status != TFA_OK || PyList_Append(*texts, text) < 0 ? -1 : 0;
        if (text && status != TFA_OK)
            raise_load_error(status, file, &report);
        else if (!text && PyErr_ExceptionMatches(PyExc_TypeError))
            raise_from_current(field, "must be a file, bytes, or a list of them");
        Py_XDECREF(text);
        free(file);
    }
    Py_XDECREF(list);
    return bad;
}

/* Dicts with the keys of a side file, as its text: JSON is YAML. Arrays become lists. */
static PyObject *text_of_dicts(PyObject *list)
{
    PyObject *json = PyImport_ImportModule("json"), *operators = PyImport_ImportModule("operator");
    PyObject *dumps = json ? PyObject_GetAttrString(json, "dumps") : NULL;
    PyObject *to_list =
        operators ? PyObject_CallMethod(operators, "methodcaller", "s", "tolist") : NULL;
    PyObject *args = Py_BuildValue("({sO})", "constraints", list);
    PyObject *kwargs = to_list ? Py_BuildValue("{sO}", "default", to_list) : NULL;
    PyObject *text = dumps && args && kwargs ? PyObject_Call(dumps, args, kwargs) : NULL;
    PyObject *bytes = text ? PyUnicode_AsUTF8String(text) : NULL;
    PyObject *const all[] = {json, operators, dumps, to_list, args, kwargs, text};
    for (size_t k = 0; k < sizeof all / sizeof *all; k++)
        Py_XDECREF(all[k]);
    static const char form[] = "must be dicts of texts, numbers and lists";
    if (!bytes && PyErr_ExceptionMatches(PyExc_AttributeError)) { /* no array */
        PyErr_Clear();
        raise_type("constraints", "constraints: %s", form);
    } else if (!bytes) {
        raise_from_current("constraints", form);
    }
    return bytes;
}

/* A dict, a list of dicts, or side files */
static int read_held_frames(model_options *o)
{
    PyObject *value = o->constraints, *texts = NULL, *text = NULL;
    PyObject *list = PyDict_Check(value)                           ? PyTuple_Pack(1, value)
                     : PyList_Check(value) || PyTuple_Check(value) ? PySequence_Tuple(value)
                                                                   : PyTuple_New(0);
    const int are_dicts = list && PyTuple_Size(list) && PyDict_Check(PyTuple_GetItem(list, 0));
    int bad = list && (!are_dicts || (text = text_of_dicts(list))) ? 0 : -1;
    if (!bad)
        bad = read_side_files("constraints", text ? text : value, parse_constraints,
                              &o->constraint_lists, &texts);
    if (!bad && !are_dicts)
        o->constraints_texts = Py_NewRef(texts);
    Py_XDECREF(list);
    Py_XDECREF(text);
    Py_XDECREF(texts);
    o->scene.constraints = o->constraint_lists.list;
    o->scene.constraint_count = o->constraint_lists.count;
    o->scene.actuated = o->constraint_lists.actuated;
    o->scene.actuated_count = o->constraint_lists.actuated_count;
    return bad;
}

static int read_side(model_options *o)
{
    if (is_given(o->modes) &&
        read_side_files("modes", o->modes, parse_modes, &o->link_modes, &o->modes_texts))
        return -1;
    o->scene.modes = o->link_modes.links;
    o->scene.modes_count = o->link_modes.count;
    if (is_given(o->constraints) && read_held_frames(o))
        return -1;
    if (is_given(o->actuated) && read_names(o, "actuated", "must be a list of joints", o->actuated,
                                            &o->actuated_names, &o->scene.actuated_count))
        return -1;
    if (is_given(o->actuated))
        o->scene.actuated = o->actuated_names;
    return 0;
}

static int read_scene(model_options *o)
{
    if (is_given(o->root) && !(o->scene.root = name_of("root", o->root, o->names)))
        return -1;
    if (is_given(o->tips) && read_names(o, "tips", "must be a list of links", o->tips,
                                        &o->tip_names, &o->scene.tip_count))
        return -1;
    o->scene.tips = o->tip_names;
    if (is_given(o->locked) && read_locks(o))
        return -1;
    if (is_given(o->payload) &&
        read_payloads(o->payload, o->names, &o->payloads, &o->scene.payload_count))
        return -1;
    if (is_given(o->rotors) && read_rotors(o))
        return -1;
    if (read_side(o))
        return -1;
    o->scene.payloads = o->payloads;
    if (o->scene.root || o->scene.tip_count || o->scene.lock_count || o->scene.payload_count ||
        o->scene.rotor_count || o->scene.modes_count || o->scene.constraint_count ||
        o->scene.actuated_count)
        o->c.scene = &o->scene;
    return 0;
}

static int read_flag(PyObject *value, uint32_t *flag)
{
    const int truth = is_given(value) ? PyObject_IsTrue(value) : 0; /* a dict with joints is */
    *flag = truth > 0;
    return truth < 0 ? -1 : 0;
}

int model_options_read(model_options *o)
{
    unsigned base, mimic, inertia;
    o->names = PyList_New(0);
    if (!o->names || choose_word("base", o->base, TFA_WORDS_BASE, &base) ||
        choose_word("mimic", o->mimic, TFA_WORDS_MIMIC, &mimic) ||
        choose_word("inertia", o->inertia, TFA_WORDS_INERTIA, &inertia) ||
        read_flag(o->rotor_inertia, &o->c.rotor_inertia) || read_flag(o->damping, &o->c.damping) ||
        read_flag(o->friction, &o->c.friction) ||
        read_flag(o->lock_massless_leaves, &o->c.lock_massless_leaves))
        return -1;
    o->c.base = (tfa_base)base;
    o->c.mimic = (tfa_mimic_policy)mimic;
    o->c.inertia = (tfa_inertia_policy)inertia;
    if (is_given(o->armature) && !PyDict_Check(o->armature))
        return raise_type("armature", "armature: %.100s, must be {joint: inertia}",
                          type_name(o->armature));
    if (is_given(o->gravity)) {
        if (read_numbers("gravity", o->gravity, 3, o->gravity_numbers))
            return -1;
        o->c.gravity = o->gravity_numbers;
    }
    if (is_given(o->friction_velocity) &&
        read_numbers("friction_velocity", o->friction_velocity, 1, &o->c.friction_velocity))
        return -1;
    if (is_given(o->snap) && read_numbers("snap", o->snap, 1, &o->c.snap))
        return -1;
    return read_scene(o);
}

void model_options_clear(model_options *o)
{
    PyMem_Free(o->locks);
    PyMem_Free(o->payloads);
    PyMem_Free(o->rotor_list);
    PyMem_Free(o->tip_names);
    PyMem_Free(o->actuated_names);
    tfa_modes_free(&o->link_modes);
    tfa_constraints_free(&o->constraint_lists);
    Py_XDECREF(o->modes_texts);
    Py_XDECREF(o->constraints_texts);
    Py_XDECREF(o->names);
}
