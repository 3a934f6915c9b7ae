/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The sentinel: is the articulated-body recursion safely above its rounding?
 *
 *   s = eps max_i (G_i / D_i)
 *
 * D_i is the projected articulated inertia of joint i, the difference of larger numbers; G_i is
 * their size: the trace of the angular or, for a translation, of the linear block of IA_i, in this
 * pose, and that of the heaviest body outboard at the lever of the joint, for what the joints
 * between have taken away leaves its rounding (model/sizes.h). The sentinel trips where s is above
 * SENTINEL_LIMIT, or a D_i is not positive.
 */
#ifndef TFA_DYNAMICS_CORE_SENTINEL_H
#define TFA_DYNAMICS_CORE_SENTINEL_H

#include "dynamics/core/sentinel_limit.h"
#include "layout/body.h"

/* Nothing seen so far */
TFA_INLINE void sentinel_reset(struct state *s)
{
    s->margin = num_of(1);
}

TFA_INLINE void sentinel_see(struct state *s, num margin)
{
    s->margin = sentinel_smaller(s->margin, margin);
}

/* G of a rotation and of a translation */
struct sentinel_size {
    num angular, linear;
};

/* Share of G of the bodies outboard; any of them may have the payloads of the request. */
TFA_INLINE num sentinel_outboard(const struct state *s, const body_constants *b, int angular)
{
    const num outboard = body_outboard(b, !angular);
    return state_payloads(s) ? outboard + num_of(s->payload_size[!angular]) : outboard;
}

TFA_INLINE struct sentinel_size sentinel_size(const struct state *s, const body_constants *b,
                                              const sym6 *IA)
{
    return (struct sentinel_size){s3_trace(IA->A) + sentinel_outboard(s, b, 1),
                                  s3_trace(IA->M) + sentinel_outboard(s, b, 0)};
}

/* Of a freedom that moves the body by H */
TFA_INLINE num sentinel_size_along(const struct sentinel_size *G, svec H)
{
    return v3_dot(H.w, H.w) * G->angular + v3_dot(H.v, H.v) * G->linear;
}

/* Of freedom k */
static inline num sentinel_size_of(const struct state *s, const body_constants *b, uint32_t k,
                                   const struct sentinel_size *G)
{
    if (b->n == 1)
        return is_revolute(b->kind) ? G->angular : G->linear;
    return sentinel_size_along(G, joint_nd_axis(&s->joint_nd[b->joint_nd], k));
}

/* D of a joint with one freedom */
TFA_INLINE void sentinel_see_D(struct state *s, const body_constants *b, const sym6 *IA,
                               int angular, num D)
{
    const struct sentinel_size G = sentinel_size(s, b, IA);
    sentinel_see(s, sentinel_margin(D, angular ? G.angular : G.linear));
}

/* From 1/D and G */
TFA_INLINE num sentinel_margin_inverse(num inverse, num G)
{
    return num_select(inverse > 0, 1 - inverse * (G * SENTINEL_RATIO), num_of(-1));
}

TFA_INLINE void sentinel_see_inverse(struct state *s, num inverse, num G)
{
    sentinel_see(s, sentinel_margin_inverse(inverse, G));
}

/* Several freedoms: entry k of the diagonal of D^-1 = L^-T diag(L)^-1 L^-1, for no pivot need be
 * small where a combination of freedoms moves little. Rows of six, the inverse pivots on the
 * diagonal. */
static inline num sentinel_margin_joint_nd(const body_constants *b, const struct sentinel_size *G,
                                           const struct joint_nd *w)
{
    num margin = num_of(1);
    for (uint32_t k = 0; k < b->n; k++) {
        num column[6], inverse = w->L[7 * k];
        for (uint32_t i = k + 1; i < b->n; i++) { /* of L^-1 */
            column[i] = -w->L[6 * i + k];
            for (uint32_t j = k + 1; j < i; j++)
                column[i] -= w->L[6 * i + j] * column[j];
            inverse += column[i] * column[i] * w->L[7 * i];
        }
        if (!(w->locked >> k & 1))
            margin = sentinel_smaller(
                margin,
                sentinel_margin_inverse(inverse, sentinel_size_along(G, joint_nd_axis(w, k))));
    }
    return margin;
}

/* The same for freedoms k .. k + 2 of a floating base, after those before them are eliminated: its
 * linear, then its angular ones. A combination of both that moves little is seen by the angular
 * ones. */
TFA_INLINE void sentinel_see_block(struct state *s, uint32_t k, const num *L, num G)
{
    const num *D = L + 7 * k, l1 = D[6], l2 = D[12], l3 = D[13], l = l1 * l3 - l2;
    sentinel_see_inverse(s, D[0] + l1 * l1 * D[7] + l * l * D[14], G);
    sentinel_see_inverse(s, D[7] + l3 * l3 * D[14], G);
    sentinel_see_inverse(s, D[14], G);
}

/* Nor may the freedoms together move much more than each would alone, for the forces G: two pivots
 * that are both small multiply. */
TFA_INLINE num sentinel_smaller_motion(num margin, num x, num unit)
{
    return sentinel_smaller(margin, unit - num_abs(x) * SENTINEL_RATIO);
}

/* Of freedom j in M = L^T D L (layout/mass_rows.h), outward: the entries of D are those of the
 * recursion. unit: a motion as large as one radian; x: M^-1 G unit of the freedoms so far. */
TFA_INLINE num sentinel_margin_row(const struct tfa_model *m, const num *M, uint32_t j, num G,
                                   num unit, int locked, num *x, num margin)
{
    const num *const L = M + m->dof_row[j];
    const num D = L[m->dof_depth[j]];
    num sum = unit * G / D;
    for (int32_t up = m->dof_parent[j]; up >= 0; up = m->dof_parent[up])
        sum -= L[m->dof_depth[up]] * x[up];
    x[j] = locked ? num_of(0) : sum;
    if (locked)
        return margin;
    return sentinel_smaller_motion(sentinel_smaller(margin, sentinel_margin(D, G)), sum, unit);
}

/* Margins of the factors of M, after crba, and of those that the
 * articulated-body recursion left in s->IA and s->Dinv */
num TFA_V(sentinel_margin_mass)(struct state *s);
num TFA_V(sentinel_margin_articulated)(const struct state *s);
/* The same of derivatives, after those of inverse dynamics: by the factors of crba, or of aba */
num TFA_V(sentinel_margin_derivatives)(struct state *s, int by_mass);

/* Of some state, if there are several */
TFA_INLINE int sentinel_trips(const struct state *s)
{
    return !num_all(s->margin >= 0);
}

#endif
