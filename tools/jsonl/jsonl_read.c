/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Reads a request out of a JSON object: one table says which keys exist, which ops use them and
 * which function reads them.
 */
#include "common/suggest.h"
#include "interface/want_words.h"
#include "jsonl_values.h"

#include <stdlib.h>
#include <string.h>
#include <totalforce/text.h>

/* The base fields exist for a floating base only. */
static int read_base(jsonl_reader *r, const json_t *value, size_t count, double *out)
{
    if (r->names->base_freedoms == 0)
        return jsonl_fail(r->error, TFA_E_ARGUMENT, "%s: the robot's base is fixed", r->key);
    return jsonl_numbers(r, value, count, out);
}

/* The same of modes */
static int read_modes(jsonl_reader *r, const json_t *value, size_t unused, double *out)
{
    (void)unused;
    if (r->names->mode_count == 0)
        return jsonl_fail(r->error, TFA_E_ARGUMENT, "%s: the robot has no flexible links", r->key);
    return jsonl_numbers(r, value, r->names->mode_count, out);
}

/* Readers of numbers into the member of the same name: jsonl_read_KEY */
#define READER(key, member, read, how)                                                             \
    static int jsonl_read_##key(jsonl_reader *r, const json_t *value)                              \
    {                                                                                              \
        r->request->member = r->buffers->member;                                                   \
        return read(r, value, how, r->buffers->member);                                            \
    }
READER(q, q, jsonl_joints, 1)
READER(v, v, jsonl_joints, 0)
READER(tau, tau, jsonl_joints, 0)
READER(posture_torques, tau, jsonl_joints, 0)
READER(qdd, qdd, jsonl_joints, 0)
READER(base_pose, base_pose, read_base, 7)
READER(base_twist, base_twist, read_base, 6)
READER(base_wrench, base_wrench, read_base, 6)
READER(base_acceleration, base_acceleration, read_base, 6)
READER(gravity, gravity, jsonl_numbers, 3)
READER(modes, modes, read_modes, 0)
READER(mode_velocities, mode_velocities, read_modes, 0)
#undef READER

static int jsonl_read_wrench(jsonl_reader *r, const json_t *value)
{
    if (!json_is_object(value))
        return jsonl_fail(r->error, TFA_E_ARGUMENT,
                          "wrench: %s, must be an object {link: [fx,fy,fz,tx,ty,tz]}",
                          jsonl_type(value));
    if (json_object_size(value) > TFA_MAX_WRENCHES)
        return jsonl_fail(r->error, TFA_E_SIZE, "wrench: %zu links, at most %d",
                          json_object_size(value), TFA_MAX_WRENCHES);
    const char *link;
    json_t *six;
    uint32_t count = 0;
    json_object_foreach((json_t *)value, link, six)
    {
        char key[320];
        snprintf(key, sizeof key, "wrench.%.200s", link);
        jsonl_reader inner = *r;
        inner.key = key;
        int status = jsonl_find_frame(r, "wrench", link, &r->request->wrench_frames[count]);
        if (status == TFA_OK)
            status = jsonl_numbers(&inner, six, 6, r->buffers->wrenches + 6 * count);
        if (status != TFA_OK)
            return status;
        count++;
    }
    r->request->wrench_count = count;
    r->request->wrenches = count ? r->buffers->wrenches : NULL;
    return TFA_OK;
}

static int jsonl_read_method(jsonl_reader *r, const json_t *value)
{
    if (!json_is_string(value))
        return jsonl_fail(r->error, TFA_E_ARGUMENT, "method: %s, must be a string",
                          jsonl_type(value));
    const char *name = json_string_value(value);
    const int32_t method = tfa_method_find(name);
    if (method < 0) {
        char list[512];
        suggest_methods(name, list, sizeof list);
        return jsonl_fail(r->error, TFA_E_METHOD, "method: no '%.200s'; %s", name, list);
    }
    r->request->method = (tfa_method)method;
    return TFA_OK;
}

