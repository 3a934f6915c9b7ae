/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * From the arguments of a Python call to a request.
 */
#include "call.h"

#include "errors.h"
#include "interface/want_words.h"
#include "read.h"

#include <stddef.h>
#include <stdio.h>
#include <totalforce/text.h>

static const char *input_name_at(const void *unused, size_t index)
{
    (void)unused;
    return inputs[index].name;
}

/* The argument of a keyword, or of a position by the names of the op's row. */
static int take_argument(request_call *call, int k, PyObject *value)
{
    if (call->given_rows >> k & 1)
        return raise_type(inputs[k].name, "%s: given twice", inputs[k].name);
    call->given_rows |= UINT64_C(1) << k;
    if (value != Py_None) {
        call->given[call->given_count].input = &inputs[k];
        call->given[call->given_count++].value = value;
    }
    return 0;
}

/* Rows of the arguments that an op takes by position: the third one differs. */
static int position(tfa_op op, Py_ssize_t place)
{
    enum { Q, V, TAU, QDD, ACCELERATION, NONE = -1 }; /* as in the table of inputs */
    static int tips = -1;
    if (tips < 0) {
        for (tips = 0; strcmp(inputs[tips].name, "tips") != 0;)
            tips++;
    }
    static const int third[OP_COUNT + 1] = {
        [TFA_OP_FORWARD_DYNAMICS] = TAU,
        [TFA_OP_INVERSE_DYNAMICS] = QDD,
        [TFA_OP_OPERATIONAL_INERTIA] = -1,
        [TFA_OP_MASS_MATRIX] = -1,
        [TFA_OP_KINEMATICS] = -1,
        [TFA_OP_BIAS] = -1,
        [TFA_OP_TASK_TORQUES] = ACCELERATION,
        [TFA_OP_DERIVATIVES] = TAU,
        [TFA_OP_INVERSE_DYNAMICS_DERIVATIVES] = QDD,
        [TFA_OP_CONSTRAINED_DYNAMICS] = TAU,
        [TFA_OP_IMPACT] = NONE,
        [TFA_OP_CONSTRAINED_INVERSE_DYNAMICS] = QDD,
        [TFA_OP_REGRESSOR] = QDD,
    };
    if (place == 0)
        return Q;
    if (place == 1)
        return op == TFA_OP_OPERATIONAL_INERTIA ? tips : op == TFA_OP_MASS_MATRIX ? NONE : V;
    return place == 2 ? third[op] : NONE;
}

static int take_arguments(request_call *call, PyObject *const *arguments, Py_ssize_t count,
                          PyObject *keywords)
{
    const tfa_op op = call->request.op;
    for (Py_ssize_t k = 0; k < count; k++) {
        const int row = position(op, k);
        if (row < 0)
            return raise_type(NULL, "%s(%s, ...): %zd arguments by position are too many",
                              op_name(op), op_rows[op - 1].positional, count);
        if (take_argument(call, row, arguments[k]))
            return -1;
    }
    const Py_ssize_t named = keywords ? PyTuple_Size(keywords) : 0;
    for (Py_ssize_t k = 0; k < named; k++) {
        PyObject *name = PyTuple_GetItem(keywords, k);
        const int row = input_find(name);
        if (row < 0 || (inputs[row].only_client && !call->for_client)) {
            char nearest[160];
            const char *text = PyUnicode_AsUTF8AndSize(name, NULL);
            PyErr_Clear();
            tfa_suggest(text ? text : "?", NULL, input_count, input_name_at, nearest,
                        sizeof nearest);
            return raise_type(text, "unknown argument '%.200s'; nearest: %s", text ? text : "?",
                              nearest);
        }
        if (take_argument(call, row, arguments[count + k]))
            return -1;
    }
    return 0;
}

/* An argument that the op does not use, and the words of `want` with which it would */
static int raise_unused(const request_call *call, const input_row *input)
{
    const int has_lambda_inv = (TFA_OP_BIT(call->request.op) & TFA_OPS_SOLVE) != 0;
    char words[200];
    tfa_want_write(input->flags & (has_lambda_inv ? TFA_WANT_ALL : TFA_WANT_MOTION), words,
                   sizeof words);
    return raise_type(input->name, "%s: %s does not use it%s%s", input->name,
                      op_name(call->request.op), words[0] ? " unless want has " : "", words);
}

