/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Type Client: connection, calls, fallback.
 */
#include "client_object.h"

#include "objects.h"
#include "python/request/errors.h"
#include "python/request/read.h"
#include "python/request/records.h"

#include <errno.h>
#include <stddef.h>

static int client_compute(solver_object *solver, request_call *call, tfa_exchange *exchange)
{
    *exchange = (tfa_exchange){0};
    return tfa_client_call(((client_object *)solver)->client, &call->request, &call->reply,
                           call->timeout_ns, exchange);
}

static const solver_kind kind = {.name = "client",
                                 .is_client = 1,
                                 .may_wait = 1,
                                 .needs_lock = 1,
                                 .needs_process = 1,
                                 .compute = client_compute};

static void client_release(client_object *c)
{
    tfa_client *const client = c->client;
    PyObject *const fallback = c->fallback;
    c->head.robot = NULL; /* before the GIL is released: another thread may call meanwhile */
    c->client = NULL;
    c->fallback = NULL;
    if (client && solver_is_ours(&c->head)) {
        Py_BEGIN_ALLOW_THREADS tfa_client_close(client);
        Py_END_ALLOW_THREADS
    }
    pending_clear(c);
    robot_clear(&c->robot);
    Py_XDECREF(fallback);
}

static void client_dealloc(PyObject *self)
{
    client_object *c = (client_object *)self;
    client_release(c);
    Py_XDECREF(c->texts);
    object_free(self);
}

/* Reads the connected robot. @return 0; -1 with an exception */
static int read_robot(client_object *c)
{
    robot_names robot;
    const tfa_client_info *info = tfa_client_get_info(c->client);
    if (robot_from_info(&robot, c->options.robot, info))
        return -1;
    robot_clear(&c->robot);
    c->robot = robot;
    solver_adopt(&c->head, &c->robot);
    return 0;
}

int client_raise(const client_object *c, int status)
{
    char text[512];
    tfa_client_explain(&c->options, status, text, sizeof text);
    return raise_status(status, NULL, "%s", text);
}

static int connect_robot(client_object *c)
{
    int status, error;
    Py_BEGIN_ALLOW_THREADS status = tfa_client_connect(&c->options, &c->client);
    error = errno;
    Py_END_ALLOW_THREADS errno = error;
    return status == TFA_OK ? read_robot(c) : client_raise(c, status);
}

/* A text that the client keeps; paths in the encoding of the file system */
static int keep(client_object *c, PyObject *value, const char **text)
{
    PyObject *bytes;
    if (!value || value == Py_None)
        return 0;
    if (!PyUnicode_FSConverter(value, &bytes))
        return -1;
    *text = PyBytes_AsString(bytes);
    const int bad = PyList_Append(c->texts, bytes) < 0;
    Py_DECREF(bytes);
    return bad ? -1 : 0;
}

static int read_times(client_object *c, double deadline, double timeout)
{
    if (!(deadline >= 0 && deadline <= 4000))
        return raise_status(TFA_E_ARGUMENT, "deadline", "deadline: %g, must be 0 to 4000 s",
                            deadline);
    if (!(timeout >= 0 && timeout <= 2e6))
        return raise_status(TFA_E_ARGUMENT, "connect_timeout",
                            "connect_timeout: %g, must be 0 to 2e6 s", timeout);
    c->options.deadline_us = (uint32_t)(deadline * 1e6);
    c->options.connect_timeout_ms = (int32_t)(timeout * 1e3);
    if (timeout > 0 && !c->options.connect_timeout_ms)
        c->options.connect_timeout_ms = 1;
    return 0;
}

