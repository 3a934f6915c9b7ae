/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The segment scan with the segments of one chain in SIMD lanes: lane l of group g computes segment
 * g * lanes + l, all lanes step by step. Groups are independent of each other and go to the threads
 * of an executor; a kernel of one number at a time scans over the segments in between. Same
 * recursion as scan_segment.c, for revolute joints only, with what it needs from step to step in
 * registers.
 *
 *   open:    sines and poses; the velocity of each end while the body before rests
 *   velocities over the boundaries
 *   inward:  U, D, u, psi of every joint, and the element of every segment
 *   outward: accelerations, twice: each segment from its own, then the gaps at the boundaries
 */
#include "dynamics/scan/segment_boundary.h"

#include <float.h>
#include <string.h>

#include "dynamics/core/revolute.h"
#include "dynamics/simd/segment_lanes_layout.h"
#include "interface/parallel_for.h"
#include "spatial/dense.h"
#include "spatial/friction.h"

/* As in scan_segment.c. */
#define OVERLAP 2u
#define MOMENT_RATIO_MIN 1e-3
/* Below so many bodies for each lane one thread is faster than two (docs/tuning.md). */
#define THREADS_BODIES_MIN 64u

/* ---- between lanes and boundary arrays ---- */

static inline num *boundary_lanes(double *name, uint32_t g)
{
    return (num *)(void *)(name + (size_t)g * NUM_LANES);
}

#define BOUNDARY_STRIDE (TFA_SEGMENTS_MAX / NUM_LANES)

static inline void put_boundary(double *name, uint32_t g, const num *x, uint32_t numbers)
{
    num *to = boundary_lanes(name, g);
    for (uint32_t e = 0; e < numbers; e++)
        to[e * BOUNDARY_STRIDE] = x[e];
}

static inline void get_boundary(double *name, uint32_t g, num *x, uint32_t numbers)
{
    const num *from = boundary_lanes(name, g);
    for (uint32_t e = 0; e < numbers; e++)
        x[e] = from[e * BOUNDARY_STRIDE];
}

static inline svec get_boundary_vector(double *name, uint32_t g)
{
    num x[6];
    get_boundary(name, g, x, 6);
    return sv_from(x);
}

static inline void put_boundary_vector(double *name, uint32_t g, svec a)
{
    num x[6];
    sv_store(x, a);
    put_boundary(name, g, x, 6);
}

/* x <- new where m says so */
static inline void select_lanes(num_mask m, num *x, const num *new, uint32_t numbers)
{
    for (uint32_t e = 0; e < numbers; e++)
        x[e] = num_select(m, new[e], x[e]);
}

/* ---- open ---- */

static void load_request(struct segment_lanes *s, uint32_t g)
{
    const tfa_request *r = s->request;
    const size_t n = s->m->v_count, first = (size_t)g * s->steps;
    const double *q = r->q + n * s->state, *qd = s->moving ? r->v + n * s->state : NULL,
                 *tau = r->tau ? r->tau + n * s->state : NULL;
    for (size_t t = first; t < first + s->steps; t++) {
        const struct body_constants *body_constants = &s->body_constants[t];
        s->q[t] = num_gather(q, 1, body_constants->from);
        s->qd[t] = qd ? num_gather(qd, 1, body_constants->from) : num_of(0);
        s->tau[t] = (tau ? num_gather(tau, 1, body_constants->from) : num_of(0)) -
                    body_constants->damping * s->qd[t];
    }
    for (size_t t = first; s->m->friction && t < first + s->steps; t++)
        s->tau[t] -= s->body_constants[t].friction *
                     friction_sign(s->qd[t], num_of(s->m->friction_velocity));
    num_sincos_many(s->q, s->sine, s->cosine, first, first + s->steps);
}

static inline sym6 body_inertia(const struct body_constants *b)
{
    const num o = num_of(0);
    return (sym6){b->I,
                  {o, -b->h.z, b->h.y, b->h.z, o, -b->h.x, -b->h.y, b->h.x, o},
                  {b->mass, o, o, b->mass, o, b->mass}};
}

