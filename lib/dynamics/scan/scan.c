/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The segment scan: where a chain is cut, the scan over the segments, and the method with one pass.
 *
 * One pass is as good as the body behind which it cuts is heavy beside the inertia outboard of it.
 * So the plan cuts there, by constants alone; and where a cut exceeds the ratio TFA_SCAN_MAX_RATIO
 * the segment inboard of it, and only that, is factored a second time as in the method with two
 * passes. Where no body has an inertia that is safely positive definite there is no cut: one
 * segment is the articulated-body algorithm itself.
 */
#include "dynamics/scan/cut_forces.h"

#include "dynamics/core/modes.h"
#include "dynamics/osim/lambda.h"
#include "dynamics/scan/chain_cut.h"
#include "interface/parallel_for.h"
#include "model/arena.h"

/* Bodies in a segment, and how far a cut may move from there. At 16 the combinations take a sixth
 * of the time (perf, random chain of 256, Xeon VM, 2026-11-21), and a chain of 1024 still has 64
 * segments for lanes and threads. */
#define SEGMENT 16u
#define REACH 4u
#define SHORTEST (SEGMENT - REACH)

static size_t layout(void *rows, size_t length, size_t segments, int with_cuts, struct scan **out)
{
    struct arena a = {rows, 0};
    struct scan *scan = arena_alloc(&a, 1, sizeof *scan);
    struct scan_segment *segment = arena_alloc(&a, segments, sizeof *segment);
    struct scan_body *body = arena_alloc(&a, length, sizeof *body);
    void *cuts = arena_alloc(&a, with_cuts ? TFA_V(cut_forces_bytes)(segments) : 0, 1);
    if (scan)
        *scan = (struct scan){0, segment, body,
                              with_cuts ? TFA_V(cut_forces_layout)(cuts, segments) : NULL};
    *out = scan;
    return a.used;
}

size_t TFA_V(scan_bytes)(size_t length)
{
    struct scan *none;
    return layout(NULL, length, length / SHORTEST + 1, 0, &none);
}

struct scan *TFA_V(scan_layout)(void *rows, size_t length)
{
    struct scan *scan;
    (void)layout(rows, length, length / SHORTEST + 1, 0, &scan);
    return scan;
}

size_t TFA_V(scan_with_cuts_bytes)(size_t length, size_t segments)
{
    struct scan *none;
    return layout(NULL, length, segments, 1, &none);
}

struct scan *TFA_V(scan_with_cuts)(void *rows, size_t length, size_t segments)
{
    struct scan *scan;
    (void)layout(rows, length, segments, 1, &scan);
    return scan;
}

/* ---- the cuts ---- */

/* The end of the segment that starts at `first`: behind the best body SEGMENT - REACH to
 * SEGMENT + REACH on. Where none of them is regular, behind the next one that is. */
static uint32_t segment_end(const struct state *s, const struct tfa_chain *chain, uint32_t first)
{
    const uint32_t middle = first + SEGMENT - 1;
    if (chain->length - first <= SEGMENT + REACH)
        return chain->length;
    const int64_t best = tfa_best_cut(s->body, chain, middle, REACH, 0);
    if (best >= 0)
        return (uint32_t)best + 1;
    for (uint32_t k = middle + REACH + 1; k < chain->length; k++)
        if (s->body[chain->body[k]].regular)
            return k + 1;
    return chain->length;
}

void TFA_V(scan_cut)(const struct state *s, const struct tfa_chain *chain, struct scan *scan)
{
    scan->segments = 0;
    for (uint32_t k = 0; k < chain->length;) {
        struct scan_segment *segment = &scan->segment[scan->segments++];
        segment->first = k;
        segment->end = segment_end(s, chain, k);
        segment->refactored = 0;
        k = segment->end;
    }
}

/* ---- factors ---- */

void TFA_V(scan_combine_segments)(struct scan *scan)
{
    uint32_t k = scan->segments - 1;
    for (int e = 0; e < 36; e++)
        scan->segment[k].J[e] = scan->segment[k].at.J[e];
    while (k-- > 0) {
        struct scan_segment *segment = &scan->segment[k];
        for (int e = 0; e < 36; e++)
            segment->remainder[e] = segment[1].J[e] - segment->seed[e];
        segment->mass_ratio = scan_factor_interface(&segment->E, segment->at.C, segment->remainder);
        scan_attach(&segment->at, &segment->E, segment->remainder, segment->EA, segment->J);
    }
}

/* Context of the parts of a step. Segments are independent of each other in every step;
 * SEGMENTS_PER_TASK of them are one part, so that handing them out costs little. */
struct scan_work {
    struct state *s;
    const struct tfa_chain *chain;
    struct scan *scan;
    const num *tau;
    num *qdd;
    int bias;
};
#define SEGMENTS_PER_TASK 4u

