/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Types Statistics and Histogram: figures of a running daemon as dicts, whose keys are the members
 * of totalforce/statistics.h.
 */
#include "objects.h"
#include "python/request/errors.h"
#include "python/request/read.h"
#include "python/request/records.h"

#include <stddef.h>
#include <time.h>
#include <totalforce/method.h>
#include <totalforce/statistics.h>

typedef struct statistics_object {
    PyObject_HEAD tfa_statistics *statistics;
    tfa_snapshot *now; /**< of the last reading, with the GIL only */
} statistics_object;

typedef struct histogram_object {
    PyObject_HEAD tfa_histogram h;
} histogram_object;

static PyTypeObject *histogram_type, *statistics_type;

/* ---- Histogram ---- */

static histogram_object *copy_histogram(const tfa_histogram *like)
{
    histogram_object *made = (histogram_object *)PyType_GenericAlloc(histogram_type, 0);
    uint64_t *buckets = made ? PyMem_Calloc(like->bucket_count, sizeof *buckets) : NULL;
    if (made && !buckets) {
        Py_CLEAR(made);
        PyErr_NoMemory();
    } else if (made) {
        made->h = *like;
        made->h.buckets = buckets;
        if (like->buckets)
            memcpy(buckets, like->buckets, like->bucket_count * sizeof *buckets);
    }
    return made;
}

static PyObject *histogram_new(PyTypeObject *type, PyObject *args, PyObject *kwargs)
{
    static char *names[] = {"values", NULL};
    const tfa_histogram empty = {.bits = TFA_STATISTICS_BITS,
                                 .bucket_count = TFA_STATISTICS_BUCKETS};
    PyObject *values = NULL, *value;
    (void)type;
    if (!PyArg_ParseTupleAndKeywords(args, kwargs, "|O:Histogram", names, &values))
        return NULL;
    histogram_object *made = copy_histogram(&empty);
    PyObject *each = made && values ? PyObject_GetIter(values) : NULL;
    while (each && (value = PyIter_Next(each))) {
        const unsigned long long ns = PyLong_AsUnsignedLongLong(value);
        Py_DECREF(value);
        if (PyErr_Occurred())
            break;
        tfa_histogram_add(&made->h, ns);
    }
    Py_XDECREF(each);
    if (made && PyErr_Occurred())
        Py_CLEAR(made);
    return (PyObject *)made;
}

static void histogram_dealloc(PyObject *self)
{
    PyMem_Free(((histogram_object *)self)->h.buckets);
    object_free(self);
}

static PyObject *quantile(PyObject *self, PyObject *value)
{
    const double share = PyFloat_AsDouble(value);
    if (share == -1 && PyErr_Occurred())
        return NULL;
    return PyLong_FromUnsignedLongLong(
        tfa_histogram_quantile(&((histogram_object *)self)->h, share));
}

static PyObject *since(PyObject *self, PyObject *value)
{
    if (!Py_IS_TYPE(value, histogram_type)) {
        raise_type("earlier", "earlier: %.100s, must be a Histogram", type_name(value));
        return NULL;
    }
    histogram_object *made = copy_histogram(&((histogram_object *)value)->h);
    if (made && tfa_histogram_since(&made->h, &((histogram_object *)self)->h) != TFA_OK) {
        raise_status(TFA_E_SIZE, "earlier", "earlier: of another resolution");
        Py_CLEAR(made);
    }
    return (PyObject *)made;
}

static PyObject *get_number(PyObject *self, void *which)
{
    const tfa_histogram *h = &((histogram_object *)self)->h;
    const char *name = which;
    return *name == 's'   ? PyFloat_FromDouble(h->sum)
           : *name == 'm' ? PyFloat_FromDouble(tfa_histogram_mean(h))
                          : PyLong_FromUnsignedLongLong(*name == 'c'   ? h->count
                                                        : *name == 'l' ? h->lowest
                                                                       : h->highest);
}

static PyObject *get_buckets(PyObject *self, void *tops)
{
    const tfa_histogram *h = &((histogram_object *)self)->h;
    npy_intp size = h->bucket_count;
    PyObject *array = PyArray_SimpleNew(1, &size, NPY_UINT64);
    uint64_t *to = array ? PyArray_DATA((PyArrayObject *)array) : NULL;
    for (uint32_t i = 0; to && i < h->bucket_count; i++)
        to[i] = tops ? tfa_histogram_top(h, i) : h->buckets[i];
    return array;
}

