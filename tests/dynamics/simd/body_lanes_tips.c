/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Tips with the factors of body lanes, forces across joints with their motions, and inverse
 * dynamics: Lambda^-1, task torques, poses and forces are those of one body after the other, to the
 * bit, in whatever order requests come, whether they use body lanes or not.
 */
#include "engine/strategy.h"
#include "layout/schedule_body_lanes.h"
#include "support/fixture.h"
#include "test.h"

#define COORDINATES 2
#define STATES (2 * COORDINATES)
#define REQUESTS 96
#define TIPS 4
#define LAMBDA (36 * TIPS * TIPS)

struct answers {
    double base[6], lambda[LAMBDA], poses[7 * TIPS];
    tfa_spectrum spectrum;
    tfa_answer answer;
    double *joints, *forces; /* accelerations, or forces */
};

/* ---- strategy ---- */

/* A workspace all of whose plain states use these body lanes, whether they pay or not. Returns the
 * memory of the body lanes. */
static void *with_body_lanes(tfa_workspace *w, const struct tfa_body_lanes_kernel *body_lanes)
{
    int32_t table[TFA_BODY_LANES_BODIES_MAX * TFA_BODY_LANES_MAX];
    const struct tfa_lane_schedule p = tfa_schedule_body_lanes(w->model, body_lanes->lanes, table);
    void *memory = aligned_alloc(64, body_lanes->size(w->model, &p));
    w->body_lanes = body_lanes;
    w->body_lanes_state = body_lanes->init(w->model, &p, memory);
    w->factors = w->kernel->factor_buffers(w->state);
    w->body_lanes_min_bodies = 0;
    w->strategies = tfa_strategies_of(w, w->strategy);
    return memory;
}

/* ---- what is asked ---- */

static tfa_method any_method(random_source *s, tfa_op op)
{
    static const tfa_method methods[] = {TFA_METHOD_AUTO, TFA_METHOD_ABA, TFA_METHOD_PROPAGATION,
                                         TFA_METHOD_PV_OSIMR, TFA_METHOD_EFPA};
    return methods[random_below(s, op == TFA_OP_INVERSE_DYNAMICS      ? 1
                                   : op == TFA_OP_OPERATIONAL_INERTIA ? 5
                                                                      : 2)];
}

/* At few states, so that coordinates come again; now and then there is an estimate, a joint is
 * locked, or a payload hangs somewhere, which body lanes leave to other strategies. */
static tfa_request any_request(random_source *s, const test_robot *robot, const random_states *x,
                               const uint32_t *joint, const double *payload)
{
    static const tfa_op ops[] = {TFA_OP_FORWARD_DYNAMICS, TFA_OP_OPERATIONAL_INERTIA,
                                 TFA_OP_INVERSE_DYNAMICS, TFA_OP_TASK_TORQUES};
    static const double task[6 * TIPS] = {1, -2, 3, 4, -5, 6, [7] = 2};
    const size_t c = random_below(s, COORDINATES), k = 2 * c + random_below(s, 2);
    const uint32_t frames = tfa_model_frame_count(robot->model);
    tfa_request r = fixture_request(robot, x);
    r.op = ops[random_below(s, sizeof ops / sizeof *ops)];
    r.method = any_method(s, r.op);
    r.estimate = random_below(s, 4) ? TFA_ESTIMATE_NEVER : TFA_ESTIMATE_ALWAYS;
    r.frame = (tfa_reference_frame)random_below(s, 3);
    r.count = 1;
    r.wrench_count = 0;
    r.q += c * robot->nq;
    r.v = random_below(s, 3) ? r.v + k * robot->nv : NULL;
    r.qdd = r.tau += k * robot->nv;
    r.base_pose = r.base_pose ? r.base_pose + 7 * c : NULL;
    r.base_twist = r.base_twist && r.v ? r.base_twist + 6 * k : NULL;
    const int moves = r.op == TFA_OP_FORWARD_DYNAMICS || r.op == TFA_OP_INVERSE_DYNAMICS;
    r.tip_count = random_below(s, TIPS) + !moves;
    r.task_acceleration = task;
    const int solves = r.op != TFA_OP_INVERSE_DYNAMICS;
    r.flags = TFA_WANT_POSES | (r.tip_count && solves ? TFA_WANT_SPECTRUM : 0) |
              (moves && random_below(s, 2) ? TFA_WANT_JOINT_FORCES : 0);
    for (uint32_t t = 0; t < r.tip_count; t++)
        r.tips[t] = random_below(s, frames);
    if (random_below(s, 8) == 0 && r.method != TFA_METHOD_EFPA) {
        r.locked = joint;
        r.locked_count = 1;
    }
    if (random_below(s, 8) == 0 && !robot->model->parts) {
        r.payload_count = 1;
        r.payload_frames[0] = random_below(s, frames);
        r.payloads = payload;
    }
    return r;
}