static uint32_t parts_of(const struct scan *scan)
{
    return (scan->segments + SEGMENTS_PER_TASK - 1) / SEGMENTS_PER_TASK;
}

/* The segments of one part */
static struct span part_of(const struct scan *scan, uint32_t part)
{
    const uint32_t end = (part + 1) * SEGMENTS_PER_TASK;
    return (struct span){part * SEGMENTS_PER_TASK, end < scan->segments ? end : scan->segments};
}

static void factor_part(void *context, uint32_t part, uint32_t worker)
{
    const struct scan_work *w = context;
    const struct span span = part_of(w->scan, part);
    (void)worker;
    for (uint32_t k = span.first; k < span.end; k++)
        TFA_V(scan_segment_factor)(w->s, w->chain, w->scan, &w->scan->segment[k], NULL);
}

static void factor_again_part(void *context, uint32_t part, uint32_t worker)
{
    const struct scan_work *w = context;
    const struct span span = part_of(w->scan, part);
    (void)worker;
    for (uint32_t k = span.first; k < span.end; k++) {
        struct scan_segment *segment = &w->scan->segment[k];
        if (segment->refactored)
            TFA_V(scan_segment_factor)(w->s, w->chain, w->scan, segment, segment[1].J);
    }
}

/* The inertias of the chain's bodies, and every segment by itself */
static void factor_segments(struct scan_work *w)
{
    for (uint32_t k = 0; k < w->chain->length; k++) {
        const uint32_t i = w->chain->body[k];
        w->scan->body[k].I = w->s->IA[i];
        if (w->s->body[i].flexible >= 0)
            TFA_V(modes_save_body)(w->s, i);
    }
    parallel_for(w->s->executor, factor_part, w, parts_of(w->scan));
}

/* The second pass needs a second scan: what it left on a segment's end is the inertia that the
 * first pass found, what its own factors hand inward differs by rounding, and where light bodies
 * carry heavy ones the difference counts. Left out, two passes had up to 177 times the error of
 * ABA, with it up to 13 (light-heavy, 1024 bodies, random torques, 40 states, 2026-11-22). */
int TFA_V(scan_factor)(struct state *s, const struct tfa_chain *chain, void *rows, num max_ratio)
{
    struct scan *scan = TFA_V(scan_layout)(rows, chain->length);
    struct scan_work scan_work = {.s = s, .chain = chain, .scan = scan};
    int second_pass = 0;
    TFA_V(scan_cut)(s, chain, scan);
    factor_segments(&scan_work);
    TFA_V(scan_combine_segments)(scan);
    for (uint32_t k = 0; k + 1 < scan->segments; k++) {
        struct scan_segment *segment = &scan->segment[k];
        segment->refactored = !(segment->mass_ratio < max_ratio);
        second_pass |= segment->refactored;
    }
    if (second_pass) {
        parallel_for(s->executor, factor_again_part, &scan_work, parts_of(scan));
        TFA_V(scan_combine_segments)(scan);
    }
    return TFA_OK;
}

int TFA_V(scan_factor_floating)(struct state *s, const struct tfa_chain *chain, struct scan *scan)
{
    struct scan_work scan_work = {.s = s, .chain = chain, .scan = scan};
    uint32_t singular;
    if (scan->segments == 1)
        scan->cuts = NULL; /* the articulated-body algorithm, without a system of forces */
    factor_segments(&scan_work);
    if (!scan->cuts)
        return TFA_OK;
    for (uint32_t k = 0; k < scan->segments; k++) {
        const uint32_t i = chain->body[scan->segment[k].first];
        scan->cuts->cut[k].X = s->X[i];
        cfa_joint_init(&scan->cuts->cut[k].joint, s, &s->body[i]);
    }
    if (TFA_V(cut_forces_factor)(scan, &singular))
        return TFA_OK;
    s->bad_body = (int32_t)chain->body[scan->segment[singular].first];
    return TFA_E_SINGULAR;
}

/* ---- solve ---- */

/* v <- E^-1 (v - C g_out),   g_in = g + A^T (g_out + left v)
 * Torques may throw a segment with nothing on its end a millionfold of how it moves in the chain:
 * v and C g_out must cancel before E^-1, whose rounding is the same in all directions, goes over
 * them. With E^-1 v - E^-1 C g_out one pass had 8 times the error of ABA, now 1.5 (zigzag, 1024
 * bodies, qdd, median of 7 states, 2026-11-22). */
void TFA_V(scan_inward)(struct scan *scan)
{
    svec g = sv_zero();
    for (uint32_t k = scan->segments; k-- > 0;) {
        struct scan_segment *segment = &scan->segment[k];
        segment->f_out = g;
        if (k + 1 < scan->segments) {
            segment->v = sv_sub(segment->v, m6_times(segment->at.C, g));
            segment->v = scan_closed(&segment->E, segment->v);
            g = sv_add(g, m6_times(segment->remainder, segment->v));
            g = m6_times_t(segment->at.A, g);
        }
        g = sv_add(segment->g, g);
    }
}