/* Inertia of the first bodies of each segment on the end of the one before: scan_segment.c */
static void overlap(struct segment_lanes *s, uint32_t g)
{
    const size_t first = (size_t)g * s->steps;
    const num o = num_of(0);
    const sym6 none = {{o, o, o, o, o, o}, {o, o, o, o, o, o, o, o, o}, {o, o, o, o, o, o}};
    sym6 G = none;
    num dense[36];
    for (size_t t = first + OVERLAP; t-- > first;) {
        sym6 IA = body_inertia(&s->body_constants[t]);
        s6_add(&IA, &G);
        const svec U = revolute_U(&IA), k = revolute_gain(U, 1 / IA.A.zz);
        const num_mask has_velocity = IA.A.zz > (IA.A.xx + IA.A.yy) * num_of(MOMENT_RATIO_MIN);
        const sym6 Ia = revolute_project(&IA, U, k);
        G = s6_to_parent_zero_z(&s->step[t].X, &Ia);
        select_lanes(~has_velocity, &G.A.xx, &none.A.xx, sizeof G / sizeof(num));
    }
    s6_dense(dense, &G);
    for (uint32_t lane = 0; lane < NUM_LANES; lane++) {
        const uint32_t k = g * NUM_LANES + lane;
        for (uint32_t e = 0; k > 0 && e < 36; e++)
            s->boundary->seed[e * TFA_SEGMENTS_MAX + k - 1] = num_lane(dense[e], lane);
    }
}

/* Poses, and with velocities where each end stands and how it moves while the body before rests:
 * the sum of the joints' motions in the frame of the body before, joint axis row z of E. */
static inline void kinematics(struct segment_lanes *s, uint32_t g, int moving)
{
    const size_t first = (size_t)g * s->steps;
    const num o = num_of(0), l = num_of(1);
    struct {
        xform X;
        svec v;
    } at = {{{l, o, o, o, l, o, o, o, l}, {o, o, o}}, sv_zero()}, end = at;
    load_request(s, g);
    for (uint32_t t = 0; t < s->steps; t++) {
        const struct body_constants *b = &s->body_constants[first + t];
        const xform X = {revolute_rotate(b->E, s->sine[first + t], s->cosine[first + t]), b->r};
        s->step[first + t].X = X;
        if (!moving)
            continue;
        at.X.r = v3_add(at.X.r, m3_tmul(at.X.E, X.r));
        at.X.E = m3_mm(X.E, at.X.E);
        const vec3 w = v3_scale(v3(at.X.E.zx, at.X.E.zy, at.X.E.zz), s->qd[first + t]);
        at.v = sv_add(at.v, (svec){w, v3_cross(at.X.r, w)});
        if (t + 1 >= s->cut.shortest)
            select_lanes(s->length[g] == num_of(t + 1), &end.X.E.xx, &at.X.E.xx,
                         sizeof at / sizeof(num));
    }
    if (moving) {
        put_boundary(s->boundary->E, g, &end.X.E.xx, 9);
        put_boundary(s->boundary->r, g, &end.X.r.x, 3);
        put_boundary_vector(s->boundary->v_end, g, xform_motion(&end.X, end.v));
    }
    if (!s->boundary->floating)
        overlap(s, g);
}

static void kinematics_task(void *context, uint32_t part, uint32_t worker)
{
    struct segment_lanes *s = context;
    (void)worker;
    if (s->moving)
        kinematics(s, part, 1);
    else
        kinematics(s, part, 0);
}

/* ---- inward ---- */

/* v_i = X_i v_{i-1} + H_i qd_i from v_in, which is known but for the rounding of E, r */
static void velocities(struct segment_lanes *s, uint32_t g)
{
    const size_t first = (size_t)g * s->steps;
    svec v = get_boundary_vector(s->boundary->v_in, g), end = v;
    for (uint32_t t = 0; t < s->steps; t++) {
        v = xform_motion(&s->step[first + t].X, v);
        v.w.z += s->qd[first + t];
        s->step[first + t].v = v;
        if (t + 1 >= s->cut.shortest)
            select_lanes(s->length[g] == num_of(t + 1), &end.w.x, &v.w.x, 6);
    }
    put_boundary_vector(s->boundary->v_end, g, end);
}

static void velocities_task(void *context, uint32_t part, uint32_t worker)
{
    (void)worker;
    velocities(context, part);
}

