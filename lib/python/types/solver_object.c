/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * One request: arguments, computing with or without the GIL, reply or exception.
 */
#include "solver_object.h"

#include "python/request/docs.h"
#include "python/request/errors.h"

#include <pthread.h>
#include <time.h>

/* Requests below it hold the GIL: they take less than about 20 us, and a thread that gives the GIL
 * away may wait for it up to the interpreter's switch interval, 5 ms. */
enum { COST_OF_RELEASE = 256 };

static unsigned forks;

static void count_fork(void)
{
    forks++;
}

int solver_is_ours(const solver_object *solver)
{
    return solver->forks == forks;
}

void solver_adopt(solver_object *solver, const robot_names *robot)
{
    solver->robot = robot;
    solver->forks = forks;
}

int solver_check(solver_object *solver)
{
    if (!solver->robot)
        return raise_status(TFA_E_ARGUMENT, NULL, "the %s is closed", solver->kind->name);
    if (solver->kind->needs_lock && solver->busy)
        return raise_status(TFA_E_BUSY, NULL,
                            "another thread uses the %s: give each thread one of its own",
                            solver->kind->name);
    if (solver->kind->needs_process && !solver_is_ours(solver))
        return raise_status(TFA_E_UNSUPPORTED, NULL,
                            "the %s was made before a fork: make one in this process",
                            solver->kind->name);
    return 0;
}

int solver_enter(solver_object *solver)
{
    if (solver_check(solver))
        return -1;
    solver->busy++;
    return 0;
}

void solver_leave(solver_object *solver)
{
    solver->busy--;
}

static int compute(solver_object *solver, request_call *call, tfa_exchange *exchange)
{
    int status;
    if (!solver->kind->may_wait && !solver->slow && call_cost(call) < COST_OF_RELEASE)
        return solver->kind->compute(solver, call, exchange);
    Py_BEGIN_ALLOW_THREADS status = solver->kind->compute(solver, call, exchange);
    Py_END_ALLOW_THREADS return status;
}

/* 1: states were computed, so that a failed request has answers of some */
static int has_answers(int status)
{
    return status == TFA_E_SINGULAR || status == TFA_E_NOT_COMPUTED || status == TFA_E_RANK;
}

static PyObject *reply_or_error(solver_object *solver, request_call *call, int status,
                                const tfa_exchange *exchange)
{
    PyObject *reply = NULL;
    if (status == TFA_OK)
        return call_reply(call, exchange);
    if (has_answers(status) && !(reply = call_reply(call, exchange)))
        return NULL;
    raise_reply(solver->robot, &call->request, &call->reply, reply);
    Py_XDECREF(reply);
    return NULL;
}

static PyObject *answer_op(PyObject *self, tfa_op op, PyObject *const *arguments, Py_ssize_t count,
                           PyObject *keywords)
{
    solver_object *s = (solver_object *)self;
    PyObject *reply = NULL;
    request_call call;
    if (solver_enter(s))
        return NULL;
    if (call_read(&call, s->robot, s->kind->is_client, op, arguments, count, keywords) == 0) {
        tfa_exchange exchange;
        const int status = compute(s, &call, &exchange);
        reply = reply_or_error(s, &call, status, s->kind->is_client ? &exchange : NULL);
    }
    call_clear(&call);
    solver_leave(s);
    return reply;
}

#define OP_FUNCTION(name, op)                                                                      \
    static PyObject *name(PyObject *self, PyObject *const *arguments, Py_ssize_t count,            \
                          PyObject *keywords)                                                      \
    {                                                                                              \
        return answer_op(self, op, arguments, count, keywords);                                    \
    }
OP_FUNCTION(forward_dynamics, TFA_OP_FORWARD_DYNAMICS)
OP_FUNCTION(inverse_dynamics, TFA_OP_INVERSE_DYNAMICS)
OP_FUNCTION(operational_inertia, TFA_OP_OPERATIONAL_INERTIA)
OP_FUNCTION(mass_matrix, TFA_OP_MASS_MATRIX)
OP_FUNCTION(kinematics, TFA_OP_KINEMATICS)
OP_FUNCTION(bias, TFA_OP_BIAS)
OP_FUNCTION(task_torques, TFA_OP_TASK_TORQUES)
OP_FUNCTION(derivatives, TFA_OP_DERIVATIVES)
OP_FUNCTION(inverse_dynamics_derivatives, TFA_OP_INVERSE_DYNAMICS_DERIVATIVES)
OP_FUNCTION(constrained_dynamics, TFA_OP_CONSTRAINED_DYNAMICS)
OP_FUNCTION(impact, TFA_OP_IMPACT)
OP_FUNCTION(constrained_inverse_dynamics, TFA_OP_CONSTRAINED_INVERSE_DYNAMICS)
OP_FUNCTION(regressor, TFA_OP_REGRESSOR)

