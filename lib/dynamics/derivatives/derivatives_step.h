/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Derivatives of inverse dynamics (inverse_derivatives.h), one joint, one body and one pair of
 * freedoms at a time: for robots of a model, and for one robot as constants.
 */
#ifndef TFA_DYNAMICS_DERIVATIVES_DERIVATIVES_STEP_H
#define TFA_DYNAMICS_DERIVATIVES_DERIVATIVES_STEP_H

#include "dynamics/derivatives/inverse_derivatives.h"
#include "layout/body.h"
#include "layout/derivative_terms.h"

/* ---- bodies ---- */

/* Rotation from the axes of a body to those of the world */
TFA_INLINE mat3 world_rotation(const struct world_pose *W)
{
    const vec3 x = vec3_of_simd(W->E.row[0]), y = vec3_of_simd(W->E.row[1]),
               z = vec3_of_simd(W->E.row[2]);
    return (mat3){x.x, y.x, z.x, x.y, y.y, z.y, x.z, y.z, z.z};
}

/* From the origin of a body to a point from where that origin is at r: 2 r.h - r h^T - h r^T
 * + m (r.r - r r^T), h the first moment about the body's origin */
TFA_INLINE sym3 shift_inertia(vec3 r, vec3 h, num m)
{
    const vec3 g = v3_add(v3_scale(h, num_of(2)), v3_scale(r, m));
    const num d = v3_dot(r, g);
    return (sym3){d - r.x * g.x, -(r.x * g.y + r.y * g.x) / 2, -(r.x * g.z + r.z * g.x) / 2,
                  d - r.y * g.y, -(r.y * g.z + r.z * g.y) / 2, d - r.z * g.z};
}

TFA_INLINE mat3 skew(vec3 a)
{
    const num o = num_of(0);
    return (mat3){o, -a.z, a.y, a.z, o, -a.x, -a.y, a.x, o};
}

TFA_INLINE svec inertia_mul(const struct subtree *t, svec m)
{
    return (svec){v3_add(s3_mul(t->I, m.w), v3_cross(t->h, m.v)),
                  v3_sub(v3_scale(m.v, t->m), v3_cross(t->h, m.w))};
}

/* The rigid inertia of a body about the reference point; A = -2 ([w] Sigma + [h] [u]), Sigma its
 * second moments, and linear momentum P: 2 B m = (A m.w, -2 P x m.w); f = I a + v x* I v */
TFA_INLINE void body_terms(const body_constants *b, const struct world_pose *W, vec3 origin,
                           struct subtree *t)
{
    const svec v = t->v;
    const mat3 E = world_rotation(W);
    const vec3 r = v3_sub(vec3_of_simd(W->r), origin);
    const sym3 I = s3_congruence(E, body_I(b));
    const vec3 h = m3_mul(E, body_h(b));
    const num m = body_mass(b), two = num_of(2);
    t->m = m;
    t->h = v3_add(h, v3_scale(r, m));
    t->I = s3_add(I, shift_inertia(r, h, m));
    const num trace = s3_trace(t->I) / two;
    const mat3 sigma = {trace - t->I.xx, -t->I.xy, -t->I.xz, -t->I.xy,       trace - t->I.yy,
                        -t->I.yz,        -t->I.xz, -t->I.yz, trace - t->I.zz};
    const mat3 A = m3_add(cross_m3(v.w, sigma), cross_m3(t->h, skew(v.v)));
    t->A = (mat3){-two * A.xx, -two * A.xy, -two * A.xz, -two * A.yx, -two * A.yy,
                  -two * A.yz, -two * A.zx, -two * A.zy, -two * A.zz};
    const svec momentum = inertia_mul(t, v);
    t->P = momentum.v;
    t->f = sv_add(inertia_mul(t, t->a), cross_force(v, momentum));
}

TFA_INLINE void add_subtree(struct subtree *p, const struct subtree *t)
{
    p->m += t->m;
    p->h = v3_add(p->h, t->h);
    p->I = s3_add(p->I, t->I);
    p->A = m3_add(p->A, t->A);
    p->P = v3_add(p->P, t->P);
    p->f = sv_add(p->f, t->f);
}

/* ---- freedoms ---- */

