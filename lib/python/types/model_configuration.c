/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Configurations of a Model: integrate, difference, neutral, random_configuration, joint_limits.
 */
#include "objects.h"
#include "python/request/errors.h"
#include "python/request/read.h"
#include "python/request/records.h"

#include <math.h>
#include <totalforce/configuration.h>
#include <totalforce/limits.h>

/* q, velocities and base as a request; q and v may be records with both parts. */
static int read_state(request_call *call, PyObject *self, PyObject *q, PyObject *base_pose,
                      PyObject *v, PyObject *base_twist)
{
    const model_object *m = (const model_object *)self;
    static PyObject *names;
    PyObject *values[] = {q, base_pose, v, base_twist};
    for (int k = 0; k < 4; k += 2)
        if (is_record_pair(values[k])) {
            values[k + 1] = PyStructSequence_GetItem(values[k], 1);
            values[k] = PyStructSequence_GetItem(values[k], 0);
        }
    if (!names)
        names = Py_BuildValue("(ssss)", "q", "base_pose", "v", "base_twist");
    if (!names || call_read(call, &m->robot, 0, TFA_OP_KINEMATICS, values, 0, names))
        return -1;
    if (tfa_request_check(m->model, &call->request, &call->reply) != TFA_OK)
        return raise_reply(call->robot, &call->request, &call->reply, NULL);
    return 0;
}

/* Two arrays for each state, which become a record; the second one is None with a fixed base. */
typedef struct pair {
    PyObject *joints, *base;
    double *of_joints, *of_base;
} pair;

static PyObject *new_array(int is_batch, uint32_t count, uint32_t width, double **numbers)
{
    npy_intp shape[2] = {count, width};
    PyObject *array = PyArray_SimpleNew(1 + is_batch, shape + !is_batch, NPY_DOUBLE);
    *numbers = array ? PyArray_DATA((PyArrayObject *)array) : NULL;
    return array;
}

static int pair_init(pair *p, const robot_names *robot, int is_batch, uint32_t count, int of_q)
{
    const uint32_t width = of_q ? robot->names.q_count : robot->names.v_count;
    *p = (pair){0};
    p->joints = new_array(is_batch, count, width, &p->of_joints);
    p->base = robot->names.base_freedoms ? new_array(is_batch, count, of_q ? 7 : 6, &p->of_base)
                                         : Py_NewRef(Py_None);
    if (p->joints && p->base)
        return 0;
    Py_XDECREF(p->joints);
    Py_XDECREF(p->base);
    return -1;
}

/* Row k of an array of states; NULL of none */
#define ROW(numbers, k, width) ((numbers) ? (numbers) + (size_t)(k) * (width) : NULL)

static PyObject *integrate(PyObject *self, PyObject *args, PyObject *kwargs)
{
    static char *keywords[] = {"q", "v", "base_pose", "base_twist", "dt", NULL};
    const model_object *m = (const model_object *)self;
    PyObject *q, *v = Py_None, *pose = Py_None, *twist = Py_None, *made = NULL;
    const size_t n_q = m->robot.names.q_count, n_v = m->robot.names.v_count;
    double dt = 1;
    request_call call;
    pair p;
    if (!PyArg_ParseTupleAndKeywords(args, kwargs, "O|O$OOd:integrate", keywords, &q, &v, &pose,
                                     &twist, &dt))
        return NULL;
    if (!isfinite(dt)) {
        raise_status(TFA_E_VALUE, "dt", "dt: %g, must be finite, s", dt);
        return NULL;
    }
    const tfa_request *r = &call.request;
    if (read_state(&call, self, q, pose, v, twist) == 0 &&
        pair_init(&p, &m->robot, call.is_batch, r->count, 1) == 0) {
        for (uint32_t k = 0; k < r->count; k++) {
            double *to = p.of_joints + k * n_q, *base = ROW(p.of_base, k, 7);
            memcpy(to, r->q + k * n_q, n_q * sizeof *to);
            if (base)
                memcpy(base, r->base_pose + (size_t)k * 7, 7 * sizeof *base);
            tfa_integrate(m->model, ROW(r->v, k, n_v), ROW(r->base_twist, k, 6), dt, to, base);
        }
        made = record_configuration(p.joints, p.base);
    }
    call_clear(&call);
    return made;
}

