/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A state whose accelerations cannot be computed still has its kinematics, in every arithmetic:
 * they have the bits of TFA_OP_KINEMATICS. And no answer that overflows comes with TFA_OK.
 */
#include "operational.h"
#include "support/fixture.h"
#include "test.h"

#define FLAGS                                                                                      \
    (TFA_WANT_POSES | TFA_WANT_FRAME_POSES | TFA_WANT_TWISTS | TFA_WANT_JACOBIAN |                 \
     TFA_WANT_BIAS_ACCELERATION | TFA_WANT_COM | TFA_WANT_MOMENTUM | TFA_WANT_ENERGY)
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

static void same(const op_case *c, uint32_t kind, const char *what, const double *x,
                 const double *y, size_t count)
{
    if (memcmp(x, y, count * sizeof *x) != 0)
        fail_msg("%s, %s: %s of a failed state", c->name, kinds[kind].name, what);
}

static void check_motion(const op_case *c, uint32_t kind, const op_answers *a, const op_answers *b)
{
    same(c, kind, "poses", a->poses, b->poses, (size_t)7 * a->tips);
    same(c, kind, "frame_poses", a->frame_poses, b->frame_poses, (size_t)7 * a->frames);
    same(c, kind, "twists", a->twists, b->twists, (size_t)6 * a->tips);
    same(c, kind, "jacobian", a->jacobian, b->jacobian, (size_t)a->rows * a->n);
    same(c, kind, "bias_acceleration", a->bias_acceleration, b->bias_acceleration, a->rows);
    same(c, kind, "com", a->com, b->com, 3);
    same(c, kind, "com_velocity", a->com_velocity, b->com_velocity, 3);
    same(c, kind, "com_jacobian", a->com_jacobian, b->com_jacobian, (size_t)3 * a->n);
    same(c, kind, "mass", a->mass, b->mass, 1);
    same(c, kind, "momentum", a->momentum, b->momentum, 6);
    same(c, kind, "energy", a->energy, b->energy, 2);
}

/* Forces that leave the range of doubles as accelerations */
static void overflow(op_case *c, uint32_t kind, tfa_workspace *w, uint32_t tips)
{
    double tau[OP_FREEDOMS];
    tfa_request r = op_state(c, 0);
    for (uint32_t j = 0; j < c->nv; j++)
        tau[j] = j % 2 ? 1e308 : -1e308;
    r.tau = tau;
    r.tip_count = tips;
    r.flags = tips ? FLAGS : FLAGS & ~(TFA_WANT_TWISTS | TFA_WANT_JACOBIAN |
                                       TFA_WANT_BIAS_ACCELERATION);
    op_answers *a = op_answers_create(c, &r), *b = op_answers_create(c, &r);
    r.op = TFA_OP_KINEMATICS;
    op_compute(c, w, &r, b);
    r.op = TFA_OP_FORWARD_DYNAMICS;
    if (tfa_compute(w, &r, &a->reply) != TFA_OK) {
        assert_int_equal(a->answers[0].status, a->reply.status);
        check_motion(c, kind, a, b);
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