static void ask(const test_robot *robot, tfa_workspace *w, const tfa_request *r, struct answers *a)
{
    tfa_reply reply = {.qdd = a->joints,
                       .tau = a->joints,
                       .base_acceleration = a->base,
                       .base_wrench = a->base,
                       .lambda_inv = a->lambda,
                       .spectrum = &a->spectrum,
                       .poses = a->poses,
                       .joint_forces = a->forces,
                       .answers = &a->answer};
    double *joints = a->joints, *forces = a->forces;
    memset(a, 0, sizeof *a);
    memset(joints, 0, robot->nv * sizeof *joints);
    memset(forces, 0, 6 * tfa_model_frame_count(robot->model) * sizeof *forces);
    a->joints = joints;
    a->forces = forces;
    compute_ok(robot, w, r, &reply);
}

static void assert_same(const test_robot *robot, const struct answers *a, const struct answers *b)
{
    assert_memory_equal(a->joints, b->joints, robot->nv * sizeof *a->joints);
    assert_memory_equal(a->base, b->base, sizeof a->base);
    assert_memory_equal(a->lambda, b->lambda, sizeof a->lambda);
    assert_memory_equal(a->poses, b->poses, sizeof a->poses);
    assert_memory_equal(a->forces, b->forces,
                        6 * tfa_model_frame_count(robot->model) * sizeof *a->forces);
    assert_memory_equal(&a->spectrum, &b->spectrum, sizeof a->spectrum);
    assert_int_equal(a->answer.method, b->answer.method);
    assert_int_equal(a->answer.flags, b->answer.flags);
}

/* ---- both ---- */

static void compare(test_robot *robot, const struct tfa_body_lanes_kernel *body_lanes)
{
    random_source s = {robot->seed};
    random_states *x = fixture_states(robot, 0, STATES, 0);
    tfa_workspace *one = fixture_workspace(robot->model, TFA_F64),
                  *in_lanes = fixture_workspace(robot->model, TFA_F64);
    void *memory = with_body_lanes(in_lanes, body_lanes);
    const size_t forces = 6 * (size_t)tfa_model_frame_count(robot->model);
    struct answers a = {.joints = calloc(robot->nv + 1, sizeof(double)),
                        .forces = calloc(forces, sizeof(double))},
                   b = {.joints = calloc(robot->nv + 1, sizeof(double)),
                        .forces = calloc(forces, sizeof(double))};
    const uint32_t joint = random_below(&s, tfa_model_joint_count(robot->model));
    double payload[TFA_PAYLOAD_NUMBERS];
    random_payload(&s, payload);
    one->body_lanes = NULL;
    one->strategies = tfa_strategies_of(one, one->strategy);
    for (uint32_t k = 0; k < REQUESTS; k++) {
        const tfa_request r = any_request(&s, robot, x, &joint, payload);
        ask(robot, one, &r, &a);
        ask(robot, in_lanes, &r, &b);
        assert_same(robot, &a, &b);
    }
    free(b.forces);
    free(b.joints);
    free(a.forces);
    free(a.joints);
    tfa_workspace_free(in_lanes);
    tfa_workspace_free(one);
    free(memory);
    random_states_free(x);
}

static void every_variant(test_robot *robot)
{
    const struct tfa_body_lanes_kernel *body_lanes;
    for (uint32_t k = 0;
         k < TFA_BODY_LANES_KERNELS_MAX && (body_lanes = tfa_backend_select()->body_lanes[k]); k++)
        if (!robot->model->mimics && tfa_model_joint_count(robot->model))
            compare(robot, body_lanes);
}

EVERY_ROBOT(same_bits_in_any_order, every_variant, false)