static int read_phase(request_call *call, enum phase phase)
{
    for (uint32_t k = 0; k < call->given_count; k++) {
        const input_row *input = call->given[k].input;
        if (input->phase == phase && input->read(call, input, call->given[k].value))
            return -1;
    }
    return 0;
}

/* Arguments that the request cannot do without; tfa_request_check finds the rest. */
static int require(request_call *call)
{
    const tfa_request *request = &call->request;
    char joints[600], refusal[300];
    if (!request->q && call->robot->names.q_count) {
        (void)tfa_names_describe(&call->robot->names, 1, joints, sizeof joints);
        return raise_status(TFA_E_ARGUMENT, "q", "q: missing; the robot has %s", joints);
    }
    if (!request->base_pose && call->robot->names.base_freedoms)
        return raise_status(TFA_E_ARGUMENT, "base_pose",
                            "base_pose: missing; the base floats: x y z, quaternion x y z w");
    const uint32_t op = TFA_OP_BIT(request->op);
    tfa_want_refuse(request->flags, op, op_name(request->op), refusal, sizeof refusal);
    if (refusal[0])
        return raise_status(TFA_E_ARGUMENT, "want", "want: %s", refusal);
    if (op & TFA_OPS_TASK && !request->task_acceleration)
        return raise_status(TFA_E_ARGUMENT, "acceleration",
                            "acceleration: missing; {tip: 6 numbers, of a point 3}");
    if (!request->tip_count && (op & TFA_OPS_OSIM || request->flags & TFA_WANT_OF_TIPS))
        return raise_status(TFA_E_SIZE, "tips", "tips: missing; 1 to %d links", TFA_MAX_TIPS);
    return 0;
}

static int read_all(request_call *call, PyObject *const *arguments, Py_ssize_t count,
                    PyObject *keywords)
{
    if (take_arguments(call, arguments, count, keywords) || read_phase(call, PHASE_CHOICES))
        return -1;
    for (uint32_t k = 0; k < call->given_count; k++)
        if (!input_is_used(call->given[k].input, call->request.op, call->request.flags))
            return raise_unused(call, call->given[k].input);
    if (read_phase(call, PHASE_ARRAYS) || require(call) || finish_arrays(call) ||
        read_phase(call, PHASE_LAST))
        return -1;
    return call_allocate(call);
}

int call_read(request_call *call, const robot_names *robot, int for_client, tfa_op op,
              PyObject *const *arguments, Py_ssize_t count, PyObject *keywords)
{
    memset(call, 0, offsetof(struct request_call, staged));
    call->robot = robot;
    call->for_client = for_client;
    call->request.op = op;
    call->request.count = 1;
    call->request.refine = TFA_REFINE_DEFAULT;
    if (TFA_OP_BIT(op) & TFA_OPS_CONSTRAINED) /* unless the argument names some */
        call->request.constraints = tfa_all_constraints(robot->names.constraint_count);
    return read_all(call, arguments, count, keywords);
}

void call_clear(request_call *call)
{
    for (uint32_t k = 0; k < call->piece_count; k++)
        Py_DECREF(call->pieces[k].array);
    for (uint32_t k = 0; k < call->buffer_count; k++)
        PyMem_Free(call->buffers[k]);
    for (int k = 0; k < OUTPUT_COUNT; k++)
        Py_XDECREF(call->outputs[k]);
    Py_XDECREF(call->answers);
    Py_XDECREF(call->reused);
    PyMem_Free(call->locked);
}

size_t call_cost(const request_call *call)
{
    const size_t n = (size_t)call->robot->names.base_freedoms + call->robot->names.v_count + 1;
    const size_t rows = extent_size(EXTENT_ROWS, call->robot, &call->request) +
                        extent_size(EXTENT_CONSTRAINTS, call->robot, &call->request);
    const uint32_t squares = TFA_OPS_DERIVATIVES | TFA_OPS_ID_DERIVATIVES;
    const size_t state = TFA_OP_BIT(call->request.op) & squares ? n * n : n + rows * rows / 4;
    return state * call->request.count;
}
