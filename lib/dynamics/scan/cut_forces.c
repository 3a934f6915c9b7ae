/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The constraint force algorithm over the segments of a chain.
 */
#include "dynamics/scan/cut_forces.h"

#include "model/arena.h"

static size_t layout(void *memory, size_t segments, struct cut_forces **out)
{
    struct arena a = {memory, 0};
    struct cut_forces *x = arena_alloc(&a, 1, sizeof *x);
    struct cut *cut = arena_alloc(&a, segments, sizeof *cut);
    struct cyclic_row *system = arena_alloc(&a, segments, sizeof *system);
    if (x)
        *x = (struct cut_forces){.cut = cut, .system = system};
    *out = x;
    return a.used;
}

size_t TFA_V(cut_forces_bytes)(size_t segments)
{
    struct cut_forces *none;
    return layout(NULL, segments, &none);
}

struct cut_forces *TFA_V(cut_forces_layout)(void *memory, size_t segments)
{
    struct cut_forces *x;
    (void)layout(memory, segments, &x);
    return x;
}

/* ---- factors ---- */

/* AP = A P, and A P A^T + C */
static sym6 compliance_of_end(const struct scan_element *x, const num *P, num *AP)
{
    num sum[36];
    m6_mul(AP, x->A, P);
    for (int i = 0; i < 6; i++)
        for (int j = 0; j <= i; j++)
            sum[6 * i + j] = sum[6 * j + i] =
                x->C[6 * i + j] + dense_dot(AP + 6 * i, x->A + 6 * j, 6);
    return s6_from_dense(sum);
}

/* X M, column by column */
static void motions_to_child(const xform *X, num *M)
{
    for (int j = 0; j < 6; j++) {
        num column[6];
        for (int e = 0; e < 6; e++)
            column[e] = M[6 * e + j];
        sv_store(column, xform_motion(X, sv_from(column)));
        for (int e = 0; e < 6; e++)
            M[6 * e + j] = column[e];
    }
}

/* S_kk and S_{k,k-1} */
static void assemble(const struct scan *scan, uint32_t k)
{
    const struct cut *cut = &scan->cuts->cut[k];
    struct cyclic_row *row = &scan->cuts->system[k];
    num G[36];
    num AP[36];
    row->size = cfa_size(&cut->joint);
    const sym6 end = k > 1 ? compliance_of_end(&scan->segment[k - 1].at, cut[-1].P, AP)
                           : s6_from_dense(scan->segment[0].at.C);
    const sym6 end_here = s6_inv_to_child(&cut->X, &end);
    if (k > 1) {
        motions_to_child(&cut->X, AP);
        for (int e = 0; e < 36; e++)
            AP[e] = -AP[e];
        cfa_project(&cut->joint, AP, AP, 6);
        cfa_project_columns(&cut[-1].joint, AP, row->L);
    }
    s6_dense(G, &end_here);
    for (int e = 0; e < 36; e++)
        G[e] += cut->P[e];
    cfa_project_columns(&cut->joint, G, G);
    cfa_project(&cut->joint, G, row->D.a, (int)row->size);
}

/* Factors of J and P = J^-1. Returns 0 where J is not positive definite. */
static int invert(const num *J, struct cut *cut)
{
    int positive = 1;
    for (int e = 0; e < 36; e++) {
        cut->J[e] = J[e];
        cut->P[e] = num_of(e % 7 == 0);
    }
    ldl6_factor(cut->J);
    for (int e = 0; e < 6; e++) {
        positive &= num_all(cut->J[7 * e] > 0);
        ldl6_solve(cut->J, cut->P + 6 * e);
    }
    return positive;
}

int TFA_V(cut_forces_factor)(const struct scan *scan, uint32_t *singular)
{
    struct cut_forces *x = scan->cuts;
    for (uint32_t k = 1; k < scan->segments; k++) {
        *singular = k;
        if (!invert(scan->segment[k].at.J, &x->cut[k]))
            return 0;
        assemble(scan, k);
    }
    if (x->tolerance > 0)
        conjugate_factor(x->system + 1, scan->segments - 1);
    else
        cyclic_factor(x->system + 1, scan->segments - 1, CYCLIC_SYMMETRIC);
    return 1;
}

/* ---- solve ---- */

/* J^-1 f by the factors: forces balance to rounding, which with P, whose error is the same in all
 * directions, those of a segment that starts on a light body do not */
static svec segment_acceleration(const struct cut *cut, svec f)
{
    num x[6];
    sv_store(x, f);
    ldl6_solve(cut->J, x);
    return sv_from(x);
}

/* a1 and a2 of segment k by the forces f of the cuts; a1 of the first: that of the ground; *out:
 * f2 */
