/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Type Workspace.
 */
#include "objects.h"
#include "python/request/errors.h"
#include "python/request/read.h"

#include <stddef.h>

int read_precision(PyObject *precision, PyObject *residual, tfa_precision *p, tfa_residual *r)
{
    unsigned k, l;
    if (choose_word("precision", precision, TFA_WORDS_PRECISION, &k) ||
        choose_word("residual", residual, TFA_WORDS_RESIDUAL, &l))
        return -1;
    *p = (tfa_precision)k;
    *r = (tfa_residual)l;
    return 0;
}

int read_methods(PyObject *value, uint32_t *methods)
{
    *methods = 0;
    if (!value || value == Py_None)
        return 0;
    PyObject *list = PyUnicode_Check(value) ? PyTuple_Pack(1, value) : PySequence_Tuple(value);
    if (!list)
        return raise_from_current("methods", "must be a list of methods");
    int bad = 0;
    for (Py_ssize_t k = 0; !bad && k < PyTuple_Size(list); k++) {
        PyObject *entry = PyTuple_GetItem(list, k);
        const char *name = PyUnicode_Check(entry) ? PyUnicode_AsUTF8AndSize(entry, NULL) : NULL;
        const int32_t method = name ? tfa_method_find(name) : -1;
        if (method < 0)
            bad = raise_status(TFA_E_METHOD, "methods", "methods: no '%.200s'", name ? name : "?");
        else
            *methods |= TFA_METHOD_BIT(method);
    }
    Py_DECREF(list);
    return bad;
}

int read_specialised(PyObject *value, const tfa_specialised **specialised)
{
    *specialised = NULL;
    if (!value || value == Py_None)
        return 0;
    if (!Py_IS_TYPE(value, specialised_type))
        return raise_type("specialised", "specialised: %.100s, must be a Specialised",
                          type_name(value));
    *specialised = ((specialised_object *)value)->specialised;
    return 0;
}

static int workspace_compute(solver_object *solver, request_call *call, tfa_exchange *exchange)
{
    (void)exchange;
    return tfa_compute(((workspace_object *)solver)->workspace, &call->request, &call->reply);
}

static const solver_kind kind = {
    .name = "workspace", .needs_lock = 1, .compute = workspace_compute};

static void workspace_dealloc(PyObject *self)
{
    workspace_object *w = (workspace_object *)self;
    tfa_workspace_free(w->workspace);
    Py_XDECREF(w->model);
    Py_XDECREF(w->specialised);
    object_free(self);
}

static PyObject *workspace_new(PyTypeObject *type, PyObject *args, PyObject *kwargs)
{
    static char *names[] = {"",         "precision",   "residual",     "states", "methods",
                            "max_tips", "specialised", "round_sincos", NULL};
    static const char *const states[] = {"auto", "one"};
    PyObject *model, *precision = NULL, *residual = NULL, *batch = NULL, *methods = NULL;
    PyObject *specialised = NULL;
    unsigned k = 0;
    tfa_workspace_options o = {0};
    if (!PyArg_ParseTupleAndKeywords(args, kwargs, "O!|$OOOOO&Op:Workspace", names, model_type,
                                     &model, &precision, &residual, &batch, &methods, convert_u32,
                                     &o.max_tips, &specialised, &o.round_sincos) ||
        read_precision(precision, residual, &o.precision, &o.residual) ||
        (batch && batch != Py_None && choose("states", batch, states, 2, &k)) ||
        read_methods(methods, &o.methods) || read_specialised(specialised, &o.specialised))
        return NULL;
    o.states = (tfa_states)k;
    workspace_object *w = (workspace_object *)PyType_GenericAlloc(type, 0);
    if (!w)
        return NULL;
    w->head.kind = &kind;
    w->head.slow = o.precision == TFA_F128 || o.residual == TFA_RESIDUAL_F128;
    w->model = Py_NewRef(model);
    w->specialised = o.specialised ? Py_NewRef(specialised) : NULL;
    w->precision = tfa_word(TFA_WORDS_PRECISION, o.precision);
    const tfa_model *m = ((model_object *)model)->model;
    int status;
    Py_BEGIN_ALLOW_THREADS status = tfa_workspace_create(m, &o, &w->workspace);
    Py_END_ALLOW_THREADS if (status != TFA_OK)
    {
        raise_status(status, NULL, "workspace: %s: %s", tfa_status_text(status),
                     tfa_status_cause(status));
        Py_DECREF(w);
        return NULL;
    }
    solver_adopt(&w->head, &((model_object *)model)->robot);
    return (PyObject *)w;
}

