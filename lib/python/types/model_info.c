/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Attributes of a Model; checks of requests; the adviser for scenes.
 */
#include "objects.h"
#include "python/request/errors.h"
#include "python/request/records.h"

#include <math.h>
#include <totalforce/advise.h>

static const tfa_model *c_model(PyObject *self)
{
    return ((model_object *)self)->model;
}

static PyObject *get_name(PyObject *self, void *unused)
{
    (void)unused;
    return PyUnicode_FromString(tfa_model_name(c_model(self)));
}

static PyObject *get_hash(PyObject *self, void *unused)
{
    (void)unused;
    return PyUnicode_FromString(tfa_model_hash_text(c_model(self)));
}

static PyObject *get_tag(PyObject *self, void *unused)
{
    (void)unused;
    return PyUnicode_FromStringAndSize(tfa_model_hash_text(c_model(self)), 16);
}

static PyObject *get_q_count(PyObject *self, void *unused)
{
    (void)unused;
    return PyLong_FromUnsignedLong(((model_object *)self)->robot.names.q_count);
}

static PyObject *get_v_count(PyObject *self, void *unused)
{
    (void)unused;
    return PyLong_FromUnsignedLong(((model_object *)self)->robot.names.v_count);
}

static PyObject *get_base_freedoms(PyObject *self, void *unused)
{
    (void)unused;
    return PyLong_FromUnsignedLong(((model_object *)self)->robot.names.base_freedoms);
}

static PyObject *get_joint_names(PyObject *self, void *unused)
{
    (void)unused;
    return Py_NewRef(((model_object *)self)->robot.joints);
}

static PyObject *get_links(PyObject *self, void *unused)
{
    (void)unused;
    return Py_NewRef(((model_object *)self)->robot.links);
}

static PyObject *get_modes(PyObject *self, void *unused)
{
    (void)unused;
    return Py_NewRef(((model_object *)self)->robot.modes);
}

static PyObject *get_constraints(PyObject *self, void *unused)
{
    (void)unused;
    return Py_NewRef(((model_object *)self)->robot.constraints);
}

static PyObject *joint_at(const tfa_model *model, uint32_t k)
{
    const tfa_joint_info joint = tfa_model_joint(model, k);
    return record_joint(&joint);
}

static PyObject *body_at(const tfa_model *model, uint32_t k)
{
    const tfa_body_info body = tfa_model_body(model, k);
    return record_body(&body);
}

static PyObject *declared_at(const tfa_model *model, uint32_t k)
{
    const tfa_declared_joint joint = tfa_model_declared(model, k);
    return record_declared(&joint);
}

static PyObject *link_body_at(const tfa_model *model, uint32_t k)
{
    return PyLong_FromLong(tfa_model_frame(model, k).body);
}

static PyObject *tuple_of(const tfa_model *model, uint32_t count,
                          PyObject *(*at)(const tfa_model *, uint32_t))
{
    PyObject *tuple = PyTuple_New(count);
    for (uint32_t k = 0; tuple && k < count; k++) {
        PyObject *entry = at(model, k);
        if (entry)
            PyTuple_SetItem(tuple, k, entry);
        else
            Py_CLEAR(tuple);
    }
    return tuple;
}

static PyObject *get_joints(PyObject *self, void *unused)
{
    (void)unused;
    return tuple_of(c_model(self), ((model_object *)self)->robot.names.joint_count, joint_at);
}

static PyObject *get_bodies(PyObject *self, void *unused)
{
    (void)unused;
    return tuple_of(c_model(self), tfa_model_summarise(c_model(self)).bodies, body_at);
}

static PyObject *get_declared(PyObject *self, void *unused)
{
    (void)unused;
    return tuple_of(c_model(self), tfa_model_declared_count(c_model(self)), declared_at);
}

static PyObject *get_link_bodies(PyObject *self, void *unused)
{
    (void)unused;
    return tuple_of(c_model(self), ((model_object *)self)->robot.names.frame_count, link_body_at);
}

static PyObject *get_summary(PyObject *self, void *unused)
{
    (void)unused;
    const tfa_model_summary summary = tfa_model_summarise(c_model(self));
    return record_summary(&summary);
}

