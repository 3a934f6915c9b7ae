/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Lambda^-1 of many tips by composed force propagators (PV-OSIMr: Sathya, Decre, Swevers, IEEE RA-L
 * 2024, arXiv 2310.03676).
 *
 * The wrenches of one tip alone go inward as in force propagation. From one common ancestor to the
 * next the tips share a path segment, through which six unit wrenches are propagated once:
 *   C = sum of psi^T D^-1 psi, compliance at its outer end;  A^T: propagator of a wrench there
 * The tips' wrenches propagate through it in one step, P <- A^T P. Omega, the inverse inertia at
 * the outer end, goes outward over the segments, and each pair is accumulated once, at the
 * outermost end that both have:
 *   Omega = C + A Omega_inboard A^T,   Lambda^-1_tu = P_t^T Omega P_u
 * O(N + m^2). Only sums of positive semidefinite terms. Time over that of propagation:
 * 0.71 (floating quadruped, 2 tips) to 0.23 (floating humanoid, 32 tips), AMD EPYC (Zen 5),
 * 2026-11-24; efpa and crba take longer.
 */
#include "dynamics/osim/lambda.h"

#define SHARED_PATHS_MAX (TFA_MAX_TIPS - 1) /* m tips have at most m - 1 first common ancestors */

struct shared_path {
    uint32_t tips;           /* bits: whose support it is */
    int32_t inboard;         /* the next segment of their support; -1: none */
    struct wrench_columns A; /* columns of A^T: six unit wrenches propagated */
    struct mat6_simd Omega;  /* C, then the inverse inertia at its outer end */
    num *P;                  /* the tips' wrenches at its outer end, 36 numbers each */
};

struct shared_paths {
    uint32_t count;
    struct shared_path at[SHARED_PATHS_MAX];
    int32_t last_path[TFA_MAX_TIPS]; /* the one that a tip passed last; -1: none */
};

/* Start of the tips, and the tips that each body supports. 0: one stands inside a joint, whose
 * first freedoms only move it. */
static int start_tips(struct state *s, tfa_reference_frame frame, struct tip_wrenches *w)
{
    TFA_V(lambda_clear)(s);
    for (uint32_t t = 0; t < s->tips; t++) {
        TFA_V(tip_start)(s, t, frame, &w[t]);
        if (w[t].body >= 0 && w[t].moved < s->body[w[t].body].n)
            return 0;
        for (int32_t i = w[t].body; i >= 0; i = s->body[i].parent)
            s->support[i] |= 1u << t;
    }
    return 1;
}

/* The last of the bodies that wrenches act on; parents stand before their children, so that all
 * that it supports are there. -1: none is left. */
static int32_t outermost(const struct state *s, const struct tip_wrenches *w)
{
    int32_t body = -1;
    for (uint32_t t = 0; t < s->tips; t++)
        body = w[t].body > body ? w[t].body : body;
    return body;
}

/* Takes the wrenches of a tip to the first body that others have in common with it: its own block,
 * but for the contributions from there. */
static void propagate_single_tip(struct state *s, uint32_t t, struct tip_wrenches *w)
{
    struct mat6_simd C = mat6_simd_zero();
    w->body = TFA_V(propagate_forces)(s, w->body, 1u << t, w->moved, &w->P, &C);
    w->moved = 6;
    TFA_V(lambda_put)(s, t, t, &C);
}

/* The wrenches of tip t at the outer end */
static void wrenches_store(const struct shared_path *path, uint32_t t,
                           const struct wrench_columns *P)
{
    for (int k = 0; k < 6; k++)
        vec6_store(path->P + 36 * (size_t)t + 6 * k, &P->at[k]);
}

static struct wrench_columns wrenches_load(const struct shared_path *path, uint32_t t)
{
    struct wrench_columns P;
    for (int k = 0; k < 6; k++)
        P.at[k] = vec6_load(path->P + 36 * (size_t)t + 6 * k);
    return P;
}

/* psi of the tips of a segment, from body i to body `end`: that of six unit wrenches at its outer
 * end, which propagate_forces left in s->phi, times those of the tips there */
static void keep_psi_of_segment(const struct state *s, uint32_t tips, int32_t i, int32_t end,
                                const struct tip_wrenches *w)
{
    for (; i != end; i = s->body[i].parent)
        for (uint32_t j = s->body[i].v; j < s->body[i].v + s->body[i].n; j++) {
            num unit[6];
            memcpy(unit, tip_columns(s, s->phi, j, (uint32_t)__builtin_ctz(tips)), sizeof unit);
            for (uint32_t t = 0; t < s->tips; t++) {
                vec6 psi = vec6_zero();
                if (!(tips >> t & 1))
                    continue;
                for (uint32_t e = 0; e < 6; e++)
                    psi = vec6_add_scaled(psi, unit[e], w[t].P.at[e]);
                vec6_store(tip_columns(s, s->psi, j, t), &psi);
            }
        }
}

