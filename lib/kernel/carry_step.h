/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * One body's step of six wrenches on their way inward, side by side (six.h): what its joint yields to
 * them and what it passes on.
 *   psi = H^T P,  phi = D^-1 psi,  P <- X^T (P - U phi),  C += psi^T phi
 */
#ifndef TFA_KERNEL_CARRY_STEP_H
#define TFA_KERNEL_CARRY_STEP_H

#include "kernel/body.h"
#include "spatial/six.h"

/* Past a joint with one freedom, along component `axis`, in the coordinates of its body. What is left
 * along the axis is R phi: psi - (D - R) phi would be rounding. A locked joint has U = 0, D^-1 = 0. */
TFA_INLINE void past_1(const struct state *s, int32_t i, int axis, struct wrenches *P, six *psi,
                       six *phi)
{
    num U[6];
    sv_store(U, s->U[i]);
    *psi = P->at[axis];
    *phi = six_scale(s->Dinv[i], *psi);
    for (int k = 0; k < 6; k++)
        if (k != axis)
            P->at[k] = six_sub(P->at[k], U[k], *phi);
    P->at[axis] = s->locked ? six_sub(*psi, U[axis], *phi)
                            : six_scale(terms_armature(body_terms(s, (uint32_t)i)), *phi);
}

/* x <- D^-1 x with the factors of ldl_factor */
static inline void six_solve(const num *L, uint32_t n, six *x)
{
    for (uint32_t i = 1; i < n; i++)
        for (uint32_t k = 0; k < i; k++)
            x[i] = six_sub(x[i], L[6 * i + k], x[k]);
    for (uint32_t i = 0; i < n; i++)
        x[i] = six_scale(L[7 * i], x[i]);
    for (uint32_t i = n - 1; i-- > 0;)
        for (uint32_t k = i + 1; k < n; k++)
            x[i] = six_sub(x[i], L[6 * k + i], x[k]);
}

/* Past a joint with several, the first `moved` of which move what the wrenches act on */
static inline void past_n(const struct state *s, const struct tfa_body *b, uint32_t moved,
                          struct wrenches *P, six psi[6], six phi[6])
{
    const struct multi *w = &s->multi[b->multi];
    for (uint32_t k = 0; k < b->n; k++) {
        psi[k] = b->base ? P->at[(k + 3) % 6] : six_zero();
        for (uint32_t e = 0; !b->base && k < moved && e < 6; e++)
            psi[k] = six_add(psi[k], w->H[6 * k + e], P->at[e]);
        phi[k] = !b->base && w->locked >> k & 1 ? six_zero() : psi[k];
    }
    six_solve(w->L, b->n, phi);
    for (uint32_t k = 0; k < b->n; k++)
        for (uint32_t e = 0; e < 6; e++)
            P->at[e] = six_sub(P->at[e], w->U[6 * k + e], phi[k]);
}

/* Past a floating base, which is a root: its freedoms are the forces, then the moments (fold_base), and
 * nothing goes on. Out of line for the same reason as carry_n. */
TFA_OUTLINE void carry_base(const struct multi *w, const struct wrenches *P, struct block *C)
{
    six phi[6];
    for (int k = 0; k < 6; k++)
        phi[k] = P->at[(k + 3) % 6];
    six_solve(w->L, 6, phi);
    for (int k = 0; k < 6; k++)
        block_add(C, &P->at[(k + 3) % 6], &phi[k]);
}

/* One step of carry past a joint with several freedoms. Out of line, so that its arrays do not keep
 * those of the others from the registers. */
TFA_OUTLINE void carry_n(const struct state *s, int32_t i, uint32_t moved, struct wrenches *P,
                         struct block *C)
{
    const struct tfa_body *b = body_terms(s, (uint32_t)i);
    six psi[6], phi[6];
    past_n(s, b, moved, P, psi, phi);
    for (uint32_t k = 0; k < b->n; k++)
        block_add(C, &psi[k], &phi[k]);
    if (b->parent >= 0)
        wrenches_to_parent(&s->X[i], P, 0);
}

TFA_INLINE void carry_1(const struct state *s, int32_t i, int axis, struct wrenches *P,
                        struct block *C)
{
    six psi, phi;
    past_1(s, i, axis, P, &psi, &phi);
    block_add(C, &psi, &phi);
    if (body_terms(s, (uint32_t)i)->parent >= 0)
        wrenches_to_parent(&s->X[i], P, 0);
}

/* A revolute joint without rotor inertia that is not locked: nothing is left along its axis. */
TFA_INLINE void carry_z(const struct state *s, int32_t i, struct wrenches *P, struct block *C)
{
    const svec U = s->U[i];
    const six psi = P->at[2], phi = six_scale(s->Dinv[i], psi);
    block_add(C, &psi, &phi);
    if (body_terms(s, (uint32_t)i)->parent < 0)
        return;
    P->at[0] = six_sub(P->at[0], U.w.x, phi);
    P->at[1] = six_sub(P->at[1], U.w.y, phi);
    P->at[3] = six_sub(P->at[3], U.v.x, phi);
    P->at[4] = six_sub(P->at[4], U.v.y, phi);
    P->at[5] = six_sub(P->at[5], U.v.z, phi);
    wrenches_to_parent(&s->X[i], P, 1);
}

#endif