/* The exception that is set says which of two configurations it is about. */
static void name_second(void)
{
    PyObject *type, *value, *trace;
    PyErr_Fetch(&type, &value, &trace);
    PyErr_NormalizeException(&type, &value, &trace);
    PyObject *args = Py_BuildValue("(N)", PyUnicode_FromFormat("to: %S", value));
    if (args)
        PyObject_SetAttrString(value, "args", args);
    Py_XDECREF(args);
    PyErr_Restore(type, value, trace);
}

static PyObject *compare(const model_object *m, const request_call *a, const request_call *b)
{
    const tfa_request *from = &a->request, *to = &b->request;
    const size_t n_q = m->robot.names.q_count, n_v = m->robot.names.v_count;
    const uint32_t count = a->is_batch ? from->count : to->count;
    pair p;
    if (a->is_batch && b->is_batch && from->count != to->count) {
        raise_status(TFA_E_SIZE, "to", "to: %u states, q has %u", to->count, from->count);
        return NULL;
    }
    if (pair_init(&p, &m->robot, a->is_batch || b->is_batch, count, 0))
        return NULL;
    for (size_t k = 0; k < count; k++) {
        const size_t i = a->is_batch ? k : 0, j = b->is_batch ? k : 0;
        tfa_difference(m->model, from->q + i * n_q, ROW(from->base_pose, i, 7), to->q + j * n_q,
                       ROW(to->base_pose, j, 7), p.of_joints + k * n_v, ROW(p.of_base, k, 6));
    }
    return record_velocity(p.joints, p.base);
}

static PyObject *difference(PyObject *self, PyObject *args, PyObject *kwargs)
{
    static char *keywords[] = {"q", "to", "base_pose", "base_pose_to", NULL};
    PyObject *q, *to, *pose = Py_None, *pose_to = Py_None, *made = NULL;
    request_call first, second;
    if (!PyArg_ParseTupleAndKeywords(args, kwargs, "OO|$OO:difference", keywords, &q, &to, &pose,
                                     &pose_to))
        return NULL;
    if (read_state(&first, self, q, pose, Py_None, Py_None) == 0) {
        if (read_state(&second, self, to, pose_to, Py_None, Py_None) == 0)
            made = compare((const model_object *)self, &first, &second);
        else
            name_second();
        call_clear(&second);
    }
    call_clear(&first);
    return made;
}

static PyObject *neutral(PyObject *self, PyObject *unused)
{
    const model_object *m = (const model_object *)self;
    pair p;
    (void)unused;
    if (pair_init(&p, &m->robot, 0, 1, 1))
        return NULL;
    tfa_neutral(m->model, p.of_joints, p.of_base);
    return record_configuration(p.joints, p.base);
}

static PyObject *random_configuration(PyObject *self, PyObject *args, PyObject *kwargs)
{
    static char *keywords[] = {"seed", "count", NULL};
    PyObject *seed = Py_None, *count = Py_None, *made = NULL;
    if (!PyArg_ParseTupleAndKeywords(args, kwargs, "|OO:random_configuration", keywords, &seed,
                                     &count))
        return NULL;
    PyObject *module = PyImport_ImportModule("totalforce.configuration");
    PyObject *drawn = module ? PyObject_CallMethod(module, "draw", "OOO", self, seed, count) : NULL;
    PyObject *q, *base;
    if (drawn && PyArg_ParseTuple(drawn, "OO", &q, &base))
        made = record_configuration(Py_NewRef(q), Py_NewRef(base));
    Py_XDECREF(drawn);
    Py_XDECREF(module);
    return made;
}

/* ---- limits of the file ---- */

