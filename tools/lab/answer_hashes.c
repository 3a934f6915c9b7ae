/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * One hash for each of some thousand requests: a refactoring that keeps every answer keeps every
 * row.
 *
 *   answer_hashes [--policies] [--every N] FILE.urdf...   rows of these robots, on both bases
 *   tools/lab/answers BIN_DIR [--every N] >after          rows of the bundled robots and of chains
 *   tools/lab/compare-answers before after [EXPECTED]     rows that differ, are missing or are new
 *
 * A row is
 *   robot base op method inputs+policy batch threads precision hash
 * The hash (FNV-1a, 64 bits) covers the status, every bit of the output buffers (M: of op `mass`
 * only; all NaNs count as one), and status, flags, method and error estimate of every state. In its
 * place a refused request has STATUS/field/index/state, and one that failed for some states
 * STATUS/hash. Inputs are random at a fixed seed.
 *
 * The product of all columns has some million rows. Always printed: every op and method with plain
 * inputs, one state, f64, and the policies default, always (one thread) and bare (one and two). Of
 * the rest one row in N (400), chosen by a hash of its key, so that two builds print the same rows;
 * none where a method refuses the robot. Quadruple precision: up to 64 bodies, and bodies x batch
 * up to 200.
 *
 * Rows depend on the instruction set (TFA_ISA), on the compiler and on libm; compare like with
 * like. The program uses the public interface only and names no more of it than it needs, so that
 * it compiles against other versions of the library:
 *   gcc -O2 -I PREFIX/include answer_hashes.c answer_robot.c -L PREFIX/lib -ltotalforce -lm
 */
#include "answer_robot.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { QUAD_STATES = 200 };

static const struct {
    const char *name;
    tfa_op op;
} ops[] = {{"fd", TFA_OP_FORWARD_DYNAMICS},
           {"id", TFA_OP_INVERSE_DYNAMICS},
           {"osim", TFA_OP_OPERATIONAL_INERTIA},
           {"mass", TFA_OP_MASS_MATRIX}};

/* Inputs of a request besides the state. `first`: which of the four frames is the first tip. */
#define WANT_BOTH (TFA_WANT_POSES | TFA_WANT_SPECTRUM)
static const struct inputs {
    const char *name;
    uint32_t tips, first, wrenches, payloads, locked, flags;
    tfa_reference_frame frame;
    int gravity, at_rest;
} all_inputs[] = {
    {.name = "plain"},
    {.name = "rest", .at_rest = 1},
    {.name = "gravity", .gravity = 1},
    {.name = "wrenches", .wrenches = WRENCHES},
    {.name = "payload", .payloads = 1},
    {.name = "locked", .locked = LOCKED},
    {.name = "tips1", .tips = 1},
    {.name = "inner", .tips = 1, .first = 1},
    {.name = "tips2", .tips = 2},
    {.name = "tips4", .tips = 4},
    {.name = "poses", .tips = 2, .first = 3, .flags = TFA_WANT_POSES},
    {.name = "spectrum", .tips = 2, .flags = TFA_WANT_SPECTRUM},
    {.name = "local", .tips = 1, .wrenches = 1, .frame = TFA_FRAME_LOCAL},
    {.name = "world", .tips = 2, .wrenches = WRENCHES, .frame = TFA_FRAME_WORLD},
    {.name = "all", .tips = 2, .wrenches = 1, .payloads = 1, .flags = WANT_BOTH, .gravity = 1},
};

static const struct policy {
    const char *name;
    tfa_estimate estimate;
    uint32_t refine;
    uint32_t basic; /* threads up to which every method has a row with plain inputs */
} policies[] = {{"default", TFA_ESTIMATE_DEFAULT, TFA_REFINE_DEFAULT, 1},
                {"refine0", TFA_ESTIMATE_DEFAULT, 0, 0},
                {"refine2", TFA_ESTIMATE_DEFAULT, 2, 0},
                {"never", TFA_ESTIMATE_NEVER, TFA_REFINE_DEFAULT, 0},
                {"bare", TFA_ESTIMATE_NEVER, 0, POOL_THREADS},
                {"always", TFA_ESTIMATE_ALWAYS, TFA_REFINE_DEFAULT, 1}};

static const uint32_t batches[] = {1, 3, BATCH_MAX};

#define COUNT(array) (sizeof(array) / sizeof *(array))

struct row {
    size_t op;
    uint32_t method, batch, threads;
    const struct inputs *inputs;
    const struct policy *policy;
    size_t precision;
};

