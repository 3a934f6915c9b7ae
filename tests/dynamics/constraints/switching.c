/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A quadruped at 1 kHz that changes the set of its feet on the ground every cycle, with other
 * requests between: a workspace has no memory of them, its answers have the bits of a fresh one.
 * And those of batches, pools and prepared requests are the bits of single states.
 */
#include "constrained_robot.h"
#include "models.h"
#include "support/step.h"
#include "test.h"

enum { STATES = 5, NUMBERS = 2 + ROWS, N = 64 }; /* N: most freedoms here */
#define DT 1e-3
#define CYCLES TEST_ROUNDS(3000)

/* Everything that the requests here answer, one state after the other in each */
typedef struct outputs {
    double qdd[STATES * N], base_acceleration[STATES * 6], tau[STATES * N];
    double base_wrench[STATES * 6], lambda_inv[STATES * 144];
    double F[STATES * ROWS], position[STATES * ROWS], velocity[STATES * ROWS];
    double residual[STATES * ROWS], lost[STATES * TFA_LOST_MAX * NUMBERS];
    double delassus[STATES * ROWS * ROWS];
    tfa_rank rank[STATES];
    tfa_answer answers[STATES];
} outputs;

/* All but lambda_inv, which is for tips */
static tfa_reply reply_of(outputs *o)
{
    memset(o, 0x5a, sizeof *o);
    return (tfa_reply){.qdd = o->qdd,
                       .base_acceleration = o->base_acceleration,
                       .tau = o->tau,
                       .base_wrench = o->base_wrench,
                       .constraint_wrenches = o->F,
                       .constraint_position = o->position,
                       .constraint_velocity = o->velocity,
                       .constraint_residual = o->residual,
                       .lost = o->lost,
                       .delassus = o->delassus,
                       .rank = o->rank,
                       .answers = o->answers};
}

/* ---- switching ---- */

static const char *const feet[MOST] = {"FL_foot", "FR_foot", "RL_foot", "RR_foot"};

typedef struct walker {
    tfa_description *description;
    test_robot robot;
    constrained_robot c;
    double q[N], v[6 + N], tau[N], pose[7]; /* v: base first */
} walker;

static tfa_request request_of(walker *x, tfa_op op)
{
    tfa_request r = request_fd(x->q, x->v + 6, x->tau);
    r.op = op;
    r.base_pose = x->pose;
    r.base_twist = x->v;
    return r;
}

/* Feet held where they stand */
static void open_walker(walker *x)
{
    double poses[MOST][7];
    *x = (walker){.description = bundled_description("quadruped.urdf"),
                  .pose = {0, 0, 0.3, 0, 0, 0, 1}};
    fixture_open_description("quadruped", x->description, TFA_BASE_FLOATING, &x->robot);
    x->c.robot = &x->robot;
    for (int k = 0; k < 12; k++)
        x->q[k] = k % 3 == 0 ? 0 : k % 3 == 1 ? 0.8 : -1.6;
    tfa_request r = request_of(x, TFA_OP_KINEMATICS);
    r.flags = TFA_WANT_POSES;
    for (uint32_t k = 0; k < MOST; k++)
        r.tips[r.tip_count++] = (uint32_t)tfa_model_find_frame(x->robot.model, feet[k]);
    tfa_reply reply = {.poses = poses[0]};
    compute_ok(&x->robot, x->robot.f64, &r, &reply);
    for (uint32_t k = 0; k < MOST; k++)
        memcpy(constrained_add(&x->c, WORLD, r.tips[k], TFA_CONSTRAINT_POINT)->pose[0], poses[k],
               3 * sizeof(double));
    assert_true(constrained_open(&x->c));
}

/* The workspace answers as a fresh one does. */
static void ask(walker *x, const tfa_request *r, outputs *o)
{
    static outputs other;
    tfa_workspace *fresh = fixture_workspace(x->c.model, TFA_F64);
    tfa_reply reply = reply_of(o);
    reply.lambda_inv = r->tip_count ? o->lambda_inv : NULL;
    compute_ok(&x->robot, x->c.f64, r, &reply);
    reply = reply_of(&other);
    reply.lambda_inv = r->tip_count ? other.lambda_inv : NULL;
    compute_ok(&x->robot, fresh, r, &reply);
    tfa_workspace_free(fresh);
    assert_memory_equal(o, &other, sizeof other);
}

