/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Steps that the ways to Lambda^-1 share.
 */
#ifndef TFA_KERNEL_LAMBDA_H
#define TFA_KERNEL_LAMBDA_H

#include "kernel/frame.h"
#include "spatial/six.h"

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

/* Takes six wrenches past joint i: psi = H^T P, phi = D^-1 psi, P <- X^T (P - U phi), where they act
 * on what its first `moved` freedoms move. Needs the articulated-body factors of body i. */
void TFA_V(propagate)(const struct state *s, int32_t i, uint32_t moved, struct wrenches *P,
                      six psi[6], six phi[6]);

/* Takes them inward from body i, past all bodies whose s->support is `tips` (0: past all), and adds what
 * these yield: C += psi^T phi. They end on the body that is returned; on a root where it is -1. */
int32_t TFA_V(carry)(const struct state *s, int32_t i, uint32_t tips, uint32_t moved,
                     struct wrenches *P, struct block *C);

/* The six unit wrenches of a tip on their way inward */
struct tip_wrenches {
    int32_t body;   /* on which they act, in its coordinates; -1: none is left */
    uint32_t moved; /* by how many freedoms of its joint they are moved */
    struct wrenches P;
};

/* Takes them to the root, past all bodies: what these yield is the tip's Lambda^-1, if it is alone. */
void TFA_V(carry_home)(const struct state *s, const struct tip_wrenches *w, num lambda[36]);

/* The same while the factors are computed, which are not there: each body is folded, then the wrenches
 * pass its joint. Neither waits for the other, 0.85 of the time of one after the other (arm of 7, AMD EPYC
 * Zen 5, gcc 12, 2026-11-22). */
void TFA_V(lambda_fold)(struct state *s, tfa_reference_frame frame);

/* Where they start: at the tip's own body. */
void TFA_V(tip_start)(const struct state *s, uint32_t t, tfa_reference_frame frame,
                      struct tip_wrenches *w);

/* Takes them past the joint of their body: its psi and phi are kept, s->support says so. */
void TFA_V(tip_pass)(struct state *s, uint32_t t, struct tip_wrenches *w);

/* Takes the wrenches of `tips` (bits) past a stretch of bodies that moves its outer end by C f
 * under a force f there and passes A^T f on: Lambda^-1_tu += P_t^T C P_u, P <- A^T P. */
void TFA_V(tips_cross)(struct state *s, uint32_t tips, struct tip_wrenches *w, const num *A,
                       const num *C);

/* Lambda^-1 = 0, no body supports a tip. */
void TFA_V(lambda_clear)(struct state *s);

/* Lambda^-1_tu = C. */
void TFA_V(lambda_put)(struct state *s, uint32_t t, uint32_t u, const struct block *C);

/* Lambda^-1_tu += psi_t^T phi_u of every joint that supports both tips. Upper triangle. */
void TFA_V(lambda_joints)(struct state *s);

/* s->qdd = M^-1 s->tau with refinement steps: r = tau - M x, x += M^-1 r; `perturbed`: the last residual
 * is that of an estimate (rnea.c). */
void TFA_V(solve_refined)(struct state *s, tfa_method method, uint32_t steps, int perturbed);

/* Copies the upper triangle of s->lambda to the lower one, where propagation and composed propagators
 * leave numbers that are finite if those above are, and no more: unload does the same on the way out. */
void TFA_V(lambda_mirror)(struct state *s);

/* Lambda^-1 of the request's tips into s->lambda, with the factors that either scan left. 0: a tip
 * reaches a chain before its last segment, or there are mimics. O(N / 16) for each tip. */
int TFA_V(scan_lambda)(struct state *s, tfa_reference_frame frame);

#endif