/* The error of v_in applies to all bodies of the segment. */
static inline void correct_velocities(struct segment_lanes *s, uint32_t g)
{
    const size_t first = (size_t)g * s->steps;
    svec dv = get_boundary_vector(s->boundary->dv_in, g);
    for (size_t t = first; t < first + s->steps; t++) {
        dv = xform_motion(&s->step[t].X, dv);
        s->step[t].v = sv_add(s->step[t].v, dv);
    }
}

/* Carried inward from step to step */
struct inward_carry {
    sym6 IA; /* contribution of the outboard bodies */
    svec pA;
    svec P[6]; /* force on it for each unit of the force that the segment passes on */
    num C[36]; /* upper triangle: compliance of the end */
    num a[6];  /* acceleration of the end without a_in and f_out */
};

/* The inward pass of a segment begins at its end: the inertia that is known to be outboard, and
 * the unit forces */
static void inward_start(struct segment_lanes *s, uint32_t g, struct inward_carry *w)
{
    num seed[36];
    memset(w, 0, sizeof *w);
    if (!s->boundary->floating) {
        get_boundary(s->boundary->seed, g, seed, 36);
        w->IA = s6_from_dense(seed);
    }
    for (int e = 0; e < 6; e++)
        sv_put(&w->P[e], e, num_of(1));
}

/* Through one joint; the factors are stored in x. */
static inline void through_joint(const struct body_constants *b, struct step *x, num tau, num qd,
                                 struct inward_carry *w, num *margin, int moving)
{
    const xform X = x->X;
    sym6 IA = body_inertia(b);
    svec c = sv_zero(), pA = w->pA;
    s6_add(&IA, &w->IA);
    if (moving) {
        pA = sv_add(s6_rigid_bias(b->I, b->h, b->mass, x->v), pA);
        c = revolute_velocity_product(x->v, qd);
    }
    const svec U = revolute_U(&IA);
    const num Dinv = 1 / IA.A.zz, u = tau - pA.w.z;
    *margin = sentinel_smaller(*margin, sentinel_margin(IA.A.zz, s3_trace(IA.A) + b->outboard));
    const svec k = revolute_gain(U, Dinv);
    const sym6 Ia = revolute_project(&IA, U, k);
    x->U = U;
    x->Dinv = Dinv;
    x->u = u;
    pA = revolute_force(pA, k, u);
    num qdd = Dinv * u;
    if (moving) {
        pA = revolute_add_bias(pA, &Ia, c);
        qdd -= k.w.x * c.w.x + k.w.y * c.w.y + k.v.x * c.v.x + k.v.y * c.v.y;
    }
    w->pA = xform_t_force(&X, pA);
    w->IA = s6_to_parent_zero_z(&X, &Ia);
    num psi[6], phi[6];
    for (int e = 0; e < 6; e++) {
        svec P = w->P[e];
        psi[e] = x->psi[e] = P.w.z;
        phi[e] = Dinv * psi[e];
        w->a[e] += psi[e] * qdd;
        if (moving)
            w->a[e] += P.w.x * c.w.x + P.w.y * c.w.y + P.v.x * c.v.x + P.v.y * c.v.y;
        P = sv_sub(P, sv_scale(U, phi[e]));
        P.w.z = num_of(0); /* psi - D phi is rounding */
        w->P[e] = xform_t_force(&X, P);
    }
    m6_add_outer_upper(w->C, psi, phi);
}

/* The element of a segment, to which the bodies of w belong */
static inline void put_element(struct segment_lanes *s, uint32_t g, const struct inward_carry *w)
{
    num dense[36];
    s6_dense(dense, &w->IA);
    put_boundary(s->boundary->J, g, dense, 36);
    put_boundary(s->boundary->C, g, w->C, 36);
    put_boundary(s->boundary->a_end, g, w->a, 6);
    put_boundary_vector(s->boundary->g, g, w->pA);
    for (uint32_t e = 0; e < 6; e++)
        sv_store(dense + 6 * e, w->P[e]);
    put_boundary(s->boundary->A, g, dense, 36);
}