PyObject *limits_of_joints(PyObject *source, PyObject *names)
{
    const size_t count = (size_t)PyTuple_Size(names);
    const char **list = PyMem_Calloc(count + 1, sizeof *list);
    tfa_joint_limits *limits = PyMem_Calloc(count + 1, sizeof *limits);
    PyObject *made = list && limits ? PyDict_New() : PyErr_NoMemory();
    for (size_t k = 0; made && k < count; k++) {
        PyObject *name = PyTuple_GetItem(names, (Py_ssize_t)k);
        list[k] = PyUnicode_Check(name) ? PyUnicode_AsUTF8AndSize(name, NULL) : NULL;
        if (list[k])
            continue;
        if (!PyErr_Occurred())
            raise_type("names", "names: %.100s, must be a str", type_name(name));
        Py_CLEAR(made);
    }
    const int status = made ? tfa_urdf_limits(PyBytes_AsString(source),
                                              (size_t)PyBytes_Size(source), list, count, limits)
                            : TFA_OK;
    if (status != TFA_OK) {
        raise_status(status, NULL, "limits: %s: %s", tfa_status_text(status),
                     tfa_status_cause(status));
        Py_CLEAR(made);
    }
    for (size_t k = 0; made && k < count; k++) {
        PyObject *limit = record_limits(&limits[k]);
        if (!limit || PyDict_SetItem(made, PyTuple_GetItem(names, (Py_ssize_t)k), limit) < 0)
            Py_CLEAR(made);
        Py_XDECREF(limit);
    }
    PyMem_Free(list);
    PyMem_Free(limits);
    return made;
}

static PyObject *joint_limits(PyObject *self, PyObject *args, PyObject *kwargs)
{
    static char *keywords[] = {"names", NULL};
    const model_object *m = (const model_object *)self;
    PyObject *names = Py_None;
    if (!PyArg_ParseTupleAndKeywords(args, kwargs, "|O:joint_limits", keywords, &names))
        return NULL;
    while (!m->source)
        m = (const model_object *)m->parent;
    names = names == Py_None ? Py_NewRef(m->robot.joints) : PySequence_Tuple(names);
    PyObject *made = names ? limits_of_joints(m->source, names) : NULL;
    Py_XDECREF(names);
    return made;
}

#define METHOD(function) (PyCFunction)(void (*)(void)) function, METH_VARARGS | METH_KEYWORDS

PyMethodDef configuration_methods[] = {
    {"integrate", METHOD(integrate),
     "integrate($self, /, q, v=None, *, base_pose=None, base_twist=None, dt=1.0)\n--\n\n"
     "The configuration after `dt` seconds at constant velocities, dt of any sign.\n\n"
     "Quaternions and planar joints move on their group: exactly, along the screw of the twist.\n"
     "q: (n_q,), (count, n_q) or a Configuration; v likewise or a Velocity; None: at rest.\n"
     "Returns Configuration."},
    {"difference", METHOD(difference),
     "difference($self, /, q, to, *, base_pose=None, base_pose_to=None)\n--\n\n"
     "The velocities that lead from q to `to` in 1 s: integrate(q, difference(q, to)) is `to`.\n\n"
     "Turns are the short way, at most pi; those of revolute joints are the plain difference.\n"
     "q, to: (n_q,), (count, n_q) or Configuration. Returns Velocity."},
    {"neutral", neutral, METH_NOARGS,
     "neutral($self, /)\n--\n\nThe identity: zeros, quaternions 0 0 0 1. Returns Configuration."},
    {"random_configuration", METHOD(random_configuration),
     "random_configuration($self, /, seed=None, count=None)\n--\n\n"
     "Draws uniformly within the position limits of the file, those of followers included.\n\n"
     "Without limits: angles within pi, lengths within 1 m, rotations uniform. seed: int or\n"
     "numpy.random.Generator. count: states of a batch. Returns Configuration."},
    {"joint_limits", METHOD(joint_limits),
     "joint_limits($self, /, names=None)\n--\n\n"
     "Limits of joints, as the file states them: {joint: JointLimits}. No answer uses them.\n\n"
     "names: joints of the file; None: joint_names."},
    {0}};
