/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Lambda^-1 of many tips by composed force propagators (PV-OSIMr: Sathya, Decre, Swevers, IEEE RA-L
 * 2024, arXiv 2310.03676).
 *
 * The wrenches of one tip alone go inward joint by joint as in force propagation. From where tips
 * meet to where they meet the next one they have a stretch of bodies in common, which six unit
 * wrenches cross once:
 *   C = sum of psi^T D^-1 psi, what its outer end yields;  A^T, what it passes on of a wrench there
 * The tips' wrenches cross it in one step, P <- A^T P. Omega, the inverse inertia at the outer end,
 * goes outward over the stretches, and two tips meet once, at the outermost end that both have:
 *   Omega = C + A Omega_inboard A^T,   Lambda^-1_tu = P_t^T Omega P_u
 * O(N + m^2). Only sums of positive semidefinite terms. Measured beside propagation: docs/methods.md.
 */
#include "kernel/kernel.h"
#include "kernel/lambda.h"

#define STRETCHES (TFA_MAX_TIPS - 1) /* m tips meet at m - 1 bodies at most */
/* Fewer freedoms than this are passed joint by joint. 2, 3 and 5 differ by at most 3 % on the robots
 * of docs/methods.md but for a finger of four joints with two tips, 17 % slower with 5. gcc 12, f64
 * without AVX, Intel Xeon with AVX-512, 2026-11-22. */
#define SHORT 3u

struct stretch {
    uint32_t tips;  /* bits: whose support it is */
    int32_t inward; /* the next stretch of their support; -1: none */
    num A[36], Omega[36];
    svec P[TFA_MAX_TIPS][6]; /* the tips' wrenches at its outer end */
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

/* Does a stretch start at this body? Not for one tip, nor for few freedoms before the first. */
static int is_stretch(const struct state *s, const struct stretches *x, int32_t body)
{
    const uint32_t tips = s->support[body];
    uint32_t freedoms = 0;
    if (!(tips & (tips - 1)))
        return 0;
    for (uint32_t t = 0; t < s->tips; t++)
        if (tips >> t & 1 && x->last[t] >= 0)
            return 1;
    for (int32_t i = body; i >= 0 && s->support[i] == tips; i = s->body[i].parent)
        freedoms += s->body[i].n;
    return freedoms >= SHORT;
}

/* A and C of the bodies from `body` inward that support these tips and no others, which counts as
 * done: s->support of them is 0. Returns the body before them. */
static int32_t compose(struct state *s, int32_t body, uint32_t tips, num *A, num *C)
{
    svec P[6];
    int32_t i = body;
    for (int e = 0; e < 6; e++) {
        P[e] = sv_zero();
        sv_put(&P[e], e, 1);
    }
    for (int e = 0; e < 36; e++)
        C[e] = 0;
    for (; i >= 0 && s->support[i] == tips; i = s->body[i].parent) {
        num psi[6][6], phi[6][6];
        TFA_V(propagate)(s, i, 6, P, psi, phi);
        for (uint32_t k = 0; k < s->body[i].n; k++)
            add_response(C, psi[k], phi[k]);
        s->support[i] = 0;
    }
    for (int e = 0; e < 6; e++) {
        sv_store(A + 6 * e, P[e]);
        for (int f = 0; f < e; f++)
            C[6 * e + f] = C[6 * f + e];
    }
    return i;
}

/* Takes the tips that a body supports past the stretch that starts there. */
static void cross(struct state *s, struct stretches *x, struct tip_wrenches *w, int32_t body)
{
    struct stretch *here = &x->at[x->count];
    here->tips = s->support[body];
    here->inward = -1;
    body = compose(s, body, here->tips, here->A, here->Omega);
    for (uint32_t t = 0; t < s->tips; t++) {
        if (!(here->tips >> t & 1))
            continue;
        if (x->last[t] >= 0)
            x->at[x->last[t]].inward = (int32_t)x->count;
        x->last[t] = (int32_t)x->count;
        for (int e = 0; e < 6; e++) {
            here->P[t][e] = w[t].P[e];
            if (body >= 0)
                w[t].P[e] = m6_times_t(here->A, w[t].P[e]);
        }
        w[t].body = body;
        w[t].moved = 6;
    }
    x->count++;
}

/* Omega = C + A Omega_inboard A^T, inboard first */
static void go_outward(struct stretches *x)
{
    for (uint32_t k = x->count; k-- > 0;) {
        struct stretch *here = &x->at[k];
        num OA[36]; /* rows: Omega times the rows of A */
        if (here->inward < 0)
            continue;
        for (int e = 0; e < 6; e++)
            sv_store(OA + 6 * e, m6_times(x->at[here->inward].Omega, sv_from(here->A + 6 * e)));
        for (int e = 0; e < 6; e++)
            for (int f = 0; f < 6; f++)
                here->Omega[6 * e + f] += sv_dot(sv_from(here->A + 6 * e), sv_from(OA + 6 * f));
    }
}

/* The blocks of the tips of a stretch that have not met further out: met[u] says whom tip u has met,
 * itself among them. */
static void meet(struct state *s, const struct stretch *here, uint32_t met[])
{
    for (uint32_t u = 0; u < s->tips; u++) {
        const uint32_t fresh = here->tips & ~met[u] & ((2u << u) - 1);
        svec a[6];
        if (!(here->tips >> u & 1))
            continue;
        for (int f = 0; fresh && f < 6; f++)
            a[f] = m6_times(here->Omega, here->P[u][f]);
        for (uint32_t t = 0; t <= u; t++)
            for (uint32_t e = 0; fresh >> t & 1 && e < 6; e++)
                for (uint32_t f = u == t ? e : 0; f < 6; f++)
                    *lambda_entry(s, t, u, e, f) += sv_dot(here->P[t][e], a[f]);
        met[u] |= here->tips;
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
        if (is_stretch(s, &x, body))
            cross(s, &x, w, body);
        else
            for (uint32_t t = 0; t < s->tips; t++)
                if (w[t].body == body)
                    TFA_V(tip_pass)(s, t, &w[t]);
    }
    go_outward(&x);
    for (uint32_t k = 0; k < x.count; k++)
        meet(s, &x.at[k], met);
    TFA_V(lambda_joints)(s);
    TFA_V(lambda_mirror)(s);
}