static PyObject *get_model(PyObject *self, void *unused)
{
    (void)unused;
    return Py_NewRef(((workspace_object *)self)->model);
}

static PyObject *get_max_tips(PyObject *self, void *unused)
{
    (void)unused;
    return PyLong_FromUnsignedLong(tfa_workspace_max_tips(((workspace_object *)self)->workspace));
}

static PyObject *get_precision(PyObject *self, void *unused)
{
    (void)unused;
    return PyUnicode_FromString(((workspace_object *)self)->precision);
}

static PyObject *get_methods(PyObject *self, void *unused)
{
    (void)unused;
    const uint32_t bits = tfa_workspace_methods(((workspace_object *)self)->workspace);
    PyObject *list = PyList_New(0);
    for (uint32_t k = 0; list && k < 32 && tfa_method_describe(k); k++) {
        PyObject *name = bits >> k & 1 ? PyUnicode_FromString(tfa_method_name(k)) : NULL;
        if (name && PyList_Append(list, name) < 0)
            Py_CLEAR(list);
        Py_XDECREF(name);
    }
    return list;
}

static PyGetSetDef attributes[] = {
    {"model", get_model, NULL, "Model of the workspace.", NULL},
    {"max_tips", get_max_tips, NULL, "Tips of a request that it has memory for.", NULL},
    {"precision", get_precision, NULL, "Arithmetic of the factors.", NULL},
    {"methods", get_methods, NULL, "Names of the methods that it has memory for.", NULL},
    {0}};

static const PyMethodDef own_methods[] = {
    {"close_loops", (PyCFunction)(void (*)(void))workspace_close_loops,
     METH_FASTCALL | METH_KEYWORDS,
     "close_loops($self, /, q, v=None, *, base_is_free=False, iterations=0, tolerance=0.0, "
     "**fields)\n--\n\n"
     "A posture near q that meets the active constraints, and velocities near v.\n\n"
     "`locked` names the joints that were measured: they keep q and v. A floating base keeps its\n"
     "pose and twist unless `base_is_free`. `fields` are those of impact: base_pose, base_twist,\n"
     "constraints, locked, rank_loss, rank_threshold, characteristic_length, method; others are\n"
     "not used. Returns Posture. If the loops stay open, NotComputedError with the best posture\n"
     "as `reply`. iterations: at most, 0: 50; tolerance: m, rad, m/s, rad/s, 0: 1e-10. Cost: an\n"
     "impact for each iteration."},
    {0}};

static PyMethodDef methods[SOLVER_METHOD_COUNT + 2];

PyTypeObject *workspace_type;

static const type_members workspace_members = {
    .name = "totalforce.Workspace",
    .doc = "Workspace(model, /, *, precision=None, residual=None, states=None, methods=None, "
           "max_tips=0, specialised=None, round_sincos=False)\n--\n\n"
           "Memory of one computation: answers requests in this process, one thread at a time.\n\n"
           "A second thread that asks meanwhile gets BusyError. Requests of more than about 20 us\n"
           "release the GIL.\n\n"
           "Parameters\n----------\n"
           "model : Model\n"
           "        kept alive\n"
           "precision : 'f64', 'f32' or 'f128'\n"
           "        arithmetic of the factors; None: 'f64'\n"
           "residual : 'same', 'f64' or 'f128'\n"
           "        arithmetic of refinement residuals; None: 'same'\n"
           "states : 'auto' or 'one'\n"
           "        states computed together; None: 'auto'\n"
           "methods : list of str\n"
           "        methods to reserve memory for; None: all for robots up to 256 bodies\n"
           "max_tips : int\n"
           "        tips of a request to reserve memory for, up to 32; 0: 8\n"
           "specialised : Specialised\n"
           "        kernel of this model; None: none\n"
           "round_sincos : bool\n"
           "        'f128' only: rounds sine and cosine to double\n",
    .size = sizeof(workspace_object),
    .dealloc = workspace_dealloc,
    .methods = methods,
    .attributes = attributes,
    .make = workspace_new,
};

int workspace_init(PyObject *module)
{
    solver_join_methods(solver_methods, own_methods, methods);
    return add_type(module, &workspace_members, &workspace_type);
}