/* S of freedom j, with its multiplier */
TFA_INLINE svec subspace(const struct freedom_terms *t)
{
    const quad *x = t->vector;
    return (svec){{quad_lane(&x[0], 2), quad_lane(&x[1], 2), quad_lane(&x[2], 2)},
                  {quad_lane(&x[3], 2), quad_lane(&x[4], 2), quad_lane(&x[5], 2)}};
}

/* The motions times x */
TFA_INLINE void store_terms(struct freedom_terms *t, svec psi_dot, svec rate, svec S, vec3 psi,
                            num x)
{
    num a[6], b[6], c[6];
    const num d[3] = {psi.x, psi.y, psi.z}, o = num_of(0);
    sv_store(a, psi_dot);
    sv_store(b, rate);
    sv_store(c, S);
    for (int e = 0; e < 6; e++)
        t->vector[e] = quad_scale(x, quad_of(a[e], b[e], c[e], c[e]));
    for (int e = 0; e < 3; e++)
        t->angular[e] = quad_scale(x, quad_of(d[e], c[e], o, o));
}

/* A joint and its motion in world axes */
struct joint_motion {
    svec S[6];
    num multiplier[6]; /* of a follower */
    const num *qd, *qdd;
    uint32_t n;
    int in_parts; /* one freedom behind the other: one, or a fused joint */
    vec3 boost;   /* velocity that is left out of qd of a root, whose qdd have w x that */
};

/* Terms of the freedoms of a joint, and the motion of its body: a += S qdd + psi qd for each, where
 * t->v and t->a are those of the body before the joint; within a fused joint, of the part before
 * each freedom. */
TFA_INLINE void joint_terms(const struct joint_motion *j, struct freedom_terms *terms,
                            struct subtree *t)
{
    svec v = t->v, a = t->a;
    svec v_behind = v, a_behind = a;
    for (uint32_t k = 0; k < j->n; k++)
        v_behind = sv_add_scaled(v_behind, j->S[k], j->qd[k]);
    for (uint32_t k = 0; k < j->n; k++) {
        const svec S = j->S[k], psi = cross_motion(v, S),
                   psi_dot = sv_add(cross_motion(a, S), cross_motion(v, psi)),
                   behind = j->in_parts ? psi : cross_motion(v_behind, S),
                   rate = sv_add(psi, (svec){behind.w, v3_add(behind.v, v3_cross(S.w, j->boost))});
        store_terms(&terms[k], psi_dot, rate, S, psi.w, j->multiplier[k]);
        a_behind = sv_add_scaled(sv_add_scaled(a_behind, S, j->qdd[k]), psi, j->qd[k]);
        if (j->in_parts) {
            a = a_behind;
            v = sv_add_scaled(v, S, j->qd[k]);
        }
    }
    t->v = v_behind;
    t->a = a_behind;
}

/* ---- pairs ---- */

/* I m of four motions at once, angular first */
TFA_INLINE void inertia_mul_quads(const struct subtree *t, const quad x[6], quad y[6])
{
    const sym3 I = t->I;
    const num m = t->m;
    const vec3 h = t->h;
    for (int k = 0; k < QUAD_VECS; k++) {
#define X(e) x[e].vec[k]
        y[0].vec[k] = I.xx * X(0) + I.xy * X(1) + I.xz * X(2) + h.y * X(5) - h.z * X(4);
        y[1].vec[k] = I.xy * X(0) + I.yy * X(1) + I.yz * X(2) + h.z * X(3) - h.x * X(5);
        y[2].vec[k] = I.xz * X(0) + I.yz * X(1) + I.zz * X(2) + h.x * X(4) - h.y * X(3);
        y[3].vec[k] = m * X(3) - h.y * X(2) + h.z * X(1);
        y[4].vec[k] = m * X(4) - h.z * X(0) + h.x * X(2);
        y[5].vec[k] = m * X(5) - h.x * X(1) + h.y * X(0);
#undef X
    }
}

