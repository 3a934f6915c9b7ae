/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Operational-space inverse inertia Lambda^-1 = J M^-1 J^T: the methods, and the steps they share.
 */
#ifndef TFA_DYNAMICS_OSIM_LAMBDA_H
#define TFA_DYNAMICS_OSIM_LAMBDA_H

#include "dynamics/chain/chain.h"
#include "dynamics/kinematics/frame.h"
#include "spatial/vec6.h"

/* ---- methods ---- */

/* J^T columns of the tips into s->psi (nv x 6m). Linear columns first. */
void TFA_V(jacobian)(struct state *s, tfa_reference_frame frame);

/* Each writes Lambda^-1 into s->lambda (6m x 6m). Force propagation: needs the articulated-body
 * factors. */
void TFA_V(lambda_propagation)(struct state *s, tfa_reference_frame frame);

/* From the factors of M */
void TFA_V(lambda_crba)(struct state *s, tfa_reference_frame frame);

/* Forward elimination of tfa: TFA_OK, TFA_E_SINGULAR with s->bad_body, or TFA_E_UNSUPPORTED for
 * these tips */
int TFA_V(lambda_one_sided)(struct state *s, tfa_reference_frame frame);

/* Extended force propagation. Needs the articulated-body factors. */
void TFA_V(lambda_efpa)(struct state *s, tfa_reference_frame frame);

/* The same with the stretches of bodies that several tips share passed in one step (PV-OSIMr). */
void TFA_V(lambda_pv)(struct state *s, tfa_reference_frame frame);

/* Of every tip by the total forces of the main chains, with kept factors of a method that
 * has forces_6rhs, each tip refined so many times. O(N) for each tip. */
void TFA_V(lambda_chain)(struct state *s, tfa_reference_frame frame,
                         const struct chain_method *method, uint32_t refine);

/* ---- shared steps ---- */

/* Row j of a table of freedoms by tip columns (psi, phi), the six of tip t */
static inline num *tip_columns(const struct state *s, num *table, uint32_t j, uint32_t t)
{
    return table + (size_t)j * 6 * s->tips + 6 * (size_t)t;
}

/* Entry e, f of the block of tips t and u */
static inline num *lambda_entry(const struct state *s, uint32_t t, uint32_t u, uint32_t e,
                                uint32_t f)
{
    return s->lambda + (size_t)(6 * t + e) * 6 * s->tips + 6 * u + f;
}

/* M x and M^T x for a dense M */
static inline svec m6_times(const num *M, svec x)
{
    num in[6], out[6];
    sv_store(in, x);
    m6_apply(out, M, in);
    return sv_from(out);
}

static inline svec m6_times_t(const num *M, svec x)
{
    num in[6], out[6] = {0};
    sv_store(in, x);
    for (int k = 0; k < 6; k++)
        for (int e = 0; e < 6; e++)
            out[e] += M[6 * k + e] * in[k];
    return sv_from(out);
}

/* Propagates six wrenches through joint i: psi = H^T P, phi = D^-1 psi, P <- X^T (P - U phi), where
 * they act on what its first `moved` freedoms move. Needs the articulated-body factors of body
 * i. */
void TFA_V(propagate_through_joint)(const struct state *s, int32_t i, uint32_t moved,
                                    struct wrench_columns *P, vec6 psi[6], vec6 phi[6]);

/* Propagates them inward from body i, through all bodies whose s->support is `tips`, and adds the
 * responses: C += psi^T phi. If s->keeps_psi, psi goes to the first of these tips in s->psi or, of
 * several, in s->phi. They end on the body that is returned; on a root where it is -1. */
int32_t TFA_V(propagate_forces)(const struct state *s, int32_t i, uint32_t tips, uint32_t moved,
                                struct wrench_columns *P, struct mat6_simd *C);

/* The six unit wrenches of a tip on their way inward */
struct tip_wrenches {
    int32_t body;   /* on which they act, in its coordinates; -1: none is left */
    uint32_t moved; /* by how many freedoms of its joint they are moved */
    int32_t handle; /* of a flexible body, on which they act; -1: on what is clamped */
    struct wrench_columns P;
};

/* Propagates them to the root: the sum of the responses is the tip's Lambda^-1, if it is the
 * only tip. Keeps psi if s->keeps_psi. */
void TFA_V(propagate_to_root)(struct state *s, const struct tip_wrenches *w, num lambda[36]);

/* The same while the factors are computed, which are not there: the step of each body, then the
 * wrenches pass its joint. Neither waits for the other, 0.85 of the time of one after the other
 * (arm of 7, AMD EPYC Zen 5, gcc 12, 2026-11-22). */
void TFA_V(lambda_while_factoring)(struct state *s, tfa_reference_frame frame);

/* Where they start: at the tip's own body. */
void TFA_V(tip_start)(const struct state *s, uint32_t t, tfa_reference_frame frame,
                      struct tip_wrenches *w);

/* Propagates them through the joint of their body: its psi and phi are kept, s->support says so. */
void TFA_V(tip_through_joint)(struct state *s, uint32_t t, struct tip_wrenches *w);

/* At a floating base of a rigid body, where they end: keeps psi and no phi. */
void TFA_V(tip_at_base)(struct state *s, uint32_t t, struct tip_wrenches *w);

/* Propagates the wrenches of `tips` (bits) through a segment of bodies that moves its outer end by
 * C f under a force f there and passes A^T f on: Lambda^-1_tu += P_t^T C P_u, P <- A^T P. */
void TFA_V(tips_through_segment)(struct state *s, uint32_t tips, struct tip_wrenches *w,
                                 const num *A, const num *C);

/* No body supports a tip. */
void TFA_V(support_clear)(struct state *s);

/* Lambda^-1 = 0, no body supports a tip. */
void TFA_V(lambda_clear)(struct state *s);

/* Lambda^-1_tu = C. */
void TFA_V(lambda_put)(struct state *s, uint32_t t, uint32_t u, const struct mat6_simd *C);

/* Lambda^-1_tu += psi_t^T phi_u of every joint that supports both tips. Upper triangle. */
void TFA_V(lambda_joints)(struct state *s);

/* Copies the upper triangle of s->lambda to the lower one, where propagation and composed
 * propagators leave numbers that are finite if those above are, and no more: unload does the
 * same on the way out. */
void TFA_V(lambda_mirror)(struct state *s);

#endif
