/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Total forces across joints against the oracle, which adds up what moves every link outboard;
 * their part along the joint is its force, equation (58) of the paper; and an arm at rest by hand.
 */
#include "models.h"
#include "operational.h"
#include "support/small_robot.h"
#include "test.h"

enum { FORWARD, INVERSE, FLOATS, ALONG, KINDS };
/* In double; in f128 */
static op_bound bounds[KINDS] = {
    {"of forward dynamics", {4e-15, 4e-16}, {0}},
    {"of inverse dynamics", {4e-15, 4e-16}, {0}},
    {"of forward dynamics by floats", {4e-15, 0}, {0}},
    {"H^T F = tau - damping - friction - armature qdd", {2e-15, 4e-16}, {0}},
};

/* Accelerations of state k, base first */
static void accelerations(const op_case *c, const op_answers *a, uint32_t k, quad *qdd)
{
    const int given = c->r.op == TFA_OP_INVERSE_DYNAMICS;
    const double *base = given ? c->r.base_acceleration : a->base_acceleration;
    const double *joints = given ? c->r.qdd : a->qdd;
    for (uint32_t i = 0; i < c->n; i++)
        qdd[i] = i < c->six ? (base ? base[6 * (size_t)k + i] : 0)
                            : joints[(size_t)k * c->nv + i - c->six];
}

static quad norm(const quad *x, int n)
{
    quad sum = 0;
    for (int e = 0; e < n; e++)
        sum += x[e] * x[e];
    return quad_sqrt(sum);
}

static void check_links(op_case *c, const op_answers *a, uint32_t k, const oracle_wrench *F,
                        op_bound *bound)
{
    for (uint32_t f = 0; f < c->link_count; f++) {
        const double *got = a->joint_forces + 6 * ((size_t)k * c->link_count + f);
        quad want[6], off[6];
        oracle_wrench_in(c->o, c->link[f], c->r.frame, &F[c->link[f]], want);
        for (int e = 0; e < 6; e++)
            off[e] = got[e] - want[e];
        op_within(c, bound,
                  (double)(norm(off, 6) / (F[c->link[f]].size + norm(want, 6) + (quad)1e-300)));
    }
}

static uint32_t frame_of(const op_case *c, uint32_t link)
{
    uint32_t f = 0;
    while (f < c->link_count && c->link[f] != link)
        f++;
    return f;
}

/* The largest terms of each row of M qdd: a last bit of qdd is worth so much. */
static void add_terms(const op_case *c, const quad *qdd, double *size)
{
    double *M = op_alloc((size_t)c->n * c->n, sizeof *M);
    oracle_mass_matrix(c->o, M);
    for (uint32_t i = 0; i < c->n; i++)
        for (uint32_t j = 0; j < c->n; j++)
            size[i] += fabs(M[i * c->n + j] * (double)qdd[j]);
    free(M);
}

/* Of joints with one freedom, in the frames of their links */
static void check_along(op_case *c, const op_answers *a, uint32_t k, const quad *accelerations,
                        const oracle_wrench *F)
{
    double terms[OP_FREEDOMS] = {0};
    if (c->r.frame != TFA_FRAME_LOCAL || c->tie)
        return;
    add_terms(c, accelerations, terms);
    for (uint32_t v = 0, within; v < c->nv; v++) {
        const tfa_joint *j = &c->whole->joints[oracle_joint_of_freedom(c->o, v, &within)];
        if (j->type == TFA_JOINT_PLANAR || j->type == TFA_JOINT_FLOATING)
            continue;
        const size_t at = (size_t)k * c->nv + v;
        const int given = c->r.op == TFA_OP_INVERSE_DYNAMICS;
        const double qdd = given ? c->r.qdd[at] : a->qdd[at];
        const double tau = given ? a->tau[at] : c->r.tau[at];
        const double *f = a->joint_forces + 6 * ((size_t)k * c->link_count + frame_of(c, j->child));
        f += j->type == TFA_JOINT_PRISMATIC ? 0 : 3;
        const double along =
            (f[0] * j->axis[0] + f[1] * j->axis[1] + f[2] * j->axis[2]) / norm2(j->axis, 3);
        const double s = c->friction_velocity, x = c->r.v[at],
                     damping = c->damped ? j->damping * x : 0,
                     friction = s > 0 ? j->friction * x / sqrt(x * x + s * s) : 0;
        const double size = terms[c->six + v] + (double)F[j->child].size + fabs(tau);
        op_within(c, &bounds[ALONG],
                  fabs(along + j->armature * qdd + damping + friction - tau) / size);
    }
}

/* Links of trees that a scene leaves out are no frames. */
static void find_absent(const op_case *c, bool *absent)
{
    for (size_t l = 0; l < c->whole->link_count; l++)
        absent[l] = frame_of(c, (uint32_t)l) == c->link_count;
}

