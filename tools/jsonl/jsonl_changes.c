/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Reads the changes of the robot by a request: locked joints, payloads.
 */
#include "jsonl_values.h"

#include <string.h>

/* One name of a list of joints; `named` marks those that came before. */
static int read_joint(jsonl_reader *r, const json_t *name, size_t entry, uint32_t *joint)
{
    uint8_t *named = r->buffers->named;
    if (!json_is_string(name))
        return jsonl_fail(r->error, TFA_E_ARGUMENT, "%s[%zu]: %s, must be a joint name", r->key,
                          entry, jsonl_type(name));
    const char *text = json_string_value(name);
    int64_t index = tfa_names_joint(r->names, text);
    if (index < 0) {
        char key[64];
        snprintf(key, sizeof key, "%.40s[%zu]", r->key, entry);
        return jsonl_no_joint(r, key, text);
    }
    if (named[index])
        return jsonl_fail(r->error, TFA_E_JOINT, "%s[%zu]: joint '%.200s' twice; name it once",
                          r->key, entry, text);
    named[index] = 1;
    *joint = (uint32_t)index;
    return TFA_OK;
}

/* ["joint",...] into at most joint_count indices. */
static int read_joints(jsonl_reader *r, const json_t *list, uint32_t *joints, uint32_t *count)
{
    size_t names = json_array_size(list);
    memset(r->buffers->named, 0, r->names->joint_count);
    for (size_t i = 0; i < names; i++) {
        uint32_t joint = 0; /* no name comes twice: never more than there are joints */
        int status = read_joint(r, json_array_get(list, i), i, &joint);
        if (status != TFA_OK)
            return status;
        joints[i] = joint;
    }
    *count = (uint32_t)names;
    return TFA_OK;
}

int jsonl_read_locked(jsonl_reader *r, const json_t *value)
{
    if (!json_is_array(value))
        return jsonl_fail(r->error, TFA_E_ARGUMENT, "locked: %s, must be an array of joint names",
                          jsonl_type(value));
    r->request->locked = r->buffers->locked;
    return read_joints(r, value, r->buffers->locked, &r->request->locked_count);
}

/* The numbers of a payload, as in tfa_payload; absent ones are 0. */
static int read_payload_numbers(jsonl_reader *r, const json_t *payload, const char *entry,
                                double *numbers)
{
    const json_t *mass = json_object_get(payload, "mass");
    const json_t *com = json_object_get(payload, "com");
    const json_t *inertia = json_object_get(payload, "inertia");
    char key[64];
    jsonl_reader inner = *r;
    int status = TFA_OK;
    inner.key = key;
    memset(numbers, 0, TFA_PAYLOAD_NUMBERS * sizeof *numbers);
    if (!json_is_number(mass))
        return jsonl_fail(r->error, TFA_E_ARGUMENT, "%s.mass: %s, must be a number in kg", entry,
                          mass ? jsonl_type(mass) : "missing");
    numbers[0] = json_number_value(mass);
    snprintf(key, sizeof key, "%s.com", entry);
    if (com)
        status = jsonl_numbers(&inner, com, 3, numbers + 1);
    if (status != TFA_OK)
        return status;
    snprintf(key, sizeof key, "%s.inertia", entry);
    return inertia ? jsonl_numbers(&inner, inertia, 6, numbers + 4) : TFA_OK;
}

/* Every key of a payload is one of four. */
static int check_payload_keys(jsonl_reader *r, const json_t *payload, const char *entry)
{
    const char *key;
    json_t *value;
    json_object_foreach((json_t *)payload, key, value)
    {
        if (strcmp(key, "link") != 0 && strcmp(key, "mass") != 0 && strcmp(key, "com") != 0 &&
            strcmp(key, "inertia") != 0)
            return jsonl_fail(r->error, TFA_E_ARGUMENT,
                              "%s: unknown key '%.200s'; there are link, mass, com, inertia", entry,
                              key);
    }
    return TFA_OK;
}

static int read_one_payload(jsonl_reader *r, const json_t *payload, const char *entry)
{
    uint32_t at = r->request->payload_count;
    const json_t *link = json_object_get(payload, "link");
    char key[64];
    if (!json_is_object(payload))
        return jsonl_fail(r->error, TFA_E_ARGUMENT,
                          "%s: %s, must be an object {link, mass, com, inertia}", entry,
                          jsonl_type(payload));
    int status = check_payload_keys(r, payload, entry);
    if (status != TFA_OK)
        return status;
    snprintf(key, sizeof key, "%s.link", entry);
    if (!json_is_string(link))
        return jsonl_fail(r->error, TFA_E_ARGUMENT, "%s: %s, must be a link name", key,
                          link ? jsonl_type(link) : "missing");
    status = jsonl_find_frame(r, key, json_string_value(link), &r->request->payload_frames[at]);
    if (status == TFA_OK)
        status = read_payload_numbers(r, payload, entry,
                                      r->buffers->payloads + TFA_PAYLOAD_NUMBERS * (size_t)at);
    r->request->payload_count = at + 1;
    return status;
}

int jsonl_read_payload(jsonl_reader *r, const json_t *value)
{
    r->request->payloads = r->buffers->payloads;
    if (!json_is_array(value))
        return read_one_payload(r, value, "payload");
    size_t count = json_array_size(value);
    if (count > TFA_MAX_PAYLOADS)
        return jsonl_fail(r->error, TFA_E_SIZE, "payload: %zu of them, at most %d", count,
                          TFA_MAX_PAYLOADS);
    for (size_t i = 0; i < count; i++) {
        char entry[32];
        snprintf(entry, sizeof entry, "payload[%zu]", i);
        int status = read_one_payload(r, json_array_get(value, i), entry);
        if (status != TFA_OK)
            return status;
    }
    return TFA_OK;
}
