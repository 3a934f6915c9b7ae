/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Type _Sweep: the blocks of `totalforce sweep`, a worker for each thread.
 */
#include "objects.h"
#include "python/request/errors.h"
#include "python/request/read.h"
#include "python/sweep/sweep_block.h"

typedef struct sweep_object {
    PyObject_HEAD sweep_plan plan;
    PyObject *model, *specialised;
    sweep_worker *workers;
    uint32_t count;
} sweep_object;

static void sweep_dealloc(PyObject *self)
{
    sweep_object *s = (sweep_object *)self;
    for (uint32_t k = 0; k < s->count; k++)
        sweep_worker_close(&s->workers[k]);
    PyMem_Free(s->workers);
    sweep_plan_free(&s->plan);
    Py_XDECREF(s->model);
    Py_XDECREF(s->specialised);
    object_free(self);
}

/* Words of the request. @return 0; -1 with an exception */
static int read_request(sweep_plan *plan, PyObject *op, const char *method, PyObject *estimate)
{
    const int32_t number = tfa_method_find(method);
    unsigned k;
    if (number < 0)
        return raise_status(TFA_E_METHOD, "method", "method: no '%.200s'", method);
    if (read_op(op, &plan->request.op) || choose_word("estimate", estimate, TFA_WORDS_ESTIMATE, &k))
        return -1;
    if (plan->request.op > TFA_OP_MASS_MATRIX)
        return raise_status(TFA_E_UNSUPPORTED, "op", "op: sweeps do not compute %s",
                            op_name(plan->request.op));
    plan->request.method = (tfa_method)number;
    plan->request.estimate = (tfa_estimate)k;
    return 0;
}

static int read_links(sweep_object *s, PyObject *tips)
{
    tfa_request *request = &s->plan.request;
    const Py_ssize_t count = tips ? PyTuple_Size(tips) : 0;
    if (count > TFA_MAX_TIPS)
        return raise_status(TFA_E_SIZE, "tips", "tips: more than %d links", TFA_MAX_TIPS);
    for (Py_ssize_t k = 0; k < count; k++)
        if (robot_find_link(&((model_object *)s->model)->robot, "tips", PyTuple_GetItem(tips, k),
                            &request->tips[request->tip_count++]))
            return -1;
    return 0;
}

static int complete(sweep_object *s, const state_ranges *ranges)
{
    PyObject *source = ((model_object *)s->model)->source; /* NULL: of a derived model */
    const int status =
        sweep_plan_complete(&s->plan, ranges, source ? PyBytes_AsString(source) : NULL,
                            source ? (size_t)PyBytes_Size(source) : 0);
    return status == TFA_OK ? 0 : raise_status(status, NULL, "%s", tfa_status_text(status));
}

static PyObject *sweep_new(PyTypeObject *type, PyObject *args, PyObject *kwargs)
{
    static char *names[] = {"",          "",       "method",      "precision", "residual",
                            "estimate",  "refine", "tips",        "ranges",    "seed",
                            "reference", "first",  "specialised", NULL};
    PyObject *model, *op, *precision = NULL, *residual = NULL, *estimate = NULL, *tips = NULL;
    PyObject *specialised = NULL;
    const char *method = "auto";
    sweep_plan plan = {.request.refine = TFA_REFINE_DEFAULT};
    state_ranges ranges = {1, 1, 1};
    unsigned long long seed = 1, reference = 0, first = 0;
    if (!PyArg_ParseTupleAndKeywords(args, kwargs, "O!O|$sOOOO&O!(ddd)KKKO:_Sweep", names,
                                     model_type, &model, &op, &method, &precision, &residual,
                                     &estimate, convert_u32, &plan.request.refine, &PyTuple_Type,
                                     &tips, &ranges.velocity, &ranges.force, &ranges.acceleration,
                                     &seed, &reference, &first, &specialised) ||
        read_request(&plan, op, method, estimate) ||
        read_precision(precision, residual, &plan.workspace.precision, &plan.workspace.residual) ||
        read_specialised(specialised, &plan.workspace.specialised))
        return NULL;
    sweep_object *s = (sweep_object *)PyType_GenericAlloc(type, 0);
    if (!s)
        return NULL;
    plan.model = ((model_object *)model)->model;
    plan.seed = seed;
    plan.reference = reference;
    plan.first = first;
    s->plan = plan;
    s->model = Py_NewRef(model);
    s->specialised = plan.workspace.specialised ? Py_NewRef(specialised) : NULL;
    if (read_links(s, tips) || complete(s, &ranges))
        Py_CLEAR(s);
    return (PyObject *)s;
}

