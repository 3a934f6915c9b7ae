/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Every method agrees with the oracle: accelerations, forces, M and Lambda^-1.
 *
 * The bounds are relative errors in the 2-norm over one state's answer. They are about ten times
 * the worst that these seeds and files gave; each test prints that worst.
 */
#include <math.h>

#include "support/fixture.h"
#include "test.h"

#define STATES 3 /* at most, see count_states */
#define WRENCHES 3

static uint32_t count_states(void)
{
    return test_extent(2, STATES);
}

/* Precisions and numbers of refinement steps */
static const struct column {
    const char *name;
    uint32_t refine;
    tfa_precision precision;
} columns[] = {{"", 0, TFA_F64},        {", refined", 1, TFA_F64}, {", refined twice", 2, TFA_F64},
               {", f128", 0, TFA_F128}, {", f32", 0, TFA_F32},     {", f32, refined", 1, TFA_F32}};
#define COLUMNS (sizeof columns / sizeof *columns)
enum { REFINED = 1 };

/* One method, and what it may lose in each column; 0: not asked. auto refines as it chooses. */
struct way {
    tfa_method method;
    double bound[COLUMNS], worst[COLUMNS];
    uint32_t asked[COLUMNS];
};

static void print_worst(const struct way *ways, size_t count)
{
    for (const struct way *way = ways; way < ways + count; way++)
        for (size_t c = 0; c < COLUMNS; c++)
            if (way->bound[c] > 0 && !way->asked[c])
                fail_msg("%s%s: nothing was asked", tfa_method_name(way->method), columns[c].name);
            else if (way->bound[c] > 0)
                print_message("  %s%s: worst %.2g, bound %g\n", tfa_method_name(way->method),
                              columns[c].name, way->worst[c], way->bound[c]);
}

static tfa_workspace *workspace_of(const test_robot *robot, tfa_precision precision)
{
    return precision == TFA_F128 ? robot->f128 : precision == TFA_F32 ? robot->f32 : robot->f64;
}

/* The oracle's answer to state k as one array, base first. */
static void ask_oracle(const test_robot *robot, const random_states *x, const tfa_request *r,
                       uint32_t k, double *want)
{
    const uint32_t six = robot->n - robot->nv;
    const size_t joints = (size_t)k * robot->nv, base = 6 * (size_t)k;
    oracle_set_state(robot->o, r, k);
    if (r->op == TFA_OP_FORWARD_DYNAMICS)
        oracle_forward(robot->o, x->tau + joints, x->base_wrench + base, want + six, want);
    else if (r->op == TFA_OP_INVERSE_DYNAMICS)
        oracle_inverse(robot->o, x->qdd + joints, x->base_acceleration + base, want + six, want);
    else if (r->op == TFA_OP_MASS_MATRIX)
        oracle_mass_matrix(robot->o, want);
    else
        oracle_lambda_inv(robot->o, r->tips, r->tip_count, r->frame, want);
}

static void check_method(tfa_op op, const struct way *way, const tfa_answer *answer)
{
    assert_int_equal(answer->status, TFA_OK);
    if (op == TFA_OP_FORWARD_DYNAMICS && way->method != TFA_METHOD_AUTO &&
        !(answer->flags & TFA_ANSWER_FALLBACK))
        assert_int_equal(answer->method, way->method);
}

/* All states of a request by every way, against the oracle; refined, a way loses at most three
 * times what the first one (aba, propagation) loses alone, whose smallest errors are luck. */
#define LUCK 2e-15
static void by_every_way(test_robot *robot, const random_states *x, tfa_request r, struct way *ways,
                         size_t count)
{
    const uint32_t six = robot->n - robot->nv;
    const bool vector = r.op == TFA_OP_FORWARD_DYNAMICS || r.op == TFA_OP_INVERSE_DYNAMICS;
    const size_t m = r.op == TFA_OP_MASS_MATRIX ? robot->n : 6 * (size_t)r.tip_count;
    const size_t size = vector ? robot->n : m * m, nv = robot->nv;
    double *joints = calloc(STATES * nv + 1, sizeof *joints), *got = calloc(size, sizeof *got);
    double *matrix = calloc(STATES * size, sizeof *matrix);
    double *want = calloc(STATES * size, sizeof *want), base[STATES * 6];
    tfa_answer answers[STATES];
    double of_first[STATES];
    tfa_reply reply = {.qdd = joints,
                       .tau = joints,
                       .base_acceleration = base,
                       .base_wrench = base,
                       .mass_matrix = matrix,
                       .lambda_inv = r.tip_count ? matrix : NULL,
                       .answers = answers};
    for (uint32_t k = 0; k < x->count; k++)
        ask_oracle(robot, x, &r, k, want + k * size);
    for (size_t w = 0; w < count * COLUMNS; w++) {
        struct way *way = &ways[w / COLUMNS];
        const size_t c = w % COLUMNS;
        char what[80];
        if (way->bound[c] == 0 || fixture_refuses(robot, way->method))
            continue;
        snprintf(what, sizeof what, "%s%s, %u tips, frame %d", tfa_method_name(way->method),
                 columns[c].name, (unsigned)r.tip_count, (int)r.frame);
        r.method = way->method;
        r.refine = way->method == TFA_METHOD_AUTO ? TFA_REFINE_DEFAULT : columns[c].refine;
        compute_ok(robot, workspace_of(robot, columns[c].precision), &r, &reply);
        for (uint32_t k = 0; k < x->count; k++) {
            memcpy(got, vector ? base + 6 * (size_t)k : matrix + k * size,
                   (vector ? six : size) * sizeof *got);
            if (vector)
                memcpy(got + six, joints + k * nv, nv * sizeof *got);
            const double error = relative_error(got, want + k * size, size);
            assert_within(robot, what, error, way->bound[c], &way->worst[c]);
            if (w == 0)
                of_first[k] = error;
            if (c == REFINED)
                assert_within(robot, what, error, 3 * fmax(of_first[k], LUCK), NULL);
            check_method(r.op, way, &answers[k]);
            way->asked[c]++;
        }
    }
    free(want);
    free(matrix);
    free(got);
    free(joints);
}