static PyObject *get_messages(PyObject *self, void *unused)
{
    (void)unused;
    return Py_NewRef(((model_object *)self)->messages);
}

/* Texts of the messages of one severity */
static PyObject *get_texts(PyObject *self, void *severity)
{
    const model_object *m = (const model_object *)self;
    PyObject *list = PyList_New(0);
    for (Py_ssize_t k = 0; list && k < PyTuple_Size(m->texts); k++) {
        PyObject *word = PyStructSequence_GetItem(PyTuple_GetItem(m->messages, k), 0);
        if (PyUnicode_CompareWithASCIIString(word, severity) == 0 &&
            PyList_Append(list, PyTuple_GetItem(m->texts, k)) < 0)
            Py_CLEAR(list);
    }
    return list;
}

static PyObject *get_parent(PyObject *self, void *unused)
{
    (void)unused;
    PyObject *parent = ((model_object *)self)->parent;
    return Py_NewRef(parent ? parent : Py_None);
}

PyGetSetDef model_attributes[] = {
    {"name", get_name, NULL, "Name of the robot in the file.", NULL},
    {"hash", get_hash, NULL, "SHA-256 of all constants and names, 64 hexadecimal digits.", NULL},
    {"tag", get_tag, NULL, "First 16 digits of the hash: Reply.model.", NULL},
    {"q_count", get_q_count, NULL, "Coordinates of the joints in q (n_q).", NULL},
    {"v_count", get_v_count, NULL, "Freedoms of the joints in v, tau, qdd (n_v).", NULL},
    {"base_freedoms", get_base_freedoms, NULL, "6 with a floating base, else 0.", NULL},
    {"joint_names", get_joint_names, NULL, "Names of the joints in the order of the arrays.", NULL},
    {"links", get_links, NULL, "Names of the links; the position is the frame index.", NULL},
    {"modes", get_modes, NULL, "Link of each modal coordinate.", NULL},
    {"constraints", get_constraints, NULL, "Names of the constraints of the scene.", NULL},
    {"joints", get_joints, NULL, "Joints with their places in the arrays (Joint).", NULL},
    {"bodies", get_bodies, NULL, "Mass properties of the bodies (Body).", NULL},
    {"declared", get_declared, NULL, "Joints of the file and their fates (DeclaredJoint).", NULL},
    {"link_bodies", get_link_bodies, NULL, "Body that carries each link; -1: the world.", NULL},
    {"summary", get_summary, NULL, "Sizes and totals (Summary).", NULL},
    {"messages", get_messages, NULL, "Messages of loading (Message).", NULL},
    {"warnings", get_texts, NULL, "Warnings of loading, 'FILE:LINE: warning: text [code]'.",
     "warning"},
    {"notes", get_texts, NULL, "Notes of loading, 'FILE:LINE: note: text [code]'.", "note"},
    {"parent", get_parent, NULL, "Model whose constants it shares, or None.", NULL},
    {0}};

/* Runs `use` for a request that was read. */
static PyObject *with_request(PyObject *self, tfa_op op, PyObject *const *arguments,
                              Py_ssize_t count, PyObject *names,
                              PyObject *(*use)(PyObject *, request_call *, const void *),
                              const void *context)
{
    request_call call;
    PyObject *result = NULL;
    if (call_read(&call, &((model_object *)self)->robot, 0, op, arguments, count, names) == 0)
        result = use(self, &call, context);
    call_clear(&call);
    return result;
}

static PyObject *use_check(PyObject *self, request_call *call, const void *unused)
{
    (void)unused;
    if (tfa_request_check(c_model(self), &call->request, &call->reply) == TFA_OK)
        Py_RETURN_NONE;
    raise_reply(call->robot, &call->request, &call->reply, NULL);
    return NULL;
}

static PyObject *model_check(PyObject *self, PyObject *const *arguments, Py_ssize_t count,
                             PyObject *names)
{
    tfa_op op;
    if (count < 1) {
        raise_type("op", "op: missing");
        return NULL;
    }
    return read_op(arguments[0], &op)
               ? NULL
               : with_request(self, op, arguments + 1, count - 1, names, use_check, NULL);
}

