/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * What identification and observers are built on, by the definitions in request.h:
 *
 *     sum of Y p over all bodies + armature + damping + friction + external = inverse dynamics
 *     a payload adds Y of its link times its own ten parameters
 *     generalised_momentum = M v,   its rate along any motion = inverse dynamics + momentum_rate
 */
#include "operational.h"
#include "support/step.h"
#include "test.h"

enum { SUM, PAYLOAD, MOMENTUM, RATE, KINDS };
/* In double; in f128 */
static op_bound bounds[KINDS] = {
    {"Y p = inverse dynamics", {4e-14, 3e-15}, {0}},
    {"Y p of a payload", {4e-14, 3e-14}, {0}},
    {"M v", {4e-14, 3e-15}, {0}},
    {"rate by differences", {1e-8, 1e-8}, {0}},
};

/* |Y| |p|, and sum += Y p, of the ten columns from 10 t on */
static double add_product(const op_case *c, const double *Y, uint32_t tips, uint32_t t,
                          const double p[10], double *sum)
{
    double size = 0;
    for (uint32_t i = 0; i < c->n; i++)
        for (uint32_t e = 0; e < 10; e++) {
            const double term = Y[10 * ((size_t)i * tips + t) + e] * p[e];
            sum[i] += term;
            size += term * term;
        }
    return sqrt(size);
}

/* Parameters of a payload about the origin of its link's frame */
static void parameters_of(const double x[TFA_PAYLOAD_NUMBERS], double p[10])
{
    const double m = x[0], *c = x + 1, *I = x + 4;
    const double square = c[0] * c[0] + c[1] * c[1] + c[2] * c[2];
    p[0] = m;
    for (int e = 0; e < 3; e++)
        p[1 + e] = m * c[e];
    for (int i = 0, e = 4; i < 3; i++)
        for (int j = i; j < 3; j++, e++)
            p[e] = I[e - 4] + m * ((i == j ? square : 0) - c[i] * c[j]);
}

/* State 0 of a request about the links `tips` .. `tips` + count - 1 of a list */
static op_answers *regressor_of(const op_case *c, tfa_workspace *w, const uint32_t *links,
                                uint32_t count)
{
    tfa_request r = op_state(c, 0);
    r.op = TFA_OP_REGRESSOR;
    r.tip_count = count;
    r.rows = TFA_ROWS_POSE;
    memcpy(r.tips, links, count * sizeof *links);
    return op_answer(c, w, &r);
}

static void inverse_of(const op_case *c, tfa_workspace *w, const tfa_request *state, double *tau)
{
    tfa_request r = *state;
    r.op = TFA_OP_INVERSE_DYNAMICS;
    op_answers *a = op_answer(c, w, &r);
    op_forces(c, a, 0, tau);
    op_answers_free(a);
}

/* Everything of inverse dynamics that no body's inertia causes */
static double other_forces(const op_case *c, tfa_workspace *w, double *out)
{
    tfa_request r = op_state(c, 0);
    double size = 0;
    r.op = TFA_OP_BIAS;
    op_answers *a = op_answer(c, w, &r);
    const double *terms[] = {a->damping_force, a->friction_force, a->external_force,
                             a->armature_force};
    for (int k = 0; k < 4; k++) {
        for (uint32_t i = 0; i < c->n; i++)
            out[i] = (k ? out[i] : 0) + terms[k][i];
        size += norm2(terms[k], c->n);
    }
    op_answers_free(a);
    return size;
}

static void check_sum(const op_case *c, tfa_workspace *w)
{
    enum { CHUNK = 8 };
    const uint32_t bodies = tfa_model_summarise(c->model).bodies;
    double sum[OP_FREEDOMS], tau[OP_FREEDOMS], p[10], size = other_forces(c, w, sum);
    for (uint32_t first = 0; first < bodies; first += CHUNK) {
        const uint32_t count = bodies - first < CHUNK ? bodies - first : CHUNK;
        uint32_t links[CHUNK];
        for (uint32_t t = 0; t < count; t++)
            links[t] = tfa_model_body_frame(c->model, first + t);
        op_answers *a = regressor_of(c, w, links, count);
        for (uint32_t t = 0; t < count; t++) {
            tfa_model_parameters(c->model, links[t], p);
            size += add_product(c, a->regressor, count, t, p, sum);
        }
        op_answers_free(a);
    }
    for (uint32_t k = 0; k < c->r.payload_count; k++) {
        op_answers *a = regressor_of(c, w, &c->r.payload_frames[k], 1);
        parameters_of(c->r.payloads + (size_t)TFA_PAYLOAD_NUMBERS * k, p);
        size += add_product(c, a->regressor, 1, 0, p, sum);
        op_answers_free(a);
    }
    const tfa_request state = op_state(c, 0);
    inverse_of(c, w, &state, tau);
    op_within(c, &bounds[SUM], op_difference(sum, tau, c->n, size));
}

