/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Velocities and bias accelerations by differences of the library's own poses and twists along a
 * motion: Jacobians of tips and of the centre of mass, twists, J-dot v, potential energy. No oracle
 * takes part.
 *
 * Four-point differences: f' = (8 (f(h) - f(-h)) - (f(2 h) - f(-2 h))) / 12 h. Their error is
 * O(h^4), although a step of a quaternion or of a plane's axes is right to second order only: what
 * is off by an odd power of h cancels as well.
 */
#include "operational.h"
#include "support/step.h"
#include "test.h"

#define POINTS 4
#define STEP 2e-3 /* of the sum of all velocities, rad or m */
#define TIPS 2

static op_bound bounds[] = {
    {"twist by poses", {1e-10}, {0}},      {"column of J by poses", {1e-10}, {0}},
    {"J-dot v by twists", {1e-10}, {0}},   {"com_velocity by com", {1e-10}, {0}},
    {"com_jacobian by com", {1e-10}, {0}}, {"momentum by com", {1e-10}, {0}},
    {"gravity by energy", {1e-10}, {0}},
};
enum { TWIST, COLUMN, BIAS, COM_VELOCITY, COM_COLUMN, MOMENTUM, GRAVITY };

/* ---- differences ---- */

/* A motion along v: q and base_pose of POINTS states at -2 h .. 2 h */
struct motion {
    double *q, *v, *base_pose, *base_twist;
    double h;
    op_answers *a;
};

static const int places[POINTS] = {-2, -1, 1, 2};
static const double weights[POINTS] = {1, -8, 8, -1};

static double derivative(const struct motion *m, const double *f, size_t stride)
{
    double sum = 0;
    for (int k = 0; k < POINTS; k++)
        sum += weights[k] * f[(size_t)k * stride];
    return sum / (12 * m->h);
}

static void motion_free(struct motion *m)
{
    op_answers_free(m->a);
    free(m->base_twist);
    free(m->base_pose);
    free(m->v);
    free(m->q);
}

/* Answers along the motion with velocities `v`, which stay constant, through a state. */
static void move_along(const op_case *c, const tfa_request *state, const double *v, uint32_t flags,
                       struct motion *m)
{
    double speed = 0;
    for (uint32_t i = 0; i < c->n; i++)
        speed += fabs(v[i]);
    m->h = STEP / fmax(speed, 1e-3);
    m->q = op_alloc((size_t)POINTS * c->nq, sizeof *m->q);
    m->v = op_alloc((size_t)POINTS * c->nv, sizeof *m->v);
    m->base_pose = op_alloc(POINTS * 7, sizeof *m->base_pose);
    m->base_twist = op_alloc(POINTS * 6, sizeof *m->base_twist);
    for (size_t k = 0; k < POINTS; k++) {
        step_model(c->model, state->q, state->base_pose, v, places[k] * m->h, m->q + k * c->nq,
                   m->base_pose + 7 * k);
        memcpy(m->v + k * c->nv, v + c->six, c->nv * sizeof *v);
        memcpy(m->base_twist + 6 * k, v, c->six * sizeof *v);
    }
    tfa_request r = *state;
    r.op = TFA_OP_KINEMATICS;
    r.flags = flags;
    r.count = POINTS;
    r.q = m->q;
    r.v = m->v;
    r.base_pose = m->base_pose;
    r.base_twist = m->base_twist;
    m->a = op_answer(c, c->f64, &r);
}

/* Twist of tip t in `frame` by the derivative of its pose; `pose`: in the middle. */
static void twist_by_poses(const op_case *c, const struct motion *m, uint32_t t, const double *pose,
                           double *twist)
{
    double quats[POINTS][4], rate[4], v[3], w[3];
    const double *q = pose + 3;
    for (size_t k = 0; k < POINTS; k++) {
        const double *at = m->a->poses + 7 * (k * m->a->tips + t) + 3;
        double along = 0;
        for (int i = 0; i < 4; i++)
            along += at[i] * q[i];
        for (int i = 0; i < 4; i++) /* q and -q are the same rotation */
            quats[k][i] = along < 0 ? -at[i] : at[i];
    }
    for (int i = 0; i < 4; i++)
        rate[i] = derivative(m, &quats[0][i], 4);
    for (int i = 0; i < 3; i++) { /* w = 2 q' q^-1 */
        const int a = (i + 1) % 3, b = (i + 2) % 3;
        w[i] = 2 * (rate[i] * q[3] - rate[3] * q[i] - rate[a] * q[b] + rate[b] * q[a]);
        v[i] = derivative(m, m->a->poses + 7 * (size_t)t + i, 7 * (size_t)m->a->tips);
    }
    memcpy(twist, v, sizeof v);
    memcpy(twist + 3, w, sizeof w);
    if (c->r.frame == TFA_FRAME_LOCAL) {
        const double back[4] = {-q[0], -q[1], -q[2], q[3]};
        rotate_vector(back, v, twist);
        rotate_vector(back, w, twist + 3);
    } else if (c->r.frame == TFA_FRAME_WORLD) {
        for (int i = 0; i < 3; i++)
            twist[i] -= w[(i + 1) % 3] * pose[(i + 2) % 3] - w[(i + 2) % 3] * pose[(i + 1) % 3];
    }
}

