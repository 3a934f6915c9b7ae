/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Turns a reply with an error into an exception: place, value, reason, remedy.
 */
#include "call.h"
#include "errors.h"
#include "fields.h"
#include "robot.h"

#include <math.h>
#include <stdio.h>

/** What the exception is about */
typedef struct error_place {
    const char *field;    /**< keyword; NULL: none */
    char entry[400];      /**< "q[3] (elbow) of state 17" */
    const char *joint;    /**< that owns the entry; NULL: none */
    const char *link;     /**< NULL: none */
    const double *number; /**< invalid number; NULL: none */
} error_place;

static int is_joint_field(tfa_field field)
{
    return field == TFA_FIELD_Q || field == TFA_FIELD_V || field == TFA_FIELD_TAU ||
           field == TFA_FIELD_QDD;
}

/* Link that the index of a reply names */
static const char *link_of(const robot_names *robot, const tfa_request *request,
                           const tfa_reply *answer)
{
    const uint32_t k = answer->index;
    switch (answer->field) {
    case TFA_FIELD_BODY:
        return robot_link_name(robot, k);
    case TFA_FIELD_TIPS:
        return answer->status == TFA_E_LINK && k < request->tip_count
                   ? robot_link_name(robot, request->tips[k])
                   : NULL;
    case TFA_FIELD_PAYLOADS:
        return k < request->payload_count ? robot_link_name(robot, request->payload_frames[k])
                                          : NULL;
    case TFA_FIELD_WRENCHES:
        return k / 6 < request->wrench_count ? robot_link_name(robot, request->wrench_frames[k / 6])
                                             : NULL;
    default:
        return NULL;
    }
}

static void find_place(const robot_names *robot, const tfa_request *request,
                       const tfa_reply *answer, error_place *at)
{
    const input_row *input = input_of_field(answer->field, request->op);
    const char *owner = is_joint_field(answer->field)
                            ? robot_owner(robot, answer->field == TFA_FIELD_Q, answer->index)
                            : NULL;
    const uint32_t width = input ? input_width(input, robot, request) : 0;
    *at =
        (error_place){.field = input ? input->name : tfa_field_name(answer->field), .joint = owner};
    at->link = link_of(robot, request, answer);
    if (!at->field[0])
        at->field = NULL;
    int used = snprintf(at->entry, sizeof at->entry, "%s", at->field ? at->field : "");
    if (width) {
        const double *numbers = *(const double *const *)((const char *)request + input->member);
        at->number = numbers ? numbers + (size_t)width * answer->state + answer->index : NULL;
        used += snprintf(at->entry + used, sizeof at->entry - (size_t)used, "[%u]", answer->index);
        if (owner || at->link)
            used += snprintf(at->entry + used, sizeof at->entry - (size_t)used, " (%.200s)",
                             owner ? owner : at->link);
        if (request->count > 1)
            snprintf(at->entry + used, sizeof at->entry - (size_t)used, " of state %u",
                     answer->state);
    }
}

static void explain_quaternion(const error_place *at, const tfa_reply *answer, char *text,
                               size_t size)
{
    double norm = 0;
    /* the index is that of the quaternion's first number */
    for (int i = 0; at->number && i < 4; i++)
        norm = hypot(norm, at->number[i]);
    snprintf(text, size, "%s: quaternion of norm %.6g, must be 1 within 1e-3 (order x y z w)",
             at->entry[0] ? at->entry : tfa_field_name(answer->field), norm);
}

static void explain_payload(const tfa_request *request, const tfa_reply *answer,
                            const error_place *at, char *text, size_t size)
{
    const char *link = at->link ? at->link : "?";
    if (answer->status == TFA_E_UNSUPPORTED)
        snprintf(text, size,
                 "payload on '%.200s': the link moves with some joints of a body and not with "
                 "others, without mass of its own; load a link at its end",
                 link);
    else if (answer->status == TFA_E_ARGUMENT && answer->index < request->payload_count)
        snprintf(text, size,
                 "payload on '%.200s': no body of %g kg has this inertia; mass and the eigenvalues "
                 "of ixx ixy ixz iyy iyz izz about the centre of mass must not be negative",
                 link, request->payloads[TFA_PAYLOAD_NUMBERS * (size_t)answer->index]);
    else
        snprintf(text, size, "payload: %s: %s", tfa_status_text(answer->status),
                 tfa_status_cause(answer->status));
}

static void explain_tips(const tfa_request *request, const tfa_reply *answer, char *text,
                         size_t size)
{
    const uint32_t rows = (request->rows == TFA_ROWS_POINT ? 3u : 6u) * request->tip_count;
    if (answer->status == TFA_E_RANK)
        snprintf(text, size,
                 "tips: lambda_inv has rank %u of %u here; rank_loss='truncate' or 'damp' answers",
                 answer->index, rows);
    else
        snprintf(text, size, "tips: %u links, there is memory for %u (max_tips)",
                 request->tip_count, answer->index);
}

