/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Lambda^-1 of one tip at the end of a chain, by-product of the segment scan: six unit wrenches go
 * inward body by body through the last segment, and in one step through each of the others.
 */
#include "kernel/lambda.h"
#include "kernel/scan.h"

/* The chain that ends with this segment-full of bodies, and its rows; NULL where the body stands
 * elsewhere */
static const struct tfa_chain *chain_of(const struct state *s, int32_t body, struct scan **scan,
                                        uint32_t *position)
{
    char *rows = s->rows;
    for (uint32_t t = 0; t < s->m->trees; t++) {
        const struct tfa_chain *chain = &s->m->chain[t];
        *scan = (struct scan *)(void *)rows;
        for (uint32_t k = (*scan)->segment[(*scan)->segments - 1].first; k < chain->length; k++)
            if (chain->body[k] == (uint32_t)body) {
                *position = k;
                return chain;
            }
        rows += TFA_V(scan_bytes)(chain->length);
    }
    return NULL;
}

/* L += P^T C P,  P <- A^T P, with C and A of the segment that has all of the outboard part on its
 * end:  y = E^-1 C P,  L += P^T y,  P <- A^T (P - left y) */
static void cross_segment(const struct scan_segment *segment, svec P[6], num *L)
{
    svec y[6];
    for (int e = 0; e < 6; e++) {
        y[e] = scan_times(segment->at.C, P[e]);
        y[e] = scan_closed(&segment->E, y[e]);
        for (int f = e; f < 6; f++)
            L[6 * e + f] += sv_dot(P[f], y[e]);
    }
    for (int e = 0; e < 6; e++) {
        P[e] = sv_sub(P[e], scan_times(segment->left, y[e]));
        P[e] = scan_times_t(segment->at.A, P[e]);
    }
}

int TFA_V(scan_lambda)(struct state *s, tfa_reference_frame frame)
{
    struct scan *scan;
    uint32_t position;
    svec P[6];
    if (s->tips != 1 || s->m->mimics)
        return 0;
    int32_t i = TFA_V(frame_columns)(s, s->tip[0], frame, P);
    const struct tfa_chain *chain = i < 0 ? NULL : chain_of(s, i, &scan, &position);
    if (!chain)
        return 0;
    uint32_t moved = TFA_V(frame_freedoms)(s, s->tip[0]);
    num psi[6][6], phi[6][6];
    for (int k = 0; k < 36; k++)
        s->lambda[k] = 0;
    for (uint32_t k = position + 1; k-- > scan->segment[scan->segments - 1].first; moved = 6) {
        i = (int32_t)chain->body[k];
        TFA_V(propagate)(s, i, moved, P, psi, phi);
        for (uint32_t j = 0; j < s->body[i].n; j++)
            scan_add_response(s->lambda, psi[j], phi[j]);
    }
    for (uint32_t k = scan->segments - 1; k-- > 0;)
        cross_segment(&scan->segment[k], P, s->lambda);
    TFA_V(lambda_mirror)(s);
    return 1;
}
