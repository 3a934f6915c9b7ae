/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Turns a reply with a bad status into a sentence: the error, its place and its value.
 */
#include "jsonl.h"

#include <math.h>
#include <string.h>

/* The numbers of one state that a field stands for; NULL when the field is no array. */
static const double *field_numbers(const tfa_request *request, tfa_field field)
{
    switch (field) {
    case TFA_FIELD_Q:
        return request->q;
    case TFA_FIELD_V:
        return request->v;
    case TFA_FIELD_TAU:
        return request->tau;
    case TFA_FIELD_QDD:
        return request->qdd;
    case TFA_FIELD_BASE_POSE:
        return request->base_pose;
    case TFA_FIELD_BASE_TWIST:
        return request->base_twist;
    case TFA_FIELD_BASE_WRENCH:
        return request->base_wrench;
    case TFA_FIELD_BASE_ACCELERATION:
        return request->base_acceleration;
    case TFA_FIELD_GRAVITY:
        return request->gravity;
    case TFA_FIELD_WRENCHES:
        return request->wrenches;
    case TFA_FIELD_TASK_ACCELERATION:
        return request->task_acceleration;
    default:
        return NULL;
    }
}

static int is_joint_field(tfa_field field)
{
    return field == TFA_FIELD_Q || field == TFA_FIELD_V || field == TFA_FIELD_TAU ||
           field == TFA_FIELD_QDD;
}

/* The key of a field: posture torques are the tau of task torques. */
static const char *field_key(const tfa_request *request, tfa_field field)
{
    return request->op == TFA_OP_TASK_TORQUES && field == TFA_FIELD_TAU ? "posture_torques"
                                                                        : tfa_field_name(field);
}

/* "q[3] (elbow)", "base_pose[2]", "wrenches": where the trouble is. */
static void name_entry(const robot_names *names, const tfa_request *request, const tfa_reply *reply,
                       char *entry, size_t size)
{
    const char *field = field_key(request, reply->field);
    const robot_joint *joint = NULL;
    if (is_joint_field(reply->field))
        joint = robot_names_owner(names, reply->field == TFA_FIELD_Q, reply->index);
    if (joint)
        snprintf(entry, size, "%s[%u] (%s)", field, reply->index, joint->name);
    else if (field_numbers(request, reply->field))
        snprintf(entry, size, "%s[%u]", field, reply->index);
    else
        snprintf(entry, size, "%s", field);
}

static int explain_quaternion(const robot_names *names, const tfa_request *request,
                              const tfa_reply *reply, jsonl_error *error)
{
    const double *quaternion = NULL;
    char entry[320] = "base_pose";
    if (reply->field == TFA_FIELD_BASE_POSE && request->base_pose)
        quaternion = request->base_pose + 3;
    const robot_joint *joint = robot_names_owner(names, 1, reply->index);
    if (reply->field == TFA_FIELD_Q && joint && joint->q_count == 7) {
        quaternion = request->q + joint->q_index + 3;
        snprintf(entry, sizeof entry, "q[%u] (%s)", reply->index, joint->name);
    }
    if (!quaternion)
        return jsonl_fail(error, reply->status, "%s: %s", tfa_field_name(reply->field),
                          tfa_status_text(reply->status));
    double norm = 0;
    for (int i = 0; i < 4; i++)
        norm = hypot(norm, quaternion[i]);
    return jsonl_fail(error, reply->status,
                      "%s: quaternion of norm %.6g, must be 1 within 1e-3 (order x y z w)", entry,
                      norm);
}

/* "body 'forearm': "; "" when it is about none. */
static void name_body(const robot_names *names, const tfa_reply *reply, char *body, size_t size)
{
    if (reply->field != TFA_FIELD_BODY)
        snprintf(body, size, "%s", "");
    else
        snprintf(body, size, "body '%s': ", robot_names_frame_name(names, reply->index));
}

/* " with locked joints": the part of the request that the method refuses */
static const char *unsupported_part(const tfa_request *request, tfa_field field)
{
    if (field == TFA_FIELD_LOCKED)
        return " with locked joints; aba does";
    return request->op == TFA_OP_FORWARD_DYNAMICS && request->tip_count ? " with tips" : "";
}

static int explain_payload(const robot_names *names, const tfa_request *request,
                           const tfa_reply *reply, jsonl_error *error)
{
    uint32_t k = reply->index < request->payload_count ? reply->index : 0;
    char entry[32] = "payload";
    if (request->payload_count > 1)
        snprintf(entry, sizeof entry, "payload[%u]", k);
    if (reply->status == TFA_E_UNSUPPORTED)
        return jsonl_fail(error, reply->status,
                          "%s: link '%.200s' moves with some joints of a body and not with "
                          "others, without mass of its own; load a link at its end",
                          entry, robot_names_frame_name(names, request->payload_frames[k]));
    if (reply->status == TFA_E_ARGUMENT && request->payloads) {
        double mass = request->payloads[TFA_PAYLOAD_NUMBERS * (size_t)k];
        if (mass < 0)
            return jsonl_fail(error, reply->status, "%s.mass: %g: must not be negative", entry,
                              mass);
        return jsonl_fail(error, reply->status,
                          "%s.inertia: no body of %g kg has it; give ixx,ixy,ixz,iyy,iyz,izz about "
                          "the centre of mass, with eigenvalues that are not negative",
                          entry, mass);
    }
    return jsonl_fail(error, reply->status, "%s: %s: %s", entry, tfa_status_text(reply->status),
                      tfa_status_cause(reply->status));
}

