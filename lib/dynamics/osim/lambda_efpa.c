/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Lambda^-1 of many tips by extended force propagation (Wensing, Featherstone, Orin 2012).
 *
 * Omega_i, the inverse inertia that body i offers to a force on it, goes outward once:
 *   Omega_i = H D^-1 H^T + L X Omega_parent X^T L^T,   L = 1 - H D^-1 U^T
 * The wrenches of each tip propagate inward through the joints, psi = H^T P, P' = X^T (P - U D^-1
 * psi), and the pair of two tips is accumulated once, at the last body a that supports both:
 *   Lambda^-1_tu = psi_t^T D^-1 psi_u + P'_t^T Omega_parent(a) P'_u      through the joint of a
 * O(N + m d + m^2) where force propagation with all joints of all pairs is O(m^2 d). Only sums of
 * positive semidefinite terms. It pays from four tips of a long chain on: 64 bodies, 8 tips 42 us
 * against 57, one tip 10 against 7; on robots of common depth it does not (8 branches of 5: 8
 * against 6). Measured 2026-11-21, gcc 12, f64 without AVX, medians of 31 calls on an Intel Xeon
 * VM. With up to eight tips composed propagators (lambda_pv.c) are faster than both.
 */
#include "dynamics/osim/lambda.h"
#include "layout/body.h"

#define COMMON_ANCESTORS_MAX                                                                       \
    (TFA_MAX_TIPS - 1) /* m tips have at most m - 1 first common ancestors */

/* First common ancestors of two tips; the wrenches of each tip inboard of the joint there are in
 * s->shared_wrenches. */
struct common_ancestors {
    uint32_t count;
    int32_t body[COMMON_ANCESTORS_MAX];
};

/* Wrench e of tip t there, for the common ancestor k: six numbers */
static num *inboard_wrench(const struct state *s, uint32_t k, uint32_t t, uint32_t e)
{
    return s->shared_wrenches + 6 * (((size_t)k * s->tips + t) * 6 + e);
}

/* L Y L^T + H D^-1 H^T for one freedom: L is 1 but for the joint's row l, whose own entry is
 * R / D = 1 - U_z / D without the cancellation. */
static sym6 omega_1(const struct state *s, uint32_t i, const struct tfa_body *b, const sym6 *Y)
{
    const int axis = body_axis(b);
    svec l = sv_scale(s->U[i], -s->Dinv[i]);
    num o[36], row[6];
    sv_put(&l, axis, joint_armature(s, b, 0) * s->Dinv[i]);
    const svec Yl = s6_mul(Y, l);
    s6_dense(o, Y);
    sv_store(row, Yl);
    for (int e = 0; e < 6; e++)
        o[6 * axis + e] = o[6 * e + axis] = row[e];
    o[7 * axis] = sv_dot(l, Yl) + s->Dinv[i];
    return s6_from_dense(o);
}

/* The same for several: row e of L is e_e - H_e D^-1 U^T */
static sym6 omega_n(const struct state *s, const struct tfa_body *b, const sym6 *Y)
{
    const struct joint_nd *w = &s->joint_nd[b->joint_nd];
    num o[36] = {0};
    svec L[6], YL[6];
    num h[6][6];
    for (uint32_t e = 0; e < 6; e++) {
        for (uint32_t k = 0; k < b->n; k++)
            h[e][k] = w->H[6 * k + e];
        ldl_solve(w->L, b->n, h[e]);
        L[e] = sv_zero();
        sv_put(&L[e], (int)e, num_of(1));
        for (uint32_t k = 0; k < b->n; k++)
            L[e] = sv_sub(L[e], sv_scale(sv_from(w->U + 6 * k), h[e][k]));
        YL[e] = s6_mul(Y, L[e]);
    }
    for (uint32_t e = 0; e < 6; e++)
        for (uint32_t f = e; f < 6; f++) {
            o[6 * e + f] = sv_dot(L[e], YL[f]);
            for (uint32_t k = 0; k < b->n; k++)
                o[6 * e + f] += w->H[6 * k + e] * h[f][k];
        }
    return s6_from_dense(o);
}

