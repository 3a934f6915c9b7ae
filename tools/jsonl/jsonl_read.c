/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Reads a request out of a JSON object: one table says which keys exist, which ops use them and
 * which function reads them.
 */
#include "common/suggest.h"
#include "jsonl_values.h"

#include <stdlib.h>
#include <string.h>
#include <totalforce/text.h>

/* Which ops use a key. */
enum { FD = 1, ID = 2, OI = 4, MM = 8, ALL = FD | ID | OI | MM };

static const struct {
    const char *name;
    tfa_op op;
    unsigned bit;
} ops[] = {
    {"forward_dynamics", TFA_OP_FORWARD_DYNAMICS, FD},
    {"inverse_dynamics", TFA_OP_INVERSE_DYNAMICS, ID},
    {"operational_inertia", TFA_OP_OPERATIONAL_INERTIA, OI},
    {"mass_matrix", TFA_OP_MASS_MATRIX, MM},
};
enum { OP_COUNT = sizeof ops / sizeof ops[0] };

static const char *const frames[] = {
    [TFA_FRAME_LOCAL_WORLD_ALIGNED] = "local_world_aligned",
    [TFA_FRAME_LOCAL] = "local",
    [TFA_FRAME_WORLD] = "world",
};
enum { FRAME_COUNT = sizeof frames / sizeof frames[0] };

const char *jsonl_op_name(tfa_op op)
{
    for (size_t i = 0; i < OP_COUNT; i++)
        if (ops[i].op == op)
            return ops[i].name;
    return "unknown";
}

const char *jsonl_frame_name(tfa_reference_frame frame)
{
    return (unsigned)frame < FRAME_COUNT ? frames[frame] : "unknown";
}

static int read_q(jsonl_reader *r, const json_t *value)
{
    r->request->q = r->buffers->q;
    return jsonl_joints(r, value, 1, r->buffers->q);
}

static int read_v(jsonl_reader *r, const json_t *value)
{
    r->request->v = r->buffers->v;
    return jsonl_joints(r, value, 0, r->buffers->v);
}

static int read_tau(jsonl_reader *r, const json_t *value)
{
    r->request->tau = r->buffers->tau;
    return jsonl_joints(r, value, 0, r->buffers->tau);
}

static int read_qdd(jsonl_reader *r, const json_t *value)
{
    r->request->qdd = r->buffers->qdd;
    return jsonl_joints(r, value, 0, r->buffers->qdd);
}

/* The base fields exist for a floating base only. */
static int read_base(jsonl_reader *r, const json_t *value, size_t count, double *out)
{
    if (r->names->base_freedoms == 0)
        return jsonl_fail(r->error, TFA_E_ARGUMENT, "%s: the robot's base is fixed", r->key);
    return jsonl_numbers(r, value, count, out);
}

static int read_base_pose(jsonl_reader *r, const json_t *value)
{
    r->request->base_pose = r->buffers->base_pose;
    return read_base(r, value, 7, r->buffers->base_pose);
}

static int read_base_twist(jsonl_reader *r, const json_t *value)
{
    r->request->base_twist = r->buffers->base_twist;
    return read_base(r, value, 6, r->buffers->base_twist);
}

static int read_base_wrench(jsonl_reader *r, const json_t *value)
{
    r->request->base_wrench = r->buffers->base_wrench;
    return read_base(r, value, 6, r->buffers->base_wrench);
}

static int read_base_acceleration(jsonl_reader *r, const json_t *value)
{
    r->request->base_acceleration = r->buffers->base_acceleration;
    return read_base(r, value, 6, r->buffers->base_acceleration);
}

static int read_gravity(jsonl_reader *r, const json_t *value)
{
    r->request->gravity = r->buffers->gravity;
    return jsonl_numbers(r, value, 3, r->buffers->gravity);
}