/* Something else on the same workspace */
static void ask_between(walker *x, random_source *s)
{
    static const double wanted[12] = {0.1, 0.2, 0.3, 1, 2, 3, -1};
    static outputs o;
    tfa_request r = request_of(x, TFA_OP_FORWARD_DYNAMICS);
    r.tip_count = random_below(s, 3);
    for (uint32_t t = 0; t < r.tip_count; t++)
        r.tips[t] = x->c.link[random_below(s, MOST)][1];
    if (r.tip_count)
        r.op = TFA_OP_TASK_TORQUES;
    r.task_acceleration = wanted;
    ask(x, &r, &o);
}

/* Springs to the stance, semi-implicit Euler */
static void move(walker *x, const outputs *o)
{
    for (int k = 0; k < 6; k++)
        x->v[k] += DT * o->base_acceleration[k];
    for (int k = 0; k < 12; k++)
        x->v[6 + k] += DT * o->qdd[k];
    step_model(x->c.model, x->q, x->pose, x->v, DT, x->q, x->pose);
    for (int k = 0; k < 12; k++)
        x->tau[k] = 60 * ((k % 3 == 0 ? 0 : k % 3 == 1 ? 0.8 : -1.6) - x->q[k]) - 2 * x->v[6 + k];
}

TEST(feet_that_change_every_cycle)
{
    static const double gains[2] = {2e4, 500};
    static outputs o;
    walker x;
    random_source s = {12};
    uint32_t sets = 0;
    double fall = 0;
    open_walker(&x);
    for (int k = 0; k < CYCLES; k++) {
        tfa_request r = request_of(&x, TFA_OP_CONSTRAINED_DYNAMICS);
        r.constraints = 1 + random_below(&s, 15);
        r.stabilisation = gains;
        r.flags = k & 1 ? TFA_WANT_DELASSUS : 0;
        if (k % 3)
            ask_between(&x, &s);
        ask(&x, &r, &o);
        move(&x, &o);
        sets |= 1u << r.constraints;
        fall = fmax(fall, fabs(x.pose[2] - 0.3));
    }
    print_message("  %d cycles, the trunk within %.0f mm of where it was\n", CYCLES, 1e3 * fall);
    assert_int_equal(sets, 0xfffe);
    assert_true(fall < 0.15);
    constrained_close(&x.c);
    fixture_close(&x.robot);
    tfa_description_free(x.description);
}

/* ---- batches ---- */

static uint32_t robots;

/* Places of state k in the answers about all */
static tfa_reply at_state(const constrained_robot *c, const tfa_reply *all, uint32_t k)
{
    const size_t six = (size_t)6 * c->count;
    tfa_reply y = *all;
    y.qdd += k * c->robot->nv;
    y.base_acceleration += 6 * k;
    y.constraint_wrenches += k * six;
    y.constraint_position += k * six;
    y.constraint_velocity += k * six;
    y.constraint_residual += k * six;
    y.lost += k * TFA_LOST_MAX * (2 + six);
    y.delassus += k * six * six;
    y.rank += k;
    y.answers += k;
    return y;
}

static void ask_each(const constrained_robot *c, const tfa_request *all, outputs *o)
{
    const tfa_reply whole = reply_of(o);
    for (uint32_t k = 0; k < STATES; k++) {
        tfa_request r = *all;
        r.count = 1;
        r.q += k * c->robot->nq;
        r.v += k * c->robot->nv;
        r.tau += k * c->robot->nv;
        r.constraint_acceleration += (size_t)6 * c->count * k;
        if (r.base_pose) {
            r.base_pose += 7 * k;
            r.base_twist += 6 * k;
            r.base_wrench += 6 * k;
        }
        tfa_reply reply = at_state(c, &whole, k);
        compute_ok(c->robot, c->f64, &r, &reply);
    }
}

