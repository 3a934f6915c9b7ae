/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Times of two contestants in turns, so that disturbances of the machine meet both. Each call of a
 * contestant is another request than its one before: a workspace keeps the factors of the same q.
 */
#include "objects.h"
#include "python/request/errors.h"
#include "python/request/read.h"

#include <math.h>
#include <string.h>
#include <time.h>

enum { SAMPLES_MIN = 3, SAMPLES_MAX = 101, CALLS_MAX = 1000 };

/* Reading the thread's clock is a system call of some 0.3 us: a sample must be long against it. */
#define SAMPLE_SECONDS 50e-6

/* Forward dynamics and Lambda^-1 of a link by another library (tools/peers/peer.h) */
typedef void peer_forward(void *robot, const double *q, const double *v, const double *tau,
                          double *qdd);
typedef int peer_lambda(void *robot, const double *q, const char *link, double *lambda_inv);

typedef struct contestant {
    uint32_t count, next; /* of requests */
    uint32_t calls;       /* of a sample */
    int status;           /* of the last call */
    solver_object *solver;
    request_call *requests; /* `count` of them */
    /* a peer, where there is no solver: */
    union {
        void *address;
        peer_forward *forward;
        peer_lambda *lambda;
    } peer;
    void *robot;
    const char *link;      /* NULL: forward dynamics */
    PyArrayObject *states; /* count x 3 x n: q, v, tau */
    double *found;
} contestant;

typedef struct turns {
    clockid_t clock;
    int warm; /* threads of a pool fell asleep in the turn of the other */
} turns;