/* Workers, and a state that is tried. @return a status */
static int open_workers(sweep_object *s, uint32_t count, const sweep_file *states)
{
    int status = TFA_OK;
    s->workers = PyMem_Calloc(count, sizeof *s->workers);
    while (s->workers && status == TFA_OK && s->count < count)
        status = sweep_worker_open(&s->workers[s->count++], &s->plan);
    if (!s->workers || status != TFA_OK)
        return s->workers ? status : TFA_E_MEMORY;
    s->workers[0].states = *states;
    return sweep_worker_try(&s->workers[0]);
}

static PyObject *sweep_open(PyObject *self, PyObject *args)
{
    sweep_object *s = (sweep_object *)self;
    sweep_file states;
    uint32_t count;
    if (!PyArg_ParseTuple(args, "O&(is):open", convert_u32, &count, &states.number, &states.path))
        return NULL;
    const int status = s->workers || !count ? TFA_E_ARGUMENT : open_workers(s, count, &states);
    if (status == TFA_OK)
        Py_RETURN_NONE;
    const tfa_field field = s->count ? s->workers[0].reply.field : TFA_FIELD_NONE;
    raise_status(status, NULL, "%s%s%s: %s", tfa_field_name(field), field ? ": " : "",
                 tfa_status_text(status), tfa_status_cause(status));
    return NULL;
}

static PyObject *sweep_block(PyObject *self, PyObject *args)
{
    const sweep_object *s = (const sweep_object *)self;
    sweep_file states, out, out_states;
    unsigned long long first, count;
    uint32_t k;
    if (!PyArg_ParseTuple(args, "O&KK(is)(is)(is):block", convert_u32, &k, &first, &count,
                          &states.number, &states.path, &out.number, &out.path, &out_states.number,
                          &out_states.path))
        return NULL;
    sweep_worker *const w = k < s->count ? &s->workers[k] : NULL;
    if (!w || w->busy) {
        raise_status(TFA_E_BUSY, NULL, "worker %u: %s", k, w ? "is in use" : "is not open");
        return NULL;
    }
    w->states = states;
    w->out = out;
    w->out_states = out_states;
    w->busy = 1;
    int bad;
    Py_BEGIN_ALLOW_THREADS tfa_stack_prepare();
    bad = sweep_worker_block(w, first, count);
    Py_END_ALLOW_THREADS w->busy = 0;
    return bad ? PyErr_Format(PyExc_OSError, "%s", w->error)
               : PyBytes_FromStringAndSize((const char *)&w->statistics, sizeof w->statistics);
}

/* FNV-1a, 64 bits */
static PyObject *sweep_checksum(PyObject *unused, PyObject *bytes)
{
    Py_buffer text;
    uint64_t hash = UINT64_C(0xcbf29ce484222325);
    (void)unused;
    if (PyObject_GetBuffer(bytes, &text, PyBUF_SIMPLE) < 0)
        return NULL;
    for (Py_ssize_t k = 0; k < text.len; k++)
        hash = (hash ^ ((const unsigned char *)text.buf)[k]) * UINT64_C(0x100000001b3);
    PyBuffer_Release(&text);
    return PyLong_FromUnsignedLongLong(hash);
}

