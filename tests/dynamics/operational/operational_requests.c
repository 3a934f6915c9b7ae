/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Requests of operational space that must be refused: each gets the status that dynamics.h promises
 * and the name of the invalid field, in the check as in the computation, and nothing is answered.
 * And inputs that a request does not use are not read.
 */
#include "models.h"
#include "operational.h"
#include "support/small_robot.h"
#include "test.h"

#include <stdbool.h>
#include <totalforce/totalforce.h>

#define STATES 2
#define TIPS 2
#define NQ 3 /* revolute, prismatic, revolute */
#define ROWS (6 * TIPS)
#define MOST 4096
#define MARK 42

static tfa_model *model;
static tfa_workspace *workspace;

/* A request in which everything is right, and room to spoil every part of it */
struct scene {
    tfa_request r;
    double q[NQ * STATES], v[NQ * STATES], tau[NQ * STATES], qdd[NQ * STATES];
    double pose[7 * STATES], twist[6 * STATES], acceleration[6 * STATES];
    double gravity[3], wrenches[6 * STATES], task[ROWS * STATES], threshold;
};

static void set_scene(struct scene *s, tfa_op op)
{
    *s = (struct scene){.gravity = {0, 0, -9.81}, .threshold = 1e-9};
    for (int k = 0; k < STATES; k++) {
        s->q[NQ * k] = 0.3 + k;
        s->q[NQ * k + 2] = 0.7;
        s->v[NQ * k + 1] = 0.5;
        s->pose[7 * k + 6] = 1;
    }
    s->r = (tfa_request){.op = op,
                         .refine = TFA_REFINE_DEFAULT,
                         .count = STATES,
                         .tip_count = TIPS,
                         .tips = {3, 2},
                         .wrench_count = 1,
                         .wrench_frames = {3},
                         .q = s->q,
                         .v = s->v,
                         .tau = s->tau,
                         .qdd = s->qdd,
                         .base_pose = s->pose,
                         .base_twist = s->twist,
                         .base_acceleration = s->acceleration,
                         .gravity = s->gravity,
                         .wrenches = s->wrenches,
                         .task_acceleration = s->task,
                         .rank_threshold = &s->threshold};
}

static int setup(void **state)
{
    (void)state;
    static small_robot robot;
    small_robot_begin(&robot);
    for (uint32_t k = 0; k < 3; k++) {
        tfa_joint *j = small_robot_add(&robot, k, k == 1 ? TFA_JOINT_PRISMATIC : TFA_JOINT_REVOLUTE,
                                       0, k == 0, k != 0);
        j->xyz[0] = 0.3;
        j->xyz[2] = 0.1;
    }
    for (uint32_t k = 0; k < 4; k++)
        small_robot_load(&robot, k, 1.5, 0.02, 0.03, 0.04);
    const tfa_model_options options = {.base = TFA_BASE_FLOATING};
    model = compiled(&robot.d, &options);
    workspace = workspace_for(model, NULL);
    return 0;
}

static int teardown(void **state)
{
    (void)state;
    tfa_workspace_free(workspace);
    tfa_model_free(model);
    return 0;
}

#define ANY UINT32_MAX /* an index that nothing promises */

/* Every buffer is one: what is written there is written by a request that fails. */
static void expect(const char *what, const tfa_request *r, int status, tfa_field field,
                   uint32_t index, uint32_t state)
{
    static double x[MOST];
    tfa_rank rank[STATES];
    for (int k = 0; k < MOST; k++)
        x[k] = MARK;
    for (int check = 0; check < 2; check++) {
        tfa_reply reply = {.rank = rank};
        for (const tfa_output *o = tfa_outputs; o < tfa_outputs + TFA_WIRE_REPLY_BLOCKS; o++)
            if (o->size == sizeof *x)
                tfa_output_set_buffer(o, &reply, x);
        const int got =
            check ? tfa_request_check(model, r, &reply) : tfa_compute(workspace, r, &reply);
        if (got != status || reply.status != status || reply.field != field ||
            (index != ANY && reply.index != index) || reply.state != state)
            fail_msg("%s, op %d: %s (%s) at %s %u of state %u, expected %s at %s %u of state %u",
                     what, (int)r->op, tfa_status_name(got), tfa_status_name(reply.status),
                     tfa_field_name(reply.field), (unsigned)reply.index, (unsigned)reply.state,
                     tfa_status_name(status), tfa_field_name(field), (unsigned)index,
                     (unsigned)state);
        for (int k = 0; status != TFA_OK && k < MOST; k++)
            assert_true(x[k] == MARK);
    }
}