static PyGetSetDef histogram_attributes[] = {
    {"count", get_number, NULL, "Values.", "count"},
    {"lowest", get_number, NULL, "Lowest value; 0: none.", "lowest"},
    {"highest", get_number, NULL, "Highest value; 0: none.", "highest"},
    {"sum", get_number, NULL, "Sum of the values.", "sum"},
    {"mean", get_number, NULL, "Mean of the values; 0: none.", "mean"},
    {"buckets", get_buckets, NULL, "Values in each bucket.", NULL},
    {"tops", get_buckets, NULL, "Largest value that falls into each bucket.", "tops"},
    {0}};

static PyMethodDef histogram_methods[] = {
    {"quantile", quantile, METH_O,
     "quantile($self, share, /)\n--\n\n"
     "Value that this share of the values does not exceed; at most 6.3 % too high."},
    {"since", since, METH_O,
     "since($self, earlier, /)\n--\n\nThe values that were added since it was `earlier`."},
    {0}};

static PyTypeObject *histogram_type;

static const type_members histogram_members = {
    .name = "totalforce.Histogram",
    .doc = "Histogram(values=())\n--\n\nHistogram of times, ns, as the statistics of a daemon "
           "have them.",
    .size = sizeof(histogram_object),
    .dealloc = histogram_dealloc,
    .methods = histogram_methods,
    .attributes = histogram_attributes,
    .make = histogram_new,
};

/* ---- dicts ---- */

typedef struct member {
    const char *key;
    enum { TEXT, U32, I32, U64, DOUBLE } kind;
    size_t at;
} member;

/* clang-format off */

#define M(kind, name) {#name, kind, offsetof(STRUCT, name)}
#define SERVED(kind, name) {#name, kind, offsetof(STRUCT, served.name)}
#define ROS2(kind, name) {"ros2_" #name, kind, offsetof(STRUCT, ros2.name)}

#define STRUCT tfa_tally
static const member tally_members[] = {
    M(U64, requests), M(U64, rejected), M(U64, late), M(U64, states), M(U64, busy_ns),
    M(U64, refined), M(U64, estimates), M(U64, fallbacks), M(U64, inaccurate), M(U64, stalled),
    M(U64, not_finite), M(U64, residual_precision), M(U64, sentinel), M(DOUBLE, largest_estimate),
    {0}};
#undef STRUCT
#define STRUCT tfa_input_statistics
static const member input_members[] = {
    M(TEXT, name), M(U32, publishers), M(U64, received), M(U64, refused), M(U64, oversized),
    M(U64, last), {0}};
#undef STRUCT
#define STRUCT tfa_robot_statistics
static const member robot_members[] = {
    SERVED(TEXT, name), SERVED(TEXT, model_hash), SERVED(TEXT, kernel_isa),
    SERVED(TEXT, kernel_file), SERVED(TEXT, precision), SERVED(TEXT, ros2_namespace),
    SERVED(TEXT, ros2_node), SERVED(U32, joints), SERVED(U32, freedoms), SERVED(U32, q_count),
    SERVED(U32, base_freedoms), SERVED(U32, dds), SERVED(U32, dds_domain),
    SERVED(U32, ros2_domain), M(U32, clients), M(U32, queued), M(U64, dds_request),
    M(U64, dds_torques), ROS2(U32, subscribers), ROS2(U64, refused), ROS2(TEXT, refusal), {0}};
#undef STRUCT
#define STRUCT tfa_client_statistics
static const member client_members[] = {
    SERVED(U32, robot), SERVED(I32, worker), SERVED(I32, process), SERVED(U32, user),
    SERVED(U32, slots), SERVED(U64, since), M(U32, queued), M(U32, slot), {0}};
#undef STRUCT
#define STRUCT tfa_dds_statistics
static const member dds_members[] = {
    M(U64, requests), M(U64, torques), M(U64, replies), M(U64, rejected), M(U64, late),
    M(U64, unknown), M(U64, dropped), M(U64, handovers), M(U64, standby), M(U64, request_writers),
    M(U64, reply_readers), M(U64, torque_writers), M(U64, acceleration_readers), {0}};
#undef STRUCT
#define STRUCT tfa_snapshot
static const member snapshot_members[] = {
    M(U64, time), M(U64, start), M(I32, process), M(TEXT, version), M(TEXT, runtime_dir),
    M(U32, stopped), M(U64, reloads), M(U64, connections), M(U64, refused), M(U64, heartbeat),
    M(U32, worker_count), {0}};

/* clang-format on */

static PyObject *value_of(const void *from, const member *m)
{
    const char *at = (const char *)from + m->at;
    switch (m->kind) {
    case TEXT:
        return PyUnicode_DecodeUTF8(at, (Py_ssize_t)strlen(at), "replace");
    case U32:
        return PyLong_FromUnsignedLong(*(const uint32_t *)(const void *)at);
    case I32:
        return PyLong_FromLong(*(const int32_t *)(const void *)at);
    case U64:
        return PyLong_FromUnsignedLongLong(*(const uint64_t *)(const void *)at);
    default:
        return PyFloat_FromDouble(*(const double *)(const void *)at);
    }
}