/* The same of one that floats: with its first body, without that body's joint */
static inline void put_floating(struct segment_lanes *s, uint32_t g, struct inward_carry w,
                                int moving)
{
    const size_t first = (size_t)g * s->steps;
    const struct body_constants *b = &s->body_constants[first];
    const struct step *x = &s->step[first];
    const sym6 I = body_inertia(b);
    svec c = sv_zero();
    s6_add(&w.IA, &I);
    if (moving) {
        w.pA = sv_add(w.pA, s6_rigid_bias(b->I, b->h, b->mass, x->v));
        c = revolute_velocity_product(x->v, s->qd[first]);
    }
    put_element(s, g, &w);
    put_boundary(s->boundary->cut_E, g, &x->X.E.xx, 9);
    put_boundary(s->boundary->cut_r, g, &x->X.r.x, 3);
    put_boundary_vector(s->boundary->cut_c, g, c);
    put_boundary(s->boundary->cut_tau, g, &s->tau[first], 1);
}

/* The first segment is the only one that does not float. */
static inline void put_grounded(struct segment_lanes *s, const struct inward_carry *w)
{
    for (uint32_t e = 0; e < 36; e++)
        s->boundary->C[e * TFA_SEGMENTS_MAX] = num_lane(w->C[e], 0);
    for (uint32_t e = 0; e < 6; e++) {
        num P[6];
        sv_store(P, w->P[e]);
        s->boundary->a_end[e * TFA_SEGMENTS_MAX] = num_lane(w->a[e], 0);
        for (uint32_t f = 0; f < 6; f++)
            s->boundary->A[(6 * e + f) * TFA_SEGMENTS_MAX] = num_lane(P[f], 0);
    }
}

static inline void inward(struct segment_lanes *s, uint32_t g, int moving)
{
    const size_t first = (size_t)g * s->steps;
    struct inward_carry w, fresh;
    num margin = num_of(1);
    if (moving && !s->second_pass)
        correct_velocities(s, g);
    inward_start(s, g, &fresh);
    w = fresh;
    for (uint32_t t = s->steps; t-- > 0;) {
        if (t + 1 >= s->cut.shortest && t + 1 < s->steps)
            select_lanes(s->length[g] == num_of(t + 1), &w.IA.A.xx, &fresh.IA.A.xx,
                         sizeof w / sizeof(num));
        if (t == 0 && s->boundary->floating)
            put_floating(s, g, w, moving);
        through_joint(&s->body_constants[first + t], &s->step[first + t], s->tau[first + t],
                      s->qd[first + t], &w, &margin, moving);
    }
    s->margin[g] = margin;
    if (!s->boundary->floating)
        put_element(s, g, &w);
    else if (g == 0)
        put_grounded(s, &w);
}

static __attribute__((flatten)) void inward_task(void *context, uint32_t part, uint32_t worker)
{
    struct segment_lanes *s = context;
    (void)worker;
    if (s->moving)
        inward(s, part, 1);
    else
        inward(s, part, 0);
}

/* ---- outward ---- */

/* Every lane's acceleration to its place */
static inline void store_qdd(const struct segment_lanes *s, uint32_t g, uint32_t t, num x)
{
    const struct body_constants *b = &s->body_constants[(size_t)g * s->steps + t];
    double *out = s->reply->qdd + (size_t)s->m->v_count * s->state;
    for (uint32_t lane = 0; lane < NUM_LANES; lane++)
        if (t < s->cut.shortest || t < s->cut.length[g * NUM_LANES + lane])
            out[b->from[lane]] = num_lane(x, lane);
}

static inline void outward(struct segment_lanes *s, uint32_t g, int moving)
{
    const size_t first = (size_t)g * s->steps;
    svec a = get_boundary_vector(s->boundary->a_in, g), end = a;
    num f[6];
    get_boundary(s->boundary->f_out, g, f, 6);
    for (uint32_t t = 0; t < s->steps; t++) {
        struct step *x = &s->step[first + t];
        num u = x->u;
        a = xform_motion(&x->X, a);
        if (moving)
            a = sv_add(a, revolute_velocity_product(x->v, s->qd[first + t]));
        for (int e = 0; e < 6; e++)
            u -= x->psi[e] * f[e];
        x->u = x->Dinv * (u - sv_dot(x->U, a)); /* qdd from here on */
        a.w.z += x->u;
        if (t + 1 >= s->cut.shortest)
            select_lanes(s->length[g] == num_of(t + 1), &end.w.x, &a.w.x, 6);
    }
    put_boundary_vector(s->boundary->a_end, g, end);
}

