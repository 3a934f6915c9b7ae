/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Lambda^-1 of many tips by composed force propagators (PV-OSIMr: Sathya, Decre, Swevers, IEEE RA-L
 * 2024, arXiv 2310.03676).
 *
 * The wrenches of one tip alone go inward as in force propagation. From where tips meet to where they
 * meet the next one they have a stretch of bodies in common, which six unit wrenches cross once:
 *   C = sum of psi^T D^-1 psi, what its outer end yields;  A^T, what it passes on of a wrench there
 * The tips' wrenches cross it in one step, P <- A^T P. Omega, the inverse inertia at the outer end,
 * goes outward over the stretches, and two tips meet once, at the outermost end that both have:
 *   Omega = C + A Omega_inboard A^T,   Lambda^-1_tu = P_t^T Omega P_u
 * O(N + m^2). Only sums of positive semidefinite terms. Measured beside propagation: docs/methods.md.
 */
#include "kernel/kernel.h"
#include "kernel/lambda.h"

#define STRETCHES (TFA_MAX_TIPS - 1) /* m tips meet at m - 1 bodies at most */

struct stretch {
    uint32_t tips;                   /* bits: whose support it is */
    int32_t inward;                  /* the next stretch of their support; -1: none */
    struct wrenches A;               /* columns of A^T: what becomes of six unit wrenches */
    struct block Omega;              /* C, then the inverse inertia at its outer end */
    struct wrenches P[TFA_MAX_TIPS]; /* the tips' wrenches at its outer end */
};

struct stretches {
    uint32_t count;
    struct stretch at[STRETCHES];
    int32_t last[TFA_MAX_TIPS]; /* the one that a tip passed last; -1: none */
};

/* Where the tips start, and whom each body supports. 0: one stands inside a joint, whose first
 * freedoms only move it. */
static int start(struct state *s, tfa_reference_frame frame, struct tip_wrenches *w)
{
    TFA_V(lambda_clear)(s);
    for (uint32_t t = 0; t < s->tips; t++) {
        TFA_V(tip_start)(s, t, frame, &w[t]);
        if (w[t].body >= 0 && w[t].moved < s->body[w[t].body].n)
            return 0;
        for (int32_t i = w[t].body; i >= 0; i = s->body[i].parent)
            s->support[i] |= (uint8_t)(1u << t);
    }
    return 1;
}

/* The last of the bodies that wrenches act on; parents stand before their children, so that all that
 * it supports are there. -1: none is left. */
static int32_t outermost(const struct state *s, const struct tip_wrenches *w)
{
    int32_t body = -1;
    for (uint32_t t = 0; t < s->tips; t++)
        body = w[t].body > body ? w[t].body : body;
    return body;
}

/* Takes the wrenches of a tip to the first body that others have in common with it: its own block,
 * but for what comes from there. */
static void go_alone(struct state *s, uint32_t t, struct tip_wrenches *w)
{
    struct block C = block_zero();
    w->body = TFA_V(carry)(s, w->body, 1u << t, w->moved, &w->P, &C);
    w->moved = 6;
    TFA_V(lambda_put)(s, t, t, &C);
}

/* Takes the tips that a body supports past the stretch that starts there. */
static void cross(struct state *s, struct stretches *x, struct tip_wrenches *w, int32_t body)
{
    struct stretch *here = &x->at[x->count];
    num A[36];
    here->tips = s->support[body];
    here->inward = -1;
    here->A = wrenches_unit();
    here->Omega = block_zero();
    body = TFA_V(carry)(s, body, here->tips, 6, &here->A, &here->Omega);
    for (int k = 0; k < 6; k++)
        six_store(A + 6 * k, &here->A.at[k]);
    for (uint32_t t = 0; t < s->tips; t++) {
        if (!(here->tips >> t & 1))
            continue;
        if (x->last[t] >= 0)
            x->at[x->last[t]].inward = (int32_t)x->count;
        x->last[t] = (int32_t)x->count;
        here->P[t] = w[t].P;
        if (body >= 0)
            w[t].P = wrenches_apply(A, &w[t].P);
        w[t].body = body;
        w[t].moved = 6;
    }
    x->count++;
}

/* Omega P */
static struct wrenches yield_of(const struct stretch *here, const struct wrenches *P)
{
    num Omega[36];
    for (int k = 0; k < 6; k++)
        six_store(Omega + 6 * k, &here->Omega.row[k]);
    return wrenches_apply(Omega, P);
}

/* Omega = C + A Omega_inboard A^T, inboard first */
static void go_outward(struct stretches *x)
{
    for (uint32_t k = x->count; k-- > 0;) {
        struct stretch *here = &x->at[k];
        if (here->inward < 0)
            continue;
        const struct wrenches a = yield_of(&x->at[here->inward], &here->A);
        wrenches_respond(&here->Omega, &here->A, &a);
    }
}

/* Lambda^-1_tu += P^T a */
static inline void add_block(struct state *s, uint32_t t, uint32_t u, const struct wrenches *P,
                             const struct wrenches *a)
{
    struct block C = block_zero();
    wrenches_respond(&C, P, a);
    for (uint32_t e = 0; e < 6; e++)
        for (uint32_t f = u == t ? e : 0; f < 6; f++)
            *lambda_entry(s, t, u, e, f) += six_lane(&C.row[e], f);
}

/* The blocks of the tips of a stretch that have not met further out: met[u] says whom tip u has met,
 * itself among them. */
static void meet(struct state *s, const struct stretch *here, uint32_t met[])
{
    for (uint32_t u = 0; u < s->tips; u++) {
        const uint32_t fresh = here->tips & ~met[u] & ((2u << u) - 1);
        if (!(here->tips >> u & 1))
            continue;
        met[u] |= here->tips;
        if (!fresh)
            continue;
        const struct wrenches a = yield_of(here, &here->P[u]);
        for (uint32_t t = 0; t <= u; t++)
            if (fresh >> t & 1)
                add_block(s, t, u, &here->P[t], &a);
    }
}

void TFA_V(lambda_pv)(struct state *s, tfa_reference_frame frame)
{
    struct tip_wrenches w[TFA_MAX_TIPS];
    struct stretches x;
    uint32_t met[TFA_MAX_TIPS] = {0};
    int32_t body;
    if (!start(s, frame, w)) {
        TFA_V(lambda_propagation)(s, frame);
        return;
    }
    x.count = 0;
    for (uint32_t t = 0; t < s->tips; t++)
        x.last[t] = -1;
    while ((body = outermost(s, w)) >= 0) {
        const uint32_t tips = s->support[body];
        if (tips & (tips - 1))
            cross(s, &x, w, body);
        else
            for (uint32_t t = 0; t < s->tips; t++)
                if (tips >> t & 1)
                    go_alone(s, t, &w[t]);
    }
    go_outward(&x);
    for (uint32_t k = 0; k < x.count; k++)
        meet(s, &x.at[k], met);
}
