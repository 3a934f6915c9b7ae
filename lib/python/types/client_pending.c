/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * send and receive; attributes of a Client.
 */
#include "client_object.h"
#include "python/request/errors.h"
#include "python/request/read.h"

static void drop_oldest(client_object *c)
{
    pending_call *old = c->oldest;
    c->oldest = old->next;
    if (!c->oldest)
        c->newest = NULL;
    call_clear(&old->call);
    PyMem_Free(old);
}

void pending_clear(client_object *c)
{
    while (c->oldest)
        drop_oldest(c);
}

PyObject *client_send(PyObject *self, PyObject *const *arguments, Py_ssize_t count,
                      PyObject *keywords)
{
    client_object *c = (client_object *)self;
    tfa_op op;
    if (count < 1)
        raise_type("op", "op: missing");
    if (count < 1 || read_op(arguments[0], &op) || solver_enter(&c->head))
        return NULL;
    pending_call *p = PyMem_Malloc(sizeof *p);
    int status = TFA_E_MEMORY;
    if (!p) {
        PyErr_NoMemory();
    } else if (call_read(&p->call, &c->robot, 0, op, arguments + 1, count - 1, keywords) == 0) {
        Py_BEGIN_ALLOW_THREADS status = tfa_client_send(c->client, &p->call.request, &p->id);
        Py_END_ALLOW_THREADS p->call.reply.status = status;
        if (status != TFA_OK)
            raise_reply(&c->robot, &p->call.request, &p->call.reply, NULL);
    }
    solver_leave(&c->head);
    if (status != TFA_OK) {
        if (p)
            call_clear(&p->call);
        PyMem_Free(p);
        return NULL;
    }
    p->next = NULL;
    if (c->newest)
        c->newest->next = p;
    else
        c->oldest = p;
    c->newest = p;
    return PyLong_FromUnsignedLongLong(p->id);
}

/* Reply or exception of the oldest request, which is forgotten unless it is still under way */
static PyObject *finish(client_object *c, int status, const tfa_exchange *exchange)
{
    request_call *call = &c->oldest->call;
    PyObject *reply = NULL;
    if (status == TFA_OK)
        reply = call_reply(call, exchange);
    else
        raise_reply(&c->robot, &call->request, &call->reply, NULL);
    if (exchange->id == c->oldest->id)
        drop_oldest(c);
    return reply;
}

PyObject *client_receive(PyObject *self, PyObject *args, PyObject *kwargs)
{
    static char *names[] = {"timeout", NULL};
    static const input_row timeout = {.name = "timeout"};
    client_object *c = (client_object *)self;
    PyObject *value = NULL;
    request_call of_timeout = {.timeout_ns = 0};
    if (!PyArg_ParseTupleAndKeywords(args, kwargs, "|$O:receive", names, &value) ||
        (value && value != Py_None && read_timeout(&of_timeout, &timeout, value)) ||
        solver_enter(&c->head))
        return NULL;
    PyObject *reply = NULL;
    if (!c->oldest) {
        raise_status(TFA_E_ARGUMENT, NULL, "receive: no request of send() is outstanding");
    } else {
        tfa_exchange exchange = {0};
        tfa_reply *answer = &c->oldest->call.reply;
        int status;
        Py_BEGIN_ALLOW_THREADS status =
            tfa_client_receive(c->client, answer, of_timeout.timeout_ns, &exchange);
        Py_END_ALLOW_THREADS reply = finish(c, status, &exchange);
    }
    solver_leave(&c->head);
    return reply;
}

/* ---- attributes ---- */

static const tfa_client_info *info_of(PyObject *self)
{
    return solver_check((solver_object *)self)
               ? NULL
               : tfa_client_get_info(((client_object *)self)->client);
}

static PyObject *get_names(PyObject *self, void *closure)
{
    const client_object *c = (const client_object *)self;
    if (!info_of(self))
        return NULL;
    return Py_NewRef(*(PyObject *const *)((const char *)&c->robot + (uintptr_t)closure));
}

static PyObject *get_hash(PyObject *self, void *unused)
{
    const tfa_client_info *info = info_of(self);
    (void)unused;
    return info ? PyUnicode_FromString(info->model_hash) : NULL;
}

static PyObject *get_wait(PyObject *self, void *unused)
{
    const tfa_client_info *info = info_of(self);
    (void)unused;
    return info ? PyUnicode_FromString(tfa_word(TFA_WORDS_WAIT, info->wait)) : NULL;
}

static PyObject *get_outstanding(PyObject *self, void *unused)
{
    long count = 0;
    (void)unused;
    for (const pending_call *p = ((client_object *)self)->oldest; p; p = p->next)
        count++;
    return PyLong_FromLong(count);
}

#define NUMBER(member)                                                                             \
    static PyObject *get_##member(PyObject *self, void *unused)                                    \
    {                                                                                              \
        const tfa_client_info *info = info_of(self);                                               \
        (void)unused;                                                                              \
        return info ? PyLong_FromLongLong((long long)info->member) : NULL;                         \
    }
NUMBER(q_count)
NUMBER(v_count)
NUMBER(base_freedoms)
NUMBER(slots)
NUMBER(max_batch)
NUMBER(max_tips)
NUMBER(daemon_pid)

PyGetSetDef client_attributes[] = {
    {"joint_names", get_names, NULL, "Names of the joints in the order of the arrays.",
     (void *)offsetof(robot_names, joints)},
    {"links", get_names, NULL, "Names of the links; the position is the frame index.",
     (void *)offsetof(robot_names, links)},
    {"modes", get_names, NULL, "Link of each modal coordinate.",
     (void *)offsetof(robot_names, modes)},
    {"constraints", get_names, NULL, "Names of the constraints of the scene.",
     (void *)offsetof(robot_names, constraints)},
    {"hash", get_hash, NULL, "Hash of the daemon's model, as Model.hash.", NULL},
    {"q_count", get_q_count, NULL, "Coordinates of the joints in q (n_q).", NULL},
    {"v_count", get_v_count, NULL, "Freedoms of the joints in v, tau, qdd (n_v).", NULL},
    {"base_freedoms", get_base_freedoms, NULL, "6 with a floating base, else 0.", NULL},
    {"slots", get_slots, NULL, "Requests outstanding at once, as granted.", NULL},
    {"max_batch", get_max_batch, NULL, "States of a request, as granted.", NULL},
    {"max_tips", get_max_tips, NULL, "Tips of a request, as granted.", NULL},
    {"wait", get_wait, NULL, "Way of waiting, as granted.", NULL},
    {"daemon_pid", get_daemon_pid, NULL, "Process id of the daemon.", NULL},
    {"outstanding", get_outstanding, NULL, "Requests of send() not yet received.", NULL},
    {0}};
