/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The part that Workspace, Pool and Client have in common: a method for each op, `compute`, and the
 * rule that one thread at a time uses an object.
 */
#ifndef PYTHON_SOLVER_OBJECT_H
#define PYTHON_SOLVER_OBJECT_H

#include "python/request/call.h"
#include "python/request/python_api.h"

typedef struct solver_object solver_object;

typedef struct solver_kind {
    const char *name;  /**< "workspace": in messages */
    int is_client;     /**< 1: calls have `timeout`, replies an exchange */
    int may_wait;      /**< 1: the GIL is released for every request */
    int needs_lock;    /**< 1: one thread at a time */
    int needs_process; /**< 1: threads or a connection, which a fork does not copy */
    /** Runs without the GIL. @return status, also in call->reply */
    int (*compute)(solver_object *solver, request_call *call, tfa_exchange *exchange);
    /** 0: it may be used; -1 with an exception. NULL: always */
    int (*check)(solver_object *solver);
} solver_kind;

/** First member of the objects */
struct solver_object {
    PyObject_HEAD const solver_kind *kind;
    const robot_names *robot; /**< NULL: closed, or never initialised */
    int busy;                 /**< 1: a thread uses the object; read and written with the GIL */
    int slow;                 /**< 1: even one state takes long (quadruple precision) */
    unsigned forks;           /**< generation of the process that made it */
};

/** Methods of all three, to be followed by those of the type. */
#define SOLVER_METHOD_COUNT (TFA_OP_LAST + 2)
extern PyMethodDef solver_methods[SOLVER_METHOD_COUNT];
/** As solver_methods, for the client: with the argument `timeout`. */
extern PyMethodDef client_methods[SOLVER_METHOD_COUNT];

/** Makes the docstrings of the methods from the tables. @return 0; -1 with an exception */
int solver_init(void);

/** 0: this thread may use the object and has it until solver_leave; -1 with an exception: closed,
 *  used by another thread, or made before a fork. */
int solver_enter(solver_object *solver);
void solver_leave(solver_object *solver);
/** As solver_enter without taking the object. */
int solver_check(solver_object *solver);

/** Opens an object for this robot, which lives as long. */
void solver_adopt(solver_object *solver, const robot_names *robot);

/** 1: the object was made by this process, not by its parent before a fork */
int solver_is_ours(const solver_object *solver);

/** Appends method rows to a common table: a table of static storage for a type. */
PyMethodDef *solver_join_methods(const PyMethodDef *common, const PyMethodDef *own,
                                 PyMethodDef *all);

#endif