static void outward_task(void *context, uint32_t part, uint32_t worker)
{
    struct segment_lanes *s = context;
    (void)worker;
    if (s->moving)
        outward(s, part, 1);
    else
        outward(s, part, 0);
}

/* Corrections of a_in and f_out, applied to all bodies of the segment */
static void correct(struct segment_lanes *s, uint32_t g)
{
    const size_t first = (size_t)g * s->steps;
    svec da = get_boundary_vector(s->boundary->a_in, g);
    num f[6];
    num_mask finite = num_of(0) == num_of(0);
    get_boundary(s->boundary->f_out, g, f, 6);
    for (uint32_t t = 0; t < s->steps; t++) {
        const struct step *x = &s->step[first + t];
        num u = num_of(0);
        da = xform_motion(&x->X, da);
        for (int e = 0; e < 6; e++)
            u -= x->psi[e] * f[e];
        const num more = x->Dinv * (u - sv_dot(x->U, da)), qdd = x->u + more;
        da.w.z += more;
        finite &= (qdd - qdd == num_of(0)) | (num_of(t) >= s->length[g]);
        if (s->reply->qdd)
            store_qdd(s, g, t, qdd);
    }
    s->finite[g] = finite;
}

static void correct_task(void *context, uint32_t part, uint32_t worker)
{
    (void)worker;
    correct(context, part);
}

/* ---- the answer ---- */

static int has_velocity(const struct segment_lanes *s)
{
    const uint32_t n = s->m->v_count;
    const double *v = s->request->v ? s->request->v + (size_t)n * s->state : NULL;
    for (uint32_t j = 0; v && j < n; j++)
        if (v[j] != 0)
            return 1;
    return 0;
}

static int segment_lanes_answer(struct segment_lanes *s, struct tfa_executor *executor,
                                const tfa_request *request, uint32_t state, tfa_method method,
                                tfa_reply *reply)
{
    const double max_ratio = method == TFA_METHOD_SCAN_TWO_PASS ? -1 /* every cut */
                                                                : TFA_SCAN_MAX_RATIO;
    int finite = 1, safe = 1;
    if (s->m->bodies < THREADS_BODIES_MIN * NUM_LANES)
        executor = NULL;
    s->boundary->floating = method == TFA_METHOD_TFA_CR || method == TFA_METHOD_CFA_CR;
    s->request = request;
    s->reply = reply;
    s->state = state;
    s->moving = has_velocity(s);
    parallel_for(executor, kinematics_task, s, s->groups);
    if (s->moving) {
        s->scalar_kernel->segment_scan_velocities(s->boundary, 1);
        parallel_for(executor, velocities_task, s, s->groups);
        s->scalar_kernel->segment_scan_velocities(s->boundary, 0);
    }
    s->second_pass = 0;
    parallel_for(executor, inward_task, s, s->groups);
    s->second_pass = s->scalar_kernel->segment_scan_factor(s->scan, s->boundary, max_ratio);
    if (s->second_pass < 0)
        return TFA_NOT_ANSWERED;
    if (s->second_pass) {
        parallel_for(executor, inward_task, s, s->groups);
        (void)s->scalar_kernel->segment_scan_factor(s->scan, s->boundary, DBL_MAX);
    }
    s->scalar_kernel->segment_scan_solve(s->scan, s->boundary,
                                         request->gravity ? request->gravity : s->m->gravity);
    parallel_for(executor, outward_task, s, s->groups);
    if (!s->scalar_kernel->segment_scan_correct(s->scan, s->boundary))
        return TFA_NOT_ANSWERED;
    parallel_for(executor, correct_task, s, s->groups);
    for (uint32_t g = 0; g < s->groups; g++) {
        finite &= num_all(s->finite[g]);
        safe &= num_all(s->margin[g] >= 0);
    }
    return !finite ? TFA_NOT_ANSWERED : safe ? TFA_ANSWERED : TFA_ANSWERED_SENTINEL;
}

const struct tfa_segment_lanes_kernel TFA_V(segment_lanes) = {
    .size = segment_lanes_size,
    .init = segment_lanes_init,
    .answer = segment_lanes_answer,
};