static void expect_ok(const char *what, const tfa_request *r)
{
    expect(what, r, TFA_OK, TFA_FIELD_NONE, 0, 0);
}

static const tfa_op all_ops[] = {TFA_OP_FORWARD_DYNAMICS,    TFA_OP_INVERSE_DYNAMICS,
                                 TFA_OP_OPERATIONAL_INERTIA, TFA_OP_MASS_MATRIX,
                                 TFA_OP_KINEMATICS,          TFA_OP_BIAS,
                                 TFA_OP_DERIVATIVES,         TFA_OP_INVERSE_DYNAMICS_DERIVATIVES,
                                 TFA_OP_TASK_TORQUES};
#define OPS (sizeof all_ops / sizeof *all_ops)

#define TIP_FLAGS (TFA_WANT_TWISTS | TFA_WANT_JACOBIAN | TFA_WANT_BIAS_ACCELERATION)
#define LAMBDA_FLAGS (TFA_WANT_SPECTRUM | TFA_WANT_LAMBDA | TFA_WANT_MU | TFA_WANT_P)

/* 1: an answer by flag that the op does not have */
static bool is_unanswered(tfa_op op, uint32_t flag)
{
    return (flag & LAMBDA_FLAGS && !op_has_lambda(op)) || flag == TFA_WANT_DELASSUS ||
           (flag == TFA_WANT_JOINT_FORCES && op != TFA_OP_FORWARD_DYNAMICS &&
            op != TFA_OP_INVERSE_DYNAMICS);
}

TEST(every_flag_of_every_op)
{
    struct scene s;
    for (size_t k = 0; k < OPS; k++)
        for (uint32_t flag = 1; flag <= TFA_WANT_ALL; flag *= 2) {
            set_scene(&s, all_ops[k]);
            s.r.flags = flag;
            if (is_unanswered(all_ops[k], flag))
                expect("unanswered", &s.r, TFA_E_UNSUPPORTED, TFA_FIELD_OP, ANY, 0);
            else
                expect_ok("flag", &s.r);
        }
}

TEST(unknown_numbers)
{
    struct scene s;
    for (size_t k = 0; k < OPS; k++) {
        for (uint32_t flag = TFA_WANT_ALL + 1; flag; flag *= 2) {
            set_scene(&s, all_ops[k]);
            s.r.flags = flag;
            expect("unknown flag", &s.r, TFA_E_ARGUMENT, TFA_FIELD_FLAGS, ANY, 0);
        }
        set_scene(&s, all_ops[k]);
        s.r.rows = (tfa_rows)2;
        expect("rows 2", &s.r, TFA_E_ARGUMENT, TFA_FIELD_ROWS, ANY, 0);
        s.r.rows = (tfa_rows)-1;
        expect("rows -1", &s.r, TFA_E_ARGUMENT, TFA_FIELD_ROWS, ANY, 0);
        set_scene(&s, all_ops[k]);
        s.r.rank_loss = (tfa_rank_loss)4;
        expect("rank_loss 4", &s.r, TFA_E_ARGUMENT, TFA_FIELD_RANK_LOSS, ANY, 0);
        s.r.rank_loss = (tfa_rank_loss)-1;
        expect("rank_loss -1", &s.r, TFA_E_ARGUMENT, TFA_FIELD_RANK_LOSS, ANY, 0);
    }
    set_scene(&s, (tfa_op)(TFA_OP_LAST + 1));
    expect("op behind the last", &s.r, TFA_E_ARGUMENT, TFA_FIELD_OP, ANY, 0);
    set_scene(&s, (tfa_op)0);
    expect("op 0", &s.r, TFA_E_ARGUMENT, TFA_FIELD_OP, ANY, 0);
}

