/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Type Model: loading, deriving, pickling, releasing.
 */
#include "mechanism/move.h"
#include "objects.h"
#include "python/request/errors.h"
#include "python/request/records.h"

#include <errno.h>
#include <pthread.h>

/* urdfdom's log handler is global: one load at a time, without the GIL */
static pthread_mutex_t load_lock = PTHREAD_MUTEX_INITIALIZER;

/* How messages name options */
static tfa_option_syntax report_syntax = TFA_SYNTAX_PYTHON;

PyObject *model_speak_command_line(PyObject *module, PyObject *unused)
{
    (void)module;
    (void)unused;
    report_syntax = TFA_SYNTAX_COMMAND_LINE;
    Py_RETURN_NONE;
}

static void unlock_in_child(void)
{
    load_lock = (pthread_mutex_t)PTHREAD_MUTEX_INITIALIZER;
}

static void model_dealloc(PyObject *self)
{
    model_object *m = (model_object *)self;
    tfa_model_free(m->model);
    robot_clear(&m->robot);
    Py_XDECREF(m->parent);
    Py_XDECREF(m->messages);
    Py_XDECREF(m->texts);
    Py_XDECREF(m->source);
    Py_XDECREF(m->file);
    Py_XDECREF(m->options);
    object_free(self);
}

/* Messages of a report: records, and "FILE:LINE: severity: text [code]". */
static int keep_report(const tfa_report *report, PyObject **messages, PyObject **texts)
{
    const Py_ssize_t count = (Py_ssize_t)report->count;
    *messages = PyTuple_New(count);
    *texts = PyTuple_New(count);
    for (Py_ssize_t k = 0; *messages && *texts && k < count; k++) {
        char line[ERROR_TEXT];
        tfa_report_format(report, (size_t)k, line, sizeof line);
        PyObject *message = record_message(report, (size_t)k);
        PyObject *text = PyUnicode_DecodeUTF8(line, (Py_ssize_t)strlen(line), "replace");
        if (message)
            PyTuple_SetItem(*messages, k, message);
        if (text)
            PyTuple_SetItem(*texts, k, text);
        if (!message || !text)
            return -1;
    }
    return *messages && *texts ? 0 : -1;
}

/* A Model of a compiled model, which it owns from then on, in either case. */
static PyObject *wrap(PyTypeObject *type, tfa_model *model, const tfa_report *report,
                      PyObject *parent)
{
    model_object *m = (model_object *)PyType_GenericAlloc(type, 0);
    if (!m) {
        tfa_model_free(model);
        return NULL;
    }
    m->model = model;
    m->parent = Py_XNewRef(parent);
    if (robot_from_model(&m->robot, model) || keep_report(report, &m->messages, &m->texts)) {
        Py_DECREF(m);
        return NULL;
    }
    return (PyObject *)m;
}

/* Wraps a model or raises its report; releases the report. */
static PyObject *finish(PyTypeObject *type, int status, tfa_model *model, const char *path,
                        tfa_report *report, PyObject *parent)
{
    const int error = errno;
    PyObject *made = NULL, *messages = NULL, *texts = NULL;
    if (status == TFA_OK) {
        made = wrap(type, model, report, parent);
    } else if (keep_report(report, &messages, &texts) == 0) {
        errno = error;
        raise_report(status, path, report, messages);
    }
    Py_XDECREF(messages);
    Py_XDECREF(texts);
    tfa_report_free(report);
    return made;
}

PyObject *raise_load_error(int status, const char *path, tfa_report *report)
{
    return finish(model_type, status, NULL, path, report, NULL);
}

static char *keywords[] = {"",
                           "base",
                           "gravity",
                           "rotor_inertia",
                           "damping",
                           "friction",
                           "friction_velocity",
                           "lock_massless_leaves",
                           "inertia",
                           "mimic",
                           "snap",
                           "root",
                           "tips",
                           "locked",
                           "payload",
                           "armature",
                           "rotors",
                           "modes",
                           "constraints",
                           "actuated",
                           NULL};

