/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Flexible bodies: a body whose link has modes, with modal coordinates eta (docs/methods.md). The
 * link's centre of mass moves with them, c = c0 + lambda / m with lambda = sum eta_k l_k; its
 * inertia about it, and its momentum about it by each mode, are constant. I(eta) and the rows
 * B_k(eta) = (a_k + lambda / m x l_k, l_k) are those about the body's origin:
 *
 *   f = I a + B^T eta'' + p     p: with v x* B^T eta' + I' v
 *   0 = B a + M eta'' + r - u   r_k = -1/2 v^T dI/deta_k v + 2/m w . lambda' x l_k,
 *                               u = -K eta - D eta'
 *
 * A child joint on a handle moves with a + Phi eta'', Phi a row of six for each mode; the child's
 * force f_c counts Phi^T f_c in the second equation. Inward, the children's articulated inertias
 * give W = B + sum Phi^T IA_c, D = M + sum Phi^T IA_c Phi, and the modes are eliminated before the
 * joint is:
 *
 *   IA <- IA - W^T D^-1 W,  pA <- pA + W^T D^-1 u,  eta'' = D^-1 (u - W a)
 *
 * Modes are freedoms behind those of all joints (model->freedoms). Cost of n modes: n^3/6 for D,
 * 21 n and, for every child, 36 n + 6 n (n + 1)/2 multiplications for factors; 12 n and n^2 for
 * each solution.
 */
#ifndef TFA_DYNAMICS_CORE_MODES_H
#define TFA_DYNAMICS_CORE_MODES_H

#include "dynamics/core/recursions.h"
#include "layout/body.h"
#include "layout/parent_transfer.h"

/* ---- pose and velocity ---- */

/* Where all handles stand, Phi, and s->X of the bodies on them, which had no deformation */
void TFA_V(modes_pose)(struct state *s);
/* Axes (columns, E) and origin (r) of a frame that rides on a handle, from those without */
void TFA_V(modes_move_frame)(const struct state *s, int32_t handle, xform *at);
/* v_i, c_i and p_i of all bodies, as velocity does of rigid ones, and r of modes */
void TFA_V(modes_velocity)(struct state *s);

/* sum of Phi_k x_k: motion of a handle by its modes, x all freedoms; 0 of handle -1 */
svec TFA_V(modes_motion)(const struct state *s, int32_t handle, const num *x);
/* Phi-dot eta' for that sum of eta' */
svec TFA_V(modes_rate)(const struct state *s, int32_t handle, svec motion);
/* Phi^T f into tau, all freedoms: f a force on what hangs from the handle */
void TFA_V(modes_force)(const struct state *s, int32_t handle, svec f, num *tau);

/* The motion of the parent's part that carries body i, from that of the parent */
svec TFA_V(modes_parent)(const struct state *s, uint32_t i, svec parent, const num *x);

/* sum of B_k x_k of flexible body i, x all freedoms */
svec TFA_V(modes_momentum_by)(const struct state *s, uint32_t i, const num *x);
/* What modes add to the momentum of body i, twice what they add to its kinetic energy, and to its
 * first moment; eta^T K eta / 2 of all */
svec TFA_V(modes_momentum)(const struct state *s, uint32_t i);
num TFA_V(modes_kinetic)(const struct state *s, uint32_t i);
vec3 TFA_V(modes_moment)(const struct state *s, uint32_t i);
num TFA_V(modes_elastic)(const struct state *s);

/* ---- recursive Newton-Euler ---- */

/* f of flexible body i gets what modes add to I a + p, tau of its modes what they take by
 * themselves. bias as rnea's, when the state moves. */
void TFA_V(modes_euler)(struct state *s, uint32_t i, const num *qdd, num *tau, int products);
/* The force that body i hands to its parent, into tau of the modes of that */
void TFA_V(modes_euler_parent)(const struct state *s, uint32_t i, svec up, num *tau);

/* ---- articulated bodies ---- */

/* Own terms of a flexible body, before the children add theirs: s->IA gets I(eta) */
void TFA_V(modes_start_body)(struct state *s, uint32_t i, const num *tau, int flags);
/* What a child hands inward, in the frame of the body that carries its handle */
void TFA_V(modes_add_inertia)(struct state *s, int32_t handle, const sym6 *IA);
void TFA_V(modes_add_force)(struct state *s, int32_t handle, svec pA);
/* Modes out of s->IA and s->pA, when all children are in: by the flags ABA_INERTIA, ABA_FORCE */
void TFA_V(modes_eliminate_body)(struct state *s, uint32_t i, int flags);
/* x = D^-1 u, the motion when s->a is 0. Returns the number of modes. */
uint32_t TFA_V(modes_solve)(const struct state *s, uint32_t i, num *x);
/* eta'' from s->a into x, all freedoms */
void TFA_V(modes_forward_body)(struct state *s, uint32_t i, num *x);

/* Passes of aba over all bodies, with the flags of aba_backward_step; the outward one as aba's */
void TFA_V(modes_inward)(struct state *s, const num *tau, int flags);
void TFA_V(modes_outward)(struct state *s, svec ground, num *qdd, int bias);

/* W and D with side branches alone, which chain methods add the next body to again and again */
void TFA_V(modes_save_body)(struct state *s, uint32_t i);
void TFA_V(modes_restore_body)(struct state *s, uint32_t i);

/* ---- unit forces at a handle (-1: at the clamped part) on their way inward ---- */

/* psi_k = Phi_k . P for `count` forces P, phi = D^-1 psi, both rows of `count` numbers a mode;
 * P <- P - W^T phi. Returns the number of modes of the flexible body. */
uint32_t TFA_V(modes_propagate)(const struct state *s, uint32_t i, int32_t handle, svec P[6],
                                num *psi, num *phi);

static inline void modes_start(struct state *s, uint32_t i, const num *tau, int flags)
{
    if (body_flexible(body_constants_of(s, i)) >= 0)
        TFA_V(modes_start_body)(s, i, tau, flags);
}

static inline void modes_eliminate(struct state *s, uint32_t i, int flags)
{
    if (body_flexible(body_constants_of(s, i)) >= 0)
        TFA_V(modes_eliminate_body)(s, i, flags);
}

static inline void modes_forward(struct state *s, uint32_t i, num *x)
{
    if (body_flexible(body_constants_of(s, i)) >= 0)
        TFA_V(modes_forward_body)(s, i, x);
}

/* Motion of what rides on a handle of a body that moves by m; handle -1: of the body itself */
static inline svec modes_at_handle(const struct state *s, int32_t handle, svec m, const num *x)
{
    return handle < 0 ? m : sv_add(m, TFA_V(modes_motion)(s, handle, x));
}

#endif
