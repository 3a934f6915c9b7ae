/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Lambda^-1 of tips beyond the last cut of their chains, by-product of the segment scan: unit
 * wrenches go inward joint by joint as far as the last segment reaches, side branches included, and
 * in one step through each segment before it. A tip further in would need the articulated inertia
 * of its bodies: those segments have it only up to the scan's inertia beyond their cut.
 */
#include "dynamics/osim/lambda.h"
#include "dynamics/scan/scan.h"

/* The chain of a body's tree, and its rows */
static const struct tfa_chain *chain_of(const struct state *s, int32_t body,
                                        const struct scan **scan)
{
    const char *rows = s->rows;
    const struct tfa_chain *chain = s->m->chain;
    for (; (uint32_t)body >= chain->end; chain++)
        rows += TFA_V(scan_bytes)(chain->length);
    *scan = (const struct scan *)(const void *)rows;
    return chain;
}

/* Position on the chain of a body or, on a side branch, of the body that carries it */
static uint32_t position(const struct state *s, const struct tfa_chain *chain, int32_t i)
{
    while (!chain_has(s, chain, i))
        i = s->body[i].parent;
    return s->body[i].depth - 1;
}

static const struct scan_segment *last_segment(const struct scan *scan)
{
    return &scan->segment[scan->segments - 1];
}

/* Whether all tips stand beyond the last cut of their chain */
static int tips_in_last_segment(const struct state *s)
{
    for (uint32_t t = 0; t < s->tips; t++) {
        const struct scan *scan;
        const int32_t i = s->m->frame[s->tip[t]].body;
        const struct tfa_chain *chain = i < 0 ? NULL : chain_of(s, i, &scan);
        if (chain && position(s, chain, i) < last_segment(scan)->first)
            return 0;
    }
    return 1;
}

/* One segment inward, with all of the outboard part on its end: A and C become E^-1 A and E^-1
 * C. */
static void through_segment(struct state *s, uint32_t tips, struct tip_wrenches *w,
                            const struct scan_segment *segment)
{
    struct row6 rows[6];
    num C[MAT6_PADDED];
    mat6_rows_load(rows, segment->at.C);
    mat6_rows_lu_solve(&segment->E, rows);
    mat6_rows_store(C, rows);
    TFA_V(tips_through_segment)(s, tips, w, segment->EA, C);
}

int TFA_V(scan_lambda)(struct state *s, tfa_reference_frame frame)
{
    struct tip_wrenches w[TFA_MAX_TIPS];
    uint32_t left = 0;
    if (s->m->mimics || !tips_in_last_segment(s))
        return 0;
    TFA_V(lambda_clear)(s);
    for (uint32_t t = 0; t < s->tips; t++) {
        const struct scan *scan;
        TFA_V(tip_start)(s, t, frame, &w[t]);
        if (w[t].body < 0)
            continue;
        const struct tfa_chain *chain = chain_of(s, w[t].body, &scan);
        const uint32_t cut = last_segment(scan)->first;
        while (w[t].body >= 0 && position(s, chain, w[t].body) >= cut)
            TFA_V(tip_through_joint)(s, t, &w[t]);
        left |= (uint32_t)(w[t].body >= 0) << t;
    }
    TFA_V(lambda_joints)(s);
    while (left) { /* tree by tree */
        const struct scan *scan;
        uint32_t tips = 0, first = 0;
        while (!(left >> first & 1))
            first++;
        (void)chain_of(s, w[first].body, &scan);
        for (uint32_t t = first; t < s->tips; t++)
            if (left >> t & 1 && s->body[w[t].body].tree == s->body[w[first].body].tree)
                tips |= 1u << t;
        for (uint32_t k = scan->segments - 1; k-- > 0;)
            through_segment(s, tips, w, &scan->segment[k]);
        left &= ~tips;
    }
    TFA_V(lambda_mirror)(s);
    return 1;
}