/* ---- accelerations ---- */

static struct way forward_ways[] = {
    {TFA_METHOD_ABA, {2e-12, 5e-14, 0, 1e-14, 7e-4, 2e-5}, {0}, {0}},
    {TFA_METHOD_CRBA, {3e-11, 5e-14, 0, 1e-14, 8e-3}, {0}, {0}},
    {TFA_METHOD_TFA, {2e-11, 5e-14, 0, 1e-14, 6e-3, 7e-4}, {0}, {0}},
    {TFA_METHOD_TFA_CR, {2e-11, 5e-14, 0, 1e-14}, {0}, {0}},
    {TFA_METHOD_CFA, {2e-11, 5e-14, 0, 1e-14, 5e-3}, {0}, {0}},
    {TFA_METHOD_CFA_CR, {2e-11, 5e-14, 0, 1e-14}, {0}, {0}},
    {TFA_METHOD_SCAN, {2e-12, 5e-14, 0, 1e-14, 7e-4}, {0}, {0}},
    {TFA_METHOD_DCA, {1e-10, 5e-14, 0, 1e-14, 3e-2}, {0}, {0}},
    {TFA_METHOD_HESSENBERG, {2e-11, 5e-14, 0, 1e-14, 1e-2}, {0}, {0}},
    {TFA_METHOD_SCAN_TWO_PASS, {2e-12}, {0}, {0}},
    {TFA_METHOD_HYBRID, {2e-12, 5e-14, 0, 1e-14}, {0}, {0}},
    {TFA_METHOD_AUTO, {2e-12}, {0}, {0}},
};
#define FORWARD_WAYS (sizeof forward_ways / sizeof *forward_ways)

static void forward_dynamics(test_robot *robot)
{
    random_states *x = fixture_states(robot, 0, count_states(), WRENCHES);
    tfa_request r = fixture_request(robot, x);
    r.estimate = TFA_ESTIMATE_NEVER;
    for (int pass = 0; pass < 4; pass++) { /* wrenches in three frames, and at rest */
        r.frame = (tfa_reference_frame)(pass % 3);
        r.v = pass < 3 ? x->v : NULL;
        r.base_twist = pass < 3 && robot->base == TFA_BASE_FLOATING ? x->base_twist : NULL;
        by_every_way(robot, x, r, forward_ways, FORWARD_WAYS);
    }
    random_states_free(x);
}

TEST(every_method_gives_the_acceleration)
{
    for_every_robot(forward_dynamics, false);
    print_worst(forward_ways, FORWARD_WAYS);
}

/* ---- forces and M ---- */

static struct way force_ways[] = {
    {TFA_METHOD_RNEA, {2e-13, 0, 0, 1e-13, 4e-5}, {0}, {0}},
};
#define FORCE_WAYS (sizeof force_ways / sizeof *force_ways)
static struct way mass_ways[] = {
    {TFA_METHOD_CRBA, {1e-14, 0, 0, 1e-14, 6e-6}, {0}, {0}},
};
#define MASS_WAYS (sizeof mass_ways / sizeof *mass_ways)

static void inverse_dynamics(test_robot *robot)
{
    random_states *x = fixture_states(robot, 7, count_states(), WRENCHES);
    tfa_request r = fixture_request(robot, x);
    r.op = TFA_OP_INVERSE_DYNAMICS;
    by_every_way(robot, x, r, force_ways, FORCE_WAYS);
    random_states_free(x);
}

TEST(inverse_dynamics_gives_the_force)
{
    for_every_robot(inverse_dynamics, false);
    print_worst(force_ways, FORCE_WAYS);
}

static void mass_matrix(test_robot *robot)
{
    random_states *x = fixture_states(robot, 8, count_states(), 0);
    tfa_request r = fixture_request(robot, x);
    r.op = TFA_OP_MASS_MATRIX;
    by_every_way(robot, x, r, mass_ways, MASS_WAYS);
    random_states_free(x);
}