static int parse_options(PyObject *args, PyObject *kwargs, const char *format, PyObject **source,
                         model_options *o)
{
    return PyArg_ParseTupleAndKeywords(
               args, kwargs, format, keywords, source, &o->base, &o->gravity, &o->rotor_inertia,
               &o->damping, &o->friction, &o->friction_velocity, &o->lock_massless_leaves,
               &o->inertia, &o->mimic, &o->snap, &o->root, &o->tips, &o->locked, &o->payload,
               &o->armature, &o->rotors, &o->modes, &o->constraints, &o->actuated)
               ? 0
               : -1;
}

/* ---- what makes a model again ---- */

/* A deep copy of the options before they are read: their owner may change them, and iterators end.
 * NULL without an exception where there is none. */
static PyObject *copy_options(PyObject *kwargs)
{
    if (!kwargs || PyDict_Size(kwargs) == 0)
        return PyDict_New();
    PyObject *copy = PyImport_ImportModule("copy");
    PyObject *made = copy ? PyObject_CallMethod(copy, "deepcopy", "O", kwargs) : NULL;
    Py_XDECREF(copy);
    PyErr_Clear(); /* a generator, for one */
    return made;
}

/* Keeps source, file and the copy of the options in a model that was made, with the texts of its
 * side files, if any, in place of their names. `options` NULL: it has none. */
static PyObject *remember(PyObject *made, PyObject *source, const char *file, PyObject *copy,
                          const model_options *options)
{
    model_object *m = (model_object *)made;
    if (!m)
        return NULL;
    m->source = Py_XNewRef(source);
    m->file = file ? PyUnicode_DecodeFSDefault(file) : Py_NewRef(Py_None);
    m->options = Py_XNewRef(copy);
    if (copy && options && options->modes_texts &&
        PyDict_SetItemString(copy, "modes", options->modes_texts) < 0)
        Py_CLEAR(made);
    if (made && copy && options && options->constraints_texts &&
        PyDict_SetItemString(copy, "constraints", options->constraints_texts) < 0)
        Py_CLEAR(made);
    if (made && !m->file)
        Py_CLEAR(made);
    return made;
}

/* random: NULL, or every number moves to a neighbour or stays (move.h) */
static PyObject *compile_source(PyTypeObject *type, PyObject *source, const char *file,
                                const model_options *options, PyObject *copy, uint64_t *random)
{
    tfa_report report = {.syntax = report_syntax};
    tfa_model *model = NULL;
    tfa_description *description = NULL;
    const char *text = PyBytes_AsString(source);
    const size_t length = (size_t)PyBytes_Size(source);
    int status;
    Py_BEGIN_ALLOW_THREADS pthread_mutex_lock(&load_lock);
    status = tfa_urdf_parse(text, length, file, &description, &report);
    pthread_mutex_unlock(&load_lock);
    Py_END_ALLOW_THREADS if (status == TFA_OK && set_joint_values(options, description))
    {
        tfa_description_free(description);
        tfa_report_free(&report);
        return NULL;
    }
    Py_BEGIN_ALLOW_THREADS if (status == TFA_OK && random) move_description(random, description);
    if (status == TFA_OK)
        status = tfa_model_create(description, &options->c, &report, &model);
    tfa_description_free(description);
    Py_END_ALLOW_THREADS return remember(finish(type, status, model, file, &report, NULL), source,
                                         file, copy, options);
}

/* The bytes of a str or of an object like bytes, a new reference; NULL with an exception. */
static PyObject *bytes_of(PyObject *source)
{
    PyObject *bytes = PyUnicode_Check(source)        ? PyUnicode_AsUTF8String(source)
                      : PyObject_CheckBuffer(source) ? PyBytes_FromObject(source)
                                                     : NULL;
    if (!bytes && !PyErr_Occurred())
        raise_type("text", "text: %.100s, must be URDF as str or bytes", type_name(source));
    else if (!bytes)
        raise_from_current("text", "must be URDF as str or bytes");
    return bytes;
}

/* 1: the text of a URDF where the name of a file may stand: no name starts with '<'. */
static int is_text(PyObject *source)
{
    const char *text = PyUnicode_Check(source) ? PyUnicode_AsUTF8AndSize(source, NULL)
                       : PyBytes_Check(source) ? PyBytes_AsString(source)
                                               : "";
    PyErr_Clear(); /* a name with surrogates */
    if (text && strncmp(text, "\xef\xbb\xbf", 3) == 0)
        text += 3;
    return text && text[strspn(text, " \t\r\n")] == '<';
}