static int read_tips(jsonl_reader *r, const json_t *value)
{
    if (!json_is_array(value))
        return jsonl_fail(r->error, TFA_E_ARGUMENT, "tips: %s, must be an array of link names",
                          jsonl_type(value));
    size_t count = json_array_size(value);
    if (count < 1 || count > TFA_MAX_TIPS)
        return jsonl_fail(r->error, TFA_E_SIZE, "tips: %zu links, must be 1 to %d", count,
                          TFA_MAX_TIPS);
    for (size_t i = 0; i < count; i++) {
        const json_t *link = json_array_get(value, i);
        char key[32];
        snprintf(key, sizeof key, "tips[%zu]", i);
        if (!json_is_string(link))
            return jsonl_fail(r->error, TFA_E_ARGUMENT, "%s: %s, must be a link name", key,
                              jsonl_type(link));
        int status = jsonl_find_frame(r, key, json_string_value(link), &r->request->tips[i]);
        if (status != TFA_OK)
            return status;
    }
    r->request->tip_count = (uint32_t)count;
    r->request->flags |= TFA_WANT_SPECTRUM;
    return TFA_OK;
}

static int read_wrench(jsonl_reader *r, const json_t *value)
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

static int read_method(jsonl_reader *r, const json_t *value)
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

static int read_refine(jsonl_reader *r, const json_t *value)
{
    if (!json_is_integer(value) || json_integer_value(value) < 0 ||
        json_integer_value(value) > TFA_MAX_REFINE)
        return jsonl_fail(r->error, TFA_E_ARGUMENT, "refine: must be 0, 1, 2 or 3");
    r->request->refine = (uint32_t)json_integer_value(value);
    return TFA_OK;
}

static int read_frame(jsonl_reader *r, const json_t *value)
{
    for (unsigned i = 0; json_is_string(value) && i < FRAME_COUNT; i++)
        if (strcmp(frames[i], json_string_value(value)) == 0) {
            r->request->frame = (tfa_reference_frame)i;
            return TFA_OK;
        }
    return jsonl_fail(r->error, TFA_E_ARGUMENT,
                      "frame: must be \"world\", \"local\" or \"local_world_aligned\"");
}

static int read_estimate(jsonl_reader *r, const json_t *value)
{
    const char *policy = json_is_string(value) ? json_string_value(value) : "";
    if (strcmp(policy, "always") == 0)
        r->request->estimate = TFA_ESTIMATE_ALWAYS;
    else if (strcmp(policy, "never") == 0)
        r->request->estimate = TFA_ESTIMATE_NEVER;
    else if (strcmp(policy, "default") == 0)
        r->request->estimate = TFA_ESTIMATE_DEFAULT;
    else
        return jsonl_fail(r->error, TFA_E_ARGUMENT,
                          "estimate: must be \"default\", \"always\" or \"never\"");
    return TFA_OK;
}

static int reject_key_of_other_op(jsonl_reader *r, const json_t *value)
{
    (void)r;
    (void)value;
    return TFA_OK;
}

/* The state (q, v, base, gravity) may be given with every op, used or not, so that a program can
 * ask different questions about one state; its inputs belong to some ops only. */
static const struct {
    const char *name;
    unsigned ops;
    int (*read)(jsonl_reader *, const json_t *);
} keys[] = {
    {"id", ALL, reject_key_of_other_op},
    {"op", ALL, reject_key_of_other_op},
    {"q", ALL, read_q},
    {"v", ALL, read_v},
    {"base_pose", ALL, read_base_pose},
    {"base_twist", ALL, read_base_twist},
    {"gravity", ALL, read_gravity},
    {"tau", FD, read_tau},
    {"base_wrench", FD, read_base_wrench},
    {"qdd", ID, read_qdd},
    {"base_acceleration", ID, read_base_acceleration},
    {"wrench", FD | ID, read_wrench},
    {"tips", FD | OI, read_tips},
    {"frame", FD | ID | OI, read_frame},
    {"method", ALL, read_method},
    {"refine", FD | OI, read_refine},
    {"estimate", FD | OI, read_estimate},
    {"poses", FD | OI, jsonl_read_poses},
    {"payload", ALL, jsonl_read_payload},
    {"locked", FD | OI, jsonl_read_locked},
};

