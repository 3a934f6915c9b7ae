/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A state whose accelerations cannot be computed still has its kinematics, in every arithmetic:
 * they have the bits of TFA_OP_KINEMATICS. No answer that overflows comes with TFA_OK, and no
 * failed state leaves an answer as it was. Outputs are those of interface/fields.h.
 */
#include "models.h"
#include "operational.h"
#include "support/small_robot.h"
#include "test.h"

#include <stdbool.h>

#define KINDS 5

static const struct kind {
    const char *name;
    tfa_precision factors;
    tfa_residual residual;
} kinds[KINDS] = {{"f64", TFA_F64, TFA_RESIDUAL_SAME},
                  {"f128", TFA_F128, TFA_RESIDUAL_SAME},
                  {"f32", TFA_F32, TFA_RESIDUAL_SAME},
                  {"f32, residuals in f64", TFA_F32, TFA_RESIDUAL_F64},
                  {"f64, residuals in f128", TFA_F64, TFA_RESIDUAL_F128}};

static uint32_t failed[KINDS];

/* Forces that leave the range of doubles as accelerations */
static void overflow(op_case *c, uint32_t kind, tfa_workspace *w, uint32_t tips)
{
    double tau[OP_FREEDOMS];
    tfa_request r = op_state(c, 0);
    for (uint32_t j = 0; j < c->nv; j++)
        tau[j] = j % 2 ? 1e308 : -1e308;
    r.tau = tau;
    r.tip_count = tips;
    r.flags =
        tips ? OP_KINEMATICS
             : OP_KINEMATICS & ~(TFA_WANT_TWISTS | TFA_WANT_JACOBIAN | TFA_WANT_BIAS_ACCELERATION);
    op_answers *a = op_answers_create(c, &r), *b = op_answers_create(c, &r);
    r.op = TFA_OP_KINEMATICS;
    op_compute(c, w, &r, b);
    r.op = TFA_OP_FORWARD_DYNAMICS;
    if (tfa_compute(w, &r, &a->reply) != TFA_OK) {
        assert_int_equal(a->answers[0].status, a->reply.status);
        op_same(c, kinds[kind].name, a, 0, b, 0, op_outputs_of(OP_KINEMATICS));
        failed[kind]++;
    }
    op_answers_free(b);
    op_answers_free(a);
}

static void overflows(op_case *c)
{
    for (uint32_t kind = 0; kind < KINDS; kind++) {
        tfa_workspace *w = fixture_mixed(c->model, kinds[kind].factors, kinds[kind].residual);
        op_choose_tips(c, 2, TFA_ROWS_POSE, TFA_FRAME_LOCAL);
        overflow(c, kind, w, 2);
        overflow(c, kind, w, 0);
        tfa_workspace_free(w);
    }
}

TEST(failed_states_have_kinematics)
{
    op_for_each(OP_ALL, overflows);
    for (uint32_t kind = 0; kind < KINDS; kind++) {
        print_message("  %s: %u states failed\n", kinds[kind].name, (unsigned)failed[kind]);
        assert_true(failed[kind] > 50);
    }
}

/* ---- answers that overflow ---- */

static uint32_t refused, answered;

static bool is_finite(const double *x, size_t count)
{
    for (size_t e = 0; e < count; e++)
        if (!isfinite(x[e]))
            return false;
    return true;
}

/* 1: so are the answers of these flags */
static bool answers_are_finite(const op_answers *a, uint32_t flags)
{
    bool finite = true;
    for (uint32_t k = 0; k < TFA_WIRE_REPLY_BLOCKS; k++)
        if (tfa_outputs[k].flags & flags && k != TFA_WIRE_RANK && k != TFA_WIRE_LOST)
            finite = finite && is_finite(op_output(a, k, 0), op_numbers(a, k));
    return finite;
}

#define BEFORE 42.5

static void fill(const op_answers *a)
{
    for (size_t e = 0; e < a->size; e++)
        a->memory[e] = BEFORE;
}

/* Nothing of before is left in what the request asks for. */
static void check_written(const op_case *c, const tfa_request *r, const op_answers *a)
{
    for (uint32_t k = 0; k < TFA_WIRE_REPLY_BLOCKS; k++)
        if (tfa_outputs[k].size == sizeof(double) &&
            tfa_is_printed(&tfa_outputs[k], a->n - a->nv, 0, r))
            for (size_t e = 0; e < op_numbers(a, k); e++)
                if (((double *)op_output(a, k, 0))[e] == BEFORE)
                    fail_msg("%s, op %d, %s: %s[%zu] is that of before", c->name, (int)r->op,
                             tfa_status_name(a->reply.status), op_output_names[k], e);
}