/* Rows end with one without a key. */
static PyObject *dict_of(const void *from, const member *rows)
{
    PyObject *dict = PyDict_New();
    for (; dict && rows->key; rows++)
        if (set_entry(dict, rows->key, value_of(from, rows)))
            Py_CLEAR(dict);
    return dict;
}

/* A list of `count` entries of `size` bytes. */
static PyObject *list_of(const void *from, size_t size, uint32_t count,
                         PyObject *(*entry)(const void *))
{
    PyObject *list = PyList_New(count);
    for (uint32_t i = 0; list && i < count; i++) {
        PyObject *made = entry((const char *)from + i * size);
        if (made)
            PyList_SetItem(list, i, made);
        else
            Py_CLEAR(list);
    }
    return list;
}

/* {name: count} of those that are not 0 */
static PyObject *counts_of(const uint64_t *counts, int size, const char *(*name)(int))
{
    PyObject *dict = PyDict_New();
    for (int i = 0; dict && i < size; i++)
        if (counts[i] && set_entry(dict, name(i), PyLong_FromUnsignedLongLong(counts[i])))
            Py_CLEAR(dict);
    return dict;
}

static const char *name_of_status(int k)
{
    return tfa_status_name(-k);
}

static const char *name_of_method(int k)
{
    return k ? tfa_method_name((uint32_t)k) : "unknown";
}

static PyObject *tally_of(const tfa_tally *t)
{
    PyObject *dict = dict_of(t, tally_members);
    if (dict && (set_entry(dict, "statuses",
                           counts_of(t->statuses, TFA_STATISTICS_STATUSES, name_of_status)) ||
                 set_entry(dict, "methods",
                           counts_of(t->methods, TFA_STATISTICS_METHODS, name_of_method)) ||
                 set_entry(dict, "queue", (PyObject *)copy_histogram(&t->queue)) ||
                 set_entry(dict, "compute", (PyObject *)copy_histogram(&t->compute)) ||
                 set_entry(dict, "total", (PyObject *)copy_histogram(&t->total))))
        Py_CLEAR(dict);
    return dict;
}

static PyObject *state_of(const tfa_robot_state *s)
{
    if (!s->time)
        return Py_NewRef(Py_None);
    return Py_BuildValue("{s:K,s:N,s:N}", "time", (unsigned long long)s->time, "base_pose",
                         s->floating ? array_of(s->base_pose, 7) : Py_NewRef(Py_None), "q",
                         array_of(s->q, s->q_count));
}

static PyObject *input_of(const void *input)
{
    return dict_of(input, input_members);
}

static PyObject *robot_of(const void *robot)
{
    const tfa_robot_statistics *r = robot;
    PyObject *dict = dict_of(r, robot_members);
    if (dict &&
        (set_entry(dict, "total", tally_of(&r->total)) ||
         set_entry(dict, "state", state_of(&r->state)) ||
         set_entry(dict, "inputs",
                   list_of(r->ros2.inputs, sizeof *r->ros2.inputs, r->ros2.input_count, input_of))))
        Py_CLEAR(dict);
    return dict;
}

static PyObject *client_of(const void *client)
{
    const tfa_client_statistics *c = client;
    PyObject *dict = dict_of(c, client_members);
    if (dict &&
        (set_entry(dict, "kind", PyUnicode_FromString(tfa_client_kind_name(c->served.kind))) ||
         set_entry(dict, "tally", tally_of(&c->tally))))
        Py_CLEAR(dict);
    return dict;
}

static PyObject *dds_of(const tfa_snapshot *s)
{
    return s->dds_on ? dict_of(&s->dds, dds_members) : Py_NewRef(Py_None);
}

static PyObject *snapshot_of(const tfa_snapshot *s)
{
    PyObject *dict = dict_of(s, snapshot_members);
    if (dict && (set_entry(dict, "dds", dds_of(s)) ||
                 set_entry(dict, "robots",
                           list_of(s->robots, sizeof *s->robots, s->robot_count, robot_of)) ||
                 set_entry(dict, "clients",
                           list_of(s->clients, sizeof *s->clients, s->client_count, client_of))))
        Py_CLEAR(dict);
    return dict;
}

/* ---- Statistics ---- */