PyObject *read_source(PyObject *source, char **file)
{
    PyObject *path = NULL, *bytes = NULL;
    tfa_report report = {0};
    char *text;
    size_t length;
    int status;
    *file = NULL;
    if (is_text(source))
        return bytes_of(source);
    if (!PyUnicode_FSConverter(source, &path))
        return NULL;
    const char *name = PyBytes_AsString(path);
    Py_BEGIN_ALLOW_THREADS status = tfa_urdf_read(name, &text, &length, &report);
    Py_END_ALLOW_THREADS if (status == TFA_OK)
    {
        bytes = PyBytes_FromStringAndSize(text, (Py_ssize_t)length);
        free(text);
        *file = strdup(report.file ? report.file : name);
        tfa_report_free(&report);
    }
    else
    {
        raise_load_error(status, report.file ? report.file : name, &report);
    }
    Py_DECREF(path);
    return bytes;
}

static PyObject *model_new(PyTypeObject *type, PyObject *args, PyObject *kwargs)
{
    model_options options = {0};
    PyObject *source = NULL, *bytes = NULL, *made = NULL, *copy = copy_options(kwargs);
    char *file = NULL;
    if (parse_options(args, kwargs, "O|$OOOOOOOOOOOOOOOOOOO:Model", &source, &options) == 0 &&
        model_options_read(&options) == 0 && (bytes = read_source(source, &file)))
        made = compile_source(type, bytes, file, &options, copy, NULL);
    Py_XDECREF(bytes);
    Py_XDECREF(copy);
    free(file);
    model_options_clear(&options);
    return made;
}

/* Model.parse, and with a file's name what makes a pickled model again. */
static PyObject *parse_model(PyTypeObject *type, PyObject *args, const char *file, PyObject *kwargs)
{
    model_options options = {0};
    PyObject *source = NULL, *bytes = NULL, *made = NULL, *copy = copy_options(kwargs);
    if (parse_options(args, kwargs, "O|$OOOOOOOOOOOOOOOOOOO:parse", &source, &options) == 0 &&
        model_options_read(&options) == 0 && (bytes = bytes_of(source)))
        made = compile_source(type, bytes, file, &options, copy, NULL);
    Py_XDECREF(bytes);
    Py_XDECREF(copy);
    model_options_clear(&options);
    return made;
}

static PyObject *model_parse(PyObject *type, PyObject *args, PyObject *kwargs)
{
    return parse_model((PyTypeObject *)type, args, NULL, kwargs);
}

static PyObject *model_derive(PyObject *self, PyObject *args, PyObject *kwargs)
{
    static char *names[] = {"gravity", "payload", NULL};
    const model_object *m = (const model_object *)self;
    model_options options = {0};
    PyObject *made = NULL, *copy = copy_options(kwargs);
    if (PyArg_ParseTupleAndKeywords(args, kwargs, "|$OO:derive", names, &options.gravity,
                                    &options.payload) &&
        model_options_read(&options) == 0) {
        tfa_report report = {.syntax = report_syntax};
        tfa_model *model = NULL;
        int status;
        Py_BEGIN_ALLOW_THREADS status =
            tfa_model_derive(m->model, options.c.gravity, options.payloads,
                             options.scene.payload_count, &report, &model);
        Py_END_ALLOW_THREADS made = remember(
            finish(Py_TYPE(self), status, model, NULL, &report, self), NULL, NULL, copy, NULL);
    }
    Py_XDECREF(copy);
    model_options_clear(&options);
    return made;
}

/* ---- pickling: text and options, of a derived model its parent and options ---- */

static PyObject *model_reduce(PyObject *self, PyObject *unused)
{
    const model_object *m = (const model_object *)self;
    (void)unused;
    if (!m->options)
        return PyErr_Format(PyExc_TypeError,
                            "a Model cannot be pickled whose options cannot be copied: give lists");
    PyObject *restore = PyObject_GetAttrString((PyObject *)Py_TYPE(self), "_restore");
    if (!restore)
        return NULL;
    return m->source ? Py_BuildValue("N(OOO)", restore, m->source, m->file, m->options)
                     : Py_BuildValue("N(OOO)", restore, Py_None, m->parent, m->options);
}

