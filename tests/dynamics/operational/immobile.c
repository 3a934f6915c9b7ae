/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Robots at the edge: without freedoms, a rigid body that floats, tips on links fixed to the world,
 * one tip many times.
 */
#include "models.h"
#include "operational.h"
#include "support/small_robot.h"
#include "test.h"

/* root, a joint, and a link welded to it, all of them solid */
static void describe(small_robot *r, tfa_joint_type type)
{
    small_robot_begin(r);
    for (uint32_t k = 0; k < 2; k++) {
        tfa_joint *j = small_robot_add(r, k, k ? TFA_JOINT_FIXED : type, 0, 1, 0);
        j->xyz[0] = 0.3;
        j->xyz[2] = 0.1;
    }
    for (uint32_t k = 0; k < 3; k++) {
        small_robot_load(r, k, 2, 0.02, 0.03, 0.04);
        memcpy(r->link[k].com, (double[3]){0.1, 0.2, -0.1}, sizeof r->link[k].com);
    }
}

static const double desired[12] = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12};

/* Nothing moves: everything that could is zero, nothing is NaN. */
TEST(robot_without_freedoms)
{
    small_robot robot;
    describe(&robot, TFA_JOINT_FIXED);
    op_case c = {.name = "no freedoms", .model = compiled(&robot.d, NULL), .link_count = 3};
    tfa_workspace *w = workspace_for(c.model, NULL);
    for (size_t k = 0; k < OP_OPS; k++)
        for (int policy = 0; policy < 2; policy++) {
            tfa_request r = {.op = op_ops[k],
                             .flags = op_flags(op_ops[k]),
                             .count = 1,
                             .tip_count = 2,
                             .tips = {2, 0},
                             .rank_loss = (tfa_rank_loss)policy,
                             .task_acceleration = desired};
            op_answers *a = op_answers_create(&c, &r);
            op_compute(&c, w, &r, a);
            assert_true(a->mass[0] == 0 && a->energy[0] == 0 && a->energy[1] == 0);
            for (int i = 0; i < 3; i++)
                assert_true(isfinite(a->com[i]) && a->com_velocity[i] == 0);
            for (int i = 0; i < 6; i++)
                assert_true(a->momentum[i] == 0);
            assert_true(fabs(a->poses[0] - 0.6) < 1e-15 && a->poses[6] == 1);
            for (uint32_t i = 0; i < 12; i++)
                assert_true(a->twists[i] == 0 && a->bias_acceleration[i] == 0);
            for (uint32_t i = 0; op_has_lambda(op_ops[k]) && i < 144; i++) {
                assert_true(a->lambda_inv[i] == 0 && a->lambda[i] == 0);
                assert_true(a->mu[i % 12] == 0 && a->p[i % 12] == 0 && a->rank[0].rank == 0);
            }
            op_answers_free(a);
        }
    tfa_workspace_free(w);
    tfa_model_free((tfa_model *)(uintptr_t)c.model);
}

/* One rigid body: Lambda at its centre of mass would be its mass and inertia. */
TEST(floating_body)
{
    small_robot robot;
    const tfa_model_options options = {.base = TFA_BASE_FLOATING};
    const double pose[7] = {0.3, -0.2, 0.5, 0.5, 0.5, 0.5, 0.5}, twist[6] = {1, 2, 3, -1, 0.5, 2};
    describe(&robot, TFA_JOINT_FIXED);
    op_case c = {
        .name = "body", .model = compiled(&robot.d, &options), .link_count = 3, .n = 6, .six = 6};
    tfa_workspace *w = workspace_for(c.model, NULL);
    tfa_request r = {.op = TFA_OP_TASK_TORQUES,
                     .flags = op_flags(TFA_OP_TASK_TORQUES),
                     .count = 1,
                     .tip_count = 1,
                     .tips = {2},
                     .frame = TFA_FRAME_LOCAL,
                     .base_pose = pose,
                     .base_twist = twist,
                     .task_acceleration = desired};
    op_answers *a = op_answers_create(&c, &r), *M = op_answers_create(&c, &r);
    op_compute(&c, w, &r, a);
    assert_true(fabs(a->mass[0] - 6) < 1e-14);
    assert_int_equal(a->rank[0].rank, 6);
    r.op = TFA_OP_MASS_MATRIX;
    r.flags = 0;
    op_compute(&c, w, &r, M);
    double error = 0, size = 0; /* J^T Lambda J = M */
    for (int i = 0; i < 6; i++)
        for (int j = 0; j < 6; j++) {
            double x = 0;
            for (int k = 0; k < 6; k++)
                for (int l = 0; l < 6; l++)
                    x += a->jacobian[6 * k + i] * a->lambda[6 * k + l] * a->jacobian[6 * l + j];
            error = fmax(error, fabs(x - M->mass_matrix[6 * i + j]));
            size = fmax(size, fabs(x));
        }
    print_message("  J^T lambda J - M: %.2g of %.2g\n", error, size);
    assert_true(error <= 1e-13 * size);
    r.op = TFA_OP_FORWARD_DYNAMICS;
    r.base_wrench = a->base_wrench;
    op_compute(&c, w, &r, M);
    for (int i = 0; i < 6; i++) {
        double x = a->bias_acceleration[i];
        for (int j = 0; j < 6; j++)
            x += a->jacobian[6 * i + j] * M->base_acceleration[j];
        assert_true(fabs(x - desired[i]) <= 1e-12 * 6);
    }
    op_answers_free(M);
    op_answers_free(a);
    tfa_workspace_free(w);
    tfa_model_free((tfa_model *)(uintptr_t)c.model);
}

/* A joint, a tip that it moves, one that it does not, and the first again: each in its own rows. */
TEST(tips_fixed_to_the_world)
{
    small_robot robot;
    const double q = 0.4, v = 1.5;
    describe(&robot, TFA_JOINT_REVOLUTE);
    op_case c = {
        .name = "arm", .model = compiled(&robot.d, NULL), .link_count = 3, .n = 1, .nv = 1};
    tfa_workspace *w = workspace_for(c.model, NULL);
    for (size_t k = 0; k < OP_OPS; k++) {
        static const double wanted[18] = {1};
        tfa_request r = {.op = op_ops[k],
                         .flags = op_flags(op_ops[k]),
                         .count = 1,
                         .tip_count = 3,
                         .tips = {2, 0, 2},
                         .q = &q,
                         .v = &v,
                         .task_acceleration = wanted};
        op_answers *a = op_answers_create(&c, &r);
        op_compute(&c, w, &r, a);
        assert_true(fabs(a->mass[0] - 4) < 1e-14); /* without the root */
        for (uint32_t i = 0; i < 6; i++) {
            assert_true(a->jacobian[6 + i] == 0 && a->twists[6 + i] == 0);
            assert_true(a->bias_acceleration[6 + i] == 0);
            assert_true(a->jacobian[i] == a->jacobian[12 + i]);
            for (uint32_t j = 0; op_has_lambda(op_ops[k]) && j < 18; j++) {
                assert_true(a->lambda_inv[(6 + i) * 18 + j] == 0);
                assert_true(fabs(a->lambda[(6 + i) * 18 + j]) <= 1e-300);
                assert_int_equal(a->rank[0].rank, 1);
            }
        }
        op_answers_free(a);
    }
    tfa_workspace_free(w);
    tfa_model_free((tfa_model *)(uintptr_t)c.model);
}
