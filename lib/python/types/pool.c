/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Types Pool and ThreadPool.
 */
#include "objects.h"
#include "python/request/errors.h"
#include "python/request/read.h"

#include <errno.h>
#include <stddef.h>

typedef struct thread_pool_object {
    solver_object head; /* computes nothing; closed and forked like the others */
    tfa_thread_pool *threads;
    Py_ssize_t users; /**< pools that share it */
} thread_pool_object;

typedef struct pool_object {
    solver_object head;
    tfa_batch_pool *pool;
    PyObject *model, *specialised;
    thread_pool_object *threads; /**< shared; NULL: its own */
} pool_object;

static int pool_compute(solver_object *solver, request_call *call, tfa_exchange *exchange)
{
    (void)exchange;
    return tfa_batch_pool_compute(((pool_object *)solver)->pool, &call->request, &call->reply);
}

/* Any number of threads may call; the library gives E_BUSY to all but one. */
static const solver_kind pool_kind = {
    .name = "pool", .may_wait = 1, .needs_process = 1, .compute = pool_compute};
static const solver_kind thread_pool_kind = {.name = "thread pool", .needs_process = 1};
/* A thread pool has no robot; this stands for "open". */
static const robot_names no_robot;

/* Processors to pin to. @return 0; -1 with an exception */
static int read_cpus(PyObject *value, uint32_t threads, int **cpus)
{
    *cpus = NULL;
    if (!value || value == Py_None)
        return 0;
    PyObject *list = PySequence_Tuple(value);
    if (!list)
        return raise_from_current("cpus", "must be a list of processors");
    const Py_ssize_t count = PyTuple_Size(list);
    int bad = 0;
    if (count != (Py_ssize_t)threads)
        bad =
            raise_status(TFA_E_SIZE, "cpus", "cpus: %zd processors for %u threads", count, threads);
    *cpus = bad ? NULL : PyMem_Calloc((size_t)count + 1, sizeof **cpus);
    for (Py_ssize_t k = 0; *cpus && k < count && !PyErr_Occurred(); k++)
        (*cpus)[k] = (int)PyLong_AsLong(PyTuple_GetItem(list, k));
    Py_DECREF(list);
    if (!bad && !*cpus)
        PyErr_NoMemory();
    if (PyErr_Occurred()) {
        PyMem_Free(*cpus);
        *cpus = NULL;
        return bad ? -1 : raise_from_current("cpus", "must be a list of processors");
    }
    return 0;
}

/* ---- ThreadPool ---- */

/* It is closed before the GIL is released, as a pool below: another thread may call meanwhile. */
static void thread_pool_release(thread_pool_object *t)
{
    tfa_thread_pool *const threads = t->threads;
    t->head.robot = NULL;
    t->threads = NULL;
    if (threads && solver_is_ours(&t->head)) {
        Py_BEGIN_ALLOW_THREADS tfa_thread_pool_free(threads);
        Py_END_ALLOW_THREADS
    }
}

static void thread_pool_dealloc(PyObject *self)
{
    thread_pool_release((thread_pool_object *)self);
    object_free(self);
}

static PyObject *thread_pool_new(PyTypeObject *type, PyObject *args, PyObject *kwargs)
{
    static char *names[] = {"threads", "spin_ns", "cpus", "priority", NULL};
    tfa_thread_pool_options o = {0};
    PyObject *list = NULL;
    int *cpus;
    if (!PyArg_ParseTupleAndKeywords(args, kwargs, "|O&$O&OO&:ThreadPool", names, convert_u32,
                                     &o.threads, convert_u32, &o.spin_ns, &list, convert_u32,
                                     &o.priority) ||
        read_cpus(list, o.threads, &cpus))
        return NULL;
    thread_pool_object *t = (thread_pool_object *)PyType_GenericAlloc(type, 0);
    if (t) {
        t->head.kind = &thread_pool_kind;
        o.cpus = cpus;
        const int status = tfa_thread_pool_create(&o, &t->threads);
        if (status == TFA_OK) {
            solver_adopt(&t->head, &no_robot);
        } else {
            raise_status(status, NULL, "thread pool: %s: %s", tfa_status_text(status),
                         tfa_status_cause(status));
            Py_CLEAR(t);
        }
    }
    PyMem_Free(cpus);
    return (PyObject *)t;
}

