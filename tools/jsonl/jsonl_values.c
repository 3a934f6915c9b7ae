/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Reads numbers out of JSON values: plain arrays, and joint values by order or by name; looks up
 * links.
 */
#include "jsonl_values.h"

#include <stdarg.h>
#include <string.h>

int jsonl_fail(jsonl_error *error, int status, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(error->text, sizeof error->text, format, arguments);
    va_end(arguments);
    error->status = status;
    return status;
}

int jsonl_explain(const tfa_names *names, const tfa_request *request, const tfa_reply *reply,
                  jsonl_error *error)
{
    (void)tfa_explain(names, request, reply, TFA_SYNTAX_JSON, error->text, sizeof error->text);
    error->status = reply->status;
    return reply->status;
}

const char *jsonl_type(const json_t *value)
{
    switch (json_typeof(value)) {
    case JSON_OBJECT:
        return "an object";
    case JSON_ARRAY:
        return "an array";
    case JSON_STRING:
        return "a string";
    case JSON_INTEGER:
    case JSON_REAL:
        return "a number";
    case JSON_TRUE:
    case JSON_FALSE:
        return "a boolean";
    default:
        return "null";
    }
}

int jsonl_numbers(jsonl_reader *r, const json_t *value, size_t count, double *out)
{
    if (!json_is_array(value))
        return jsonl_fail(r->error, TFA_E_ARGUMENT, "%s: %s, must be an array of %zu numbers",
                          r->key, jsonl_type(value), count);
    if (json_array_size(value) != count)
        return jsonl_fail(r->error, TFA_E_SIZE, "%s: %zu values, must be %zu", r->key,
                          json_array_size(value), count);
    for (size_t i = 0; i < count; i++) {
        const json_t *number = json_array_get(value, i);
        if (!json_is_number(number))
            return jsonl_fail(r->error, TFA_E_ARGUMENT, "%s[%zu]: %s, must be a number", r->key, i,
                              jsonl_type(number));
        out[i] = json_number_value(number);
    }
    return TFA_OK;
}

/* An array as long as if the numbers of a floating base stood in it */
static int fail_with_base(const jsonl_reader *r, int of_q, size_t size, const char *robot)
{
    return jsonl_fail(r->error, TFA_E_SIZE,
                      "%s: %zu values, the robot has %s; a floating base has a field of its own, "
                      "%s%s%s",
                      r->key, size, robot, tfa_base_field_name(r->key),
                      of_q ? " [x,y,z,qx,qy,qz,qw]" : "",
                      r->names->base_freedoms ? "" : "; this robot's base is fixed");
}

static int read_joint_array(jsonl_reader *r, const json_t *value, int of_q, double *out)
{
    uint32_t count = of_q ? r->names->q_count : r->names->v_count;
    char robot[512];
    if (json_array_size(value) != count) {
        (void)tfa_names_describe(r->names, of_q, robot, sizeof robot);
        if (json_array_size(value) == count + (of_q ? 7 : 6))
            return fail_with_base(r, of_q, json_array_size(value), robot);
        return jsonl_fail(r->error, TFA_E_SIZE, "%s: %zu values, the robot has %s", r->key,
                          json_array_size(value), robot);
    }
    for (uint32_t i = 0; i < count; i++) {
        const json_t *number = json_array_get(value, i);
        if (!json_is_number(number))
            return jsonl_fail(r->error, TFA_E_ARGUMENT, "%s[%u] (%s): %s, must be a number", r->key,
                              i, tfa_names_owner(r->names, of_q, i)->name, jsonl_type(number));
        out[i] = json_number_value(number);
    }
    return TFA_OK;
}

/* A joint left out stands at 0; a floating one at the identity, for a zero quaternion is none. */
static void rest(const tfa_names *names, int of_q, double *out)
{
    memset(out, 0, sizeof *out * (of_q ? names->q_count : names->v_count));
    for (uint32_t i = 0; of_q && i < names->joint_count; i++)
        if (names->joints[i].quaternion >= 0)
            out[names->joints[i].q_index + (uint32_t)names->joints[i].quaternion + 3] = 1.0;
}

static int read_joint_value(jsonl_reader *r, const tfa_joint_span *joint, const json_t *value,
                            int of_q, double *out)
{
    uint32_t first = of_q ? joint->q_index : joint->v_index;
    uint32_t count = of_q ? joint->q_count : joint->v_count;
    if (count == 1 && json_is_number(value)) {
        out[first] = json_number_value(value);
        return TFA_OK;
    }
    char key[320];
    snprintf(key, sizeof key, "%s.%s", r->key, joint->name);
    if (count == 1)
        return jsonl_fail(r->error, TFA_E_ARGUMENT, "%s: %s, must be a number", key,
                          jsonl_type(value));
    jsonl_reader inner = *r;
    inner.key = key;
    return jsonl_numbers(&inner, value, count, out + first);
}

static int read_joint_object(jsonl_reader *r, const json_t *value, int of_q, double *out)
{
    rest(r->names, of_q, out);
    const char *name;
    json_t *number;
    json_object_foreach((json_t *)value, name, number)
    {
        int64_t joint = tfa_names_joint(r->names, name);
        if (joint < 0) {
            return jsonl_no_joint(r, r->key, name);
        }
        int status = read_joint_value(r, &r->names->joints[joint], number, of_q, out);
        if (status != TFA_OK)
            return status;
    }
    return TFA_OK;
}

int jsonl_joints(jsonl_reader *r, const json_t *value, int of_q, double *out)
{
    if (json_is_array(value))
        return read_joint_array(r, value, of_q, out);
    if (json_is_object(value))
        return read_joint_object(r, value, of_q, out);
    return jsonl_fail(r->error, TFA_E_ARGUMENT,
                      "%s: %s, must be an array in joint order or an object {joint: value}", r->key,
                      jsonl_type(value));
}

int jsonl_no_joint(jsonl_reader *r, const char *key, const char *name)
{
    char text[900];
    tfa_names_unknown_joint(r->names, name, text, sizeof text);
    return jsonl_fail(r->error, TFA_E_JOINT, "%s: %s", key, text);
}

int jsonl_find_frame(jsonl_reader *r, const char *key, const char *link, uint32_t *frame)
{
    int64_t index = tfa_names_link(r->names, link);
    if (index < 0) {
        char text[500];
        tfa_names_unknown_link(r->names, link, text, sizeof text);
        return jsonl_fail(r->error, TFA_E_LINK, "%s: %s", key, text);
    }
    *frame = (uint32_t)index;
    return TFA_OK;
}
