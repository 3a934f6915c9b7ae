/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Bodies of one state in SIMD lanes: a schedule holds every body once, behind its parent, in as few
 * steps as can be; and the answers and estimates are those of one body after the other, to the bit,
 * whatever was asked before.
 */
#include "engine/strategy.h"
#include "layout/schedule_body_lanes.h"
#include "support/fixture.h"
#include "test.h"

#define STATES 64

/* ---- the schedule ---- */

static uint32_t row_class(const struct tfa_body *b)
{
    return b->kind == TFA_KIND_REVOLUTE ? 100u + 2u * (b->armature > 0) + b->axial : b->kind;
}

/* Bodies of one step: of one kind; alone where they have several freedoms. */
static void check_row(const struct tfa_model *m, const int32_t *row, uint32_t lanes)
{
    const struct tfa_body *first = NULL;
    for (uint32_t l = 0; l < lanes; l++) {
        if (row[l] < 0)
            continue;
        const struct tfa_body *b = &m->body[row[l]];
        if (first) {
            assert_int_equal(b->n, 1);
            assert_int_equal(row_class(b), row_class(first));
        } else {
            first = b;
        }
    }
    assert_non_null(first);
    if (first->base)
        assert_int_equal(row[0], 0);
}

static void check_table(const struct tfa_model *m, const struct tfa_lane_schedule *p)
{
    uint32_t step_of[TFA_BODY_LANES_BODIES_MAX], seen = 0;
    memset(step_of, 0xff, sizeof step_of);
    for (uint32_t k = 0; k < p->steps; k++) {
        check_row(m, p->body + (size_t)k * p->lanes, p->lanes);
        for (uint32_t l = 0; l < p->lanes; l++) {
            const int32_t i = p->body[k * p->lanes + l];
            if (i < 0)
                continue;
            assert_int_equal(step_of[i], UINT32_MAX);
            assert_true(m->body[i].parent < 0 || step_of[m->body[i].parent] < k);
            step_of[i] = k;
            seen++;
        }
    }
    assert_int_equal(seen, m->bodies);
}

/* The fewest steps there can be: bodies deeper than d are more than so many steps, and before them
 * go d more. Hu 1961: there is a schedule that needs no more. */
static uint32_t fewest_steps(const struct tfa_model *m, uint32_t lanes)
{
    uint32_t fewest = 0;
    for (uint32_t d = 0; d < m->depth; d++) {
        uint32_t deeper = 0;
        for (uint32_t i = 0; i < m->bodies; i++)
            deeper += m->body[i].depth > d;
        const uint32_t steps = d + (deeper + lanes - 1) / lanes;
        fewest = steps > fewest ? steps : fewest;
    }
    return fewest;
}

static int all_alike(const struct tfa_model *m)
{
    for (uint32_t i = 0; i < m->bodies; i++)
        if (m->body[i].n > 1 || row_class(&m->body[i]) != row_class(&m->body[0]))
            return 0;
    return 1;
}

static void plan_of(test_robot *robot)
{
    static const uint32_t lanes[] = {2, 4, 8};
    const struct tfa_model *m = robot->model;
    int32_t *table = malloc((size_t)m->bodies * TFA_BODY_LANES_MAX * sizeof *table);
    for (size_t k = 0; k < sizeof lanes / sizeof *lanes; k++) {
        const struct tfa_lane_schedule p = tfa_schedule_body_lanes(m, lanes[k], table);
        assert_true(p.steps > 0 || m->bodies == 0);
        check_table(m, &p);
        if (all_alike(m))
            assert_int_equal(p.steps, fewest_steps(m, lanes[k]));
    }
    free(table);
}

EVERY_ROBOT(every_body_once_in_the_fewest_steps, plan_of, false)

/* ---- the answers ---- */

struct answer {
    double *joints, base[6]; /* accelerations, or forces */
};

/* A request whose states share their coordinates two by two, at rest in every third. */
static tfa_request request_of(const test_robot *robot, random_states *x)
{
    tfa_request r = fixture_request(robot, x);
    r.count = 1;
    r.wrench_count = 0;
    r.estimate = TFA_ESTIMATE_ALWAYS;
    return r;
}

