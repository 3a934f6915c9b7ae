/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * What a workspace takes (docs/real-time.md): bounds for each body, methods that it reserves memory
 * for and those that it refuses, and nothing beyond its end.
 */
#include "models.h"
#include "support/random_robot.h"
#include "test.h"

#include <totalforce/totalforce.h>

#define MIB ((size_t)1 << 20)
#define GUARD 4096 /* bytes behind a workspace that no code may touch */
#define GUARDED 0xa5
#define LARGE 257 /* one more body than robots with memory for all methods have */

static tfa_model *chain(uint32_t joints, tfa_base base)
{
    const random_robot_options options = {.shape = RANDOM_CHAIN, .joints = joints};
    const tfa_model_options how = {.base = base};
    tfa_description *d = random_robot_create(joints, &options);
    tfa_model *model = compiled(d, &how);
    random_robot_free(d);
    return model;
}

static const tfa_workspace_options plain, all = {.methods = TFA_METHODS_ALL};

/* Bytes a workspace of a chain may take: so many for each body, and the mass matrix; up to 256
 * freedoms three more matrices for derivatives. */
static const struct {
    uint32_t bodies;
    const tfa_workspace_options *options;
    size_t each, most;
} bounds[] = {
    {7, &plain, 96 * 1024, MIB},
    {64, &plain, 96 * 1024, 8 * MIB}, /* batches of states */
    {256, &plain, 11 * 1024 + 512 + 3 * 8 * 256, 5 * MIB},
    {1000, &plain, 4 * 1024, 4 * MIB},
    {4096, &plain, 4 * 1024, 0},
    {1000, &all, 9 * 1024 + 4004, 0},
    {4096, &all, 9 * 1024, 0}, /* no memory for M of more than 4 Mi entries */
};

TEST(test_bounds)
{
    for (size_t k = 0; k < sizeof bounds / sizeof *bounds; k++) {
        tfa_model *model = chain(bounds[k].bodies, TFA_BASE_FIXED);
        const size_t size = tfa_workspace_size(model, bounds[k].options);
        const size_t fixed = 96 * 1024; /* whatever the robot */
        if (size > fixed + bounds[k].each * bounds[k].bodies ||
            (bounds[k].most && size > bounds[k].most))
            fail_msg("%u bodies%s: %zu bytes, %zu for each", (unsigned)bounds[k].bodies,
                     bounds[k].options == &all ? ", all methods" : "", size,
                     size / bounds[k].bodies);
        tfa_model_free(model);
    }
}

/* A workspace with a guard behind it, in memory full of noise. */
static tfa_workspace *guarded(const tfa_model *model, const tfa_workspace_options *options)
{
    const size_t size = tfa_workspace_size(model, options);
    char *memory = aligned_alloc(64, (size + GUARD + 63) / 64 * 64);
    tfa_workspace *w = NULL;
    assert_non_null(memory);
    memset(memory, GUARDED, size + GUARD);
    assert_int_equal(tfa_workspace_init(memory, size, model, options, &w), TFA_OK);
    return w;
}

static void release(tfa_workspace *w, const tfa_model *model, const tfa_workspace_options *options)
{
    const char *end = (const char *)w + tfa_workspace_size(model, options);
    for (int k = 0; k < GUARD; k++)
        if ((unsigned char)end[k] != GUARDED)
            fail_msg("byte %d behind the workspace was written", k);
    free(w);
}

struct numbers {
    double q[LARGE], v[LARGE], tau[LARGE], qdd[LARGE], lambda[36];
};

static tfa_request request(struct numbers *x, tfa_op op, tfa_method method, uint32_t tip)
{
    static const double pose[7] = {0, 0, 0, 0, 0, 0, 1};
    for (int k = 0; k < LARGE; k++) {
        x->q[k] = 0.37 * (k % 11) - 1;
        x->v[k] = 0.1 * (k % 7) - 0.3;
        x->tau[k] = 1 - 0.2 * (k % 5);
    }
    return (tfa_request){.op = op,
                         .method = method,
                         .estimate = TFA_ESTIMATE_NEVER,
                         .count = 1,
                         .tip_count = op == TFA_OP_OPERATIONAL_INERTIA,
                         .tips = {tip},
                         .q = x->q,
                         .v = x->v,
                         .tau = x->tau,
                         .base_pose = pose};
}