TEST(thresholds)
{
    static const struct {
        double value;
        int status;
    } rows[] = {{0, TFA_E_ARGUMENT},     {1, TFA_E_ARGUMENT},     {-0.1, TFA_E_ARGUMENT},
                {2, TFA_E_ARGUMENT},     {-0.0, TFA_E_ARGUMENT},  {NAN, TFA_E_VALUE},
                {INFINITY, TFA_E_VALUE}, {-INFINITY, TFA_E_VALUE}};
    struct scene s;
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++)
        for (int op = 0; op < 2; op++) {
            set_scene(&s, op ? TFA_OP_TASK_TORQUES : TFA_OP_OPERATIONAL_INERTIA);
            s.r.flags = TFA_WANT_LAMBDA;
            s.threshold = rows[k].value;
            expect("threshold", &s.r, rows[k].status, TFA_FIELD_RANK_THRESHOLD, 0, 0);
        }
    set_scene(&s, TFA_OP_TASK_TORQUES);
    s.threshold = 0x1p-1074;
    expect_ok("smallest threshold", &s.r);
    s.threshold = 1 - 0x1p-53;
    expect_ok("largest threshold", &s.r);
    s.r.rank_threshold = NULL;
    expect_ok("default threshold", &s.r);
}

TEST(tasks)
{
    struct scene s;
    set_scene(&s, TFA_OP_TASK_TORQUES);
    s.r.task_acceleration = NULL;
    expect("no task", &s.r, TFA_E_ARGUMENT, TFA_FIELD_TASK_ACCELERATION, 0, 0);
    set_scene(&s, TFA_OP_TASK_TORQUES);
    s.task[ROWS + 7] = NAN;
    expect("task", &s.r, TFA_E_VALUE, TFA_FIELD_TASK_ACCELERATION, 7, 1);
    s.r.rows = TFA_ROWS_POINT; /* 12 numbers are two states now, the last 12 are not read */
    s.task[ROWS + 7] = 0;
    s.task[ROWS] = NAN;
    expect_ok("task of points", &s.r);
    s.task[ROWS - 1] = INFINITY;
    expect("task of points", &s.r, TFA_E_VALUE, TFA_FIELD_TASK_ACCELERATION, 5, 1);
    set_scene(&s, TFA_OP_TASK_TORQUES);
    s.tau[NQ + 2] = NAN;
    expect("posture", &s.r, TFA_E_VALUE, TFA_FIELD_TAU, 2, 1);
    for (size_t k = 0; k + 1 < OPS; k++) {
        set_scene(&s, all_ops[k]);
        s.task[0] = NAN;
        expect_ok("task of another op", &s.r);
    }
}

TEST(tips_that_flags_need)
{
    struct scene s;
    for (size_t k = 0; k < OPS; k++) {
        set_scene(&s, all_ops[k]);
        s.r.tip_count = 0;
        const tfa_op op = all_ops[k];
        if (op == TFA_OP_OPERATIONAL_INERTIA || op == TFA_OP_TASK_TORQUES)
            expect("no tips", &s.r, TFA_E_SIZE, TFA_FIELD_TIPS, ANY, 0);
        else
            expect_ok("no tips", &s.r);
        for (uint32_t flag = 1; flag <= TFA_WANT_ALL; flag *= 2) {
            s.r.flags = flag;
            if (flag & TIP_FLAGS || (flag & LAMBDA_FLAGS && op_has_lambda(op)))
                expect("flag without tips", &s.r, TFA_E_SIZE, TFA_FIELD_TIPS, ANY, 0);
        }
        s.r.flags = TFA_WANT_FRAME_POSES | TFA_WANT_COM | TFA_WANT_MOMENTUM | TFA_WANT_ENERGY;
        if (op != TFA_OP_OPERATIONAL_INERTIA && op != TFA_OP_TASK_TORQUES)
            expect_ok("flags that need none", &s.r);
    }
    set_scene(&s, TFA_OP_KINEMATICS);
    s.r.flags = TFA_WANT_JACOBIAN;
    s.r.tips[1] = 4;
    expect("tip that is no frame", &s.r, TFA_E_LINK, TFA_FIELD_TIPS, 1, 0);
    s.r.tip_count = TFA_MAX_TIPS + 1;
    expect("33 tips", &s.r, TFA_E_SIZE, TFA_FIELD_TIPS, TFA_MAX_TIPS + 1, 0);
}