/* ---- laws ---- */

static void check_column(op_case *c, const tfa_request *state, const op_answers *now,
                         uint32_t column)
{
    double v[OP_FREEDOMS] = {0}, twist[6], got[6], com[3], com_got[3];
    struct motion m;
    v[column] = 1;
    move_along(c, state, v, TFA_WANT_POSES | TFA_WANT_COM, &m);
    for (uint32_t t = 0; t < now->tips; t++) {
        const uint32_t rows = op_tips(c).rows;
        const double *pose = now->poses + 7 * (size_t)t;
        twist_by_poses(c, &m, t, pose, twist);
        for (uint32_t i = 0; i < rows; i++)
            got[i] = now->jacobian[(size_t)(rows * t + i) * c->n + column];
        const double reach = c->chain ? fmax(1, norm2(pose, 3)) : 1;
        op_within(c, &bounds[COLUMN], op_difference(got, twist, rows, reach));
    }
    for (int i = 0; i < 3; i++) {
        com[i] = derivative(&m, m.a->com + i, 3);
        com_got[i] = now->com_jacobian[(size_t)i * c->n + column];
    }
    op_within(c, &bounds[COM_COLUMN], op_difference(com_got, com, 3, 1));
    motion_free(&m);
}

/* Potential energy rises with the power of the forces that hold against gravity. */
static void check_energy(op_case *c, const tfa_request *state, const struct motion *m,
                         const double *v)
{
    tfa_request r = *state;
    r.op = TFA_OP_BIAS;
    op_answers *a = op_answer(c, c->f64, &r);
    double power = 0, size = 0;
    for (uint32_t i = 0; i < c->n; i++) {
        power += a->gravity_force[i] * v[i];
        size += fabs(a->gravity_force[i] * v[i]);
    }
    size += norm2(m->a->energy, 2); /* a constant has its rounding, too */
    op_within(c, &bounds[GRAVITY], fabs(derivative(m, m->a->energy + 1, 2) - power) / (1 + size));
    op_answers_free(a);
}

static void check_motion(op_case *c, uint32_t k, const tfa_request *state, const op_answers *now)
{
    double v[OP_FREEDOMS], twist[6], bias[6], com[3];
    struct motion m;
    op_velocities(c, k, v);
    move_along(c, state, v, TFA_WANT_POSES | TFA_WANT_TWISTS | TFA_WANT_COM | TFA_WANT_ENERGY, &m);
    const double speed = norm2(v, c->n);
    const double size = c->chain ? fmax(1, norm2(now->jacobian, (size_t)now->rows * c->n)) : 1;
    const double fast = speed * size; /* test mechanisms reach far */
    for (uint32_t t = 0; t < now->tips; t++) {
        const uint32_t rows = op_tips(c).rows;
        const double *got = now->twists + 6 * (size_t)t;
        const double *got_bias = now->bias_acceleration + (size_t)rows * t;
        twist_by_poses(c, &m, t, now->poses + 7 * (size_t)t, twist);
        op_within(c, &bounds[TWIST], op_difference(got, twist, 6, fast));
        for (uint32_t i = 0; i < rows; i++)
            bias[i] = derivative(&m, m.a->twists + 6 * (size_t)t + i, 6 * (size_t)now->tips);
        op_within(c, &bounds[BIAS], op_difference(got_bias, bias, rows, speed * fast));
    }
    for (int i = 0; i < 3; i++)
        com[i] = derivative(&m, m.a->com + i, 3);
    op_within(c, &bounds[COM_VELOCITY], op_difference(now->com_velocity, com, 3, fast));
    for (int i = 0; i < 3; i++)
        com[i] *= now->mass[0];
    op_within(c, &bounds[MOMENTUM], op_difference(now->momentum, com, 3, fast * now->mass[0]));
    check_energy(c, state, &m, v);
    motion_free(&m);
}

/* State k, in one frame: all columns, and along the state's own velocities */
static void differences_at(op_case *c, uint32_t k, tfa_reference_frame frame)
{
    op_choose_tips(c, TIPS, (tfa_rows)random_below(&c->s, 2), frame);
    tfa_request r = op_state(c, k);
    r.op = TFA_OP_KINEMATICS;
    r.flags = TFA_WANT_POSES | TFA_WANT_TWISTS | TFA_WANT_JACOBIAN | TFA_WANT_COM |
              TFA_WANT_BIAS_ACCELERATION | TFA_WANT_MOMENTUM;
    op_answers *a = op_answer(c, c->f64, &r);
    for (uint32_t column = 0; column < c->n; column++)
        check_column(c, &r, a, column);
    check_motion(c, k, &r, a);
    op_answers_free(a);
}

static void differences(op_case *c)
{
    for (uint32_t k = 0; k < OP_STATES; k++)
        for (int frame = 0; frame < 3; frame++)
            differences_at(c, k, (tfa_reference_frame)frame);
}

TEST(velocities_are_derivatives)
{
    op_for_each(OP_ALL, differences);
    op_print(bounds, sizeof bounds / sizeof *bounds);
}