/* One method in one workspace: what it says must be what the workspace reserves memory for. */
static void ask(tfa_workspace *w, const tfa_method_info *row, tfa_op op, struct numbers *x,
                uint32_t tip)
{
    const tfa_request r = request(x, op, row->method, tip);
    tfa_reply reply = {.qdd = x->qdd, .lambda_inv = x->lambda};
    const int status = tfa_compute(w, &r, &reply);
    if (row->refuses & TFA_REFUSES_LENGTH) {
        assert_int_equal(status, TFA_E_UNSUPPORTED); /* hessenberg on a long chain */
    } else if (tfa_workspace_methods(w) & TFA_METHOD_BIT(row->method)) {
        if (status != TFA_OK)
            fail_msg("%s: %s", row->name, tfa_status_name(status));
    } else {
        assert_int_equal(status, TFA_E_UNSUPPORTED);
        assert_int_equal(reply.field, TFA_FIELD_METHOD);
        assert_int_equal(reply.index, row->method);
    }
}

static void ask_all(tfa_workspace *w, struct numbers *x, uint32_t tip)
{
    const tfa_method_info *row;
    for (uint32_t method = 0; (row = tfa_method_describe(method)) != NULL; method++) {
        if (row->forward_dynamics)
            ask(w, row, TFA_OP_FORWARD_DYNAMICS, x, tip);
        if (row->lambda)
            ask(w, row, TFA_OP_OPERATIONAL_INERTIA, x, tip);
    }
}

static void try_methods(uint32_t bodies, tfa_base base, const tfa_workspace_options *options)
{
    tfa_model *model = chain(bodies, base);
    tfa_workspace *w = guarded(model, options);
    struct numbers x;
    ask_all(w, &x, tfa_model_frame_count(model) - 1);
    release(w, model, options);
    tfa_model_free(model);
}

TEST(test_methods)
{
    static const tfa_workspace_options some[] = {
        {.methods = TFA_METHOD_BIT(TFA_METHOD_TFA)},
        {.methods = TFA_METHOD_BIT(TFA_METHOD_TFA_CR) | TFA_METHOD_BIT(TFA_METHOD_CRBA)},
        {.methods = TFA_METHOD_BIT(TFA_METHOD_DCA)},
        {.methods = TFA_METHOD_BIT(TFA_METHOD_CFA_CR), .residual = TFA_RESIDUAL_F128},
        {.methods = TFA_METHOD_BIT(TFA_METHOD_AUTO), .precision = TFA_F32},
    };
    try_methods(LARGE - 1, TFA_BASE_FIXED, &plain);
    try_methods(LARGE, TFA_BASE_FIXED, &plain);
    try_methods(LARGE - 1, TFA_BASE_FLOATING, &plain); /* with the base one body more */
    try_methods(LARGE, TFA_BASE_FIXED, &all);
    for (size_t k = 0; k < sizeof some / sizeof *some; k++)
        try_methods(140, TFA_BASE_FLOATING, &some[k]);
}