/* Changes of the robot by a request: payloads, locked joints. @return 0: nothing of
 * that is named */
static int explain_change(const robot_names *names, const tfa_request *request,
                          const tfa_reply *reply, jsonl_error *error)
{
    if (reply->field == TFA_FIELD_PAYLOADS)
        return explain_payload(names, request, reply, error);
    if (reply->status == TFA_E_UNSUPPORTED && reply->field == TFA_FIELD_LOCKED)
        return jsonl_fail(error, reply->status, "locked: %s does not go with locked joints",
                          jsonl_op_name(request->op));
    return 0;
}

/* Tips: rank lost, more of them than the daemon reserved memory for. @return as explain_change */
static int explain_tips(const tfa_request *request, const tfa_reply *reply, jsonl_error *error)
{
    const uint32_t rows = request->rows == TFA_ROWS_POINT ? 3 : 6;
    if (reply->field != TFA_FIELD_TIPS)
        return 0;
    if (reply->status == TFA_E_RANK)
        return jsonl_fail(error, reply->status,
                          "tips: lambda_inv has rank %u of %u here; \"rank_loss\":\"truncate\" or "
                          "\"damp\" answers",
                          reply->index, rows * request->tip_count);
    if (reply->status == TFA_E_UNSUPPORTED && request->tip_count > reply->index)
        return jsonl_fail(error, reply->status, "tips: %u links, there is memory for %u",
                          request->tip_count, reply->index);
    return 0;
}

/* Limits of the robot's size, and memory that was not reserved. @return as explain_change */
static int explain_limit(const robot_names *names, const tfa_request *request,
                         const tfa_reply *reply, jsonl_error *error)
{
    const char *op = jsonl_op_name(request->op), *method = tfa_method_name(request->method);
    const int of_method = reply->field == TFA_FIELD_METHOD;
    if (reply->status != TFA_E_UNSUPPORTED || (!of_method && reply->field != TFA_FIELD_OP))
        return 0;
    if (tfa_limit_text(reply)[0])
        return jsonl_fail(error, reply->status, "%s: %s of a robot of %u freedoms: %s",
                          tfa_field_name(reply->field), of_method ? method : op,
                          names->base_freedoms + names->v_count, tfa_limit_text(reply));
    if (of_method || request->op == TFA_OP_MASS_MATRIX)
        return jsonl_fail(error, reply->status,
                          "%s: no memory was reserved for %s; in the daemon's configuration, "
                          "methods: all of the robot reserves it",
                          tfa_field_name(reply->field), of_method ? method : "the mass matrix");
    return 0;
}

int jsonl_explain(const robot_names *names, const tfa_request *request, const tfa_reply *reply,
                  jsonl_error *error)
{
    int status = reply->status;
    const char *text = tfa_status_text(status), *cause = tfa_status_cause(status);
    char entry[320], body[300];
    name_entry(names, request, reply, entry, sizeof entry);
    name_body(names, reply, body, sizeof body);
    switch (status) {
    case TFA_E_QUATERNION:
        return explain_quaternion(names, request, reply, error);
    case TFA_E_SINGULAR:
        return jsonl_fail(error, status, "%s: %s%s: %s", tfa_method_name(request->method), body,
                          text, cause);
    case TFA_E_METHOD:
        return jsonl_fail(error, status, "method: %s does not answer %s%s",
                          tfa_method_name(request->method), jsonl_op_name(request->op),
                          unsupported_part(request, reply->field));
    case TFA_E_NOT_COMPUTED:
        return jsonl_fail(error, status, "%s: %s%s: %s", jsonl_op_name(request->op), body, text,
                          cause);
    default:
        break;
    }
    if (explain_change(names, request, reply, error) || explain_tips(request, reply, error) ||
        explain_limit(names, request, reply, error))
        return status;
    const double *numbers = field_numbers(request, reply->field);
    if (status == TFA_E_VALUE && numbers)
        return jsonl_fail(error, status, "%s: %g: %s", entry, numbers[reply->index], text);
    if (reply->field != TFA_FIELD_NONE)
        return jsonl_fail(error, status, "%s: %s: %s", entry, text, cause);
    return jsonl_fail(error, status, "%s of robot '%s': %s: %s", jsonl_op_name(request->op),
                      names->robot, text, cause);
}
