/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Reads the active constraints and what belongs to them: wanted accelerations, gains, weights of
 * torques.
 */
#include "interface/fields.h"
#include "jsonl_values.h"

#include <string.h>

/* Looks a constraint up; `key` stands for it in the message. */
static int find_constraint(jsonl_reader *r, const char *key, const char *name, uint32_t *found)
{
    const int32_t index = tfa_names_constraint(r->names, name);
    if (index < 0) {
        char text[900];
        tfa_names_unknown_constraint(r->names, name, text, sizeof text);
        return jsonl_fail(r->error, TFA_E_ARGUMENT, "%s: %s", key, text);
    }
    *found = (uint32_t)index;
    return TFA_OK;
}

static int read_name(jsonl_reader *r, const json_t *name, size_t entry)
{
    uint32_t k = 0;
    char key[48];
    snprintf(key, sizeof key, "constraints[%zu]", entry);
    if (!json_is_string(name))
        return jsonl_fail(r->error, TFA_E_ARGUMENT, "%s: %s, must be the name of a constraint", key,
                          jsonl_type(name));
    const int status = find_constraint(r, key, json_string_value(name), &k);
    if (status != TFA_OK)
        return status;
    if (r->request->constraints >> k & 1)
        return jsonl_fail(r->error, TFA_E_ARGUMENT, "%s: constraint '%.200s' twice; name it once",
                          key, json_string_value(name));
    r->request->constraints |= 1u << k;
    return TFA_OK;
}

int jsonl_read_constraints(jsonl_reader *r, const json_t *value)
{
    if (!json_is_array(value))
        return jsonl_fail(r->error, TFA_E_ARGUMENT,
                          "constraints: %s, must be an array of names of constraints",
                          jsonl_type(value));
    r->constraints_given = 1;
    int status = TFA_OK;
    for (size_t k = 0; status == TFA_OK && k < json_array_size(value); k++)
        status = read_name(r, json_array_get(value, k), k);
    return status;
}

int jsonl_read_constraint_acceleration(jsonl_reader *r, const json_t *value)
{
    if (!json_is_object(value))
        return jsonl_fail(
            r->error, TFA_E_ARGUMENT,
            "constraint_acceleration: %s, must be an object {constraint: [6 numbers]}",
            jsonl_type(value));
    r->constraint_acceleration = value;
    return TFA_OK;
}

int jsonl_read_stabilisation(jsonl_reader *r, const json_t *value)
{
    r->request->stabilisation = r->buffers->stabilisation;
    return jsonl_numbers(r, value, 2, r->buffers->stabilisation);
}

/* As tau, but joints left out have the weight 1. */
int jsonl_read_torque_weights(jsonl_reader *r, const json_t *value)
{
    double *weights = r->buffers->torque_weights;
    const int status = jsonl_joints(r, value, 0, weights);
    r->request->torque_weights = weights;
    for (uint32_t j = 0; status == TFA_OK && json_is_object(value) && j < r->names->joint_count;
         j++) {
        const tfa_joint_span *joint = &r->names->joints[j];
        for (uint32_t i = 0; !json_object_get(value, joint->name) && i < joint->v_count; i++)
            weights[joint->v_index + i] = 1;
    }
    return status;
}

/* One acceleration, to its place among the active constraints */
static int read_one(jsonl_reader *r, const char *name, const json_t *six)
{
    uint32_t k = 0;
    int status = find_constraint(r, "constraint_acceleration", name, &k);
    if (status != TFA_OK)
        return status;
    const uint32_t active = r->request->constraints;
    if (!(active >> k & 1))
        return jsonl_fail(r->error, TFA_E_ARGUMENT,
                          "constraint_acceleration: '%.200s' is not active; name it in constraints",
                          name);
    char key[320];
    snprintf(key, sizeof key, "constraint_acceleration.%.200s", name);
    jsonl_reader inner = *r;
    inner.key = key;
    const int before = __builtin_popcount(active & ((1u << k) - 1));
    return jsonl_numbers(&inner, six, 6, r->buffers->constraint_acceleration + 6 * before);
}

int jsonl_finish_constraints(jsonl_reader *r)
{
    if (!r->constraints_given)
        r->request->constraints = tfa_all_constraints(r->names->constraint_count);
    if (!r->constraint_acceleration)
        return TFA_OK;
    double *numbers = r->buffers->constraint_acceleration;
    memset(numbers, 0, sizeof r->buffers->constraint_acceleration);
    r->request->constraint_acceleration = numbers;
    int status = TFA_OK;
    const char *name;
    json_t *six;
    json_object_foreach((json_t *)r->constraint_acceleration, name, six)
    {
        status = read_one(r, name, six);
        if (status != TFA_OK)
            break;
    }
    return status;
}