/* Robots that fit reserve memory for all, larger ones for what auto takes; asking is enough. */
TEST(test_defaults)
{
    tfa_model *small = chain(LARGE - 1, TFA_BASE_FIXED), *large = chain(LARGE, TFA_BASE_FIXED);
    const uint32_t tfa = TFA_METHOD_BIT(TFA_METHOD_TFA), crba = TFA_METHOD_BIT(TFA_METHOD_CRBA);
    tfa_workspace *w = guarded(small, &plain);
    assert_int_equal(tfa_workspace_methods(w), TFA_METHODS_ALL);
    release(w, small, &plain);
    w = guarded(large, &plain);
    assert_int_equal(tfa_workspace_methods(w) & (tfa | crba), 0);
    assert_true(tfa_workspace_methods(w) & TFA_METHOD_BIT(TFA_METHOD_SCAN));
    static double mass[LARGE * LARGE];
    struct numbers x;
    const tfa_request r = request(&x, TFA_OP_MASS_MATRIX, TFA_METHOD_AUTO, 0);
    tfa_reply reply = {.mass_matrix = mass};
    assert_int_equal(tfa_compute(w, &r, &reply), TFA_E_UNSUPPORTED);
    assert_int_equal(reply.field, TFA_FIELD_OP);
    release(w, large, &plain);
    const tfa_workspace_options whole = {.methods = crba};
    w = guarded(large, &whole);
    assert_int_equal(tfa_compute(w, &r, &reply), TFA_OK);
    release(w, large, &whole);
    tfa_model_free(small);
    tfa_model_free(large);
}

/* Limits of the robot's size are named by their number, and begin where it says. */
TEST(test_limits)
{
    static const double q[2896];
    static const struct {
        uint32_t bodies;
        tfa_op op;
        tfa_method method;
        uint32_t limit;
        const char *text;
    } rows[] = {
        {256, TFA_OP_DERIVATIVES, TFA_METHOD_AUTO, 0, ""},
        {257, TFA_OP_DERIVATIVES, TFA_METHOD_AUTO, 256, "the limit is 256 freedoms; "},
        {2895, TFA_OP_MASS_MATRIX, TFA_METHOD_AUTO, 0, ""},
        {2896, TFA_OP_MASS_MATRIX, TFA_METHOD_AUTO, 4 << 20, "(a chain of 2895 bodies); "},
        {2896, TFA_OP_FORWARD_DYNAMICS, TFA_METHOD_CRBA, 4 << 20, "aba and rnea need no M"},
        {130, TFA_OP_FORWARD_DYNAMICS, TFA_METHOD_HESSENBERG, 0, ""},
        {131, TFA_OP_FORWARD_DYNAMICS, TFA_METHOD_HESSENBERG, 130, "tfa and auto answer"},
    };
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
        tfa_model *model = chain(rows[k].bodies, TFA_BASE_FIXED);
        const tfa_request r = {.op = rows[k].op, .method = rows[k].method, .count = 1, .q = q};
        tfa_reply reply = {0};
        assert_int_equal(tfa_request_check(model, &r, &reply),
                         rows[k].limit ? TFA_E_UNSUPPORTED : TFA_OK);
        assert_int_equal(reply.index, rows[k].limit);
        assert_non_null(strstr(tfa_limit_text(&reply), rows[k].text));
        tfa_model_free(model);
    }
    assert_string_equal(tfa_limit_text(&(tfa_reply){.status = TFA_E_UNSUPPORTED, .index = 4}), "");
}

/* Reserved methods answer the same bits whatever else is reserved. */
TEST(test_same_bits)
{
    tfa_model *model = chain(LARGE, TFA_BASE_FIXED);
    tfa_workspace *lean = guarded(model, &plain), *rich = guarded(model, &all);
    struct numbers x, y;
    const tfa_method_info *row;
    for (uint32_t method = 0; (row = tfa_method_describe(method)) != NULL; method++) {
        if (!row->forward_dynamics || !(tfa_workspace_methods(lean) & TFA_METHOD_BIT(method)))
            continue;
        const tfa_request r = request(&x, TFA_OP_FORWARD_DYNAMICS, row->method, 0);
        tfa_reply a = {.qdd = x.qdd}, b = {.qdd = y.qdd};
        assert_int_equal(tfa_compute(lean, &r, &a), TFA_OK);
        assert_int_equal(tfa_compute(rich, &r, &b), TFA_OK);
        assert_memory_equal(x.qdd, y.qdd, sizeof x.qdd);
    }
    release(lean, model, &plain);
    release(rich, model, &all);
    tfa_model_free(model);
}