static void same_bits(const constrained_robot *c, const tfa_request *r)
{
    static outputs each, other;
    tfa_prepared *prepared = NULL;
    ask_each(c, r, &each);
    tfa_reply reply = reply_of(&other);
    compute_ok(c->robot, c->f64, r, &reply);
    assert_memory_equal(&other, &each, sizeof each);
    for (uint32_t threads = 1; threads <= 3; threads++) {
        const tfa_batch_pool_options options = {.threads = threads};
        tfa_batch_pool *pool;
        assert_int_equal(tfa_batch_pool_create(c->model, &options, &pool), TFA_OK);
        reply = reply_of(&other);
        assert_int_equal(tfa_batch_pool_compute(pool, r, &reply), TFA_OK);
        assert_memory_equal(&other, &each, sizeof each);
        tfa_batch_pool_free(pool);
    }
    reply = reply_of(&other);
    assert_int_equal(tfa_prepare(c->f64, r, &reply, &prepared), TFA_OK);
    reply = reply_of(&other);
    assert_int_equal(tfa_run(prepared, r, &reply), TFA_OK);
    assert_memory_equal(&other, &each, sizeof each);
    tfa_prepared_free(prepared);
}

/* A request with everything, for each robot */
static void with_request(test_robot *robot,
                         void (*check)(const constrained_robot *c, const tfa_request *r))
{
    static const double gains[2] = {3, 2};
    double wanted[STATES * ROWS];
    random_source s = {robot->seed + 5 * robot->base};
    constrained_robot c = {.robot = robot};
    if (robot->n > N)
        return;
    constrained_draw(&c, &s, MOST);
    if (!constrained_open(&c))
        return;
    random_states *x = fixture_states(robot, 8, STATES, 0);
    tfa_request r = constrained_request(&c, x);
    for (uint32_t k = 0; k < STATES * ROWS; k++)
        wanted[k] = random_uniform(&s, -9, 9);
    r.constraint_acceleration = wanted;
    r.stabilisation = gains;
    r.flags = TFA_WANT_DELASSUS;
    check(&c, &r);
    robots++;
    random_states_free(x);
    constrained_close(&c);
}

static void bits_law(test_robot *robot)
{
    with_request(robot, same_bits);
}

TEST(batches_pools_and_prepared_requests)
{
    robots = 0;
    for_every_robot(bits_law, false);
    assert_true(robots > 20);
}

/* ---- tips ---- */

/* Tips of the request beside the constraints: where they are and how they move, as kinematics
 * answer it; lambda_inv is no answer of this op. */
static void check_tips(const constrained_robot *c, const tfa_request *state)
{
    static outputs o;
    double poses[2][14], twists[2][12], jacobian[2][12 * N], bias[2][12];
    const uint32_t links = tfa_model_frame_count(c->model);
    tfa_request r = *state;
    r.count = 1;
    r.flags = TFA_WANT_POSES | TFA_WANT_TWISTS | TFA_WANT_JACOBIAN | TFA_WANT_BIAS_ACCELERATION;
    r.tip_count = 2;
    r.tips[0] = links - 1;
    r.tips[1] = links / 2;
    for (int op = 0; op < 2; op++) {
        tfa_reply reply = reply_of(&o);
        r.op = op ? TFA_OP_CONSTRAINED_DYNAMICS : TFA_OP_KINEMATICS;
        reply.lambda_inv = o.lambda_inv;
        reply.poses = poses[op];
        reply.twists = twists[op];
        reply.jacobian = jacobian[op];
        reply.bias_acceleration = bias[op];
        compute_ok(c->robot, c->f64, &r, &reply);
    }
    assert_memory_equal(poses[1], poses[0], sizeof poses[0]);
    assert_memory_equal(twists[1], twists[0], sizeof twists[0]);
    assert_memory_equal(jacobian[1], jacobian[0], (size_t)12 * c->robot->n * sizeof(double));
    assert_memory_equal(bias[1], bias[0], sizeof bias[0]);
    for (size_t k = 0; k < sizeof o.lambda_inv; k++)
        if (((const uint8_t *)o.lambda_inv)[k] != 0x5a)
            fail_msg("%s: lambda_inv is written, byte %zu", c->robot->name, k);
}

static void tips_law(test_robot *robot)
{
    with_request(robot, check_tips);
}

TEST(tips_beside_constraints)
{
    robots = 0;
    for_every_robot(tips_law, false);
    assert_true(robots > 20);
}
