/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Segments by the articulated-body algorithm, direct; the forces at their cuts by conjugate
 * gradients, iterative. Where a chain is cut depends on the chain alone, each solve starts from
 * zero and has a fixed number of iterations at most: the same bits in batches and on threads.
 */
#include "dynamics/scan/chain_cut.h"
#include "dynamics/scan/cut_forces.h"

/* What conjugate gradients leave of the gaps between segments; the rest is closed afterwards. */
#define TOLERANCE (4096 * NUM_EPSILON)

static size_t bytes(size_t length)
{
    return TFA_V(scan_with_cuts_bytes)(length, TFA_SEGMENTS_MAX);
}

/* Where no body near the end of a segment will do, it goes on. */
static void cut(const struct state *s, const struct tfa_chain *chain, struct scan *scan)
{
    uint32_t first = 0;
    scan->segments = 0;
    for (uint32_t k = 0; k < tfa_segment_count(chain->length); k++) {
        const int64_t end = tfa_segment_end(s->body, chain, k, 1);
        if (end < 0)
            continue;
        scan->segment[scan->segments++] =
            (struct scan_segment){.first = first, .end = (uint32_t)end + 1};
        first = (uint32_t)end + 1;
    }
}

static int factor(struct state *s, const struct tfa_chain *chain, void *rows, num tolerance)
{
    struct scan *scan = TFA_V(scan_with_cuts)(rows, chain->length, TFA_SEGMENTS_MAX);
    scan->cuts->tolerance = tolerance;
    cut(s, chain, scan);
    return TFA_V(scan_factor_floating)(s, chain, scan);
}

static int factor_hybrid(struct state *s, const struct tfa_chain *chain, void *rows)
{
    return factor(s, chain, rows, (num)TOLERANCE);
}

CHAIN_METHOD(hybrid) = {.bytes = bytes, .factor = factor_hybrid, .solve = TFA_V(scan_solve)};

/* Of tfa-cr and cfa-cr: the same system by cyclic reduction */
static int factor_direct(struct state *s, const struct tfa_chain *chain, void *rows)
{
    return factor(s, chain, rows, 0);
}

CHAIN_METHOD(segments) = {.bytes = bytes, .factor = factor_direct, .solve = TFA_V(scan_solve)};