static void accelerations(const struct scan *scan, uint32_t k, svec *a1, svec *a2, svec *out)
{
    const struct scan_segment *segment = &scan->segment[k];
    const struct cut *cut = &scan->cuts->cut[k];
    const int last = k + 1 == scan->segments;
    *out = last ? sv_zero() : xform_t_force(&cut[1].X, sv_from(cut[1].f));
    if (k > 0) {
        svec f = sv_sub(sv_from(cut->f), segment->g);
        if (!last)
            f = sv_sub(f, m6_times_t(segment->at.A, *out));
        *a1 = segment_acceleration(cut, f);
    }
    if (last)
        return;
    *a2 = sv_sub(m6_times(segment->at.A, *a1), m6_times(segment->at.C, *out));
    *a2 = sv_add(*a2, segment->v);
}

/* Of conjugate gradients: the gaps that the forces leave open are closed to this part of them. */
#define GAPS_TOLERANCE 0x1p-24
/* Larger gaps, beside the accelerations at the cuts, tell of a system without digits. Ordinary
 * chains of up to 1024 bodies leave 2e-4 at most; neighbours of masses 1 : 1e12 leave 0.6, and
 * qdd has three digits then (torques of a random qdd, 2026-11-27). */
#define GAPS_MAX 1e-3

static void solve_system(struct cut_forces *x, uint32_t segments, num tolerance)
{
    if (x->tolerance > 0) {
        x->iterations = conjugate_solve(x->system + 1, segments - 1, tolerance);
        x->failed |= x->iterations < 0;
    } else {
        cyclic_solve(x->system + 1, segments - 1, CYCLIC_SYMMETRIC, 1);
    }
    for (uint32_t k = 1; k < segments; k++)
        cfa_add_constraint_force(&x->cut[k].joint, x->system[k].x, x->cut[k].f);
}

/* X^-1 W (W^T W)^-1 W^T r: the part of a motion that the joint does not allow, before it. The
 * columns of W are orthogonal. */
static svec forbidden_motion(const struct cut *cut, svec r)
{
    svec m = sv_zero();
    for (uint32_t j = 0; j < cfa_size(&cut->joint); j++) {
        const svec w = sv_from(cut->joint.basis + 6 * j);
        m = sv_add_scaled(m, w, sv_dot(w, r) / sv_dot(w, w));
    }
    const vec3 w = m3_tmul(cut->X.E, m.w);
    return (svec){w, v3_add(m3_tmul(cut->X.E, m.v), v3_cross(cut->X.r, w))};
}

/* Segments start from the acceleration that their own balance of forces gives, of which the joint
 * at the cut moves them only along the constrained directions: a heavy segment on a light end has
 * digits there that the end has not. */
static void solve(struct scan *scan, svec ground, num tolerance)
{
    struct cut_forces *x = scan->cuts;
    svec before, a1 = ground, a2, out;
    accelerations(scan, 0, &a1, &before, &out);
    for (uint32_t k = 1; k < scan->segments; k++) {
        const struct cut *cut = &x->cut[k];
        accelerations(scan, k, &a1, &a2, &out);
        const svec gap = sv_sub(sv_add(xform_motion(&cut->X, before), cut->c), a1);
        for (uint32_t e = 0; e < cfa_size(&cut->joint); e++)
            x->system[k].x[e] = sv_dot(sv_from(cut->joint.basis + 6 * e), gap);
        before = a2;
    }
    solve_system(x, scan->segments, tolerance);
    scan->segment[0].a_in = a1 = ground;
    accelerations(scan, 0, &a1, &before, &scan->segment[0].f_out);
    for (uint32_t k = 1; k < scan->segments; k++) {
        const struct cut *cut = &x->cut[k];
        struct scan_segment *segment = &scan->segment[k];
        accelerations(scan, k, &a1, &a2, &segment->f_out);
        const svec rest = sv_sub(sv_sub(a1, xform_motion(&cut->X, before)), cut->c);
        segment->a_in = sv_add(before, forbidden_motion(cut, rest));
        before = a2;
    }
}

void TFA_V(cut_forces_solve)(struct scan *scan, svec ground)
{
    scan->cuts->failed = 0;
    solve(scan, ground, scan->cuts->tolerance);
}

int TFA_V(cut_forces_close_gaps)(struct scan *scan)
{
    struct cut_forces *x = scan->cuts;
    num gaps = num_of(0), size = num_of(0);
    for (uint32_t k = 0; k < scan->segments; k++) {
        struct scan_segment *segment = &scan->segment[k];
        segment->g = x->cut[k].c = sv_zero();
        sv_store(x->cut[k].f, sv_zero());
        if (k + 1 == scan->segments)
            break;
        segment->v = sv_sub(segment->a_end, segment[1].a_in);
        gaps += sv_dot(segment->v, segment->v);
        size += sv_dot(segment->a_end, segment->a_end);
    }
    x->failed |= !num_all(gaps <= size * num_of(GAPS_MAX * GAPS_MAX));
    solve(scan, sv_zero(), (num)GAPS_TOLERANCE);
    return !x->failed;
}