static PyObject *statistics_new(PyTypeObject *type, PyObject *args, PyObject *kwargs)
{
    static char *keywords[] = {"runtime_dir", "timeout", NULL};
    PyObject *value = Py_None, *path = NULL;
    double timeout = 10;
    int status;
    if (!PyArg_ParseTupleAndKeywords(args, kwargs, "|O$d:Statistics", keywords, &value, &timeout) ||
        (value != Py_None && !PyUnicode_FSConverter(value, &path)))
        return NULL;
    statistics_object *made = NULL;
    if (!(timeout > 0 && timeout < 2e6))
        raise_status(TFA_E_ARGUMENT, "timeout", "timeout: %g, must be above 0 s", timeout);
    else
        made = (statistics_object *)PyType_GenericAlloc(type, 0);
    if (made) {
        const char *directory = path ? PyBytes_AsString(path) : NULL;
        Py_BEGIN_ALLOW_THREADS status =
            tfa_statistics_open(directory, (int32_t)(timeout * 1e3) + 1, &made->statistics);
        if (status == TFA_OK)
            status = tfa_snapshot_create(made->statistics, &made->now);
        Py_END_ALLOW_THREADS if (status != TFA_OK)
        {
            raise_status(status, NULL, "statistics: %s", tfa_status_cause(status));
            Py_CLEAR(made);
        }
    }
    Py_XDECREF(path);
    return (PyObject *)made;
}

static void statistics_dealloc(PyObject *self)
{
    tfa_snapshot_free(((statistics_object *)self)->now);
    tfa_statistics_close(((statistics_object *)self)->statistics);
    object_free(self);
}

static PyObject *statistics_read(PyObject *self, PyObject *args, PyObject *kwargs)
{
    static char *keywords[] = {"timeout", NULL};
    const struct timespec pause = {.tv_nsec = 1000000};
    const statistics_object *s = (const statistics_object *)self;
    double timeout = 1;
    if (!PyArg_ParseTupleAndKeywords(args, kwargs, "|$d:read", keywords, &timeout))
        return NULL;
    int status = tfa_statistics_read(s->statistics, s->now);
    for (; status == TFA_E_BUSY && timeout > 0; timeout -= 1e-3) {
        Py_BEGIN_ALLOW_THREADS nanosleep(&pause, NULL); /* the writer waits for a processor */
        Py_END_ALLOW_THREADS status = tfa_statistics_read(s->statistics, s->now);
    }
    if (status == TFA_OK)
        return snapshot_of(s->now);
    raise_status(status, NULL, "statistics: a worker of the daemon is stopped: %s",
                 tfa_status_cause(status));
    return NULL;
}

static PyMethodDef statistics_methods[] = {
    {"read", (PyCFunction)(void (*)(void))statistics_read, METH_VARARGS | METH_KEYWORDS,
     "read($self, /, *, timeout=1.0)\n--\n\n"
     "A copy of all statistics: a dict of the daemon with 'robots', 'clients' and 'dds'.\n\n"
     "Keys are the members of totalforce/statistics.h, of `served` and `ros2` those of theirs;\n"
     "times ns, CLOCK_MONOTONIC. 'total' of a robot and 'tally' of a client have the counters,\n"
     "'methods' and 'statuses' as {name: count}, and 'queue', 'compute' and 'total' as Histogram.\n"
     "'state' is None, or the last q and base_pose. No writer waits for a reader; BusyError:\n"
     "a writer was interrupted for longer than timeout, s."},
    {0}};

static PyTypeObject *statistics_type;

static const type_members statistics_members = {
    .name = "totalforce.Statistics",
    .doc = "Statistics(runtime_dir=None, *, timeout=10.0)\n--\n\n"
           "Statistics of a running daemon, in memory that this process can only read.\n\n"
           "runtime_dir as of Client; timeout in s. After the end of the daemon its last figures\n"
           "stay readable.",
    .size = sizeof(statistics_object),
    .dealloc = statistics_dealloc,
    .methods = statistics_methods,
    .make = statistics_new,
};

/* {name: (text, cause)} of every status, which the keys of 'statuses' refer to */
static int add_statuses(PyObject *module)
{
    PyObject *dict = PyDict_New();
    for (int k = 0; dict && k < TFA_STATISTICS_STATUSES; k++)
        if (set_entry(dict, tfa_status_name(-k),
                      Py_BuildValue("(ss)", tfa_status_text(-k), tfa_status_cause(-k))))
            Py_CLEAR(dict);
    const int bad = !dict || PyModule_AddObjectRef(module, "STATUSES", dict) < 0;
    Py_XDECREF(dict);
    return bad;
}

int snapshots_init(PyObject *module)
{
    return add_type(module, &histogram_members, &histogram_type) ||
           add_type(module, &statistics_members, &statistics_type) || add_statuses(module);
}
