/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Six wrenches propagated inward in SIMD lanes (vec6.h): the response of the joints and what they
 * pass on.
 *   psi = H^T P,  phi = D^-1 psi,  P <- X^T (P - U phi),  C = sum of psi^T phi
 */
#include "dynamics/core/aba_step.h"
#include "dynamics/osim/lambda.h"
#include "dynamics/osim/propagate_step.h"

/* Through the joint of body i, any. Returns its freedoms. */
static inline uint32_t through_joint(const struct state *s, int32_t i, uint32_t moved,
                                     struct wrench_columns *P, vec6 psi[6], vec6 phi[6])
{
    const struct tfa_body *b = &s->body[i];
    if (is_revolute(b->kind))
        through_joint_1dof(s, i, AXIS_RZ, P, psi, phi);
    else if (is_prismatic(b->kind))
        through_joint_1dof(s, i, AXIS_TZ, P, psi, phi);
    else
        through_joint_nd(s, b, moved, P, psi, phi);
    return b->n;
}

void TFA_V(propagate_through_joint)(const struct state *s, int32_t i, uint32_t moved,
                                    struct wrench_columns *P, vec6 psi[6], vec6 phi[6])
{
    (void)through_joint(s, i, moved, P, psi, phi);
    wrench_columns_to_parent(&s->X[i], P, 0);
}

/* Through the joint of body i, any, and its response */
TFA_INLINE void propagate_body(const struct state *s, int32_t i, uint32_t moved,
                               struct wrench_columns *p, struct mat6_simd *c)
{
    const struct tfa_body *b = &s->body[i];
    if (is_revolute(b->kind) && !(b->armature > 0) && !s->locked) {
        propagate_revolute(s, i, p, c);
    } else if (is_revolute(b->kind)) {
        propagate_1dof(s, i, AXIS_RZ, p, c);
    } else if (is_prismatic(b->kind)) {
        propagate_1dof(s, i, AXIS_TZ, p, c);
    } else {
        struct wrench_columns P; /* in memory, for steps that are out of line */
        struct mat6_simd C;
        wrench_columns_copy(&P, p);
        mat6_simd_copy(&C, c);
        if (b->base)
            propagate_base(&s->joint_nd[b->joint_nd], &P, &C);
        else
            propagate_nd(s, i, moved, &P, &C);
        wrench_columns_copy(p, &P);
        mat6_simd_copy(c, &C);
    }
}

/* Keeps psi of body i in tip t's place of a table; that of several freedoms out of line, as
 * propagate_nd. */
TFA_OUTLINE void keep_psi_nd(const struct state *s, const struct tfa_body *b, uint32_t moved,
                             const struct wrench_columns *P, num *table, uint32_t t)
{
    vec6 psi[6];
    joint_psi(s, b, moved, P, psi);
    for (uint32_t k = 0; k < b->n; k++)
        vec6_store(tip_columns(s, table, b->v + k, t), &psi[k]);
}

void TFA_V(tip_at_base)(struct state *s, uint32_t t, struct tip_wrenches *w)
{
    keep_psi_nd(s, &s->body[w->body], w->moved, &w->P, s->psi, t);
    s->support[w->body] |= 1u << t;
    w->body = -1;
}

TFA_INLINE void keep_psi(const struct state *s, int32_t i, uint32_t moved,
                         const struct wrench_columns *p, num *table, uint32_t t)
{
    const struct tfa_body *b = &s->body[i];
    s->support[i] |= 1u << t;
    if (is_revolute(b->kind)) { /* constant indices leave p in registers */
        vec6_store(tip_columns(s, table, b->v, t), &p->at[AXIS_RZ]);
    } else if (is_prismatic(b->kind)) {
        vec6_store(tip_columns(s, table, b->v, t), &p->at[AXIS_TZ]);
    } else {
        struct wrench_columns P;
        wrench_columns_copy(&P, p);
        keep_psi_nd(s, b, moved, &P, table, t);
    }
}

/* From body i on, through all whose s->support is `tips`; 0: through all */
TFA_INLINE int32_t propagate_path(const struct state *s, int32_t i, uint32_t tips, uint32_t moved,
                                  struct wrench_columns *p, struct mat6_simd *c)
{
    for (; i >= 0 && (!tips || s->support[i] == tips); i = s->body[i].parent) {
        if (s->keeps_psi)
            keep_psi(s, i, moved, p, tips & (tips - 1) ? s->phi : s->psi,
                     tips ? (uint32_t)__builtin_ctz(tips) : 0);
        propagate_body(s, i, moved, p, c);
        moved = 6;
    }
    return i;
}

int32_t TFA_V(propagate_forces)(const struct state *s, int32_t i, uint32_t tips, uint32_t moved,
                                struct wrench_columns *P, struct mat6_simd *C)
{
    struct wrench_columns p;
    struct mat6_simd c;
    wrench_columns_copy(&p, P);
    mat6_simd_copy(&c, C);
    i = propagate_path(s, i, tips, moved, &p, &c);
    wrench_columns_copy(P, &p);
    mat6_simd_copy(C, &c);
    return i;
}

void TFA_V(propagate_to_root)(struct state *s, const struct tip_wrenches *w, num lambda[36])
{
    struct wrench_columns p;
    struct mat6_simd c = mat6_simd_zero();
    if (s->keeps_psi)
        TFA_V(support_clear)(s);
    wrench_columns_copy(&p, &w->P);
    (void)propagate_path(s, w->body, 0, w->moved, &p, &c);
    for (int e = 0; e < 6; e++)
        vec6_store(lambda + 6 * e, &c.row[e]);
}

void TFA_V(lambda_while_factoring)(struct state *s, tfa_reference_frame frame)
{
    struct tip_wrenches w;
    struct wrench_columns p;
    struct mat6_simd c = mat6_simd_zero();
    TFA_V(tip_start)(s, 0, frame, &w);
    wrench_columns_copy(&p, &w.P);
    if (s->keeps_psi)
        TFA_V(support_clear)(s);
    sentinel_reset(s);
    for (uint32_t k = s->spans; k-- > 0;)
        for (uint32_t i = s->span[k].end; i-- > s->span[k].first;) {
            aba_backward_step(s, i, NULL, ABA_INERTIA | ABA_FULL_SWEEP | ABA_SENTINEL);
            if ((int32_t)i != w.body)
                continue;
            if (s->keeps_psi)
                keep_psi(s, w.body, w.moved, &p, s->psi, 0);
            propagate_body(s, w.body, w.moved, &p, &c);
            w.body = s->body[i].parent;
            w.moved = 6;
        }
    have_aba(s);
    if (s->keeps_psi)
        s->psi_frame = (int32_t)frame;
    for (int e = 0; e < 6; e++)
        vec6_store(s->lambda + 6 * e, &c.row[e]);
}