static void check_status(const op_case *c, tfa_workspace *w, const tfa_request *r, bool lambda)
{
    op_answers *a = op_answers_create(c, r);
    fill(a);
    const int status = tfa_compute(w, r, &a->reply);
    const bool finite = answers_are_finite(a, OP_KINEMATICS | (lambda ? TFA_WANT_RANK : 0));
    check_written(c, r, a);
    assert_int_equal(a->answers[0].status, status);
    if (status == TFA_OK && !finite)
        fail_msg("%s, op %d: not finite, and TFA_OK", c->name, (int)r->op);
    if (status != TFA_OK)
        assert_int_equal(status, TFA_E_NOT_COMPUTED);
    refused += !finite;
    answered += finite;
    op_answers_free(a);
}

/* Velocities whose squares, and gravity whose products, leave the range of doubles */
static void huge(op_case *c)
{
    static const double gravity[3] = {0, 0, -1e308};
    double v[OP_FREEDOMS], twist[6], desired[2 * 6] = {0};
    tfa_request r = op_state(c, 0);
    op_choose_tips(c, 2, TFA_ROWS_POSE, TFA_FRAME_LOCAL_WORLD_ALIGNED);
    memcpy(r.tips, c->r.tips, sizeof r.tips);
    r.tip_count = 2;
    for (uint32_t j = 0; j < c->nv; j++)
        v[j] = 1e160;
    for (int e = 0; e < 6; e++)
        twist[e] = 1e160;
    r.task_acceleration = desired;
    for (int fast = 0; fast < 2; fast++)
        for (int op = TFA_OP_FORWARD_DYNAMICS; op <= TFA_OP_TASK_TORQUES; op++) {
            const bool lambda = op_has_lambda((tfa_op)op);
            r.op = (tfa_op)op;
            r.v = fast ? v : NULL;
            r.base_twist = fast ? twist : NULL;
            r.gravity = fast ? NULL : gravity;
            r.locked_count = 0;
            r.flags = OP_KINEMATICS | (lambda ? TFA_WANT_LAMBDA | TFA_WANT_MU | TFA_WANT_P : 0);
            check_status(c, c->f64, &r, lambda);
            check_status(c, c->f32, &r, lambda);
            check_status(c, c->f128, &r, lambda);
        }
}

TEST(no_overflow_is_ok)
{
    op_for_each(OP_ALL, huge);
    print_message("  %u answers overflow, %u do not\n", (unsigned)refused, (unsigned)answered);
    assert_true(refused > 1000 && answered > 100);
}

/* ---- modes ---- */

/* Link 1 has a mode; link 2 is a point mass, whose inertia dca cannot invert. */
static tfa_model *flexible_model(void)
{
    static const double momentum[6] = {0.2}, mass = 0.1, stiffness = 50, shape[6] = {1};
    const tfa_mode_shape shapes[] = {{"j1", shape}};
    const tfa_link_modes modes[] = {{.link = "l1",
                                     .mode_count = 1,
                                     .momentum = momentum,
                                     .mass = &mass,
                                     .stiffness = &stiffness,
                                     .shapes = shapes,
                                     .shape_count = 1}};
    const tfa_scene scene = {.modes = modes, .modes_count = 1};
    const tfa_model_options options = {.scene = &scene};
    small_robot u;
    small_robot_begin(&u);
    small_robot_add(&u, 0, TFA_JOINT_REVOLUTE, 1, 0, 0);
    small_robot_add(&u, 1, TFA_JOINT_REVOLUTE, 0, 1, 0);
    small_robot_add(&u, 2, TFA_JOINT_REVOLUTE, 0, 0, 1);
    small_robot_load(&u, 1, 1, 0.1, 0.1, 0.1);
    small_robot_load(&u, 2, 1, 0, 0, 0);
    small_robot_load(&u, 3, 2, 0.2, 0.2, 0.2);
    return compiled(&u.d, &options);
}

TEST(modes_of_failed_states)
{
    static const struct {
        tfa_method method;
        double tau;
        int status;
    } rows[] = {{TFA_METHOD_ABA, 1, TFA_OK},
                {TFA_METHOD_ABA, 1e308, TFA_E_NOT_COMPUTED},
                {TFA_METHOD_DCA, 1, TFA_E_SINGULAR}};
    static const double q[3] = {0.1, 0.2, 0.3};
    tfa_model *model = flexible_model();
    tfa_workspace *w = workspace_for(model, NULL);
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
        const double tau[3] = {rows[k].tau, -rows[k].tau, rows[k].tau};
        const tfa_request r = {.op = TFA_OP_FORWARD_DYNAMICS,
                               .method = rows[k].method,
                               .count = 1,
                               .q = q,
                               .tau = tau};
        double qdd[3], mode = BEFORE;
        tfa_answer answer;
        tfa_reply reply = {.qdd = qdd, .modes = &mode, .answers = &answer};
        assert_int_equal(tfa_compute(w, &r, &reply), rows[k].status);
        assert_true(mode != BEFORE);
        assert_int_equal(isfinite(mode), rows[k].status == TFA_OK);
    }
    tfa_workspace_free(w);
    tfa_model_free(model);
}