TEST(methods_of_every_op)
{
    struct scene s;
    for (uint32_t m = 0; tfa_method_describe(m); m++)
        for (size_t k = 0; k < OPS; k++) {
            set_scene(&s, all_ops[k]);
            s.r.method = (tfa_method)m;
            if (tfa_method_describe(m)->refuses & TFA_REFUSES_TIPS &&
                all_ops[k] == TFA_OP_FORWARD_DYNAMICS)
                expect("tips", &s.r, TFA_E_METHOD, TFA_FIELD_TIPS, 0, 0);
            else if (tfa_method_describe(m)->ops & TFA_OP_BIT(all_ops[k]))
                expect_ok(tfa_method_name(m), &s.r);
            else
                expect(tfa_method_name(m), &s.r, TFA_E_METHOD, TFA_FIELD_METHOD, m, 0);
        }
}

/* ---- inputs that flags read ---- */

#define READS_WRENCHES (TFA_WANT_MU | TFA_WANT_GENERALISED_MOMENTUM)
#define READS_V                                                                                    \
    (TFA_WANT_TWISTS | TFA_WANT_BIAS_ACCELERATION | TFA_WANT_COM | TFA_WANT_MOMENTUM |             \
     TFA_WANT_ENERGY | READS_WRENCHES)
#define READS_GRAVITY (TFA_WANT_ENERGY | TFA_WANT_P | READS_WRENCHES)

/* A number of an input that is not finite; what reads it names it. */
static const struct {
    const char *name;
    size_t at;      /* in struct scene */
    uint32_t flags; /* that read it, with operational inertia */
    tfa_field field;
    uint32_t index, state;
} inputs[] = {
    {"v", offsetof(struct scene, v[NQ + 1]), READS_V, TFA_FIELD_V, 1, 1},
    {"base_twist", offsetof(struct scene, twist[6 + 4]), READS_V, TFA_FIELD_BASE_TWIST, 4, 1},
    {"gravity", offsetof(struct scene, gravity[2]), READS_GRAVITY, TFA_FIELD_GRAVITY, 2, 0},
    {"wrenches", offsetof(struct scene, wrenches[6 + 3]), READS_WRENCHES, TFA_FIELD_WRENCHES, 3, 1},
    {"qdd", offsetof(struct scene, qdd[NQ]), 0, TFA_FIELD_QDD, 0, 1},
    {"base_acceleration", offsetof(struct scene, acceleration[5]), 0, TFA_FIELD_BASE_ACCELERATION,
     5, 0},
    {"tau", offsetof(struct scene, tau[0]), 0, TFA_FIELD_NONE, 0, 0},
};
#define INPUTS (sizeof inputs / sizeof *inputs)

static void check_input(size_t k, tfa_op op, uint32_t flags, bool is_read)
{
    for (int infinite = 0; infinite < 2; infinite++) {
        struct scene s;
        set_scene(&s, op);
        s.r.flags = flags;
        *(double *)(void *)((char *)&s + inputs[k].at) = infinite ? (double)INFINITY : (double)NAN;
        if (is_read)
            expect(inputs[k].name, &s.r, TFA_E_VALUE, inputs[k].field, inputs[k].index,
                   inputs[k].state);
        else
            expect_ok(inputs[k].name, &s.r);
    }
}

TEST(inputs_are_read_by_what_needs_them)
{
    for (size_t k = 0; k < INPUTS; k++) {
        for (uint32_t flag = 1; flag <= TFA_WANT_ALL; flag *= 2)
            if (!is_unanswered(TFA_OP_OPERATIONAL_INERTIA, flag))
                check_input(k, TFA_OP_OPERATIONAL_INERTIA, flag, flag & inputs[k].flags);
        check_input(k, TFA_OP_BIAS, 0, inputs[k].field != TFA_FIELD_NONE);
        if (inputs[k].flags == 0)
            check_input(k, TFA_OP_KINEMATICS, 0, false);
    }
}

TEST(inputs_that_must_be_there)
{
    struct scene s;
    set_scene(&s, TFA_OP_BIAS);
    s.r.q = NULL;
    expect("q", &s.r, TFA_E_ARGUMENT, TFA_FIELD_Q, 0, 0);
    set_scene(&s, TFA_OP_KINEMATICS);
    s.r.base_pose = NULL;
    expect("base_pose", &s.r, TFA_E_ARGUMENT, TFA_FIELD_BASE_POSE, 0, 0);
}

int main(void)
{
    return test_run(setup, teardown);
}