static PyObject *thread_pool_close(PyObject *self, PyObject *unused)
{
    thread_pool_object *t = (thread_pool_object *)self;
    (void)unused;
    if (t->users) {
        raise_status(TFA_E_BUSY, NULL, "%zd pools use the thread pool: close them first", t->users);
        return NULL;
    }
    thread_pool_release(t);
    Py_RETURN_NONE;
}

static PyMethodDef thread_pool_methods[] = {
    {"close", thread_pool_close, METH_NOARGS,
     "close($self, /)\n--\n\nEnds the threads. Close the pools that share them first."},
    {0}};

PyTypeObject *thread_pool_type;

static const type_members thread_pool_members = {
    .name = "totalforce.ThreadPool",
    .doc = "ThreadPool(threads=0, *, spin_ns=0, cpus=None, priority=0)\n--\n\n"
           "Threads that pools of several models share.\n\n"
           "Parameters\n----------\n"
           "threads : int\n"
           "        the calling one included; 0: one for each processor\n"
           "spin_ns : int\n"
           "        time that an idle thread spins before it sleeps, ns; 0: 50000\n"
           "cpus : list of int\n"
           "        a processor for each thread, the caller's first; None: no pinning\n"
           "priority : int\n"
           "        SCHED_FIFO priority, 1 to 99; 0: that of the creator\n",
    .size = sizeof(thread_pool_object),
    .dealloc = thread_pool_dealloc,
    .methods = thread_pool_methods,
    .make = thread_pool_new,
};

/* ---- Pool ---- */

static void pool_release(pool_object *p)
{
    const pool_object was = *p;
    p->head.robot = NULL;
    p->pool = NULL;
    p->threads = NULL;
    p->model = p->specialised = NULL;
    if (was.pool && solver_is_ours(&p->head)) {
        Py_BEGIN_ALLOW_THREADS tfa_batch_pool_free(was.pool);
        Py_END_ALLOW_THREADS
    }
    if (was.threads)
        was.threads->users--;
    Py_XDECREF((PyObject *)was.threads);
    Py_XDECREF(was.model);
    Py_XDECREF(was.specialised);
}

static void pool_dealloc(PyObject *self)
{
    pool_release((pool_object *)self);
    object_free(self);
}

/* Creates the pool of an object whose references are set. */
static int create(pool_object *p, tfa_batch_pool_options *o)
{
    const tfa_model *model = ((model_object *)p->model)->model;
    int status;
    if (p->threads) {
        if (solver_check(&p->threads->head))
            return -1;
        o->thread_pool = p->threads->threads;
    }
    Py_BEGIN_ALLOW_THREADS status = tfa_batch_pool_create(model, o, &p->pool);
    Py_END_ALLOW_THREADS if (status != TFA_OK) return raise_status(
        status, NULL, "pool: %s: %s", tfa_status_text(status), tfa_status_cause(status));
    solver_adopt(&p->head, &((model_object *)p->model)->robot);
    return 0;
}

static PyObject *pool_new(PyTypeObject *type, PyObject *args, PyObject *kwargs)
{
    static char *names[] = {"",          "threads",     "spin_ns",     "cpus",
                            "precision", "residual",    "methods",     "max_tips",
                            "priority",  "thread_pool", "specialised", NULL};
    PyObject *model, *list = NULL, *precision = NULL, *residual = NULL, *methods = NULL;
    PyObject *threads = NULL, *specialised = NULL;
    tfa_batch_pool_options o = {0};
    int *cpus;
    if (!PyArg_ParseTupleAndKeywords(
            args, kwargs, "O!|O&$O&OOOOO&O&OO:Pool", names, model_type, &model, convert_u32,
            &o.threads, convert_u32, &o.spin_ns, &list, &precision, &residual, &methods,
            convert_u32, &o.max_tips, convert_u32, &o.priority, &threads, &specialised) ||
        read_precision(precision, residual, &o.precision, &o.residual) ||
        read_methods(methods, &o.methods) || read_specialised(specialised, &o.specialised))
        return NULL;
    if (threads == Py_None)
        threads = NULL;
    if (threads && !Py_IS_TYPE(threads, thread_pool_type)) {
        raise_type("thread_pool", "thread_pool: %.100s, must be a ThreadPool", type_name(threads));
        return NULL;
    }
    if (read_cpus(list, o.threads, &cpus))
        return NULL;
    o.cpus = cpus;
    pool_object *p = (pool_object *)PyType_GenericAlloc(type, 0);
    if (p) {
        p->head.kind = &pool_kind;
        p->model = Py_NewRef(model);
        p->specialised = o.specialised ? Py_NewRef(specialised) : NULL;
        p->threads = (thread_pool_object *)Py_XNewRef(threads);
        if (p->threads)
            p->threads->users++;
        if (create(p, &o))
            Py_CLEAR(p);
    }
    PyMem_Free(cpus);
    return (PyObject *)p;
}