/* y += 2 B m of four motions with rotations w */
TFA_INLINE void add_coriolis_quads(const struct subtree *t, const quad w[3], quad y[6])
{
    const mat3 A = t->A;
    const vec3 P = v3_scale(t->P, num_of(-2));
    for (int k = 0; k < QUAD_VECS; k++) {
#define W(e) w[e].vec[k]
        y[0].vec[k] += A.xx * W(0) + A.xy * W(1) + A.xz * W(2);
        y[1].vec[k] += A.yx * W(0) + A.yy * W(1) + A.yz * W(2);
        y[2].vec[k] += A.zx * W(0) + A.zy * W(1) + A.zz * W(2);
        y[3].vec[k] += P.y * W(2) - P.z * W(1);
        y[4].vec[k] += P.z * W(0) - P.x * W(2);
        y[5].vec[k] += P.x * W(1) - P.y * W(0);
#undef W
    }
}

/* Of freedom x on the subtree t, what the terms of a freedom before it are multiplied by;
 * `turning`: the force that turns with it. Vectors: r I twice, then forces whose S_j^T are dtau_j
 * by q and by v of i: by_q = I psi_dot + 2 B psi + S x* f, by_v = I rate + 2 B S. Angular: r 2 B
 * twice. */
TFA_INLINE struct freedom_terms forces_of(const struct subtree *t, const struct freedom_terms *x,
                                          svec turning)
{
    const svec S = subspace(x), force = cross_force(S, turning);
    const vec3 rB = v3_sub(m3_tmul(t->A, S.w), v3_scale(v3_cross(S.v, t->P), num_of(2)));
    const num o = num_of(0);
    struct freedom_terms y;
    inertia_mul_quads(t, x->vector, y.vector);
    add_coriolis_quads(t, x->angular, y.vector);
    for (int e = 0; e < 6; e++)
        y.vector[e] = quad_swap_halves(y.vector[e]);
    num f[6];
    sv_store(f, force);
    for (int e = 0; e < 6; e++)
        quad_lane(&y.vector[e], 2) += f[e];
    y.angular[0] = quad_of(rB.x, rB.x, o, o);
    y.angular[1] = quad_of(rB.y, rB.y, o, o);
    y.angular[2] = quad_of(rB.z, rB.z, o, o);
    return y;
}

/* dtau_i by q and by v of j, dtau_j by those of i */
TFA_INLINE quad pair(const struct freedom_terms *i, const struct freedom_terms *j)
{
    quad sum = quad_of(num_of(0), num_of(0), num_of(0), num_of(0));
    for (int e = 0; e < 3; e++)
        sum = quad_add_product(sum, i->angular[e], j->angular[e]);
    for (int e = 0; e < 6; e++)
        sum = quad_add_product(sum, i->vector[e], j->vector[e]);
    return sum;
}

/* Where derivatives are added: terms of all freedoms, their public rows and the freedoms before
 * them */
struct derivative_pairs {
    num *dq, *dv;
    size_t stride;
    const struct freedom_terms *terms;
    const uint32_t *row;
    const int32_t *parent;
};

/* dtau_i by j, public freedoms; their sum where mimics are projected */
TFA_INLINE num *entry(const struct derivative_pairs *d, num *D, uint32_t i, uint32_t j)
{
    return D + d->stride * d->row[i] + derivatives_column(d->row[j]);
}

/* Freedom i, whose forces are x, and all before it: those of the same joint, first to end - 1,
 * where a joint that is not fused is one part, then of the bodies inboard. */
TFA_INLINE void add_pairs(const struct derivative_pairs *d, const struct freedom_terms *x,
                          uint32_t i, uint32_t first, uint32_t end)
{
    for (uint32_t j = first; j < end; j++) {
        const quad by = pair(x, &d->terms[j]);
        *entry(d, d->dq, i, j) += quad_lane(&by, 0);
        *entry(d, d->dv, i, j) += quad_lane(&by, 1);
    }
    for (int32_t k = d->parent[first]; k >= 0; k = d->parent[k]) {
        const uint32_t j = (uint32_t)k;
        const quad by = pair(x, &d->terms[j]);
        *entry(d, d->dq, i, j) += quad_lane(&by, 0);
        *entry(d, d->dv, i, j) += quad_lane(&by, 1);
        *entry(d, d->dq, j, i) += quad_lane(&by, 2);
        *entry(d, d->dv, j, i) += quad_lane(&by, 3);
    }
}

#endif