PyObject *array_of(const double *numbers, uint32_t count)
{
    npy_intp size = count;
    PyObject *array = PyArray_SimpleNew(1, &size, NPY_DOUBLE);
    if (array && count)
        memcpy(PyArray_DATA((PyArrayObject *)array), numbers, count * sizeof *numbers);
    return array;
}

static PyObject *make_advice(const robot_names *robot, const tfa_advice *advice)
{
    PyObject *joints = PyList_New(0), *q = array_of(advice->q, robot->names.q_count);
    PyObject *errors = array_of(advice->single_error, robot->names.joint_count), *made = NULL;
    for (uint32_t k = 0; joints && k < advice->count; k++)
        if (PyList_Append(joints, PyTuple_GetItem(robot->joints, advice->joints[k])) < 0)
            Py_CLEAR(joints);
    if (joints && q && errors)
        made = record_advice(joints, advice->freedoms, q, errors, advice->error, advice->state);
    Py_XDECREF(joints);
    Py_XDECREF(q);
    Py_XDECREF(errors);
    return made;
}

static PyObject *use_advise(PyObject *self, request_call *call, const void *tolerance)
{
    tfa_advice advice;
    PyObject *made = NULL;
    int status;
    Py_BEGIN_ALLOW_THREADS status = tfa_advise(c_model(self), &call->request,
                                               *(const double *)tolerance, &advice, &call->reply);
    Py_END_ALLOW_THREADS if (status == TFA_OK)
    {
        made = make_advice(call->robot, &advice);
        tfa_advice_free(&advice);
    }
    else if (call->reply.status != TFA_OK)
    {
        raise_reply(call->robot, &call->request, &call->reply, NULL);
    }
    else
    {
        raise_status(status, status == TFA_E_ARGUMENT ? "tolerance" : NULL, "advise: %s: %s",
                     tfa_status_text(status), tfa_status_cause(status));
    }
    return made;
}

static PyObject *model_advise(PyObject *self, PyObject *const *arguments, Py_ssize_t count,
                              PyObject *names)
{
    const double tolerance = count < 1 ? -1 : PyFloat_AsDouble(arguments[0]);
    if (count < 1)
        raise_type("tolerance", "tolerance: missing");
    else if (!PyErr_Occurred() && !(tolerance > 0 && isfinite(tolerance)))
        raise_status(TFA_E_ARGUMENT, "tolerance", "tolerance: %g, must be above 0", tolerance);
    if (PyErr_Occurred())
        return NULL;
    return with_request(self, TFA_OP_FORWARD_DYNAMICS, arguments + 1, count - 1, names, use_advise,
                        &tolerance);
}

static PyObject *model_parameters(PyObject *self, PyObject *link)
{
    uint32_t frame;
    if (robot_find_link(&((model_object *)self)->robot, "link", link, &frame))
        return NULL;
    double p[TFA_LINK_PARAMETERS];
    tfa_model_parameters(c_model(self), frame, p);
    return array_of(p, TFA_LINK_PARAMETERS);
}

PyMethodDef model_methods[] = {
    {"check", (PyCFunction)(void (*)(void))model_check, METH_FASTCALL | METH_KEYWORDS,
     "check($self, op, /, *args, **fields)\n--\n\n"
     "Checks a request without computing it: raises the exception that the op's method would."},
    {"advise", (PyCFunction)(void (*)(void))model_advise, METH_FASTCALL | METH_KEYWORDS,
     "advise($self, tolerance, /, *args, **fields)\n--\n\n"
     "Joints that a scene may lock without changing accelerations by more than `tolerance`.\n\n"
     "The error is relative, in the energy norm |x - y|_M / |x|_M. `args` and `fields` are those\n"
     "of forward_dynamics, for a batch of states. Returns Advice. Cost: 6 solves for each joint\n"
     "and state."},
    {"parameters", model_parameters, METH_O,
     "parameters($self, link, /)\n--\n\n"
     "Inertial parameters of the body that carries a link, in its frame, as regressor multiplies\n"
     "them: mass, mass times centre (3), inertia about the link's origin (ixx ixy ixz iyy iyz "
     "izz)."},
    {0}};
