/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * One body's step of the articulated-body algorithm, inward and outward. ABA walks all bodies
 * with it, TFA the side branches, force propagation only the inertias.
 */
#ifndef TFA_DYNAMICS_CORE_ABA_STEP_H
#define TFA_DYNAMICS_CORE_ABA_STEP_H

#include "dynamics/core/revolute.h"
#include "dynamics/core/sentinel.h"
#include "layout/parent_transfer.h"
#ifdef TFA_ONE_FILE
#include "dynamics/core/aba_joints.h"
#else
#include "dynamics/core/recursions.h"
#endif

static inline int is_revolute_without_armature(const body_constants *b)
{
    return is_revolute(b->kind) && !body_has_armature(b);
}

/* A revolute joint without rotor inertia: aba_backward_1dof without the entries that the projection
 * makes zero (revolute.h).
 *   pA_parent += X^T (pA + Ia c + U D^-1 u) */
TFA_INLINE void aba_backward_revolute(struct state *s, uint32_t i, const body_constants *b,
                                      const num *tau, int flags)
{
    const sym6 IA = aba_backward_inertia(s, i, b, flags);
    svec U, k;
    if (flags & ABA_INERTIA) {
        const num Dinv = 1 / IA.A.zz;
        if (flags & ABA_SENTINEL)
            sentinel_see_D(s, b, &IA, 1, IA.A.zz);
        s->U[i] = U = revolute_U(&IA);
        s->K[i] = k = revolute_gain(U, Dinv);
        s->Dinv[i] = Dinv;
    } else {
        U = s->U[i];
        k = s->K[i];
    }
    svec pa = sv_zero();
    num u = num_of(0);
    if (flags & ABA_FORCE) {
        pa = aba_backward_force(s, i, b, flags);
        u = tau[b->v] - pa.w.z;
        s->u[i] = u;
    }
    if (b->parent < 0)
        return;
    sym6 Ia = revolute_project(&IA, U, k);
    if (b->leaf)
        hide_inertia(&Ia);
    if (flags & ABA_FORCE) {
        pa = revolute_force(pa, k, u);
        if (flags & ABA_BIAS)
            pa = flags & ABA_MODES && body_handle(b) >= 0 ? sv_add(pa, s6_mul(&Ia, s->c[i]))
                                                          : revolute_add_bias(pa, &Ia, s->c[i]);
        add_force_to_parent(s, i, force_to_parent(s, i, b, pa), flags);
    }
    if (flags & ABA_INERTIA) {
        const sym6 up = inertia_to_parent_zero_z(s, i, b, &Ia);
        add_inertia_to_parent(s, i, &up, flags);
    }
}

static inline void aba_backward_step(struct state *s, uint32_t i, const num *tau, int flags)
{
    const body_constants *b = body_constants_of(s, i);
    if (is_revolute_without_armature(b))
        aba_backward_revolute(s, i, b, tau, flags);
    else if (is_revolute(b->kind))
        TFA_V(aba_backward_1dof)(s, i, b, tau, AXIS_RZ, flags);
    else if (is_prismatic(b->kind))
        TFA_V(aba_backward_1dof)(s, i, b, tau, AXIS_TZ, flags);
    else if (b->base)
        TFA_V(aba_backward_base)(s, i, b, tau, flags);
    else
        TFA_V(aba_backward_nd)(s, i, b, tau, flags);
}

/* Outward: a' = X a_parent + c,  qdd = D^-1 (u - U^T a'),  a = a' + H qdd. Of a plain revolute
 * joint H^T a comes first, from D^-1 u and the part of U D^-1 on the other five: fewer operations
 * wait for each other. Returns a. */
TFA_INLINE svec aba_forward_step(struct state *s, uint32_t i, svec parent, num *qdd, int bias)
{
    const body_constants *b = body_constants_of(s, i);
    svec a = motion_to_child(s, i, b, parent);
    if (bias)
        a = sv_add(a, s->c[i]);
    num *x = qdd + b->v;
    if (is_revolute_without_armature(b)) {
        const svec K = s->K[i];
        const num z = s->Dinv[i] * s->u[i] - K.w.x * a.w.x - K.w.y * a.w.y - v3_dot(K.v, a.v);
        x[0] = z - a.w.z;
        a.w.z = z;
        s->a[i] = a;
        return a;
    }
    if (b->n == 1) {
        x[0] = s->Dinv[i] * (s->u[i] - sv_dot(s->U[i], a));
    } else if (b->base) {
        TFA_V(aba_forward_base)(s, i, a, x);
        return s->a[i];
    } else {
        const struct joint_nd *w = &s->joint_nd[b->joint_nd];
        for (uint32_t k = 0; k < b->n; k++)
            x[k] = w->u[k] - sv_dot(sv_from(w->U + 6 * k), a);
        ldl_solve(w->L, b->n, x);
    }
    add_joint_motion(s, b, x, &a);
    s->a[i] = a;
    return a;
}

/* A pass from tips to root: `flags` of ABA_ bits */
typedef void aba_pass_fn(struct state *s, const num *tau, int flags);

/* The pass that forward dynamics needs: inertias unless factors are kept, bias forces of a state
 * that moves. `flags` is a constant of each call, by which the compiler specialises the pass. */
TFA_INLINE void aba_backward_pass(struct state *s, const num *tau, int moving, int kept,
                                  aba_pass_fn *inward)
{
    if (moving && kept)
        inward(s, tau, ABA_FORCE | ABA_BIAS);
    else if (moving)
        inward(s, tau, ABA_INERTIA | ABA_FORCE | ABA_BIAS);
    else if (kept)
        inward(s, tau, ABA_FORCE);
    else
        inward(s, tau, ABA_INERTIA | ABA_FORCE);
}

#endif