/* Statistics whose first series is that of these doubles, states of numbers from `first` on. */
static PyObject *sweep_count(PyObject *unused, PyObject *args)
{
    Py_buffer values;
    unsigned long long first;
    double groups[SERIES] = {0};
    (void)unused;
    if (!PyArg_ParseTuple(args, "y*K:count", &values, &first))
        return NULL;
    PyObject *bytes = PyBytes_FromStringAndSize(NULL, sizeof(statistics));
    statistics *s = bytes ? memset(PyBytes_AsString(bytes), 0, sizeof *s) : NULL;
    for (size_t k = 0; s && k < (size_t)values.len / sizeof(double); k++) {
        series_add(&s->series[SERIES_ANSWER], groups, ((const double *)values.buf)[k], first + k);
        if ((first + k + 1) % STATISTICS_GROUP == 0)
            statistics_end_groups(s, groups);
    }
    if (s)
        statistics_end_groups(s, groups);
    PyBuffer_Release(&values);
    return bytes;
}

static PyObject *get_record(PyObject *self, void *unused)
{
    (void)unused;
    return PyLong_FromUnsignedLong(((sweep_object *)self)->plan.record.width);
}

static PyObject *get_answer(PyObject *self, void *unused)
{
    (void)unused;
    return PyLong_FromUnsignedLong(((sweep_object *)self)->plan.answer);
}

static PyObject *get_ranges(PyObject *self, void *unused)
{
    const state_record *r = &((sweep_object *)self)->plan.record;
    const Py_ssize_t size = (Py_ssize_t)(r->width * sizeof(double));
    (void)unused;
    return Py_BuildValue("(y#y#)", r->low, size, r->span, size);
}

static PyObject *get_seconds(PyObject *self, void *unused)
{
    const sweep_object *s = (const sweep_object *)self;
    PyObject *list = PyList_New(SWEEP_TIMES);
    (void)unused;
    for (int part = 0; list && part < SWEEP_TIMES; part++) {
        double sum = 0;
        for (uint32_t k = 0; k < s->count; k++)
            sum += s->workers[k].seconds[part];
        PyList_SetItem(list, part, PyFloat_FromDouble(sum));
    }
    return list;
}

static PyGetSetDef attributes[] = {
    {"record", get_record, NULL, "Doubles of a state.", NULL},
    {"answer", get_answer, NULL, "Doubles of an answer.", NULL},
    {"ranges", get_ranges, NULL, "Lower bounds of a state's doubles, and widths: bytes.", NULL},
    {"seconds", get_seconds, NULL,
     "Times of the workers: states, dynamics, statistics, reference, output.", NULL},
    {0}};

static PyMethodDef own_methods[] = {
    {"open", sweep_open, METH_VARARGS,
     "open($self, workers, states, /)\n--\n\n"
     "Makes the workers and answers one state, of the file `states` (descriptor, path)."},
    {"block", sweep_block, METH_VARARGS,
     "block($self, worker, first, count, states, out, out_states, /)\n--\n\n"
     "Statistics of states as words of 64 bits; files are (descriptor, path), -1: none."},
    {"checksum", sweep_checksum, METH_O | METH_STATIC,
     "checksum(data, /)\n--\n\nFNV-1a of bytes, 64 bits."},
    {"count", sweep_count, METH_VARARGS | METH_STATIC,
     "count(values, first, /)\n--\n\nStatistics of doubles, as of the answers of `block`."},
    {0}};

PyTypeObject *sweep_type;

static const type_members sweep_members = {
    .name = "totalforce._Sweep",
    .doc = "_Sweep(model, op, /, *, method='auto', precision=None, residual=None, estimate=None, "
           "refine=4294967295, tips=(), ranges=(1.0, 1.0, 1.0), seed=1, reference=0, first=0, "
           "specialised=None)"
           "\n--\n\n"
           "Blocks of states of `totalforce sweep`. ranges: of drawn velocities, torques and\n"
           "accelerations; reference: every how many states a quadruple one; first: state at\n"
           "the begin of the files that are written.",
    .size = sizeof(sweep_object),
    .dealloc = sweep_dealloc,
    .methods = own_methods,
    .attributes = attributes,
    .make = sweep_new,
};

int sweep_init(PyObject *module)
{
    return add_type(module, &sweep_members, &sweep_type);
}