/* _restore(text, file, options), or _restore(None, parent, options) */
static PyObject *model_restore(PyObject *type, PyObject *args)
{
    PyObject *text, *origin, *options, *made = NULL, *name = NULL;
    if (!PyArg_ParseTuple(args, "OOO!:_restore", &text, &origin, &PyDict_Type, &options))
        return NULL;
    if (text == Py_None && PyObject_TypeCheck(origin, model_type)) {
        PyObject *none = PyTuple_New(0);
        made = none ? model_derive(origin, none, options) : NULL;
        Py_XDECREF(none);
    } else if (origin == Py_None || PyUnicode_FSConverter(origin, &name)) {
        PyObject *one = PyTuple_Pack(1, text);
        made = one ? parse_model((PyTypeObject *)type, one, name ? PyBytes_AsString(name) : NULL,
                                 options)
                   : NULL;
        Py_XDECREF(one);
        Py_XDECREF(name);
    }
    return made;
}

/* _moved(random): the model with every number moved to a neighbour or not, and rotations rounded to
 * double. It cannot be pickled: no URDF says what it is. */
static PyObject *model_moved(PyObject *self, PyObject *seed)
{
    const model_object *m = (const model_object *)self;
    uint64_t random = PyLong_AsUnsignedLongLongMask(seed);
    model_options options = {0};
    PyObject *source, *made = NULL;
    if (PyErr_Occurred())
        return NULL;
    if (!m->source || !m->options)
        return PyErr_Format(PyExc_TypeError, "_moved: not of a model of URDF and plain options");
    PyObject *one = PyTuple_Pack(1, m->source);
    if (one &&
        parse_options(one, m->options, "O|$OOOOOOOOOOOOOOOOOOO:_moved", &source, &options) == 0 &&
        model_options_read(&options) == 0)
        made = compile_source(Py_TYPE(self), source, NULL, &options, NULL, &random);
    Py_XDECREF(one);
    model_options_clear(&options);
    return made;
}

static PyObject *model_repr(PyObject *self)
{
    const robot_names *robot = &((const model_object *)self)->robot;
    return PyUnicode_FromFormat("<totalforce.Model '%s': %u joints, %u links, %s base>",
                                tfa_model_name(((const model_object *)self)->model),
                                robot->names.joint_count, robot->names.frame_count,
                                tfa_word(TFA_WORDS_BASE, robot->names.base_freedoms > 0));
}

#define OPTIONS_TEXT                                                                               \
    "base : 'fixed' or 'floating'\n"                                                               \
    "        connection of the root link to the world; None: 'fixed'\n"                            \
    "gravity : (3,)\n"                                                                             \
    "        m/s^2, world axes; None: 0 0 -9.80665\n"                                              \
    "rotor_inertia : bool\n"                                                                       \
    "        apply those of the file; None: False\n"                                               \
    "damping, friction : bool or {joint: value}\n"                                                 \
    "        apply those of the file, or of these joints other values; None: False\n"              \
    "friction_velocity : float\n"                                                                  \
    "        rad/s or m/s: slower joints have part of their friction, at rest none; None: 0.01\n"  \
    "lock_massless_leaves : bool\n"                                                                \
    "        joints that move nothing with mass become fixed; None: they are an error\n"           \
    "inertia : 'strict', 'warn', 'repair' or 'strict-physical'\n"                                  \
    "        policy for inertias that no body can have; None: 'strict'\n"                          \
    "mimic : 'free', 'project' or 'lock'\n"                                                        \
    "        policy for joints that mimic others; None: 'free'\n"                                  \
    "snap : float\n"                                                                               \
    "        rad, up to 0.01: rotations this close to right angles become exactly that\n"          \
    "root : str\n"                                                                                 \
    "        only the subtree of this link\n"                                                      \
    "tips : list of str\n"                                                                         \
    "        fixed base: only the trees that carry one of these links\n"                           \
    "locked : {joint: position} or list of joints\n"                                               \
    "        joints that become fixed there, or at 0; rad or m\n"                                  \
    "payload : dict, or list of dicts\n"                                                           \
    "        {'link': name, 'mass': kg, 'com': (3,) m, 'inertia': (6,) kg m^2}, in link axes,\n"   \
    "        inertia ixx ixy ixz iyy iyz izz about the centre of mass\n"                           \
    "armature : {joint: inertia}\n"                                                                \
    "        reflected rotor inertias, kg m^2 or kg; URDF cannot say them\n"                       \
    "rotors : {joint: inertia}\n"                                                                  \
    "        about their own axes, kg m^2: times the square of the joint's reduction in the "      \
    "file\n"                                                                                       \
    "        added to its armature\n"                                                              \
    "modes : path, bytes, or list of them\n"                                                       \
    "        files with the modes of flexible links, or their text as bytes; YAML\n"               \
    "constraints : list of dicts, path, bytes, or list of them\n"                                  \
    "        {'name': name, 'first': frame, 'second': frame, 'hold': 'point', 'hinge', 'weld' "    \
    "or\n"                                                                                         \
    "        a list of 'x' to 'rz', 'unilateral': bool}, frame: {'link': name, 'xyz': (3,) m,\n"   \
    "        'rpy': (3,) rad}; or files of them; first: the world when absent\n"                   \
    "actuated : list of str\n"                                                                     \
    "        joints with a motor; None: those of the files of constraints, else all\n"