static double read_clock(clockid_t clock)
{
    struct timespec t;
    clock_gettime(clock, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static void call_once(contestant *c)
{
    const uint32_t k = c->next++ % c->count;
    if (c->solver) {
        tfa_exchange exchange;
        c->status = c->solver->kind->compute(c->solver, &c->requests[k], &exchange);
        return;
    }
    const npy_intp n = PyArray_DIM(c->states, 2);
    const double *q = (const double *)PyArray_DATA(c->states) + 3 * n * k;
    if (c->link)
        (void)c->peer.lambda(c->robot, q, c->link, c->found);
    else
        c->peer.forward(c->robot, q, q + n, q + 2 * n, c->found);
}

/* Seconds of a call, from so many */
static double sample(const turns *t, contestant *c, uint32_t calls)
{
    if (t->warm)
        call_once(c);
    const double start = read_clock(t->clock);
    for (uint32_t k = 0; k < calls && c->status == TFA_OK; k++)
        call_once(c);
    return (read_clock(t->clock) - start) / calls;
}

/* How many calls make a sample, from one that is thrown away */
static uint32_t calls_for(const turns *t, contestant *c)
{
    const double seconds = sample(t, c, c->count);
    return seconds > 0.0 ? (uint32_t)fmin(ceil(SAMPLE_SECONDS / seconds), CALLS_MAX) : CALLS_MAX;
}

/* @return samples */
static npy_intp run(const turns *t, contestant *both, double seconds, double times[2][SAMPLES_MAX])
{
    npy_intp n = 0;
    for (int k = 0; k < 2; k++)
        both[k].calls = calls_for(t, &both[k]);
    const double end = read_clock(t->clock) + seconds;
    for (; n < SAMPLES_MIN || (n < SAMPLES_MAX && read_clock(t->clock) < end); n++)
        for (int k = 0; k < 2; k++)
            if (both[k].status == TFA_OK)
                times[k][n] = sample(t, &both[k], both[k].calls);
            else
                return n;
    return n;
}

/* The arguments of one request, a dict */
static int read_request(contestant *c, request_call *call, tfa_op op, PyObject *fields)
{
    if (!PyDict_Check(fields))
        return raise_type("requests", "requests: must be dicts of arguments");
    PyObject *names = PySequence_Tuple(fields);
    const Py_ssize_t count = names ? PyTuple_Size(names) : 0;
    PyObject **values = PyMem_New(PyObject *, (size_t)count);
    for (Py_ssize_t k = 0; values && k < count; k++)
        values[k] = PyDict_GetItem(fields, PyTuple_GetItem(names, k));
    const int bad = !names || !values || call_read(call, c->solver->robot, 0, op, values, 0, names);
    Py_XDECREF(names);
    PyMem_Free(values);
    return bad ? -1 : 0;
}

/* (solver, op, [dict of arguments, ...]) */
static int read_solver(contestant *c, PyObject *value)
{
    PyObject *solver, *name, *list;
    tfa_op op;
    if (!PyArg_ParseTuple(value, "OOO!:_race", &solver, &name, &PyList_Type, &list) ||
        read_op(name, &op))
        return -1;
    if (!PyObject_TypeCheck(solver, workspace_type) && !PyObject_TypeCheck(solver, pool_type))
        return raise_type("solver", "_race: must be a Workspace or a Pool");
    const Py_ssize_t count = PyList_Size(list);
    if (count < 1 || solver_enter((solver_object *)solver))
        return count < 1 ? raise_type("requests", "requests: none") : -1;
    c->solver = (solver_object *)Py_NewRef(solver);
    c->requests = PyMem_Calloc((size_t)count, sizeof *c->requests);
    if (!c->requests)
        return PyErr_NoMemory(), -1;
    for (Py_ssize_t k = 0; k < count && k < PyList_Size(list); k++) {
        c->count++; /* to be cleared in any case */
        if (read_request(c, &c->requests[k], op, PyList_GetItem(list, k)))
            return -1;
    }
    return 0;
}

/* (address of its function, address of the robot, states, link or None), all of which the caller
 * keeps: of a peer */
static int read_peer(contestant *c, PyObject *value)
{
    enum { LAMBDA_NUMBERS = 36 };
    PyObject *function, *robot, *states;
    if (!PyArg_ParseTuple(value, "OOO!z:_race", &function, &robot, &PyArray_Type, &states,
                          &c->link))
        return -1;
    c->peer.address = PyLong_AsVoidPtr(function);
    c->robot = PyLong_AsVoidPtr(robot);
    if (PyErr_Occurred())
        return -1;
    c->states = (PyArrayObject *)Py_NewRef(states);
    if (PyArray_NDIM(c->states) != 3 || PyArray_DIM(c->states, 0) < 1 ||
        PyArray_DIM(c->states, 1) != 3 || PyArray_TYPE(c->states) != NPY_DOUBLE ||
        !PyArray_ISCARRAY_RO(c->states))
        return raise_type("states", "_race: states must be a C array (count, 3, n) of float64");
    c->count = (uint32_t)PyArray_DIM(c->states, 0);
    c->found = PyMem_Calloc((size_t)PyArray_DIM(c->states, 2) + LAMBDA_NUMBERS, sizeof(double));
    return c->found ? 0 : (PyErr_NoMemory(), -1);
}

static void clear(contestant *c)
{
    for (uint32_t k = 0; c->requests && k < c->count; k++)
        call_clear(&c->requests[k]);
    PyMem_Free(c->requests);
    PyMem_Free(c->found);
    if (c->solver)
        solver_leave(c->solver);
    Py_XDECREF((PyObject *)c->solver);
    Py_XDECREF((PyObject *)c->states);
}

static PyObject *finish(contestant *both, npy_intp samples, double times[2][SAMPLES_MAX])
{
    for (int k = 0; k < 2; k++)
        if (both[k].status != TFA_OK) {
            const request_call *failed = &both[k].requests[(both[k].next - 1) % both[k].count];
            raise_reply(both[k].solver->robot, &failed->request, &failed->reply, NULL);
            return NULL;
        }
    npy_intp shape[2] = {2, samples};
    PyObject *array = PyArray_SimpleNew(2, shape, NPY_DOUBLE);
    for (int k = 0; array && k < 2; k++)
        memcpy((double *)PyArray_DATA((PyArrayObject *)array) + k * samples, times[k],
               (size_t)samples * sizeof(double));
    return array;
}

PyObject *race(PyObject *module, PyObject *args, PyObject *kwargs)
{
    static char *names[] = {"", "", "", "clock", NULL};
    static const char *const clocks[] = {"thread", "monotonic"};
    PyObject *values[2], *clock = NULL, *made = NULL;
    contestant both[2] = {{0}};
    double seconds, times[2][SAMPLES_MAX];
    unsigned wall = 0;
    int bad = 0;
    (void)module;
    if (!PyArg_ParseTupleAndKeywords(args, kwargs, "O!O!d|$O:_race", names, &PyTuple_Type,
                                     &values[0], &PyTuple_Type, &values[1], &seconds, &clock) ||
        (clock && choose("clock", clock, clocks, 2, &wall)))
        return NULL;
    for (int k = 0; k < 2 && !bad; k++)
        bad = PyTuple_Size(values[k]) && PyLong_Check(PyTuple_GetItem(values[k], 0))
                  ? read_peer(&both[k], values[k])
                  : read_solver(&both[k], values[k]);
    if (!bad) {
        const turns t = {.clock = wall ? CLOCK_MONOTONIC : CLOCK_THREAD_CPUTIME_ID,
                         .warm = (int)wall};
        npy_intp samples;
        Py_BEGIN_ALLOW_THREADS samples = run(&t, both, seconds, times);
        Py_END_ALLOW_THREADS made = finish(both, samples, times);
    }
    clear(&both[0]);
    clear(&both[1]);
    return made;
}
