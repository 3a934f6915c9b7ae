/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The recursions over all bodies: pose, velocity, RNEA, ABA, CRBA.
 */
#ifndef TFA_DYNAMICS_CORE_RECURSIONS_H
#define TFA_DYNAMICS_CORE_RECURSIONS_H

#include "layout/state.h"

/* ---- pose and velocity ---- */

/* X_i = Z(q_i) T_i of the bodies in s->span, unless they are there. O(N) */
void TFA_V(pose)(struct state *s);

/* v_i, c_i and p_i = v_i x* I_i v_i - wrench_i, outward. Without velocity and wrench all are 0
 * and s->moving says so. O(N) */
void TFA_V(velocity)(struct state *s);

/* ---- recursive Newton-Euler: Featherstone 2008, table 5.1 ---- */

/* tau = M qdd + h (bias) or M qdd alone. O(N) */
void TFA_V(rnea)(struct state *s, const num *qdd, num *tau, int bias);

/* The same with motions and forces perturbed by roundings (perturb.h): the difference
 * from rnea shows the effect of rounding on either. */
void TFA_V(rnea_perturbed)(struct state *s, const num *qdd, num *tau, int bias);

/* ---- articulated-body algorithm: Featherstone 2008, table 7.1 ---- */

/* Forward dynamics in one go: factors and qdd = M^-1 (tau - h). NULL, of rigid bodies: no more than
 * the forces u that are left at the joints. O(N) */
void TFA_V(aba)(struct state *s, const num *tau, num *qdd);

/* Its outward pass alone, with the forces u that stand there. Rigid bodies */
void TFA_V(aba_outward)(struct state *s, num *qdd);

/* IA, U, D only. Both use those that are there. */
void TFA_V(aba_factor)(struct state *s);

/* qdd = M^-1 tau with kept factors (no bias). */
void TFA_V(aba_solve)(struct state *s, const num *tau, num *qdd);

/* The inward step of body i (aba_step.h), for passes that need not inline it */
void TFA_V(aba_backward_body)(struct state *s, uint32_t i, const num *tau, int flags);

/* Its cases (aba_joints.h): one freedom along component `axis`, several freedoms, a floating
 * base */
void TFA_V(aba_backward_1dof)(struct state *s, uint32_t i, const body_constants *b, const num *tau,
                              int axis, int flags);
void TFA_V(aba_backward_nd)(struct state *s, uint32_t i, const body_constants *b, const num *tau,
                            int flags);
void TFA_V(aba_backward_base)(struct state *s, uint32_t i, const body_constants *b, const num *tau,
                              int flags);
void TFA_V(joint_nd_factor)(const struct state *s, struct joint_nd *w, const sym6 *IA,
                            const body_constants *b);

/* The outward step of a floating base */
void TFA_V(aba_forward_base)(struct state *s, uint32_t i, svec a, num *x);

/* ---- composite-rigid-body algorithm: Featherstone 2008, tables 6.2 and 6.3 ---- */

/* Rows of M by structure (see model->dof_row). O(N d) for depth d */
void TFA_V(crba)(struct state *s);

/* M = L^T D L in place; with mimics, the factors of T^T M T. Needs crba. O(N d^2) */
void TFA_V(ltdl_factor)(struct state *s);

/* x <- M^-1 x. O(N d) */
void TFA_V(ltdl_solve)(struct state *s, num *x);

/* x <- L^-T x, half of the solve; and the entries of D. */
void TFA_V(ltdl_half)(const struct state *s, num *x, size_t stride);

/* ---- joints that mimic others: T^T M T ---- */

/* Freedom of T^T M T that inner freedom j belongs to, and how many times it moves with it. */
uint32_t TFA_V(reduced_freedom)(const struct tfa_model *m, uint32_t j, num *multiplier);

/* T^T M T from M, factored; x <- T (T^T M T)^-1 T^T x. */
void TFA_V(reduced_factor)(struct state *s);
void TFA_V(reduced_solve)(struct state *s, num *x);

#endif