static void with_op(op_case *c, tfa_workspace *w, tfa_op op)
{
    quad qdd[OP_FREEDOMS];
    oracle_wrench *F = op_alloc(c->whole->link_count, sizeof *F);
    bool *absent = op_alloc(c->whole->link_count, sizeof *absent);
    find_absent(c, absent);
    c->set = w == c->f128;
    c->r.op = op;
    c->r.flags = TFA_WANT_JOINT_FORCES;
    tfa_request r = c->r;
    op_choose_method(c, &r);
    if (c->set)
        r.method = TFA_METHOD_AUTO;
    op_answers *a = op_answer(c, w, &r);
    for (uint32_t k = 0; k < r.count; k++) {
        op_set_state_locked(c, k);
        accelerations(c, a, k, qdd);
        for (uint32_t l = 0; op == TFA_OP_INVERSE_DYNAMICS && l < c->r.locked_count; l++) {
            const tfa_joint_info j = tfa_model_joint(c->model, c->r.locked[l]);
            for (uint32_t i = 0; i < j.v_count; i++)
                qdd[c->six + j.v_index + i] = 0;
        }
        oracle_joint_forces(c->o, &c->whole_r, k, qdd, absent, F);
        check_links(c, a, k, F,
                    &bounds[op == TFA_OP_INVERSE_DYNAMICS ? INVERSE
                            : w == c->f32                 ? FLOATS
                                                          : FORWARD]);
        if (!c->r.locked_count && w != c->f32) /* whose accelerations are those of floats */
            check_along(c, a, k, qdd, F);
    }
    op_answers_free(a);
    free(absent);
    free(F);
    c->r.op = 0;
    c->r.flags = 0;
}

static void forces(op_case *c)
{
    for (int frame = 0; frame < 3; frame++) {
        op_choose_tips(c, 0, TFA_ROWS_POSE, (tfa_reference_frame)frame);
        for (int method = 0; method < 3; method++)
            with_op(c, c->f64, TFA_OP_FORWARD_DYNAMICS);
        with_op(c, c->f64, TFA_OP_INVERSE_DYNAMICS);
        if (c->f32)
            with_op(c, c->f32, TFA_OP_FORWARD_DYNAMICS);
    }
    op_choose_tips(c, 0, TFA_ROWS_POSE, TFA_FRAME_LOCAL);
    with_op(c, c->f128, TFA_OP_FORWARD_DYNAMICS);
    with_op(c, c->f128, TFA_OP_INVERSE_DYNAMICS);
    if (op_lock(c)) {
        with_op(c, c->f64, TFA_OP_FORWARD_DYNAMICS);
        with_op(c, c->f64, TFA_OP_INVERSE_DYNAMICS);
        op_unlock(c);
    }
}

TEST(forces_across_joints)
{
    op_for_each(OP_ALL, forces);
    op_print(bounds, KINDS);
}

/* ---- by hand ---- */

#define G 9.80665

/* A root of 7 kg, a link of 3 kg that turns about y 1 m above it, its centre 0.2 m along x, and a
 * tool of 2 kg fixed to it 0.5 m along x, its centre 0.1 m further. */
static void describe_arm(small_robot *r)
{
    small_robot_begin(r);
    small_robot_add(r, 0, TFA_JOINT_REVOLUTE, 0, 1, 0)->xyz[2] = 1;
    small_robot_add(r, 1, TFA_JOINT_FIXED, 0, 0, 1)->xyz[0] = 0.5;
    small_robot_load(r, 0, 7, 0.1, 0.1, 0.1);
    small_robot_load(r, 1, 3, 0.1, 0.1, 0.1);
    small_robot_load(r, 2, 2, 0.1, 0.1, 0.1);
    r->link[1].com[0] = 0.2;
    r->link[2].com[0] = 0.1;
}

TEST(an_arm_at_rest)
{
    static const double want[3][6] = {{0, 0, 12 * G, 0, -1.8 * G, 0},
                                      {0, 0, 5 * G, 0, -1.8 * G, 0},
                                      {0, 0, 2 * G, 0, -0.2 * G, 0}};
    const double q[1] = {0};
    double tau[1], forces[3][6];
    small_robot arm;
    describe_arm(&arm);
    SCOPED_MODEL *m = compiled(&arm.d, NULL);
    SCOPED_WORKSPACE *w = workspace_for(m, NULL);
    const tfa_request r = {.op = TFA_OP_INVERSE_DYNAMICS,
                           .count = 1,
                           .q = q,
                           .flags = TFA_WANT_JOINT_FORCES,
                           .frame = TFA_FRAME_LOCAL};
    tfa_reply reply = {.tau = tau, .joint_forces = forces[0]};
    assert_int_equal(tfa_compute(w, &r, &reply), TFA_OK);
    for (int l = 0; l < 3; l++)
        for (int e = 0; e < 6; e++)
            assert_true(fabs(forces[l][e] - want[l][e]) <= 1e-13);
    assert_true(fabs(tau[0] + 1.8 * G) <= 1e-13);
}

/* ---- what there is not ---- */

TEST(refused_by_other_ops)
{
    const double q[1] = {0};
    double qdd[1], forces[3][6];
    small_robot arm;
    describe_arm(&arm);
    SCOPED_MODEL *m = compiled(&arm.d, NULL);
    SCOPED_WORKSPACE *w = workspace_for(m, NULL);
    tfa_request r = {.count = 1, .q = q, .flags = TFA_WANT_JOINT_FORCES};
    tfa_reply reply = {.joint_forces = forces[0]};
    for (int op = TFA_OP_FORWARD_DYNAMICS; op <= TFA_OP_DERIVATIVES; op++) {
        const int answers = op == TFA_OP_FORWARD_DYNAMICS || op == TFA_OP_INVERSE_DYNAMICS;
        r.op = (tfa_op)op;
        assert_int_equal(tfa_request_check(m, &r, &reply), answers ? TFA_OK : TFA_E_UNSUPPORTED);
        assert_int_equal(reply.field, answers ? TFA_FIELD_NONE : TFA_FIELD_OP);
    }
    r.op = TFA_OP_FORWARD_DYNAMICS; /* without the accelerations there are no forces */
    assert_int_equal(tfa_compute(w, &r, &reply), TFA_E_NOT_COMPUTED);
    assert_true(isnan(forces[0][0]) && isnan(forces[2][5]));
    reply.qdd = qdd;
    assert_int_equal(tfa_compute(w, &r, &reply), TFA_OK);
}