/* Takes the tips that a body supports through the segment that starts there. */
static void through_segment(struct state *s, struct shared_paths *x, struct tip_wrenches *w,
                            int32_t body)
{
    struct shared_path *path = &x->at[x->count];
    const int32_t outer = body;
    num A[36];
    path->tips = s->support[body];
    path->inboard = -1;
    path->A = wrench_columns_identity();
    path->Omega = mat6_simd_zero();
    path->P = s->shared_wrenches + (size_t)36 * s->tips * x->count;
    body = TFA_V(propagate_forces)(s, body, path->tips, 6, &path->A, &path->Omega);
    if (s->keeps_psi)
        keep_psi_of_segment(s, path->tips, outer, body, w);
    for (int k = 0; k < 6; k++)
        vec6_store(A + 6 * k, &path->A.at[k]);
    for (uint32_t t = 0; t < s->tips; t++) {
        if (!(path->tips >> t & 1))
            continue;
        if (x->last_path[t] >= 0)
            x->at[x->last_path[t]].inboard = (int32_t)x->count;
        x->last_path[t] = (int32_t)x->count;
        wrenches_store(path, t, &w[t].P);
        if (body >= 0)
            w[t].P = wrench_columns_mul(A, &w[t].P);
        w[t].body = body;
        w[t].moved = 6;
    }
    x->count++;
}

/* Omega P */
static struct wrench_columns omega_times(const struct shared_path *path,
                                         const struct wrench_columns *P)
{
    num Omega[36];
    for (int k = 0; k < 6; k++)
        vec6_store(Omega + 6 * k, &path->Omega.row[k]);
    return wrench_columns_mul(Omega, P);
}

/* Omega = C + A Omega_inboard A^T, inboard first */
static void omega_outward(struct shared_paths *x)
{
    for (uint32_t k = x->count; k-- > 0;) {
        struct shared_path *path = &x->at[k];
        if (path->inboard < 0)
            continue;
        const struct wrench_columns a = omega_times(&x->at[path->inboard], &path->A);
        mat6_simd_add_tmul(&path->Omega, &path->A, &a);
    }
}

/* Lambda^-1_tu += P^T a */
static inline void add_block(struct state *s, uint32_t t, uint32_t u,
                             const struct wrench_columns *P, const struct wrench_columns *a)
{
    struct mat6_simd C = mat6_simd_zero();
    mat6_simd_add_tmul(&C, P, a);
    for (uint32_t e = 0; e < 6; e++)
        for (uint32_t f = u == t ? e : 0; f < 6; f++)
            *lambda_entry(s, t, u, e, f) += vec6_lane(&C.row[e], f);
}

/* The blocks of the tips of a segment that are not paired further out: paired[u] holds the tips
 * paired with u, itself among them. */
static void accumulate_pairs(struct state *s, const struct shared_path *path, uint32_t paired[])
{
    for (uint32_t u = 0; u < s->tips; u++) {
        const uint32_t fresh = path->tips & ~paired[u] & ((2u << u) - 1);
        if (!(path->tips >> u & 1))
            continue;
        paired[u] |= path->tips;
        if (!fresh)
            continue;
        const struct wrench_columns outer = wrenches_load(path, u);
        const struct wrench_columns a = omega_times(path, &outer);
        for (uint32_t t = 0; t <= u; t++)
            if (fresh >> t & 1) {
                const struct wrench_columns P = wrenches_load(path, t);
                add_block(s, t, u, &P, &a);
            }
    }
}

void TFA_V(lambda_pv)(struct state *s, tfa_reference_frame frame)
{
    struct tip_wrenches w[TFA_MAX_TIPS];
    struct shared_paths x;
    uint32_t paired[TFA_MAX_TIPS] = {0};
    int32_t body;
    if (!start_tips(s, frame, w)) {
        TFA_V(lambda_propagation)(s, frame);
        return;
    }
    x.count = 0;
    for (uint32_t t = 0; t < s->tips; t++)
        x.last_path[t] = -1;
    while ((body = outermost(s, w)) >= 0) {
        const uint32_t tips = s->support[body];
        if (tips & (tips - 1))
            through_segment(s, &x, w, body);
        else
            for (uint32_t t = 0; t < s->tips; t++)
                if (tips >> t & 1)
                    propagate_single_tip(s, t, &w[t]);
    }
    omega_outward(&x);
    for (uint32_t k = 0; k < x.count; k++)
        accumulate_pairs(s, &x.at[k], paired);
    if (s->keeps_psi)
        s->psi_frame = (int32_t)frame;
}