static int read_op(jsonl_reader *r, const json_t *object, unsigned *bit)
{
    const json_t *op = json_object_get(object, "op");
    for (size_t i = 0; json_is_string(op) && i < OP_COUNT; i++)
        if (strcmp(ops[i].name, json_string_value(op)) == 0) {
            r->request->op = ops[i].op;
            *bit = ops[i].bit;
            return TFA_OK;
        }
    static const char there_are[] =
        "forward_dynamics, inverse_dynamics, operational_inertia, mass_matrix";
    if (!op)
        return jsonl_fail(r->error, TFA_E_ARGUMENT, "op: missing; one of %s", there_are);
    if (!json_is_string(op))
        return jsonl_fail(r->error, TFA_E_ARGUMENT, "op: %s, must be one of %s", jsonl_type(op),
                          there_are);
    return jsonl_fail(r->error, TFA_E_ARGUMENT, "op: no '%.200s'; one of %s", json_string_value(op),
                      there_are);
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

static int read_key(jsonl_reader *r, const char *key, const json_t *value, unsigned op)
{
    for (size_t i = 0; i < KEY_COUNT; i++) {
        if (strcmp(keys[i].name, key) != 0)
            continue;
        if (!(keys[i].ops & op))
            return jsonl_fail(r->error, TFA_E_ARGUMENT, "%s: %s does not use it", key,
                              jsonl_op_name(r->request->op));
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
        robot_names_describe(r->names, 1, robot, sizeof robot);
        return jsonl_fail(r->error, TFA_E_ARGUMENT, "q: missing; the robot has %s", robot);
    }
    if (!request->q)
        request->q = r->buffers->q;
    if (!request->base_pose && r->names->base_freedoms)
        return jsonl_fail(r->error, TFA_E_ARGUMENT,
                          "base_pose: missing; the base floats: [x,y,z,qx,qy,qz,qw]");
    if (request->tip_count == 0 &&
        (request->op == TFA_OP_OPERATIONAL_INERTIA || request->flags & TFA_WANT_POSES))
        return jsonl_fail(r->error, TFA_E_ARGUMENT, "tips: missing; 1 to %d link names",
                          TFA_MAX_TIPS);
    return TFA_OK;
}

static int point_reply(jsonl_reader *r, tfa_reply *reply)
{
    jsonl_buffers *b = r->buffers;
    int floating = r->names->base_freedoms != 0;
    size_t n = (size_t)r->names->base_freedoms + r->names->v_count;
    *reply = (tfa_reply){.answers = &b->answer};
    switch (r->request->op) {
    case TFA_OP_FORWARD_DYNAMICS:
        reply->qdd = b->reply_qdd;
        reply->base_acceleration = floating ? b->reply_acceleration : NULL;
        break;
    case TFA_OP_INVERSE_DYNAMICS:
        reply->tau = b->reply_tau;
        reply->base_wrench = floating ? b->reply_wrench : NULL;
        break;
    case TFA_OP_MASS_MATRIX:
        /* n x n is large for a long chain: printed on request only */
        if (!b->mass_matrix)
            b->mass_matrix = calloc(n ? n : 1, (n ? n : 1) * sizeof(double));
        if (!b->mass_matrix)
            return jsonl_fail(r->error, TFA_E_MEMORY,
                              "mass_matrix: no memory for %zu x %zu numbers", n, n);
        reply->mass_matrix = b->mass_matrix;
        break;
    case TFA_OP_OPERATIONAL_INERTIA:
        break;
    }
    if (r->request->tip_count) {
        reply->lambda_inv = b->lambda_inv;
        reply->spectrum = &b->spectrum;
    }
    if (r->request->flags & TFA_WANT_POSES)
        reply->poses = b->poses;
    return TFA_OK;
}

int jsonl_read(const json_t *object, const robot_names *names, const jsonl_defaults *defaults,
               jsonl_buffers *buffers, tfa_request *request, tfa_reply *reply, jsonl_error *error)
{
    jsonl_reader r = {.names = names, .buffers = buffers, .request = request, .error = error};
    unsigned op = 0;
    *request = (tfa_request){.count = 1, .refine = TFA_REFINE_DEFAULT};
    int status = read_op(&r, object, &op);
    if (status != TFA_OK)
        return status;
    if (op & (FD | OI)) {
        request->method = defaults->method;
        request->estimate = defaults->estimate;
        request->refine = defaults->refine;
    }
    const char *key;
    json_t *value;
    json_object_foreach((json_t *)object, key, value)
    {
        status = read_key(&r, key, value, op);
        if (status != TFA_OK)
            return status;
    }
    status = require(&r);
    return status == TFA_OK ? point_reply(&r, reply) : status;
}