static PyObject *client_new(PyTypeObject *type, PyObject *args, PyObject *kwargs)
{
    static char *names[] = {"robot",           "runtime_dir", "slots",   "max_batch",
                            "max_tips",        "wait",        "spin_ns", "deadline",
                            "connect_timeout", "standby_dir", NULL};
    client_object *c = (client_object *)PyType_GenericAlloc(type, 0);
    PyObject *robot = NULL, *directory = NULL, *wait = NULL, *standby = NULL;
    double deadline = 0, timeout = 1;
    unsigned k = 0;
    if (!c)
        return NULL;
    c->head.kind = &kind;
    c->texts = PyList_New(0);
    if (!c->texts ||
        !PyArg_ParseTupleAndKeywords(args, kwargs, "O|$OO&O&O&OO&ddO:Client", names, &robot,
                                     &directory, convert_u32, &c->options.slots, convert_u32,
                                     &c->options.max_batch, convert_u32, &c->options.max_tips,
                                     &wait, convert_u32, &c->options.spin_ns, &deadline, &timeout,
                                     &standby) ||
        choose_word("wait", wait, TFA_WORDS_WAIT, &k) || keep(c, robot, &c->options.robot) ||
        keep(c, directory, &c->options.runtime_dir) || keep(c, standby, &c->options.standby_dir) ||
        read_times(c, deadline, timeout)) {
        Py_DECREF(c);
        return NULL;
    }
    c->options.wait = (tfa_wait)k;
    if (connect_robot(c))
        Py_CLEAR(c);
    return (PyObject *)c;
}

static PyObject *client_close(PyObject *self, PyObject *unused)
{
    client_object *c = (client_object *)self;
    (void)unused;
    if (c->head.busy) {
        raise_status(TFA_E_BUSY, NULL, "another thread uses the client");
        return NULL;
    }
    client_release(c);
    Py_RETURN_NONE;
}

static PyObject *client_enter(PyObject *self, PyObject *unused)
{
    (void)unused;
    return solver_check((solver_object *)self) ? NULL : Py_NewRef(self);
}

static PyObject *client_exit(PyObject *self, PyObject *unused)
{
    (void)unused;
    return client_close(self, NULL);
}

static PyObject *client_reconnect(PyObject *self, PyObject *unused)
{
    client_object *c = (client_object *)self;
    int status, error;
    (void)unused;
    if (solver_enter(&c->head))
        return NULL;
    Py_BEGIN_ALLOW_THREADS status = tfa_client_reconnect(c->client);
    error = errno;
    Py_END_ALLOW_THREADS solver_leave(&c->head);
    errno = error;
    if (status != TFA_OK ? client_raise(c, status) : read_robot(c))
        return NULL;
    Py_RETURN_NONE;
}

/* With a Model, or None to end it */
static PyObject *client_set_fallback(PyObject *self, PyObject *args, PyObject *kwargs)
{
    static char *names[] = {"model", "retry_ms", "attempt_us", NULL};
    client_object *c = (client_object *)self;
    PyObject *value;
    tfa_client_fallback fallback = {0};
    if (!PyArg_ParseTupleAndKeywords(args, kwargs, "O|$O&O&:set_fallback", names, &value,
                                     convert_u32, &fallback.retry_ms, convert_u32,
                                     &fallback.attempt_us))
        return NULL;
    if (value != Py_None && !Py_IS_TYPE(value, model_type)) {
        raise_type("model", "model: %.100s, must be a Model or None", type_name(value));
        return NULL;
    }
    /* a workspace that no other code can use */
    PyObject *made = value == Py_None
                         ? Py_NewRef(Py_None)
                         : PyObject_CallFunctionObjArgs((PyObject *)workspace_type, value, NULL);
    if (!made || solver_enter(&c->head)) {
        Py_XDECREF(made);
        return NULL;
    }
    if (made != Py_None) {
        fallback.model = ((model_object *)value)->model;
        fallback.workspace = ((workspace_object *)made)->workspace;
    }
    const int status = tfa_client_set_fallback(c->client, made == Py_None ? NULL : &fallback);
    solver_leave(&c->head);
    if (status != TFA_OK) {
        Py_DECREF(made);
        raise_status(status, "model", "fallback: %s",
                     status == TFA_E_MODEL ? "the hash of the model is not that of the daemon's"
                                           : tfa_status_text(status));
        return NULL;
    }
    Py_XDECREF(c->fallback);
    c->fallback = made;
    Py_RETURN_NONE;
}

