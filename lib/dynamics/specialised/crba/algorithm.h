/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Algorithm `crba`: bias by RNEA, M by composite rigid bodies, its factors L^T D L along the tree,
 * all in one inward walk. For robots whose bodies have one freedom each. Short chains take fewer
 * operations than by articulated bodies: a composite inertia has 10 numbers, an articulated one 21,
 * and the walks along the paths, which grow with the square of their length, are short.
 * Featherstone 2008, 6.2 to 6.5.
 */
#ifndef TFA_DYNAMICS_SPECIALISED_ALGORITHM_H
#define TFA_DYNAMICS_SPECIALISED_ALGORITHM_H

#include "dynamics/specialised/specialised_composite.h"

#define ROBOT_BY_CRBA 1

/* Rows of M, then of L, by the bodies on the path to the world; D^-1; composite inertias of the
 * children, in body coordinates; right-hand side, then solution */
struct robot_factors {
    num row[ROBOT_BODIES][ROBOT_BODIES];
    num Dinv[ROBOT_BODIES];
    rigid Ic[ROBOT_BODIES];
    num x[ROBOT_BODIES];
};

TFA_INLINE void clear_factors(struct robot_factors *f)
{
#pragma GCC unroll 64
    for (int k = 0; k < ROBOT_BODIES; k++) {
#pragma GCC unroll 64
        for (int j = 0; j < ROBOT_BODIES; j++)
            f->row[k][j] = num_of(0);
        f->Ic[k] = rigid_zero();
        f->x[k] = num_of(0);
    }
}

/* Adds row k of M to what was eliminated. */
TFA_INLINE void mass_row(const struct state *s, struct robot_factors *m, int32_t k, const rigid *Ic)
{
    num row[ROBOT_BODIES];
    (void)composite_row(s, k, Ic, row);
#pragma GCC unroll 64
    for (int32_t j = ROBOT_BODIES - 1; j >= 0; j--)
        if (j <= k && is_on_path(j, k))
            m->row[k][j] += row[j];
}

/* Eliminates freedom k: L, D^-1, and the right-hand side if there is one */
TFA_INLINE void eliminate_freedom(const struct state *s, struct robot_factors *m, int32_t k,
                                  int rhs)
{
    const num inverse = 1 / m->row[k][k];
    m->Dinv[k] = inverse;
#pragma GCC unroll 64
    for (int32_t i = ROBOT_BODIES - 1; i >= 0; i--)
        if (i < k && is_on_path(i, k)) {
            const num l = m->row[k][i] * inverse;
#pragma GCC unroll 64
            for (int32_t j = 0; j < ROBOT_BODIES; j++)
                if (j <= i && is_on_path(j, k))
                    m->row[i][j] -= l * m->row[k][j];
            if (rhs)
                m->x[i] -= l * m->x[k];
            m->row[k][i] = l;
        }
}

TFA_INLINE void crba_backward_step(struct state *s, struct robot_factors *m, int32_t k, int rhs)
{
    const body_constants *b = body_constants_of(s, (uint32_t)k);
    const rigid Ic = composite_step(s, m->Ic, k);
    mass_row(s, m, k, &Ic);
    sentinel_see(s,
                 sentinel_margin(m->row[k][k], is_revolute(b->kind) ? s3_trace(Ic.I) : 3 * Ic.m));
    eliminate_freedom(s, m, k, rhs);
}

/* ---- bias forces: Newton-Euler with the accelerations of points (Luh, Walker & Paul 1980), which
 * needs no linear velocities. U = [dw]x + [w]x [w]x takes a point of the body to the part of its
 * acceleration that depends on the point (Balafoutis & Patel 1989) ---- */

/* Angular velocity, U, and acceleration of the origin less gravity, in body coordinates, while no
 * joint accelerates */
struct body_motion {
    vec3 w, dw, a;
    mat3 U;
};

TFA_INLINE mat3 point_acceleration(vec3 w, vec3 dw)
{
    const num xx = w.x * w.x, yy = w.y * w.y;
    return (mat3){-yy - w.z * w.z,  w.x * w.y - dw.z, w.x * w.z + dw.y,
                  w.x * w.y + dw.z, -xx - w.z * w.z,  w.y * w.z - dw.x,
                  w.x * w.z - dw.y, w.y * w.z + dw.x, -xx - w.y * w.y};
}

/* x + a x b and x + A v */
TFA_INLINE vec3 add_cross(vec3 x, vec3 a, vec3 b)
{
    return (vec3){x.x + a.y * b.z - a.z * b.y, x.y + a.z * b.x - a.x * b.z,
                  x.z + a.x * b.y - a.y * b.x};
}