static void at_state(const test_robot *robot, const random_states *x, uint32_t k, tfa_request *r)
{
    const size_t c = k / 2;
    r->q = x->q + c * robot->nq;
    r->v = k % 3 ? x->v + (size_t)k * robot->nv : NULL;
    r->tau = r->qdd = k % 5 ? x->tau + (size_t)k * robot->nv : NULL;
    if (robot->base != TFA_BASE_FLOATING)
        return;
    r->base_pose = x->base_pose + 7 * c;
    r->base_twist = k % 3 ? x->base_twist + 6 * (size_t)k : NULL;
    r->base_wrench = r->base_acceleration = x->base_wrench + 6 * (size_t)k;
}

static tfa_reply reply_to(struct answer *a)
{
    return (tfa_reply){
        .qdd = a->joints, .tau = a->joints, .base_acceleration = a->base, .base_wrench = a->base};
}

static void compare(const test_robot *robot, const struct tfa_body_lanes_kernel *body_lanes)
{
    int32_t table[TFA_BODY_LANES_BODIES_MAX * TFA_BODY_LANES_MAX];
    const struct tfa_lane_schedule p =
        tfa_schedule_body_lanes(robot->model, body_lanes->lanes, table);
    const size_t size = body_lanes->size(robot->model, &p);
    void *memory = aligned_alloc(64, size);
    random_states *x = fixture_states(robot, 0, STATES, 0);
    struct answer a = {.joints = malloc(robot->nv * sizeof(double) + 1)},
                  b = {.joints = malloc(robot->nv * sizeof(double) + 1)};
    tfa_workspace *one = fixture_workspace(robot->model, TFA_F64);
    tfa_request r = request_of(robot, x);
    memset(memory, 0xff, size);
    struct state *s = body_lanes->init(robot->model, &p, memory);
    one->body_lanes = NULL;
    one->strategies = tfa_strategies_of(one, one->strategy);
    for (uint32_t k = 0; k < 2 * STATES; k++) {
        tfa_answer lanes_told = {0}, told = {0};
        tfa_reply in_lanes = reply_to(&a), single = reply_to(&b);
        single.answers = &told;
        r.op = k % 2 ? TFA_OP_INVERSE_DYNAMICS : TFA_OP_FORWARD_DYNAMICS;
        at_state(robot, x, k / 2, &r);
        compute_ok(robot, one, &r, &single);
        assert_int_equal(body_lanes->answer(s, &r, 0, &in_lanes), 1);
        assert_memory_equal(a.joints, b.joints, robot->nv * sizeof(double));
        if (robot->base == TFA_BASE_FLOATING)
            assert_memory_equal(a.base, b.base, sizeof a.base);
        if (r.op == TFA_OP_INVERSE_DYNAMICS)
            continue;
        assert_true(body_lanes->estimate(s, INFINITY, &lanes_told));
        assert_memory_equal(&lanes_told.error_estimate, &told.error_estimate, sizeof(double));
    }
    tfa_workspace_free(one);
    free(b.joints);
    free(a.joints);
    random_states_free(x);
    free(memory);
}

static void every_variant(test_robot *robot)
{
    const struct tfa_body_lanes_kernel *body_lanes;
    for (uint32_t k = 0;
         k < TFA_BODY_LANES_KERNELS_MAX && (body_lanes = tfa_backend_select()->body_lanes[k]); k++)
        if (!robot->model->mimics)
            compare(robot, body_lanes);
}

EVERY_ROBOT(same_bits_as_one_body_at_a_time, every_variant, false)

/* Kernels chosen: branched robots, and no chain. */
static void chosen_where_it_pays(test_robot *robot)
{
    const struct tfa_model *m = robot->model;
    if (m->mimics)
        assert_null(robot->f64->body_lanes);
    else if (m->depth == m->bodies)
        assert_null(robot->f64->body_lanes);
    else if (strncmp(robot->name, "quadruped", 9) == 0 && robot->f64->kernel->isa[0] == 'a')
        assert_non_null(robot->f64->body_lanes);
    assert_null(robot->f32->body_lanes);
    assert_null(robot->f128->body_lanes);
}

EVERY_ROBOT(chains_go_one_by_one, chosen_where_it_pays, false)