static void explain_method(const tfa_request *request, const tfa_reply *answer,
                           const error_place *at, char *text, size_t size)
{
    const char *method = tfa_method_name((uint32_t)request->method);
    const char *op = op_name(request->op);
    if (answer->status == TFA_E_SINGULAR)
        snprintf(text, size, "%s: body '%.200s': %s: %s", method, at->link ? at->link : "?",
                 tfa_status_text(answer->status), tfa_status_cause(answer->status));
    else if (answer->status == TFA_E_METHOD)
        snprintf(text, size, "method: %s does not answer %s%s", method, op,
                 answer->field == TFA_FIELD_LOCKED ? " with locked joints; aba does" : "");
    else
        snprintf(text, size, "%s%s%s: %s: %s", op, at->link ? " of " : "", at->link ? at->link : "",
                 tfa_status_text(answer->status), tfa_status_cause(answer->status));
}

/* Limits of the robot's size, and memory that was not reserved. Returns 0 for other reasons. */
static int explain_limit(const robot_names *robot, const tfa_request *request,
                         const tfa_reply *answer, char *text, size_t size)
{
    const int of_method = answer->field == TFA_FIELD_METHOD;
    const char *method = tfa_method_name((uint32_t)request->method), *op = op_name(request->op);
    const char *limit = tfa_limit_text(answer);
    if (answer->status != TFA_E_UNSUPPORTED || (!of_method && answer->field != TFA_FIELD_OP) ||
        (!limit[0] && !of_method && request->op != TFA_OP_MASS_MATRIX))
        return 0;
    if (limit[0])
        snprintf(text, size, "%s: %s of a robot of %u freedoms: %s", tfa_field_name(answer->field),
                 of_method ? method : op, robot->base_freedoms + robot->v_count, limit);
    else
        snprintf(text, size,
                 "%s: no memory was reserved for %s; methods=['%s'] of a Workspace or Pool "
                 "reserves it, of a daemon methods: all in its configuration",
                 tfa_field_name(answer->field), of_method ? method : op,
                 of_method ? method : "crba");
    return 1;
}

static void explain(const robot_names *robot, const tfa_request *request, const tfa_reply *answer,
                    const error_place *at, char *text, size_t size)
{
    const char *summary = tfa_status_text(answer->status),
               *cause = tfa_status_cause(answer->status);
    if (explain_limit(robot, request, answer, text, size))
        return;
    if (answer->status == TFA_E_QUATERNION)
        explain_quaternion(at, answer, text, size);
    else if (answer->status == TFA_E_SINGULAR || answer->status == TFA_E_METHOD ||
             answer->status == TFA_E_NOT_COMPUTED)
        explain_method(request, answer, at, text, size);
    else if (answer->field == TFA_FIELD_PAYLOADS)
        explain_payload(request, answer, at, text, size);
    else if (answer->field == TFA_FIELD_TIPS &&
             (answer->status == TFA_E_RANK || answer->status == TFA_E_UNSUPPORTED))
        explain_tips(request, answer, text, size);
    else if (answer->status == TFA_E_UNSUPPORTED && answer->field == TFA_FIELD_LOCKED)
        snprintf(text, size, "locked: %s does not go with locked joints", op_name(request->op));
    else if (answer->status == TFA_E_VALUE && at->number)
        snprintf(text, size, "%s: %g: %s", at->entry, *at->number, summary);
    else
        snprintf(text, size, "%s: %s: %s", at->entry[0] ? at->entry : op_name(request->op), summary,
                 cause);
}

static PyObject *optional_text(const char *text)
{
    return text ? PyUnicode_FromString(text) : Py_NewRef(Py_None);
}

int raise_reply(const robot_names *robot, const tfa_request *request, const tfa_reply *answer,
                PyObject *reply)
{
    char text[ERROR_TEXT];
    error_place at;
    find_place(robot, request, answer, &at);
    explain(robot, request, answer, &at, text, sizeof text);
    if (raise_status(answer->status, at.field, "%s", text) != -1)
        return -1;
    PyObject *type, *value, *trace;
    PyErr_Fetch(&type, &value, &trace);
    PyErr_NormalizeException(&type, &value, &trace);
    const struct {
        const char *name;
        PyObject *value;
    } attributes[] = {
        {"index", PyLong_FromUnsignedLong(answer->index)},
        {"state", PyLong_FromUnsignedLong(answer->state)},
        {"joint", optional_text(at.joint)},
        {"link", optional_text(at.link)},
        {"reply", Py_NewRef(reply ? reply : Py_None)},
    };
    for (size_t i = 0; i < sizeof attributes / sizeof *attributes; i++) {
        if (attributes[i].value && value)
            PyObject_SetAttrString(value, attributes[i].name, attributes[i].value);
        Py_XDECREF(attributes[i].value);
    }
    PyErr_Clear();
    PyErr_Restore(type, value, trace);
    return -1;
}