/* Omega of every body that supports a tip */
static void omega_outward(struct state *s)
{
    for (uint32_t k = 0; k < s->spans; k++)
        for (uint32_t i = s->span[k].first; i < s->span[k].end; i++) {
            const struct tfa_body *b = &s->body[i];
            sym6 Y = {0};
            if (!s->support[i])
                continue;
            if (b->parent >= 0)
                Y = s6_inv_to_child(&s->X[i], &s->Ic[b->parent]);
            s->Ic[i] = b->n == 1 ? omega_1(s, i, b, &Y) : omega_n(s, b, &Y);
        }
}

/* Index of that common ancestor; added if new */
static uint32_t ancestor_index(struct common_ancestors *m, int32_t body)
{
    uint32_t k = 0;
    while (k < m->count && m->body[k] != body)
        k++;
    if (k == m->count)
        m->body[m->count++] = body;
    return k;
}

/* Marks the supports and finds the common ancestors: going inward from tip t, at the first body
 * that a tip before it has marked. */
static void find_common_ancestors(struct state *s, tfa_reference_frame frame,
                                  struct common_ancestors *m)
{
    m->count = 0;
    for (uint32_t t = 0; t < s->tips; t++) {
        svec P[6];
        uint32_t paired = 0;
        for (int32_t i = TFA_V(frame_columns)(s, s->tip[t], frame, P); i >= 0;
             i = s->body[i].parent) {
            if (s->support[i] & ~paired)
                (void)ancestor_index(m, i);
            paired |= s->support[i];
            s->support[i] |= 1u << t;
        }
    }
}

/* The block of tips t and u at body i, inboard of whose joint their wrenches are P and Q */
static void put_block(struct state *s, uint32_t i, uint32_t t, uint32_t u, const svec P[6],
                      const svec Q[6])
{
    const struct tfa_body *b = &s->body[i];
    for (uint32_t f = 0; f < 6; f++) {
        const svec a = b->parent < 0 ? sv_zero() : s6_mul(&s->Ic[b->parent], Q[f]);
        for (uint32_t e = 0; e < 6; e++) {
            num sum = sv_dot(P[e], a);
            for (uint32_t k = 0; k < b->n; k++)
                sum +=
                    tip_columns(s, s->psi, b->v + k, t)[e] * tip_columns(s, s->phi, b->v + k, u)[f];
            *lambda_entry(s, t, u, e, f) = sum;
        }
    }
}

/* Answers the blocks of tip t and the tips before it whose support it meets at body i, the common
 * ancestor k, and keeps its wrenches for those behind it. */
static void pair_at(struct state *s, uint32_t k, uint32_t t, int32_t i, uint32_t paired,
                    const svec P[6])
{
    for (uint32_t u = 0; u < t; u++) {
        svec Q[6];
        if (!(s->support[i] & ~paired & 1u << u))
            continue;
        for (uint32_t e = 0; e < 6; e++)
            Q[e] = sv_from(inboard_wrench(s, k, u, e));
        put_block(s, (uint32_t)i, u, t, Q, P);
    }
    for (uint32_t e = 0; e < 6; e++)
        sv_store(inboard_wrench(s, k, t, e), P[e]);
}

/* Takes the wrenches of tip t inward and answers its block and those with the tips before it. */
static void wrenches_inward(struct state *s, uint32_t t, tfa_reference_frame frame,
                            struct common_ancestors *m)
{
    struct tip_wrenches w;
    uint32_t paired = 0;
    TFA_V(tip_start)(s, t, frame, &w);
    for (int first = 1; w.body >= 0; first = 0) {
        const int32_t i = w.body;
        svec P[6];
        TFA_V(tip_through_joint)(s, t, &w);
        wrench_columns_store(&w.P, P);
        if (first)
            put_block(s, (uint32_t)i, t, t, P, P);
        for (uint32_t k = 0; k < m->count; k++)
            if (m->body[k] == i)
                pair_at(s, k, t, i, paired, P);
        paired |= s->support[i];
    }
}

void TFA_V(lambda_efpa)(struct state *s, tfa_reference_frame frame)
{
    struct common_ancestors m;
    TFA_V(lambda_clear)(s);
    find_common_ancestors(s, frame, &m);
    omega_outward(s);
    for (uint32_t t = 0; t < s->tips; t++)
        wrenches_inward(s, t, frame, &m);
    TFA_V(lambda_mirror)(s);
}