static int jsonl_read_refine(jsonl_reader *r, const json_t *value)
{
    if (!json_is_integer(value) || json_integer_value(value) < 0 ||
        json_integer_value(value) > TFA_MAX_REFINE)
        return jsonl_fail(r->error, TFA_E_ARGUMENT, "refine: must be 0, 1, 2 or 3");
    r->request->refine = (uint32_t)json_integer_value(value);
    return TFA_OK;
}

/* Value of a word, -1 of anything else */
static int32_t find_word(tfa_words of, const json_t *value)
{
    return json_is_string(value) ? tfa_word_find(of, json_string_value(value)) : -1;
}

static int jsonl_read_frame(jsonl_reader *r, const json_t *value)
{
    const int32_t frame = find_word(TFA_WORDS_FRAME, value);
    if (frame < 0)
        return jsonl_fail(r->error, TFA_E_ARGUMENT,
                          "frame: must be \"world\", \"local\" or \"local_world_aligned\"");
    r->request->frame = (tfa_reference_frame)frame;
    return TFA_OK;
}

static int jsonl_read_estimate(jsonl_reader *r, const json_t *value)
{
    const int32_t estimate = find_word(TFA_WORDS_ESTIMATE, value);
    if (estimate < 0)
        return jsonl_fail(r->error, TFA_E_ARGUMENT,
                          "estimate: must be \"default\", \"always\" or \"never\"");
    r->request->estimate = (tfa_estimate)estimate;
    return TFA_OK;
}

/* Keys that are read before or after all others */
static int read_apart(jsonl_reader *r, const json_t *value)
{
    (void)r;
    (void)value;
    return TFA_OK;
}

#define KEY(key, ops, flags) {#key, ops, flags, jsonl_read_##key},
static const struct {
    const char *name;
    uint32_t ops, flags;
    int (*read)(jsonl_reader *, const json_t *);
} keys[] = {
    {"id", TFA_OPS_ALL, 0, read_apart},
    {"op", TFA_OPS_ALL, 0, read_apart},
    {"want", TFA_OPS_ALL, 0, read_apart},
    TFA_KEY_LIST(KEY) /* the rest */
};
#undef KEY

static int read_op(jsonl_reader *r, const json_t *object)
{
    const json_t *op = json_object_get(object, "op");
    const char *name = json_is_string(op) ? json_string_value(op) : "";
    const int32_t found = find_word(TFA_WORDS_OP, op);
    if (found >= 0) {
        r->request->op = (tfa_op)found;
        return TFA_OK;
    }
    uint32_t count;
    const char *const *words = tfa_word_list(TFA_WORDS_OP, &count) + TFA_OP_FORWARD_DYNAMICS;
    char list[512];
    tfa_suggest_words(name, words, count - TFA_OP_FORWARD_DYNAMICS, list, sizeof list);
    if (json_is_string(op))
        return jsonl_fail(r->error, TFA_E_ARGUMENT, "op: no '%.200s'; %s", name, list);
    return jsonl_fail(r->error, TFA_E_ARGUMENT, "op: %s%s; %s", op ? jsonl_type(op) : "missing",
                      op ? ", must be a string" : "", strstr(list, "there are"));
}

enum { KEY_COUNT = sizeof keys / sizeof keys[0] };

static const char *key_name(const void *unused, size_t index)
{
    (void)unused;
    return keys[index].name;
}

static int unknown_key(jsonl_reader *r, const char *key)
{
    char suggestions[160];
    tfa_suggest(key, NULL, KEY_COUNT, key_name, suggestions, sizeof suggestions);
    return jsonl_fail(r->error, TFA_E_ARGUMENT, "unknown key '%.200s'; nearest: %s", key,
                      suggestions);
}

/* A key that the op does not use, and the answers with which it would */
static int unused_key(jsonl_reader *r, size_t key)
{
    const int has_lambda_inv = (TFA_OP_BIT(r->request->op) & TFA_OPS_SOLVE) != 0;
    char words[200];
    tfa_want_write(keys[key].flags & (has_lambda_inv ? TFA_WANT_ALL : TFA_WANT_MOTION), words,
                   sizeof words);
    return jsonl_fail(r->error, TFA_E_ARGUMENT, "%s: %s does not use it%s%s", keys[key].name,
                      tfa_word(TFA_WORDS_OP, r->request->op), words[0] ? " unless want has " : "",
                      words);
}