#define OPTIONS_SIGNATURE                                                                          \
    ", /, *, base=None, gravity=None, rotor_inertia=None, damping=None, friction=None, "           \
    "friction_velocity=None, lock_massless_leaves=None, inertia=None, mimic=None, snap=None, "     \
    "root=None, tips=None, locked=None, payload=None, armature=None, rotors=None, modes=None, "    \
    "constraints=None, actuated=None)\n--\n\n"

static PyMethodDef factories[] = {
    {"parse", (PyCFunction)(void (*)(void))model_parse, METH_VARARGS | METH_KEYWORDS | METH_CLASS,
     "parse($type, text" OPTIONS_SIGNATURE
     "Compiles URDF given as str or bytes. Options as those of Model."},
    {"derive", (PyCFunction)(void (*)(void))model_derive, METH_VARARGS | METH_KEYWORDS,
     "derive($self, /, *, gravity=None, payload=None)\n--\n\n"
     "A model that shares the constants of this one and differs in gravity or payloads.\n\n"
     "None: those of this model. Cost: O(N)."},
    {"__reduce__", model_reduce, METH_NOARGS, NULL},
    {"_moved", model_moved, METH_O, NULL},
    {"_restore", model_restore, METH_VARARGS | METH_CLASS, NULL},
    {0}};

PyTypeObject *model_type;

/* factories, then those of the other files */
static PyMethodDef all_methods[24];

static const type_members model_members = {
    .name = "totalforce.Model",
    .doc =
        "Model(path" OPTIONS_SIGNATURE
        "A robot compiled for computing: constant, shared by all threads.\n\n"
        "Parameters\n----------\n"
        "path : str or os.PathLike\n"
        "        URDF file; package://PACKAGE/FILE, $(find PACKAGE)/FILE, ~/FILE and\n"
        "        file:///PATH are expanded; URDF itself, as str or bytes, is parsed\n" OPTIONS_TEXT
        "\nRaises\n------\n"
        "LoadError\n"
        "        with the messages of the report: file, line, problem, remedy\n",
    .size = sizeof(model_object),
    .dealloc = model_dealloc,
    .repr = model_repr,
    .attributes = model_attributes,
    .methods = all_methods,
    .make = model_new,
};

int model_init(PyObject *module)
{
    static int registered;
    int count = 0;
    if (!registered && pthread_atfork(NULL, NULL, unlock_in_child) == 0)
        registered = 1;
    for (const PyMethodDef *own = factories; own->ml_name; own++)
        all_methods[count++] = *own;
    for (const PyMethodDef *own = model_methods; own->ml_name; own++)
        all_methods[count++] = *own;
    for (const PyMethodDef *own = configuration_methods; own->ml_name; own++)
        all_methods[count++] = *own;
    return add_type(module, &model_members, &model_type);
}