/* Of any link: bodies whose frames are not those that give them their names */
static void check_payload(op_case *c, tfa_workspace *w)
{
    double x[TFA_PAYLOAD_NUMBERS], p[10], without[OP_FREEDOMS], with[OP_FREEDOMS];
    const uint32_t link = random_below(&c->s, c->link_count);
    tfa_request r = op_state(c, 0);
    random_payload(&c->s, x);
    parameters_of(x, p);
    inverse_of(c, c->f128, &r, without);
    r.payload_count = 1;
    r.payload_frames[0] = link;
    r.payloads = x;
    r.op = TFA_OP_INVERSE_DYNAMICS;
    tfa_reply reply = {0};
    if (c->r.payload_count || tfa_request_check(c->model, &r, &reply) != TFA_OK)
        return; /* inside a fused body */
    inverse_of(c, c->f128, &r, with);
    op_answers *a = regressor_of(c, w, &link, 1);
    double sum[OP_FREEDOMS] = {0};
    const double size = add_product(c, a->regressor, 1, 0, p, sum) + 1e-2 * norm2(with, c->n);
    for (uint32_t i = 0; i < c->n; i++)
        with[i] -= without[i];
    op_within(c, &bounds[PAYLOAD], op_difference(sum, with, c->n, size));
    op_answers_free(a);
}

static void check_joints(const op_case *c, tfa_workspace *w)
{
    const uint32_t link = tfa_model_body_frame(c->model, 0);
    const tfa_request r = op_state(c, 0);
    op_answers *a = regressor_of(c, w, &link, 1);
    for (uint32_t i = 0; i < c->nv; i++) {
        const double *x = a->joint_regressor + (size_t)3 * i, v = r.v[i],
                     s = c->friction_velocity > 0 ? c->friction_velocity : TFA_FRICTION_VELOCITY;
        assert_true(fabs(x[0] - r.qdd[i]) <= 1e-12 * (1 + fabs(x[0])) && x[1] == v);
        assert_true(fabs(x[2] - v / sqrt(v * v + s * s)) < 1e-15);
    }
    op_answers_free(a);
}

static op_answers *momentum_of(const op_case *c, tfa_workspace *w, const tfa_request *state)
{
    tfa_request r = *state;
    r.op = TFA_OP_KINEMATICS;
    r.flags = TFA_WANT_GENERALISED_MOMENTUM;
    r.tip_count = 0;
    return op_answer(c, w, &r);
}

static void check_momentum(const op_case *c, tfa_workspace *w)
{
    const tfa_request state = op_state(c, 0);
    double v[OP_FREEDOMS], want[OP_FREEDOMS], size = 0;
    tfa_request r = state;
    r.op = TFA_OP_MASS_MATRIX;
    r.locked_count = r.tip_count = 0;
    op_answers *m = op_answer(c, c->f128, &r), *a = momentum_of(c, w, &state);
    op_velocities(c, 0, v);
    for (uint32_t i = 0; i < c->n; i++) {
        want[i] = 0;
        for (uint32_t j = 0; j < c->n; j++)
            want[i] += m->mass_matrix[(size_t)i * c->n + j] * v[j];
        size = fmax(size, norm2(m->mass_matrix + (size_t)i * c->n, c->n) * norm2(v, c->n));
    }
    op_within(c, &bounds[MOMENTUM], op_difference(a->generalised_momentum, want, c->n, size));
    op_answers_free(a);
    op_answers_free(m);
}

/* p a step of h along the motion with the accelerations of the request */
static void momentum_after(const op_case *c, double h, double *p, double *size)
{
    static double q[2 * OP_FREEDOMS], v[OP_FREEDOMS], now[OP_FREEDOMS];
    double pose[7];
    tfa_request r = op_state(c, 0);
    op_velocities(c, 0, now);
    step_model(c->model, r.q, r.base_pose, now, h, q, pose);
    for (uint32_t i = 0; i < c->n; i++)
        v[i] = now[i] + h * (i < c->six ? r.base_acceleration[i] : r.qdd[i - c->six]);
    r.q = q;
    r.base_pose = c->six ? pose : NULL;
    r.base_twist = c->six ? v : NULL;
    r.v = v + c->six;
    op_answers *a = momentum_of(c, c->f128, &r);
    memcpy(p, a->generalised_momentum, c->n * sizeof *p);
    *size = norm2(p, c->n);
    op_answers_free(a);
}

static void check_rate(const op_case *c, tfa_workspace *w)
{
    const double h = 1e-5;
    double before[OP_FREEDOMS], after[OP_FREEDOMS], want[OP_FREEDOMS], size;
    const tfa_request state = op_state(c, 0);
    momentum_after(c, -h, before, &size);
    momentum_after(c, h, after, &size);
    inverse_of(c, w, &state, want);
    op_answers *a = momentum_of(c, w, &state);
    size += norm2(want, c->n) + norm2(a->momentum_rate, c->n);
    for (uint32_t i = 0; i < c->n; i++) {
        want[i] += a->momentum_rate[i];
        after[i] = (after[i] - before[i]) / (2 * h);
    }
    op_within(c, &bounds[RATE], op_difference(after, want, c->n, size));
    op_answers_free(a);
}

static void law(op_case *c)
{
    tfa_workspace *const workspaces[] = {c->f64, c->f128};
    for (c->set = 0; c->set < 2; c->set++) {
        tfa_workspace *w = workspaces[c->set];
        check_sum(c, w);
        check_payload(c, w);
        check_joints(c, w);
        check_momentum(c, w);
        check_rate(c, w);
    }
    c->set = 0;
    if (op_lock(c))
        check_sum(c, c->f64);
}

TEST(regressor_and_momentum_by_definition)
{
    op_for_each(OP_ALL, law);
    op_print(bounds, KINDS);
}
