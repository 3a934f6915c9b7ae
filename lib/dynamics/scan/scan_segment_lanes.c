/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The scan over segments that were computed in SIMD lanes (segment_lanes.c): velocities outward,
 * inertias and bias forces inward, accelerations outward.
 */
#include "dynamics/scan/cut_forces.h"
#include "dynamics/scan/segment_boundary.h"
#include "dynamics/scan/segment_scan.h"

static inline void fetch(num *out, const double *from, uint32_t segment, uint32_t numbers)
{
    for (uint32_t e = 0; e < numbers; e++)
        out[e] = (num)from[e * TFA_SEGMENTS_MAX + segment];
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
        to[e * TFA_SEGMENTS_MAX + segment] = (double)x[e];
}

/* v_in[k + 1] = X v_in[k] + v_end[k], or dv_in[k + 1] = X dv_in[k] + (v_end[k] - v_in[k + 1]) */
void TFA_V(segment_scan_velocities)(struct tfa_segment_boundary *boundary, int first)
{
    double *const out = first ? boundary->v_in : boundary->dv_in;
    svec v = sv_zero();
    put_vector(out, 0, v);
    for (uint32_t k = 0; k + 1 < boundary->count; k++) {
        num E[9], r[3];
        fetch(E, boundary->E, k, 9);
        fetch(r, boundary->r, k, 3);
        const xform X = {{E[0], E[1], E[2], E[3], E[4], E[5], E[6], E[7], E[8]},
                         {r[0], r[1], r[2]}};
        svec more = fetch_vector(boundary->v_end, k);
        if (!first)
            more = sv_sub(more, fetch_vector(boundary->v_in, k + 1));
        v = sv_add(xform_motion(&X, v), more);
        put_vector(out, k + 1, v);
    }
}

static void fetch_element(struct scan_segment *segment, const struct tfa_segment_boundary *boundary,
                          uint32_t k)
{
    fetch(segment->at.A, boundary->A, k, 36);
    fetch(segment->at.C, boundary->C, k, 36);
    fetch(segment->at.J, boundary->J, k, 36);
    fetch(segment->seed, boundary->seed, k, 36);
    for (int e = 0; e < 6; e++)
        for (int f = 0; f < e; f++)
            segment->at.C[6 * e + f] = segment->at.C[6 * f + e];
}

/* X of the cut, and H = (0, 0, 1, 0, 0, 0) */
static void fetch_cut(struct cut *cut, const struct tfa_segment_boundary *boundary, uint32_t k)
{
    num E[9], r[3];
    fetch(E, boundary->cut_E, k, 9);
    fetch(r, boundary->cut_r, k, 3);
    cut->X = (xform){{E[0], E[1], E[2], E[3], E[4], E[5], E[6], E[7], E[8]}, {r[0], r[1], r[2]}};
    cut->joint = (struct cfa_joint){.n = 1, .axis = AXIS_RZ};
    joint_basis_1dof(AXIS_RZ, cut->joint.basis);
}

int TFA_V(segment_scan_factor)(struct scan *scan, struct tfa_segment_boundary *boundary,
                               double max_ratio)
{
    uint32_t singular;
    int second_pass = 0;
    (void)TFA_V(scan_with_cuts)(scan, 0, TFA_SEGMENTS_MAX);
    scan->segments = boundary->count;
    for (uint32_t k = 0; k < boundary->count; k++)
        fetch_element(&scan->segment[k], boundary, k);
    if (boundary->floating) {
        for (uint32_t k = 0; k < boundary->count; k++)
            fetch_cut(&scan->cuts->cut[k], boundary, k);
        return TFA_V(cut_forces_factor)(scan, &singular) ? 0 : -1;
    }
    TFA_V(scan_combine_segments)(scan);
    for (uint32_t k = 0; k + 1 < boundary->count; k++) {
        if (scan->segment[k].mass_ratio < (num)max_ratio)
            continue;
        second_pass = 1;
        for (uint32_t e = 0; e < 36; e++)
            boundary->seed[e * TFA_SEGMENTS_MAX + k] = (double)scan->segment[k + 1].J[e];
    }
    return second_pass;
}

static void put_inputs(const struct scan *scan, struct tfa_segment_boundary *boundary)
{
    for (uint32_t k = 0; k < boundary->count; k++) {
        put_vector(boundary->a_in, k, scan->segment[k].a_in);
        put_vector(boundary->f_out, k, scan->segment[k].f_out);
    }
}

void TFA_V(segment_scan_solve)(struct scan *scan, struct tfa_segment_boundary *boundary,
                               const double gravity[3])
{
    const svec ground = {v3_zero(), v3_neg(v3_load(gravity))};
    for (uint32_t k = 0; k < boundary->count; k++) {
        struct cut *cut = &scan->cuts->cut[k];
        scan->segment[k].v = fetch_vector(boundary->a_end, k);
        scan->segment[k].g = fetch_vector(boundary->g, k);
        if (!boundary->floating)
            continue;
        num tau;
        fetch(&tau, boundary->cut_tau, k, 1);
        cut->c = fetch_vector(boundary->cut_c, k);
        sv_store(cut->f, cfa_active_force(&cut->joint, &tau));
    }
    if (boundary->floating) {
        TFA_V(cut_forces_solve)(scan, ground);
    } else {
        TFA_V(scan_inward)(scan);
        TFA_V(scan_outward)(scan, ground);
    }
    put_inputs(scan, boundary);
}

int TFA_V(segment_scan_correct)(struct scan *scan, struct tfa_segment_boundary *boundary)
{
    int valid = 1;
    for (uint32_t k = 0; k < boundary->count; k++)
        scan->segment[k].a_end = fetch_vector(boundary->a_end, k);
    if (boundary->floating)
        valid = TFA_V(cut_forces_close_gaps)(scan);
    else
        TFA_V(scan_close_gaps)(scan);
    put_inputs(scan, boundary);
    return valid;
}

size_t TFA_V(segment_scan_bytes)(void)
{
    return TFA_V(scan_with_cuts_bytes)(0, TFA_SEGMENTS_MAX);
}
