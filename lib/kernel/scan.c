/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The segment scan: where a chain is cut, the scan over the segments, and the method with one pass.
 *
 * One pass is as good as the body behind which it cuts is heavy beside what hangs on it. So the plan
 * cuts there, by constants alone; and where a cut turns out light (LIGHT) the segment inboard of
 * it, and only that, is factored a second time as in the method with two passes. Where no body has
 * an inertia that is safely positive definite there is no cut: one segment is the articulated-body
 * algorithm itself.
 */
#include "kernel/scan.h"

#include "kernel/kernel.h"
#include "model/arena.h"

/* Bodies in a segment, and how far a cut may move from there. At 16 the joins take a sixth of the
 * time (perf, random chain of 256, Xeon VM, 2026-11-21), and a chain of 1024 still has 64 segments
 * for lanes and threads. */
#define SEGMENT 16u
#define REACH 4u
#define SHORTEST (SEGMENT - REACH)
/* A cut moves away from the middle for a load this many times less. */
#define LIGHTER 1.5
/* Bodies beyond a cut that are looked at for its load. */
#define AHEAD 4u
/* What is left to hang on a cut beside what the segment yields (scan_meet), from where on one pass
 * loses digits that ABA keeps. Chains of revolute joints seldom get there; with all types of joints
 * the worst answer had 5 times the error of ABA at 30, and 13 times at 1000. 13 mechanisms,
 * N 24 to 256, 6 to 8 seeds each, 2026-11-21. */
#define LIGHT 30

static size_t take(void *rows, size_t length, struct scan **out)
{
    struct arena a = {rows, 0};
    struct scan *scan = arena_take(&a, 1, sizeof *scan);
    struct scan_segment *segment =
        arena_take(&a, length / SHORTEST + 1, sizeof(struct scan_segment));
    struct scan_body *body = arena_take(&a, length, sizeof(struct scan_body));
    if (scan)
        *scan = (struct scan){0, segment, body};
    *out = scan;
    return a.used;
}

size_t TFA_V(scan_bytes)(size_t length)
{
    struct scan *none;
    return take(NULL, length, &none);
}

struct scan *TFA_V(scan_place)(void *rows, size_t length)
{
    struct scan *scan;
    (void)take(rows, length, &scan);
    return scan;
}

/* ---- the cuts ---- */

static const struct tfa_body *body_at(const struct state *s, const struct tfa_chain *chain,
                                      uint32_t k)
{
    return &s->body[chain->body[k]];
}

/* What may hang on the end of a segment behind body k, in multiples of what its joint moves by
 * itself: the heaviest of the next bodies, held by the next joint, which moves with body k but for
 * its own rotation.
 *   (m |r|^2 + |I| (1 - (z . z')^2)) / D_k     r, z': of the next joint, across z and along it */
static double load_of(const struct state *s, const struct tfa_chain *chain, uint32_t k)
{
    const struct tfa_body *b = body_at(s, chain, k), *next = body_at(s, chain, k + 1);
    double mass = 0, moment = 0;
    for (uint32_t j = k + 1; j < chain->length && j <= k + AHEAD; j++) {
        const struct tfa_body *o = body_at(s, chain, j);
        mass = o->mass > mass ? o->mass : mass;
        moment = o->I[0] + o->I[3] + o->I[5] > moment ? o->I[0] + o->I[3] + o->I[5] : moment;
    }
    if (b->kind != TFA_KIND_REVOLUTE)
        return mass / (b->mass + b->armature);
    const double across = next->r[0] * next->r[0] + next->r[1] * next->r[1];
    const double along = next->kind == TFA_KIND_REVOLUTE ? next->E[8] : 0;
    return (mass * across + moment * (1 - along * along)) / (b->I[5] + b->armature);
}

/* The end of the segment that starts at `first`: behind the regular body SEGMENT - REACH to
 * SEGMENT + REACH on that has the least load, the nearest to SEGMENT of those that have about the
 * least. Where none of them is regular, behind the next one that is. */
static uint32_t end_of(const struct state *s, const struct tfa_chain *chain, uint32_t first)
{
    const uint32_t middle = first + SEGMENT - 1;
    uint32_t best = 0;
    double least = 0;
    if (chain->length - first <= SEGMENT + REACH)
        return chain->length;
    for (uint32_t away = 0; away <= 2 * REACH; away++) { /* 0, -1, +1, -2, +2, .. */
        const uint32_t k = away % 2 ? middle - (away + 1) / 2 : middle + away / 2;
        const double load = load_of(s, chain, k);
        if (body_at(s, chain, k)->regular && (!best || LIGHTER * load < least)) {
            best = k;
            least = load;
        }
    }
    for (uint32_t k = middle + REACH + 1; !best && k < chain->length; k++)
        if (body_at(s, chain, k)->regular)
            best = k;
    return best ? best + 1 : chain->length;
}