static uint64_t fnv(uint64_t hash, const void *data, size_t size)
{
    const unsigned char *bytes = data;
    for (size_t i = 0; i < size; i++)
        hash = (hash ^ bytes[i]) * 0x100000001b3u;
    return hash;
}

#define FNV_START 0xcbf29ce484222325u

/* A NaN has many bit patterns and one meaning. */
static uint64_t fnv_doubles(uint64_t hash, const double *x, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        double number = isnan(x[i]) ? (double)NAN : x[i];
        hash = fnv(hash, &number, sizeof number);
    }
    return hash;
}

static void set_state(const struct robot *r, int at_rest, tfa_request *request)
{
    request->q = r->in[Q];
    request->base_pose = r->in[POSE];
    if (at_rest)
        return;
    request->v = r->in[V];
    request->tau = r->in[TAU];
    request->qdd = r->in[QDD];
    request->base_twist = r->in[TWIST];
    request->base_wrench = r->in[BASE_WRENCH];
    request->base_acceleration = r->in[BASE_ACCELERATION];
}

static tfa_request make_request(const struct robot *r, const struct row *row)
{
    static const double gravity[3] = {0.5, -1, -9};
    static const double payload[TFA_PAYLOAD_NUMBERS] = {1.5, 0.02, 0,    0.1, 0.01,
                                                        0,   0,    0.02, 0,   0.01};
    const struct inputs *in = row->inputs;
    tfa_request request = {.op = ops[row->op].op, .method = (tfa_method)row->method};
    set_state(r, in->at_rest, &request);
    request.count = row->batch;
    request.estimate = row->policy->estimate;
    request.refine = row->policy->refine;
    request.frame = in->frame;
    request.flags = in->flags;
    request.gravity = in->gravity ? gravity : NULL;
    request.payload_count = in->payloads;
    request.payloads = payload;
    request.payload_frames[0] = r->frames[0];
    request.locked_count = in->locked;
    request.locked = r->locked;
    request.wrench_count = in->wrenches;
    request.wrenches = r->in[WRENCH];
    for (uint32_t i = 0; i < WRENCHES; i++)
        request.wrench_frames[i] = r->frames[2 * i];
    request.tip_count = in->tips;
    if (request.op == TFA_OP_OPERATIONAL_INERTIA && in->tips == 0)
        request.tip_count = 1;
    for (uint32_t i = 0; i < TIPS_MAX; i++)
        request.tips[i] = r->frames[(in->first + i) % 4];
    return request;
}

/* M is hashed where it is asked for: its size would take most of the time. */
static int outputs_of(tfa_op op)
{
    return op == TFA_OP_MASS_MATRIX ? OUTPUTS : OUT_MASS;
}

static tfa_reply make_reply(struct robot *r, const struct row *row)
{
    for (int i = 0; i < outputs_of(ops[row->op].op); i++)
        memset(r->out[i], 0, row->batch * r->out_size[i] * sizeof(double));
    memset(r->spectrum, 0, sizeof r->spectrum);
    memset(r->answers, 0, sizeof r->answers);
    return (tfa_reply){.qdd = r->out[OUT_QDD],
                       .tau = r->out[OUT_TAU],
                       .base_acceleration = r->out[OUT_BASE_A],
                       .base_wrench = r->out[OUT_BASE_W],
                       .lambda_inv = r->out[OUT_LAMBDA],
                       .mass_matrix = r->out[OUT_MASS],
                       .poses = r->out[OUT_POSES],
                       .spectrum = r->spectrum,
                       .answers = r->answers};
}

static uint64_t hash_reply(const struct robot *r, const struct row *row, int status)
{
    uint64_t hash = fnv(FNV_START, &status, sizeof status);
    for (int i = 0; i < outputs_of(ops[row->op].op); i++)
        hash = fnv_doubles(hash, r->out[i], row->batch * r->out_size[i]);
    for (size_t k = 0; k < row->batch; k++) {
        hash = fnv(hash, &r->answers[k], offsetof(tfa_answer, error_estimate));
        hash = fnv_doubles(hash, &r->answers[k].error_estimate, 1);
        hash = fnv(hash, &r->spectrum[k].rank, sizeof r->spectrum[k].rank);
        hash = fnv_doubles(hash, &r->spectrum[k].eig_min, 1);
        hash = fnv_doubles(hash, &r->spectrum[k].eig_max, 1);
    }
    return hash;
}