TEST(crba_gives_the_mass_matrix)
{
    for_every_robot(mass_matrix, false);
    print_worst(mass_ways, MASS_WAYS);
}

/* ---- Lambda^-1 ---- */

static struct way lambda_ways[] = {
    {TFA_METHOD_PROPAGATION, {2e-12, 0, 0, 2e-14, 4e-4}, {0}, {0}},
    {TFA_METHOD_ABA, {2e-12}, {0}, {0}},
    {TFA_METHOD_EFPA, {2e-12, 3e-14, 0, 2e-14, 4e-4}, {0}, {0}},
    {TFA_METHOD_PV_OSIMR, {2e-12, 3e-14, 0, 2e-14}, {0}, {0}},
    {TFA_METHOD_CRBA, {1e-11}, {0}, {0}},
    {TFA_METHOD_TFA, {2e-11, 3e-14, 3e-14, 2e-14, 1e-2}, {0}, {0}},
    {TFA_METHOD_TFA_ONE_SIDED, {4e-11, 3e-14, 0, 2e-14, 1e-2}, {0}, {0}},
    {TFA_METHOD_TFA_CR, {2e-11, 3e-14}, {0}, {0}},
    {TFA_METHOD_CFA, {2e-11}, {0}, {0}},
    {TFA_METHOD_CFA_CR, {2e-11, 3e-14}, {0}, {0}},
    {TFA_METHOD_SCAN, {2e-12, 0, 0, 0, 4e-4}, {0}, {0}},
    {TFA_METHOD_SCAN_TWO_PASS, {2e-12}, {0}, {0}},
    {TFA_METHOD_DCA, {4e-10}, {0}, {0}},
    {TFA_METHOD_HESSENBERG, {1e-11}, {0}, {0}},
    {TFA_METHOD_AUTO, {2e-12}, {0}, {0}},
};
#define LAMBDA_WAYS (sizeof lambda_ways / sizeof *lambda_ways)
#define LAMBDA_STATES 2

static void lambda_inv(test_robot *robot)
{
    random_source s = {robot->seed};
    random_states *x = fixture_states(robot, 9, test_extent(1, LAMBDA_STATES), 0);
    tfa_request r = fixture_request(robot, x);
    r.op = TFA_OP_OPERATIONAL_INERTIA;
    r.estimate = TFA_ESTIMATE_NEVER;
    r.v = r.tau = NULL;
    for (uint32_t tips = 1; tips <= TFA_DEFAULT_TIPS; tips += tips < 3 ? 1 : 5) {
        r.tip_count = tips;
        for (int frame = 0; frame < 3; frame++) {
            r.frame = (tfa_reference_frame)frame;
            for (uint32_t t = 0; t < tips; t++) /* any link: the root and doubles too */
                r.tips[t] = random_below(&s, (uint32_t)robot->description->link_count);
            by_every_way(robot, x, r, lambda_ways, LAMBDA_WAYS);
        }
    }
    random_states_free(x);
}

TEST(every_method_gives_lambda_inv)
{
    for_every_robot(lambda_inv, false);
    print_worst(lambda_ways, LAMBDA_WAYS);
}

/* ---- the table ---- */

static bool has_way(const struct way *ways, size_t count, uint32_t method)
{
    for (size_t k = 0; k < count; k++)
        if ((uint32_t)ways[k].method == method && ways[k].bound[0] > 0)
            return true;
    return false;
}

TEST(every_method_of_the_table_is_here)
{
    for (uint32_t m = 0; tfa_method_describe(m); m++) {
        const tfa_method_info *row = tfa_method_describe(m);
        if (row->forward_dynamics && !has_way(forward_ways, FORWARD_WAYS, m))
            fail_msg("%s: no law for its accelerations", row->name);
        if (row->lambda && !has_way(lambda_ways, LAMBDA_WAYS, m))
            fail_msg("%s: no law for its lambda_inv", row->name);
    }
}

/* ---- order ---- */

static void joint_order(test_robot *robot)
{
    for (uint32_t k = 0, within, joint = 0; k < robot->nv; k++) {
        uint32_t j = oracle_joint_of_freedom(robot->o, k, &within);
        if (within > 0)
            continue;
        tfa_joint_info info = tfa_model_joint(robot->model, joint);
        assert_string_equal(info.name, robot->description->joints[j].name);
        assert_int_equal(info.v_index, k);
        assert_int_equal(info.type, robot->description->joints[j].type);
        assert_int_equal(tfa_model_find_joint(robot->model, info.name), joint++);
    }
    assert_int_equal(tfa_model_frame_count(robot->model), robot->description->link_count);
    for (uint32_t k = 0; k < robot->description->link_count; k++) {
        assert_string_equal(tfa_model_frame(robot->model, k).name,
                            robot->description->links[k].name);
        assert_int_equal(tfa_model_find_frame(robot->model, robot->description->links[k].name), k);
    }
}

EVERY_ROBOT(joints_stand_in_declared_order, joint_order, false)