TFA_INLINE vec3 add_product(vec3 x, mat3 A, vec3 v)
{
    return (vec3){x.x + A.xx * v.x + A.xy * v.y + A.xz * v.z,
                  x.y + A.yx * v.x + A.yy * v.y + A.yz * v.z,
                  x.z + A.zx * v.x + A.zy * v.y + A.zz * v.z};
}

/* E v: a vector in the axes of body i's parent */
TFA_INLINE vec3 vector_to_child(const struct state *s, uint32_t i, vec3 v)
{
    const body_constants *b = &robot_body[i];
    if (!body_axial(b))
        return m3_mul(s->X[i].E, v);
    const screw k = body_screw(s, i, b);
    return rotate_z(rotate_x(v, k.ca, k.na), k.c, k.n);
}

TFA_INLINE struct body_motion body_motion_of(const struct state *s, uint32_t i,
                                             const struct body_motion *parent)
{
    const body_constants *b = &robot_body[i];
    const num qd = s->qd[b->v], o = num_of(0);
    const int root = b->parent < 0;
    struct body_motion m = {v3_zero(), v3_zero(), vector_to_child(s, i, v3_neg(s->gravity)),
                            point_acceleration(v3_zero(), v3_zero())};
    if (!root) {
        m.w = vector_to_child(s, i, parent->w);
        m.dw = vector_to_child(s, i, parent->dw);
        m.a = vector_to_child(s, i, add_product(parent->a, parent->U, s->X[i].r));
    }
    if (is_revolute(b->kind)) {
        m.dw = v3_add(m.dw, v3(m.w.y * qd, -m.w.x * qd, o)); /* w x z qd */
        m.w.z += qd;
    } else { /* 2 w x z qd */
        m.a = v3_add_scaled(m.a, v3(m.w.y * qd, -m.w.x * qd, o), num_of(2));
    }
    m.U = point_acceleration(m.w, m.dw);
    return m;
}

/* Force m a + U h, and moment about the origin h x a + I dw + w x I w */
TFA_INLINE svec body_force(const struct state *s, uint32_t i, const struct body_motion *m)
{
    const body_constants *b = body_constants_of(s, i);
    const vec3 h = body_h(b);
    const sym3 I = body_I(b);
    const vec3 moment = add_cross(s3_mul(I, m->dw), m->w, s3_mul(I, m->w));
    return (svec){add_cross(moment, h, m->a), v3_add_scaled(m3_mul(m->U, h), m->a, body_mass(b))};
}

#define ROBOT_BIAS_FORWARD(i)                                                                      \
    motion[i] =                                                                                    \
        body_motion_of(s, i, &motion[robot_body[i].parent < 0 ? 0 : robot_body[i].parent]);        \
    s->f[i] = body_force(s, i, &motion[i]);
#define ROBOT_CRBA_BACKWARD(i)                                                                     \
    m->x[i] += tau[robot_body[i].v] - axis_force(&robot_body[i], s->f[i]);                         \
    if (robot_body[i].parent >= 0)                                                                 \
        s->f[robot_body[i].parent] =                                                               \
            sv_add(s->f[robot_body[i].parent < 0 ? 0 : robot_body[i].parent],                      \
                   force_to_parent(s, i, &robot_body[i], s->f[i]));                                \
    crba_backward_step(s, m, i, 1);
#define ROBOT_CRBA_FORWARD(i) solve_freedom(m, i, qdd);

TFA_INLINE void solve_freedom(struct robot_factors *m, int32_t k, num *qdd)
{
    num x = m->x[k] * m->Dinv[k];
#pragma GCC unroll 64
    for (int32_t j = 0; j < ROBOT_BODIES; j++)
        if (j < k && is_on_path(j, k))
            x -= m->row[k][j] * m->x[j];
    m->x[k] = x;
    qdd[robot_body[k].v] = x;
}

/* qdd = M^-1 (tau - h) */
TFA_INLINE void solve_forward(struct state *s, struct robot_factors *m, const num *tau, num *qdd)
{
    struct body_motion motion[ROBOT_BODIES];
    clear_factors(m);
    ROBOT_OUTWARD(ROBOT_POSE)
    ROBOT_OUTWARD(ROBOT_BIAS_FORWARD)
    ROBOT_INWARD(ROBOT_CRBA_BACKWARD)
    ROBOT_OUTWARD(ROBOT_CRBA_FORWARD)
}

#endif