/* Prints the row; returns the status. */
static int hash_answer(struct robot *r, const struct row *row, const char *key)
{
    tfa_request request = make_request(r, row);
    tfa_reply reply = make_reply(r, row);
    int accepted = tfa_request_check(r->model, &request, &reply) == TFA_OK;
    int status = row->threads > 1
                     ? tfa_batch_pool_compute(r->pools[row->precision], &request, &reply)
                     : tfa_compute(r->workspaces[row->precision], &request, &reply);
    unsigned long long hash = hash_reply(r, row, status);
    if (status == TFA_OK)
        printf("%s %016llx\n", key, hash);
    else if (accepted && status != TFA_E_METHOD && status != TFA_E_UNSUPPORTED)
        printf("%s %s/%016llx\n", key, tfa_status_name(status), hash);
    else
        printf("%s %s/%s/%u/%u\n", key, tfa_status_name(status), tfa_field_name(reply.field),
               reply.index, reply.state);
    return status;
}

static void print_key(const struct robot *r, const struct row *row, char *key, size_t size)
{
    snprintf(key, size, "%s %s %s %s %s+%s %u %u %s", r->name, r->base, ops[row->op].name,
             tfa_method_name(row->method), row->inputs->name, row->policy->name, row->batch,
             row->threads, precisions[row->precision].name);
}

/* Row `index` of the product of inputs, policies, batch sizes, threads and precisions. */
static void decode(size_t index, struct row *row)
{
    row->precision = index % PRECISIONS;
    index /= PRECISIONS;
    row->threads = index % POOL_THREADS + 1;
    index /= POOL_THREADS;
    row->batch = batches[index % COUNT(batches)];
    index /= COUNT(batches);
    row->policy = &policies[index % COUNT(policies)];
    row->inputs = &all_inputs[index / COUNT(policies)];
}

static int is_chosen(const struct robot *r, const struct row *row, const char *key, uint64_t every)
{
    if (row->inputs == all_inputs && row->batch == 1 && row->precision == 0 &&
        row->threads <= row->policy->basic)
        return 1;
    if (!robot_has_precision(r, row->precision))
        return 0;
    if (precisions[row->precision].quad && r->bodies * row->batch > QUAD_STATES)
        return 0;
    return mix_bits(fnv(FNV_START, key, strlen(key))) % every == 0;
}

static void answer_method(struct robot *r, struct row *row, uint64_t every)
{
    const size_t count =
        COUNT(all_inputs) * COUNT(policies) * COUNT(batches) * POOL_THREADS * PRECISIONS;
    char key[256];
    decode(0, row);
    print_key(r, row, key, sizeof key);
    if (hash_answer(r, row, key) == TFA_E_METHOD)
        return;
    for (size_t i = 1; i < count; i++) {
        decode(i, row);
        print_key(r, row, key, sizeof key);
        if (is_chosen(r, row, key, every))
            hash_answer(r, row, key);
    }
}

static void answer_robot(const char *path, tfa_base base, int with_policies, uint64_t every)
{
    struct robot r;
    int status = robot_load(&r, path, base, with_policies);
    if (status == TFA_E_FILE)
        stop("file", path, tfa_status_text(status));
    if (status != TFA_OK) {
        printf("%s %s load - - - - - %s\n", r.name, r.base, tfa_status_name(status));
        return;
    }
    struct row row = {0};
    for (row.op = 0; row.op < COUNT(ops); row.op++)
        for (row.method = 0; tfa_method_describe(row.method); row.method++)
            answer_method(&r, &row, every);
    robot_free(&r);
}

int main(int argc, char **argv)
{
    uint64_t every = 400;
    int with_policies = 0, i = 1;
    for (; i < argc && argv[i][0] == '-'; i++) {
        if (strcmp(argv[i], "--policies") == 0)
            with_policies = 1;
        else if (strcmp(argv[i], "--every") == 0 && i + 1 < argc && atoi(argv[i + 1]) > 0)
            every = (uint64_t)atoi(argv[++i]);
        else
            stop("option", argv[i], "usage: answer_hashes [--policies] [--every N] FILE.urdf...");
    }
    printf("# isa %s, one row in %d\n", tfa_isa_name(), (int)every);
    for (; i < argc; i++) {
        answer_robot(argv[i], TFA_BASE_FIXED, with_policies, every);
        answer_robot(argv[i], TFA_BASE_FLOATING, with_policies, every);
    }
    return fflush(stdout) == 0 && !ferror(stdout) ? 0 : 2;
}