static PyObject *pool_close(PyObject *self, PyObject *unused)
{
    pool_object *p = (pool_object *)self;
    (void)unused;
    if (p->head.busy) {
        raise_status(TFA_E_BUSY, NULL, "another thread uses the pool");
        return NULL;
    }
    pool_release(p);
    Py_RETURN_NONE;
}

static PyObject *pool_enter(PyObject *self, PyObject *unused)
{
    (void)unused;
    return solver_check((solver_object *)self) ? NULL : Py_NewRef(self);
}

static PyObject *pool_exit(PyObject *self, PyObject *unused)
{
    (void)unused;
    return pool_close(self, NULL);
}

static PyObject *get_threads(PyObject *self, void *unused)
{
    (void)unused;
    return solver_check((solver_object *)self)
               ? NULL
               : PyLong_FromUnsignedLong(tfa_batch_pool_threads(((pool_object *)self)->pool));
}

static PyObject *get_model(PyObject *self, void *unused)
{
    (void)unused;
    return solver_check((solver_object *)self) ? NULL : Py_NewRef(((pool_object *)self)->model);
}

static PyGetSetDef attributes[] = {
    {"threads", get_threads, NULL, "Number of threads, the calling one included.", NULL},
    {"model", get_model, NULL, "Model of the pool.", NULL},
    {0}};

static PyMethodDef own_methods[] = {
    {"close", pool_close, METH_NOARGS,
     "close($self, /)\n--\n\nEnds the pool's own threads and releases its memory."},
    {"__enter__", pool_enter, METH_NOARGS, "__enter__($self, /)\n--\n\n"},
    {"__exit__", pool_exit, METH_VARARGS, "__exit__($self, /, *unused)\n--\n\nAs close."},
    {0}};
static PyMethodDef all_methods[SOLVER_METHOD_COUNT + 4];

PyTypeObject *pool_type;

static const type_members pool_members = {
    .name = "totalforce.Pool",
    .doc =
        "Pool(model, /, threads=0, *, spin_ns=0, cpus=None, precision=None, residual=None, "
        "methods=None, max_tips=0, priority=0, thread_pool=None, specialised=None)\n--\n\n"
        "Answers requests on several cores: a workspace for each thread.\n\n"
        "The states of a batch, or the parts of one long chain, are spread over the threads; the\n"
        "bits of an answer do not depend on their number. While one thread is served, others get\n"
        "BusyError. Close it, or use it in a `with` statement.\n\n"
        "Parameters\n----------\n"
        "model : Model\n"
        "        kept alive\n"
        "threads, spin_ns, cpus, priority :\n"
        "        as of ThreadPool\n"
        "precision, residual, methods, max_tips, specialised :\n"
        "        as of Workspace\n"
        "thread_pool : ThreadPool\n"
        "        threads to share; None: its own\n",
    .size = sizeof(pool_object),
    .dealloc = pool_dealloc,
    .methods = all_methods,
    .attributes = attributes,
    .make = pool_new,
};

int pool_init(PyObject *module)
{
    solver_join_methods(solver_methods, own_methods, all_methods);
    return add_type(module, &thread_pool_members, &thread_pool_type)
               ? -1
               : add_type(module, &pool_members, &pool_type);
}
