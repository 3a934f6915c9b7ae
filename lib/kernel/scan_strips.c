/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The scan over segments that were computed side by side in lanes (strips.c): velocities outward,
 * inertias and bias forces inward, accelerations outward.
 */
#include "kernel/kernel.h"
#include "kernel/scan.h"
#include "kernel/strips.h"

static inline void fetch(num *out, const double *from, uint32_t segment, uint32_t numbers)
{
    for (uint32_t e = 0; e < numbers; e++)
        out[e] = (num)from[e * TFA_STRIPS_MAX + segment];
}

static inline svec fetch_vector(const double *from, uint32_t segment)
{
    num x[6];
    fetch(x, from, segment, 6);
    return sv_from(x);
}

static inline void put_vector(double *to, uint32_t segment, svec a)
{
    num x[6];
    sv_store(x, a);
    for (uint32_t e = 0; e < 6; e++)
        to[e * TFA_STRIPS_MAX + segment] = (double)x[e];
}

/* v_in[k + 1] = X v_in[k] + v_end[k], or dv_in[k + 1] = X dv_in[k] + (v_end[k] - v_in[k + 1]) */
void TFA_V(strips_travel)(struct tfa_strip_ends *ends, int first)
{
    double *const out = first ? ends->v_in : ends->dv_in;
    svec v = sv_zero();
    put_vector(out, 0, v);
    for (uint32_t k = 0; k + 1 < ends->count; k++) {
        num E[9], r[3];
        fetch(E, ends->E, k, 9);
        fetch(r, ends->r, k, 3);
        const place X = {{E[0], E[1], E[2], E[3], E[4], E[5], E[6], E[7], E[8]},
                         {r[0], r[1], r[2]}};
        svec more = fetch_vector(ends->v_end, k);
        if (!first)
            more = sv_sub(more, fetch_vector(ends->v_in, k + 1));
        v = sv_add(x_motion(&X, v), more);
        put_vector(out, k + 1, v);
    }
}

static void fetch_element(struct scan_segment *segment, const struct tfa_strip_ends *ends,
                          uint32_t k)
{
    fetch(segment->at.A, ends->A, k, 36);
    fetch(segment->at.C, ends->C, k, 36);
    fetch(segment->at.J, ends->J, k, 36);
    fetch(segment->known, ends->known, k, 36);
    for (int e = 0; e < 6; e++)
        for (int f = 0; f < e; f++)
            segment->at.C[6 * e + f] = segment->at.C[6 * f + e];
}

int TFA_V(strips_join)(struct scan_segment *segments, struct tfa_strip_ends *ends, double light)
{
    struct scan scan = {.segments = ends->count, .segment = segments};
    int again = 0;
    for (uint32_t k = 0; k < ends->count; k++)
        fetch_element(&segments[k], ends, k);
    TFA_V(scan_join_segments)(&scan);
    for (uint32_t k = 0; k + 1 < ends->count; k++) {
        if (segments[k].load < (num)light)
            continue;
        again = 1;
        for (uint32_t e = 0; e < 36; e++)
            ends->known[e * TFA_STRIPS_MAX + k] = (double)segments[k + 1].J[e];
    }
    return again;
}

static void put_passed(const struct scan_segment *segments, struct tfa_strip_ends *ends)
{
    for (uint32_t k = 0; k < ends->count; k++) {
        put_vector(ends->a_in, k, segments[k].a_in);
        put_vector(ends->f_out, k, segments[k].f_out);
    }
}

void TFA_V(strips_pass)(struct scan_segment *segments, struct tfa_strip_ends *ends,
                        const double gravity[3])
{
    struct scan scan = {.segments = ends->count, .segment = segments};
    const svec ground = {v3_zero(), v3_neg(v3_load(gravity))};
    for (uint32_t k = 0; k < ends->count; k++) {
        segments[k].v = fetch_vector(ends->a_end, k);
        segments[k].g = fetch_vector(ends->g, k);
    }
    TFA_V(scan_inward)(&scan);
    TFA_V(scan_outward)(&scan, ground);
    put_passed(segments, ends);
}

void TFA_V(strips_close)(struct scan_segment *segments, struct tfa_strip_ends *ends)
{
    struct scan scan = {.segments = ends->count, .segment = segments};
    for (uint32_t k = 0; k < ends->count; k++)
        segments[k].a_end = fetch_vector(ends->a_end, k);
    TFA_V(scan_close_gaps)(&scan);
    put_passed(segments, ends);
}

size_t TFA_V(strips_bytes)(void)
{
    return TFA_STRIPS_MAX * sizeof(struct scan_segment);
}