/*   a_out = E^-1 A a_in + v,   f_out = g_out + left a_out */
void TFA_V(scan_outward)(struct scan *scan, svec a)
{
    for (uint32_t k = 0; k < scan->segments; k++) {
        struct scan_segment *segment = &scan->segment[k];
        segment->a_in = a;
        if (k + 1 == scan->segments)
            break;
        a = sv_add(m6_times(segment->EA, a), segment->v);
        segment->f_out = sv_add(segment->f_out, m6_times(segment->remainder, a));
    }
}

/*   da of the next = E^-1 (A da + a_end - a_in of the next),   df = left da of the next
 * The element moves an end by other roundings than its bodies one after the other, and an
 * acceleration that jumps by so much at every cut bends the chain: without this two passes had 3.1
 * (qdd) and 4.9 (tau) times the error of ABA, with it 1.3 and 0.9 (zigzag, 4096 bodies, segments of
 * 16, median of 5 states, 2026-11-22). */
void TFA_V(scan_close_gaps)(struct scan *scan)
{
    svec da = sv_zero();
    for (uint32_t k = 0; k < scan->segments; k++) {
        struct scan_segment *segment = &scan->segment[k];
        const svec in = da;
        segment->f_out = sv_zero();
        if (k + 1 < scan->segments) {
            const svec gap = sv_sub(segment->a_end, segment[1].a_in);
            da = sv_add(m6_times(segment->EA, da), scan_closed(&segment->E, gap));
            segment->f_out = m6_times(segment->remainder, da);
        }
        segment->a_in = in;
    }
}

static void inward_part(void *context, uint32_t part, uint32_t worker)
{
    const struct scan_work *w = context;
    const struct span span = part_of(w->scan, part);
    (void)worker;
    for (uint32_t k = span.end; k-- > span.first;)
        TFA_V(scan_segment_inward)
    (w->s, w->chain, w->scan, &w->scan->segment[k], w->tau, w->bias);
}

static void outward_part(void *context, uint32_t part, uint32_t worker)
{
    const struct scan_work *w = context;
    const struct span span = part_of(w->scan, part);
    (void)worker;
    for (uint32_t k = span.first; k < span.end; k++)
        TFA_V(scan_segment_outward)
    (w->s, w->chain, w->scan, &w->scan->segment[k], w->qdd, w->bias);
}

static void correct_part(void *context, uint32_t part, uint32_t worker)
{
    const struct scan_work *w = context;
    const struct span span = part_of(w->scan, part);
    (void)worker;
    for (uint32_t k = span.first; k < span.end; k++)
        TFA_V(scan_segment_correct)(w->s, w->chain, w->scan, &w->scan->segment[k], w->qdd);
}

/* c and Wa tau of the cuts, then the forces there */
static void solve_cuts(const struct scan_work *w)
{
    const struct state *s = w->s;
    for (uint32_t k = 0; k < w->scan->segments; k++) {
        const uint32_t i = w->chain->body[w->scan->segment[k].first];
        struct cut *cut = &w->scan->cuts->cut[k];
        cut->c = chain_has_velocity_products(s, w->bias) ? s->c[i] : sv_zero();
        sv_store(cut->f, cfa_active_force(&cut->joint, w->tau + s->body[i].v));
    }
    TFA_V(cut_forces_solve)(w->scan, chain_ground(s, w->bias));
}

void TFA_V(scan_solve)(struct state *s, const struct tfa_chain *chain, void *rows, const num *tau,
                       num *qdd, int bias)
{
    struct scan *scan = rows;
    struct scan_work scan_work = {
        .s = s, .chain = chain, .scan = scan, .tau = tau, .qdd = qdd, .bias = bias};
    parallel_for(s->executor, inward_part, &scan_work, parts_of(scan));
    if (scan->cuts) {
        solve_cuts(&scan_work);
    } else {
        TFA_V(scan_inward)(scan);
        TFA_V(scan_outward)(scan, chain_ground(s, bias));
    }
    parallel_for(s->executor, outward_part, &scan_work, parts_of(scan));
    if (scan->segments == 1)
        return;
    if (scan->cuts)
        s->stalled |= !TFA_V(cut_forces_close_gaps)(scan);
    else
        TFA_V(scan_close_gaps)(scan);
    parallel_for(s->executor, correct_part, &scan_work, parts_of(scan));
}

/* ---- the method with one pass ---- */

static int factor(struct state *s, const struct tfa_chain *chain, void *rows)
{
    return TFA_V(scan_factor)(s, chain, rows, (num)TFA_SCAN_MAX_RATIO);
}

CHAIN_METHOD(scan) = {.bytes = TFA_V(scan_bytes),
                      .factor = factor,
                      .solve = TFA_V(scan_solve),
                      .osim = TFA_V(scan_lambda)};
