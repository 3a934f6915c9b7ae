/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The segment scan inside one segment: the articulated-body recursion carrying six more forces,
 * unit forces at its end. Per body, and right-hand sides after it:
 *
 *   psi = H^T P,  C += psi^T D^-1 psi,  P_parent = X^T (P - U D^-1 psi)          A = P^T at last
 *   v += P^T (c + H D^-1 (u - U^T c)),  qdd = D^-1 (u - U^T a' - psi f_out)
 */
#include "dynamics/core/aba_step.h"
#include "dynamics/core/modes.h"
#include "dynamics/osim/lambda.h"
#include "dynamics/scan/scan.h"

/* Bodies beyond the end whose inertia a segment takes into account from the start. Without, one
 * pass had up to 16 times the error of ABA (median 2.5), with 1 up to 8 (1.7), with 2 up to 4
 * (1.4), with 3 the same; each costs a thirtieth of the factors. 12 mechanisms, N 24 to 256, 8
 * seeds each, 2026-11-21. */
#define OVERLAP 2u
/* A joint that moves less than this share of the moments across it has rounding for its inertia. */
#define MOMENT_RATIO_MIN 1e-3

/* P to the parent through a joint with one freedom, along component `axis` */
static inline void propagate_unit_forces_1dof(const struct state *s, uint32_t i, int axis,
                                              svec P[6], num *C)
{
    const xform X = s->X[i];
    const svec U = s->U[i];
    num psi[6], phi[6];
    for (int e = 0; e < 6; e++) {
        psi[e] = sv_get(&P[e], axis);
        phi[e] = s->Dinv[i] * psi[e];
        P[e] = sv_sub(P[e], sv_scale(U, phi[e]));
        sv_put(&P[e], axis, (num)s->body[i].armature * phi[e]); /* psi - D phi is rounding */
        P[e] = xform_t_force(&X, P[e]);
    }
    m6_add_outer_upper(C, psi, phi);
}

/* Out of the modes of the body at place k, if it is flexible: P from the handle to the body */
static inline void propagate_through_modes(struct state *s, const struct tfa_chain *chain,
                                           uint32_t k, svec P[6], num *C)
{
    const uint32_t i = chain->body[k];
    const int32_t handle = handle_of_next(s, chain, k);
    if (s->body[i].flexible < 0)
        return;
    num *psi = s->modal[s->body[i].flexible].psi, phi[6 * TFA_MAX_LINK_MODES];
    const uint32_t n = TFA_V(modes_propagate)(s, i, handle, P, psi, phi);
    for (uint32_t j = 0; j < n; j++)
        m6_add_outer_upper(C, psi + 6 * j, phi + 6 * j);
}

/* Inward through one body: P to its parent, C grows. */
static inline void propagate_unit_forces(const struct state *s, uint32_t i, struct scan_body *row,
                                         svec P[6], num *C)
{
    const struct tfa_body *b = &s->body[i];
    for (int e = 0; e < 6; e++)
        row->P[e] = P[e];
    if (is_revolute(b->kind)) {
        propagate_unit_forces_1dof(s, i, AXIS_RZ, P, C);
    } else if (is_prismatic(b->kind)) {
        propagate_unit_forces_1dof(s, i, AXIS_TZ, P, C);
    } else {
        struct wrench_columns w = wrench_columns_from(P);
        vec6 psi[6], phi[6];
        TFA_V(propagate_through_joint)(s, (int32_t)i, 6, &w, psi, phi);
        wrench_columns_store(&w, P);
        for (uint32_t k = 0; k < b->n; k++) {
            num left[6], right[6];
            vec6_store(left, &psi[k]);
            vec6_store(right, &phi[k]);
            m6_add_outer_upper(C, left, right);
        }
    }
}

/* What the next OVERLAP bodies beyond the end put on it, with nothing beyond them: never more than
 * the inertia outboard of the cut. A joint with several freedoms, one that moves little inertia by
 * itself, and a flexible body are taken to pass nothing on. */
static void overlap(const struct state *s, const struct tfa_chain *chain, const struct scan *scan,
                    uint32_t end, sym6 *G)
{
    const sym6 none = {{0, 0, 0, 0, 0, 0}, {0, 0, 0, 0, 0, 0, 0, 0, 0}, {0, 0, 0, 0, 0, 0}};
    uint32_t k = chain->length - end <= OVERLAP ? chain->length : end + OVERLAP;
    *G = none;
    while (k-- > end) {
        const struct tfa_body *b = &s->body[chain->body[k]];
        sym6 IA = scan->body[k].I;
        s6_add(&IA, G);
        *G = none;
        if (b->n > 1 || b->flexible >= 0)
            continue;
        const svec U = s6_column(&IA, body_axis(b));
        const num D = sv_get(&U, body_axis(b)) + (num)b->armature;
        if (is_revolute(b->kind) && !(D > (IA.A.xx + IA.A.yy) * (num)MOMENT_RATIO_MIN))
            continue;
        s6_rank1(&IA, U, 1 / D);
        *G = s6_to_parent(&s->X[chain->body[k]], &IA);
    }
}

/* Inertias of the segment's bodies; the last one includes the known part of the outboard inertia */
static void start_inertias(struct state *s, const struct tfa_chain *chain, const struct scan *scan,
                           struct scan_segment *segment, const num *outer)
{
    sym6 seed;
    for (uint32_t k = segment->first; k < segment->end; k++) {
        s->IA[chain->body[k]] = scan->body[k].I;
        if (s->body[chain->body[k]].flexible >= 0)
            TFA_V(modes_restore_body)(s, chain->body[k]);
    }
    if (segment->end == chain->length)
        return;
    if (scan->cuts)
        seed = s6_zero();
    else if (outer)
        seed = s6_from_dense(outer);
    else
        overlap(s, chain, scan, segment->end, &seed);
    s6_add(&s->IA[chain->body[segment->end - 1]], &seed);
    const int32_t handle = handle_of_next(s, chain, segment->end - 1);
    if (handle >= 0)
        TFA_V(modes_add_inertia)(s, handle, &seed);
    s6_dense(segment->seed, &seed);
}

/* Whether its element leaves out its first joint (cut_forces.h) */
static int segment_floats(const struct scan *scan, const struct scan_segment *segment)
{
    return scan->cuts && segment->first > 0;
}

void TFA_V(scan_segment_factor)(struct state *s, const struct tfa_chain *chain, struct scan *scan,
                                struct scan_segment *segment, const num *outer)
{
    const int last = segment->end == chain->length, floats = segment_floats(scan, segment);
    const uint32_t first = chain->body[segment->first];
    struct scan_element *x = &segment->at;
    sym6 whole = s->IA[first];
    svec P[6];
    num of_cut[36], *C = x->C;
    for (int e = 0; e < 36; e++)
        x->C[e] = x->J[e] = of_cut[e] = 0;
    for (int e = 0; e < 6; e++) {
        P[e] = sv_zero();
        sv_put(&P[e], e, 1);
    }
    start_inertias(s, chain, scan, segment, outer);
    for (uint32_t k = segment->end; k-- > segment->first;) {
        const uint32_t i = chain->body[k];
        modes_eliminate(s, i, ABA_INERTIA);
        if (!last)
            propagate_through_modes(s, chain, k, P, C);
        if (i == first) {
            whole = s->IA[i];
            C = floats ? of_cut : C;
            aba_backward_step(s, i, NULL, ABA_INERTIA | ABA_DETACH);
        } else {
            aba_backward_step(s, i, NULL, ABA_INERTIA | ABA_MODES);
        }
        if (!last)
            propagate_unit_forces(s, i, &scan->body[k], P, C);
    }
    if (floats)
        s6_dense(x->J, &whole);
    else if (s->body[first].parent >= 0)
        s6_dense(x->J, &s->IA[first]);
    s->IA[first] = whole; /* the forces want it */
    for (int e = 0; e < 6; e++) {
        sv_store(x->A + 6 * e, floats ? scan->body[segment->first].P[e] : P[e]);
        for (int f = 0; f < e; f++)
            x->C[6 * e + f] = x->C[6 * f + e];
    }
}

/* v += P^T (c + H x),  x = D^-1 (u - U^T c): motion of the end by that of the joint */
static inline void add_motion(const struct state *s, uint32_t i, const struct scan_body *row,
                              int products, num *v)
{
    const struct tfa_body *b = &s->body[i];
    svec m = products ? s->c[i] : sv_zero();
    num x[6] = {0};
    if (b->n == 1) {
        x[0] = s->Dinv[i] * (products ? s->u[i] - sv_dot(s->U[i], m) : s->u[i]);
    } else {
        const struct joint_nd *w = &s->joint_nd[b->joint_nd];
        for (uint32_t k = 0; k < b->n; k++)
            x[k] = w->u[k] - sv_dot(sv_from(w->U + 6 * k), m);
        ldl_solve(w->L, b->n, x);
    }
    if (b->n == 1 && !products) {
        for (int e = 0; e < 6; e++)
            v[e] += (is_revolute(b->kind) ? row->P[e].w.z : row->P[e].v.z) * x[0];
        return;
    }
    add_joint_motion(s, b, x, &m);
    for (int e = 0; e < 6; e++)
        v[e] += sv_dot(row->P[e], m);
}

/* The same of modes: v += psi^T D^-1 u */
static inline void add_motion_of_modes(const struct state *s, uint32_t i, num *v)
{
    const int32_t flexible = s->body[i].flexible;
    if (flexible < 0)
        return;
    const struct modal_body *w = &s->modal[flexible];
    num x[TFA_MAX_LINK_MODES];
    const uint32_t n = TFA_V(modes_solve)(s, i, x);
    for (uint32_t k = 0; k < n; k++)
        for (int e = 0; e < 6; e++)
            v[e] += w->psi[6 * k + (uint32_t)e] * x[k];
}

static inline void inward(struct state *s, const struct tfa_chain *chain, const struct scan *scan,
                          struct scan_segment *segment, const num *tau, int flags)
{
    const int last = segment->end == chain->length, floats = segment_floats(scan, segment);
    const uint32_t first = chain->body[segment->first];
    svec g = sv_zero();
    num v[6] = {0};
    for (uint32_t k = segment->end; k-- > segment->first;) {
        const uint32_t i = chain->body[k];
        modes_eliminate(s, i, flags);
        if (!last)
            add_motion_of_modes(s, i, v);
        if (i == first) {
            g = s->pA[i];
            aba_backward_step(s, i, tau, flags | ABA_DETACH);
        } else {
            aba_backward_step(s, i, tau, flags);
        }
        if (!last && !(floats && i == first))
            add_motion(s, i, &scan->body[k], flags & ABA_BIAS, v);
    }
    segment->v = sv_from(v);
    if (!floats)
        g = s->body[first].parent >= 0 ? s->pA[first] : sv_zero();
    segment->g = g;
}

void TFA_V(scan_segment_inward)(struct state *s, const struct tfa_chain *chain, struct scan *scan,
                                struct scan_segment *segment, const num *tau, int bias)
{
    if (chain_has_velocity_products(s, bias))
        inward(s, chain, scan, segment, tau, ABA_FORCE | ABA_BIAS | ABA_MODES);
    else
        inward(s, chain, scan, segment, tau, ABA_FORCE | ABA_MODES);
}

/* u -= psi f: the part of tau that the force passed on takes */
static inline void subtract_force(struct state *s, uint32_t i, const struct scan_body *row, svec f)
{
    const struct tfa_body *b = &s->body[i];
    num fe[6], x[6];
    svec force = sv_zero();
    sv_store(fe, f);
    for (uint32_t k = 0; b->flexible >= 0 && k < s->m->flexible[b->flexible].n; k++)
        for (uint32_t e = 0; e < 6; e++)
            s->modal[b->flexible].u[k] -= s->modal[b->flexible].psi[6 * k + e] * fe[e];
    if (b->n == 1) {
        for (int e = 0; e < 6; e++)
            s->u[i] -= (is_revolute(b->kind) ? row->P[e].w.z : row->P[e].v.z) * fe[e];
        return;
    }
    for (int e = 0; e < 6; e++)
        force = sv_add(force, sv_scale(row->P[e], fe[e]));
    joint_force(s, b, force, x);
    for (uint32_t k = 0; k < b->n; k++)
        s->joint_nd[b->joint_nd].u[k] -= x[k];
}

void TFA_V(scan_segment_outward)(struct state *s, const struct tfa_chain *chain, struct scan *scan,
                                 struct scan_segment *segment, num *qdd, int bias)
{
    const int last = segment->end == chain->length;
    svec a = segment->a_in;
    for (uint32_t k = segment->first; k < segment->end; k++) {
        const uint32_t i = chain->body[k];
        if (!last)
            subtract_force(s, i, &scan->body[k], segment->f_out);
        aba_forward_step(s, i, a, qdd, chain_has_velocity_products(s, bias));
        modes_forward(s, i, qdd);
        a = modes_at_handle(s, handle_of_next(s, chain, k), s->a[i], qdd);
    }
    segment->a_end = a;
}

static inline void clear_force(struct state *s, uint32_t i)
{
    const struct tfa_body *b = &s->body[i];
    if (b->n == 1)
        s->u[i] = 0;
    for (uint32_t k = 0; b->flexible >= 0 && k < s->m->flexible[b->flexible].n; k++)
        s->modal[b->flexible].u[k] = 0;
    for (uint32_t k = 0; b->n > 1 && k < b->n; k++)
        s->joint_nd[b->joint_nd].u[k] = 0;
}

void TFA_V(scan_segment_correct)(struct state *s, const struct tfa_chain *chain, struct scan *scan,
                                 const struct scan_segment *segment, num *qdd)
{
    const int last = segment->end == chain->length;
    svec da = segment->a_in;
    for (uint32_t k = segment->first; k < segment->end; k++) {
        const uint32_t i = chain->body[k];
        const struct tfa_body *b = &s->body[i];
        const svec a = s->a[i];
        const struct tfa_flexible *f = b->flexible < 0 ? NULL : &s->m->flexible[b->flexible];
        num before[6], modes_before[TFA_MAX_LINK_MODES];
        for (uint32_t j = 0; j < b->n; j++)
            before[j] = qdd[b->v + j];
        for (uint32_t j = 0; f && j < f->n; j++)
            modes_before[j] = qdd[f->v + j];
        clear_force(s, i);
        if (!last)
            subtract_force(s, i, &scan->body[k], segment->f_out);
        aba_forward_step(s, i, da, qdd, 0);
        modes_forward(s, i, qdd);
        da = modes_at_handle(s, handle_of_next(s, chain, k), s->a[i], qdd);
        s->a[i] = sv_add(a, s->a[i]);
        for (uint32_t j = 0; j < b->n; j++)
            qdd[b->v + j] += before[j];
        for (uint32_t j = 0; f && j < f->n; j++)
            qdd[f->v + j] += modes_before[j];
    }
}