static PyObject *compute_op(PyObject *self, PyObject *const *arguments, Py_ssize_t count,
                            PyObject *keywords)
{
    tfa_op op;
    if (count < 1) {
        raise_type("op", "op: missing");
        return NULL;
    }
    return read_op(arguments[0], &op) ? NULL
                                      : answer_op(self, op, arguments + 1, count - 1, keywords);
}

/* Processor time of the computation alone: `repetitions` times in C, for benchmarks.
 * @return ns of one */
static PyObject *time_op(PyObject *self, PyObject *const *arguments, Py_ssize_t count,
                         PyObject *keywords)
{
    solver_object *s = (solver_object *)self;
    struct timespec from, to;
    tfa_op op;
    request_call call;
    const long repetitions = count < 2 ? 0 : PyLong_AsLong(arguments[0]);
    if (repetitions < 1)
        return PyErr_Occurred() ? NULL
                                : PyErr_Format(PyExc_ValueError, "_time(repetitions, op, ...)");
    if (read_op(arguments[1], &op) || solver_enter(s))
        return NULL;
    int status = 0;
    if (call_read(&call, s->robot, s->kind->is_client, op, arguments + 2, count - 2, keywords))
        status = -1;
    tfa_exchange exchange;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &from);
    for (long k = 0; k < repetitions && status == 0; k++)
        status = s->kind->compute(s, &call, &exchange);
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &to);
    if (status && !PyErr_Occurred())
        raise_reply(s->robot, &call.request, &call.reply, NULL);
    call_clear(&call);
    solver_leave(s);
    return status ? NULL
                  : PyFloat_FromDouble(((double)(to.tv_sec - from.tv_sec) * 1e9 +
                                        (double)(to.tv_nsec - from.tv_nsec)) /
                                       (double)repetitions);
}

#define METHOD(name, function)                                                                     \
    {                                                                                              \
        name, (PyCFunction)(void (*)(void))function, METH_FASTCALL | METH_KEYWORDS, NULL           \
    }
#define METHODS                                                                                    \
    {                                                                                              \
        METHOD("forward_dynamics", forward_dynamics),                                              \
            METHOD("inverse_dynamics", inverse_dynamics),                                          \
            METHOD("operational_inertia", operational_inertia),                                    \
            METHOD("mass_matrix", mass_matrix), METHOD("kinematics", kinematics),                  \
            METHOD("bias", bias), METHOD("task_torques", task_torques),                            \
            METHOD("derivatives", derivatives),                                                    \
            METHOD("inverse_dynamics_derivatives", inverse_dynamics_derivatives),                  \
            METHOD("constrained_dynamics", constrained_dynamics), METHOD("impact", impact),        \
            METHOD("constrained_inverse_dynamics", constrained_inverse_dynamics),                  \
            METHOD("regressor", regressor), METHOD("compute", compute_op),                         \
            METHOD("_time", time_op),                                                              \
    }

PyMethodDef solver_methods[SOLVER_METHOD_COUNT] = METHODS;
PyMethodDef client_methods[SOLVER_METHOD_COUNT] = METHODS;

int solver_init(void)
{
    static int registered;
    if (!registered && pthread_atfork(NULL, NULL, count_fork) == 0)
        registered = 1;
    for (int k = 0; k < OP_COUNT; k++) {
        solver_methods[k].ml_doc = docs_op(&op_rows[k], 0);
        client_methods[k].ml_doc = docs_op(&op_rows[k], 1);
        if (!solver_methods[k].ml_doc || !client_methods[k].ml_doc)
            return -1;
    }
    solver_methods[OP_COUNT].ml_doc = docs_compute(0);
    client_methods[OP_COUNT].ml_doc = docs_compute(1);
    return solver_methods[OP_COUNT].ml_doc && client_methods[OP_COUNT].ml_doc ? 0 : -1;
}

PyMethodDef *solver_join_methods(const PyMethodDef *common, const PyMethodDef *own,
                                 PyMethodDef *all)
{
    int count = 0;
    for (int k = 0; k < SOLVER_METHOD_COUNT; k++)
        all[count++] = common[k];
    while (own && own->ml_name)
        all[count++] = *own++;
    all[count] = (PyMethodDef){0};
    return all;
}