static PyMethodDef own_methods[] = {
    {"send", (PyCFunction)(void (*)(void))client_send, METH_FASTCALL | METH_KEYWORDS,
     "send($self, op, /, *args, **fields)\n--\n\n"
     "Sends a request without waiting and returns its id, counted from 1."},
    {"receive", (PyCFunction)(void (*)(void))client_receive, METH_VARARGS | METH_KEYWORDS,
     "receive($self, /, *, timeout=None)\n--\n\n"
     "Waits for the reply to the oldest request of send(); its id is reply.exchange.id.\n\n"
     "timeout in s; None: until the daemon ends, or shows no progress for 3 s. After\n"
     "TimedOutError the reply can be received later."},
    {"reconnect", client_reconnect, METH_NOARGS,
     "reconnect($self, /)\n--\n\n"
     "Connects again after DisconnectedError. Requests under way are lost."},
    {"set_fallback", (PyCFunction)(void (*)(void))client_set_fallback, METH_VARARGS | METH_KEYWORDS,
     "set_fallback($self, /, model, *, retry_ms=0, attempt_us=0)\n--\n\n"
     "Lets calls be computed in process when the daemon does not answer in time.\n\n"
     "model: the daemon's, by its hash; None: none any more. reply.exchange.daemon says why.\n"
     "retry_ms: between two attempts to reconnect, 0: 50. attempt_us: limit of one, 0: 2000."},
    {"close", client_close, METH_NOARGS, "close($self, /)\n--\n\nDisconnects."},
    {"__enter__", client_enter, METH_NOARGS, "__enter__($self, /)\n--\n\n"},
    {"__exit__", client_exit, METH_VARARGS, "__exit__($self, /, *unused)\n--\n\nAs close."},
    {0}};
static PyMethodDef all_methods[SOLVER_METHOD_COUNT + 8];

PyTypeObject *client_type;

static const type_members client_members = {
    .name = "totalforce.Client",
    .doc =
        "Client(robot, *, runtime_dir=None, slots=0, max_batch=0, max_tips=0, wait=None, "
        "spin_ns=0, deadline=0.0, connect_timeout=1.0, standby_dir=None)\n--\n\n"
        "Connection to one robot of a running totalforced, over shared memory.\n\n"
        "It answers as a Workspace does, with the same bits, and releases the GIL while it waits.\n"
        "One thread at a time: a second one gets BusyError. Close it, or use it in a `with`\n"
        "statement.\n\n"
        "Parameters\n----------\n"
        "robot : str\n"
        "        name in the daemon's configuration\n"
        "runtime_dir : path\n"
        "        folder of the sockets; None: $TOTALFORCE_RUNTIME_DIR, else the user's own\n"
        "        daemon in $XDG_RUNTIME_DIR/totalforce, else /run/totalforce\n"
        "slots, max_batch, max_tips : int\n"
        "        requests outstanding at once (a power of two; 0: 16), states of a request\n"
        "        (0: 1), tips of a request (0: 8)\n"
        "wait : 'default', 'spin', 'hybrid' or 'block'\n"
        "        None: as the daemon is configured; spin_ns: spinning time of 'hybrid', ns\n"
        "deadline : float\n"
        "        s; the daemon refuses a request that begins later; 0: none\n"
        "connect_timeout : float\n"
        "        limit of connecting, s\n"
        "standby_dir : path\n"
        "        runtime_dir of another daemon with the same robot; None: none\n",
    .size = sizeof(client_object),
    .dealloc = client_dealloc,
    .methods = all_methods,
    .attributes = client_attributes,
    .make = client_new,
};

int client_init(PyObject *module)
{
    solver_join_methods(client_methods, own_methods, all_methods);
    return add_type(module, &client_members, &client_type);
}