static int read_key(jsonl_reader *r, const char *key, const json_t *value)
{
    for (size_t i = 0; i < KEY_COUNT; i++) {
        if (strcmp(keys[i].name, key) != 0)
            continue;
        if (!(keys[i].ops & TFA_OP_BIT(r->request->op)) && !(keys[i].flags & r->request->flags))
            return unused_key(r, i);
        r->key = keys[i].name;
        return keys[i].read(r, value);
    }
    return unknown_key(r, key);
}

/* Required keys, checked once every key was read */
static int require(jsonl_reader *r)
{
    tfa_request *request = r->request;
    if (!request->q && r->names->q_count) {
        char robot[512];
        (void)tfa_names_describe(r->names, 1, robot, sizeof robot);
        return jsonl_fail(r->error, TFA_E_ARGUMENT, "q: missing; the robot has %s", robot);
    }
    if (!request->q)
        request->q = r->buffers->q;
    if (!request->base_pose && r->names->base_freedoms)
        return jsonl_fail(r->error, TFA_E_ARGUMENT,
                          "base_pose: missing; the base floats: [x,y,z,qx,qy,qz,qw]");
    const uint32_t op = TFA_OP_BIT(request->op);
    char refusal[300];
    tfa_want_refuse(request->flags, op, tfa_word(TFA_WORDS_OP, request->op), refusal,
                    sizeof refusal);
    if (refusal[0])
        return jsonl_fail(r->error, TFA_E_ARGUMENT, "want: %s", refusal);
    if (request->tip_count == 0 && (op & TFA_OPS_OSIM || request->flags & TFA_WANT_OF_TIPS))
        return jsonl_fail(r->error, TFA_E_ARGUMENT, "tips: missing; 1 to %d link names",
                          TFA_MAX_TIPS);
    return TFA_OK;
}

/* Keys that depend on others, and the defaults of keys that are absent */
static int finish(jsonl_reader *r, const json_t *object)
{
    tfa_request *request = r->request;
    if (request->tip_count && TFA_OP_BIT(request->op) & (TFA_OPS_FD | TFA_OPS_OSIM) &&
        !json_object_get(object, "want"))
        request->flags |= TFA_WANT_SPECTRUM;
    if (request->op == TFA_OP_TASK_TORQUES) {
        int status = jsonl_finish_acceleration(r);
        if (status != TFA_OK)
            return status;
    }
    if (TFA_OP_BIT(request->op) & TFA_OPS_CONSTRAINED) {
        int status = jsonl_finish_constraints(r);
        if (status != TFA_OK)
            return status;
    }
    return require(r);
}

int jsonl_read(const json_t *object, const tfa_names *names, const jsonl_defaults *defaults,
               jsonl_buffers *buffers, tfa_request *request, tfa_reply *reply, jsonl_error *error)
{
    jsonl_reader r = {.names = names, .buffers = buffers, .request = request, .error = error};
    const json_t *want = json_object_get(object, "want");
    *request = (tfa_request){.count = 1, .refine = TFA_REFINE_DEFAULT};
    buffers->tip_poses_key = NULL;
    int status = read_op(&r, object);
    if (status == TFA_OK && want)
        status = jsonl_read_want(&r, want);
    if (status != TFA_OK)
        return status;
    if (TFA_OP_BIT(request->op) & TFA_OPS_SOLVE) {
        request->method = defaults->method;
        request->estimate = defaults->estimate;
        request->refine = defaults->refine;
    }
    const char *key;
    json_t *value;
    json_object_foreach((json_t *)object, key, value)
    {
        status = read_key(&r, key, value);
        if (status != TFA_OK)
            return status;
    }
    status = finish(&r, object);
    return status == TFA_OK ? jsonl_point_reply(&r, reply) : status;
}