void TFA_V(scan_cut)(const struct state *s, const struct tfa_chain *chain, struct scan *scan)
{
    scan->segments = 0;
    for (uint32_t k = 0; k < chain->length;) {
        struct scan_segment *segment = &scan->segment[scan->segments++];
        segment->first = k;
        segment->end = end_of(s, chain, k);
        segment->seeded = 0;
        k = segment->end;
    }
}

/* ---- factors ---- */

/* The scan: the inertia that hangs on each cut, inward, and how each segment moves with the part
 * of it that its factors do not know. */
static void join_segments(struct scan *scan)
{
    uint32_t k = scan->segments - 1;
    for (int e = 0; e < 36; e++)
        scan->segment[k].J[e] = scan->segment[k].at.J[e];
    while (k-- > 0) {
        struct scan_segment *segment = &scan->segment[k];
        for (int e = 0; e < 36; e++)
            segment->left[e] = segment[1].J[e] - segment->known[e];
        segment->load = scan_meet(&segment->E, segment->at.C, segment->left);
        scan_hang(&segment->at, &segment->E, segment->left, segment->EA, segment->J);
    }
}

/* The second pass needs a second scan: what it left on a segment's end is the inertia that the
 * first pass found, what its own factors hand inward differs by rounding, and where light bodies
 * carry heavy ones the difference counts. Left out, two passes had up to 177 times the error of
 * ABA, with it up to 13 (light-heavy, 1024 bodies, random torques, 40 states, 2026-11-22). */
int TFA_V(scan_factor)(struct state *s, const struct tfa_chain *chain, void *rows, num light)
{
    struct scan *scan = TFA_V(scan_place)(rows, chain->length);
    int again = 0;
    TFA_V(scan_cut)(s, chain, scan);
    for (uint32_t k = 0; k < chain->length; k++)
        scan->body[k].I = s->IA[chain->body[k]];
    for (uint32_t k = scan->segments; k-- > 0;) /* independent of each other */
        TFA_V(scan_segment_factor)(s, chain, scan, &scan->segment[k], NULL);
    join_segments(scan);
    for (uint32_t k = scan->segments - 1; k-- > 0;) { /* independent of each other */
        struct scan_segment *segment = &scan->segment[k];
        segment->seeded = !(segment->load < light);
        again |= segment->seeded;
        if (segment->seeded)
            TFA_V(scan_segment_factor)(s, chain, scan, segment, segment[1].J);
    }
    if (again)
        join_segments(scan);
    return TFA_OK;
}

/* ---- solve ---- */

/* Bias forces over the cuts, inward, and how the ends move when a_in = 0:
 *   v <- E^-1 (v - C g_out),   g_in = g + A^T (g_out + left v)
 * Torques may throw a segment with nothing on its end a millionfold of how it moves in the chain:
 * v and C g_out must cancel before E^-1, whose rounding is the same in all directions, goes over
 * them. With E^-1 v - E^-1 C g_out one pass had 8 times the error of ABA, now 1.5 (zigzag, 1024
 * bodies, qdd, median of 7 states, 2026-11-22). */
static void scan_inward(struct scan *scan)
{
    svec g = sv_zero();
    for (uint32_t k = scan->segments; k-- > 0;) {
        struct scan_segment *segment = &scan->segment[k];
        segment->f_out = g;
        if (k + 1 < scan->segments) {
            segment->v = sv_sub(segment->v, m6_times(segment->at.C, g));
            segment->v = scan_closed(&segment->E, segment->v);
            g = sv_add(g, m6_times(segment->left, segment->v));
            g = m6_times_t(segment->at.A, g);
        }
        g = sv_add(segment->g, g);
    }
}

/* Accelerations over the cuts, outward; with them the forces that the cuts pass on:
 *   a_out = E^-1 A a_in + v,   f_out = g_out + left a_out */
static void scan_outward(struct scan *scan, svec a)
{
    for (uint32_t k = 0; k < scan->segments; k++) {
        struct scan_segment *segment = &scan->segment[k];
        segment->a_in = a;
        if (k + 1 == scan->segments)
            break;
        a = sv_add(m6_times(segment->EA, a), segment->v);
        segment->f_out = sv_add(segment->f_out, m6_times(segment->left, a));
    }
}

void TFA_V(scan_solve)(struct state *s, const struct tfa_chain *chain, void *rows, const num *tau,
                       num *qdd, int bias)
{
    struct scan *scan = rows;
    for (uint32_t k = scan->segments; k-- > 0;)
        TFA_V(scan_segment_inward)(s, chain, scan, &scan->segment[k], tau, bias);
    scan_inward(scan);
    scan_outward(scan, chain_ground(s, bias));
    for (uint32_t k = 0; k < scan->segments; k++)
        TFA_V(scan_segment_outward)(s, chain, scan, &scan->segment[k], qdd, bias);
}

/* ---- the method with one pass ---- */

static int factor(struct state *s, const struct tfa_chain *chain, void *rows)
{
    return TFA_V(scan_factor)(s, chain, rows, (num)LIGHT);
}

const struct chain_method TFA_V(scan_method) = {TFA_METHOD_SCAN, TFA_V(scan_bytes), factor,
                                                TFA_V(scan_solve), NULL};
