/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The segment scan with the segments of one chain side by side: lane l of group g walks segment
 * g * lanes + l, all lanes step by step. Groups are independent of each other and go to the threads
 * of a crew; a kernel of one number at a time scans over the segments in between. Same recursion as
 * scan_segment.c, for revolute joints only, with what it needs from step to step in registers.
 *
 *   open:    sines and poses; the velocity of each end while the body before rests
 *   travel:  velocities
 *   inward:  U, D, u, psi of every joint, and the element of every segment
 *   outward: accelerations, twice: each segment from its own, then what the ends say was wrong
 */
#include "kernel/strips.h"

#include <float.h>
#include <string.h>

#include "kernel/crew.h"
#include "kernel/hinge.h"
#include "kernel/strips_place.h"
#include "spatial/dense.h"

/* As in scan_segment.c. */
#define OVERLAP 2u
#define FAINT 1e-3

/* ---- between lanes and ends ---- */

static inline num *end_numbers(double *name, uint32_t g)
{
    return (num *)(void *)(name + (size_t)g * NUM_LANES);
}

#define END_STRIDE (TFA_STRIPS_MAX / NUM_LANES)

static inline void put_end(double *name, uint32_t g, const num *x, uint32_t numbers)
{
    num *to = end_numbers(name, g);
    for (uint32_t e = 0; e < numbers; e++)
        to[e * END_STRIDE] = x[e];
}

static inline void get_end(double *name, uint32_t g, num *x, uint32_t numbers)
{
    const num *from = end_numbers(name, g);
    for (uint32_t e = 0; e < numbers; e++)
        x[e] = from[e * END_STRIDE];
}

static inline svec get_end_vector(double *name, uint32_t g)
{
    num x[6];
    get_end(name, g, x, 6);
    return sv_from(x);
}

static inline void put_end_vector(double *name, uint32_t g, svec a)
{
    num x[6];
    sv_store(x, a);
    put_end(name, g, x, 6);
}

/* x <- new where m says so */
static inline void replace(num_mask m, num *x, const num *new, uint32_t numbers)
{
    for (uint32_t e = 0; e < numbers; e++)
        x[e] = num_select(m, new[e], x[e]);
}

/* ---- open ---- */

static void load(struct strips *s, uint32_t g)
{
    const tfa_request *r = s->request;
    const size_t n = s->m->v_count, first = (size_t)g * s->steps;
    const double *q = r->q + n * s->state, *qd = s->moving ? r->v + n * s->state : NULL,
                 *tau = r->tau ? r->tau + n * s->state : NULL;
    for (size_t t = first; t < first + s->steps; t++) {
        const struct rib *rib = &s->rib[t];
        s->q[t] = num_gather(q, 1, rib->from);
        s->qd[t] = qd ? num_gather(qd, 1, rib->from) : num_of(0);
        s->tau[t] = (tau ? num_gather(tau, 1, rib->from) : num_of(0)) - rib->damping * s->qd[t];
    }
    num_sincos_many(s->q, s->sine, s->cosine, first, first + s->steps);
}

static inline sym6 rib_inertia(const struct rib *b)
{
    const num o = num_of(0);
    return (sym6){b->I,
                  {o, -b->h.z, b->h.y, b->h.z, o, -b->h.x, -b->h.y, b->h.x, o},
                  {b->mass, o, o, b->mass, o, b->mass}};
}

/* I v */
static inline svec rib_momentum(const struct rib *b, svec v)
{
    return (svec){v3_add(s3_mul(b->I, v.w), v3_cross(b->h, v.v)),
                  v3_sub(v3_scale(v.v, b->mass), v3_cross(b->h, v.w))};
}

/* What the first bodies of each segment put on the end of the one before: scan_segment.c */
static void overlap(struct strips *s, uint32_t g)
{
    const size_t first = (size_t)g * s->steps;
    const num o = num_of(0);
    const sym6 none = {{o, o, o, o, o, o}, {o, o, o, o, o, o, o, o, o}, {o, o, o, o, o, o}};
    sym6 G = none;
    num dense[36];
    for (size_t t = first + OVERLAP; t-- > first;) {
        sym6 IA = rib_inertia(&s->rib[t]);
        s6_add(&IA, &G);
        const svec U = hinge_U(&IA), k = hinge_gain(U, 1 / IA.A.zz);
        const num_mask moves = IA.A.zz > (IA.A.xx + IA.A.yy) * num_of(FAINT);
        const sym6 Ia = hinge_project(&IA, U, k);
        G = s6_to_parent_past_z(&s->step[t].X, &Ia);
        replace(~moves, &G.A.xx, &none.A.xx, sizeof G / sizeof(num));
    }
    s6_dense(dense, &G);
    for (uint32_t lane = 0; lane < NUM_LANES; lane++) {
        const uint32_t k = g * NUM_LANES + lane;
        for (uint32_t e = 0; k > 0 && e < 36; e++)
            s->ends->known[e * TFA_STRIPS_MAX + k - 1] = num_lane(dense[e], lane);
    }
}

/* Poses, and with velocities where each end stands and how it moves while the body before rests:
 * the sum of the joints' motions in the frame of the body before, joint axis row z of E. */
static inline void open(struct strips *s, uint32_t g, int moving)
{
    const size_t first = (size_t)g * s->steps;
    const num o = num_of(0), l = num_of(1);
    struct {
        place X;
        svec v;
    } at = {{{l, o, o, o, l, o, o, o, l}, {o, o, o}}, sv_zero()}, end = at;
    load(s, g);
    for (uint32_t t = 0; t < s->steps; t++) {
        const struct rib *b = &s->rib[first + t];
        const place X = {hinge_turn(b->E, s->sine[first + t], s->cosine[first + t]), b->r};
        s->step[first + t].X = X;
        if (!moving)
            continue;
        at.X.r = v3_add(at.X.r, m3_tmul(at.X.E, X.r));
        at.X.E = m3_mm(X.E, at.X.E);
        const vec3 w = v3_scale(v3(at.X.E.zx, at.X.E.zy, at.X.E.zz), s->qd[first + t]);
        at.v = sv_add(at.v, (svec){w, v3_cross(at.X.r, w)});
        if (t + 1 >= s->cut.shortest)
            replace(s->length[g] == num_of(t + 1), &end.X.E.xx, &at.X.E.xx,
                    sizeof at / sizeof(num));
    }
    if (moving) {
        put_end(s->ends->E, g, &end.X.E.xx, 9);
        put_end(s->ends->r, g, &end.X.r.x, 3);
        put_end_vector(s->ends->v_end, g, x_motion(&end.X, end.v));
    }
    overlap(s, g);
}

static void open_task(void *context, uint32_t part, uint32_t worker)
{
    struct strips *s = context;
    (void)worker;
    if (s->moving)
        open(s, part, 1);
    else
        open(s, part, 0);
}

/* ---- inward ---- */

/* v_i = X_i v_{i-1} + H_i qd_i from v_in, which is known but for the rounding of E, r */
static void velocities(struct strips *s, uint32_t g)
{
    const size_t first = (size_t)g * s->steps;
    svec v = get_end_vector(s->ends->v_in, g), end = v;
    for (uint32_t t = 0; t < s->steps; t++) {
        v = x_motion(&s->step[first + t].X, v);
        v.w.z += s->qd[first + t];
        s->step[first + t].v = v;
        if (t + 1 >= s->cut.shortest)
            replace(s->length[g] == num_of(t + 1), &end.w.x, &v.w.x, 6);
    }
    put_end_vector(s->ends->v_end, g, end);
}

static void velocities_task(void *context, uint32_t part, uint32_t worker)
{
    (void)worker;
    velocities(context, part);
}

/* What v_in was wrong by goes to all bodies of the segment alike. */
static inline void correct_velocities(struct strips *s, uint32_t g)
{
    const size_t first = (size_t)g * s->steps;
    svec dv = get_end_vector(s->ends->dv_in, g);
    for (size_t t = first; t < first + s->steps; t++) {
        dv = x_motion(&s->step[t].X, dv);
        s->step[t].v = sv_add(s->step[t].v, dv);
    }
}

/* What goes inward from step to step */
struct load {
    sym6 IA; /* what is outboard puts on the body */
    svec pA;
    svec P[6]; /* force on it for each unit of what the segment passes on */
    num C[36]; /* upper triangle: what the end yields */
    num a[6];  /* acceleration of the end without a_in and f_out */
};

/* A segment begins at its end: the inertia that is known to hang there, and the unit forces */
static void begin(struct strips *s, uint32_t g, struct load *w)
{
    num known[36];
    memset(w, 0, sizeof *w);
    get_end(s->ends->known, g, known, 36);
    w->IA = s6_from_dense(known);
    for (int e = 0; e < 6; e++)
        sv_put(&w->P[e], e, num_of(1));
}

/* Past one joint; what is kept goes to x. */
static inline void pass(const struct rib *b, struct step *x, num tau, num qd, struct load *w,
                        num *margin, int moving)
{
    const place X = x->X;
    sym6 IA = rib_inertia(b);
    svec c = sv_zero(), pA = w->pA;
    s6_add(&IA, &w->IA);
    if (moving) {
        pA = sv_add(cross_force(x->v, rib_momentum(b, x->v)), pA);
        c = hinge_products(x->v, qd);
    }
    const svec U = hinge_U(&IA);
    const num Dinv = 1 / IA.A.zz, u = tau - pA.w.z;
    *margin = sentinel_smaller(*margin, IA.A.zz - b->floor);
    const svec k = hinge_gain(U, Dinv);
    const sym6 Ia = hinge_project(&IA, U, k);
    x->U = U;
    x->Dinv = Dinv;
    x->u = u;
    pA = hinge_force(pA, k, u);
    num qdd = Dinv * u;
    if (moving) {
        pA = hinge_add_bias(pA, &Ia, c);
        qdd -= k.w.x * c.w.x + k.w.y * c.w.y + k.v.x * c.v.x + k.v.y * c.v.y;
    }
    w->pA = x_t_force(&X, pA);
    w->IA = s6_to_parent_past_z(&X, &Ia);
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
        w->P[e] = x_t_force(&X, P);
    }
    add_response(w->C, psi, phi);
}

static inline void inward(struct strips *s, uint32_t g, int moving)
{
    const size_t first = (size_t)g * s->steps;
    struct load w, fresh;
    num dense[36], margin = num_of(1);
    if (moving && !s->again)
        correct_velocities(s, g);
    begin(s, g, &fresh);
    w = fresh;
    for (uint32_t t = s->steps; t-- > 0;) {
        if (t + 1 >= s->cut.shortest && t + 1 < s->steps)
            replace(s->length[g] == num_of(t + 1), &w.IA.A.xx, &fresh.IA.A.xx,
                    sizeof w / sizeof(num));
        pass(&s->rib[first + t], &s->step[first + t], s->tau[first + t], s->qd[first + t], &w,
             &margin, moving);
    }
    s->margin[g] = margin;
    s6_dense(dense, &w.IA);
    put_end(s->ends->J, g, dense, 36);
    put_end(s->ends->C, g, w.C, 36);
    put_end(s->ends->a_end, g, w.a, 6);
    put_end_vector(s->ends->g, g, w.pA);
    for (uint32_t e = 0; e < 6; e++)
        sv_store(dense + 6 * e, w.P[e]);
    put_end(s->ends->A, g, dense, 36);
}

static __attribute__((flatten)) void inward_task(void *context, uint32_t part, uint32_t worker)
{
    struct strips *s = context;
    (void)worker;
    if (s->moving)
        inward(s, part, 1);
    else
        inward(s, part, 0);
}

/* ---- outward ---- */

/* Every lane's acceleration to its place */
static inline void unload(const struct strips *s, uint32_t g, uint32_t t, num x)
{
    const struct rib *b = &s->rib[(size_t)g * s->steps + t];
    double *out = s->reply->qdd + (size_t)s->m->v_count * s->state;
    for (uint32_t lane = 0; lane < NUM_LANES; lane++)
        if (t < s->cut.shortest || t < s->cut.length[g * NUM_LANES + lane])
            out[b->from[lane]] = num_lane(x, lane);
}

static inline void outward(struct strips *s, uint32_t g, int moving)
{
    const size_t first = (size_t)g * s->steps;
    svec a = get_end_vector(s->ends->a_in, g), end = a;
    num f[6];
    get_end(s->ends->f_out, g, f, 6);
    for (uint32_t t = 0; t < s->steps; t++) {
        struct step *x = &s->step[first + t];
        num u = x->u;
        a = x_motion(&x->X, a);
        if (moving)
            a = sv_add(a, hinge_products(x->v, s->qd[first + t]));
        for (int e = 0; e < 6; e++)
            u -= x->psi[e] * f[e];
        x->u = x->Dinv * (u - sv_dot(x->U, a)); /* qdd from here on */
        a.w.z += x->u;
        if (t + 1 >= s->cut.shortest)
            replace(s->length[g] == num_of(t + 1), &end.w.x, &a.w.x, 6);
    }
    put_end_vector(s->ends->a_end, g, end);
}

static void outward_task(void *context, uint32_t part, uint32_t worker)
{
    struct strips *s = context;
    (void)worker;
    if (s->moving)
        outward(s, part, 1);
    else
        outward(s, part, 0);
}

/* What a_in and f_out were wrong by, to all bodies of the segment */
static void correct(struct strips *s, uint32_t g)
{
    const size_t first = (size_t)g * s->steps;
    svec da = get_end_vector(s->ends->a_in, g);
    num f[6];
    num_mask finite = num_of(0) == num_of(0);
    get_end(s->ends->f_out, g, f, 6);
    for (uint32_t t = 0; t < s->steps; t++) {
        const struct step *x = &s->step[first + t];
        num u = num_of(0);
        da = x_motion(&x->X, da);
        for (int e = 0; e < 6; e++)
            u -= x->psi[e] * f[e];
        const num more = x->Dinv * (u - sv_dot(x->U, da)), qdd = x->u + more;
        da.w.z += more;
        finite &= (qdd - qdd == num_of(0)) | (num_of(t) >= s->length[g]);
        if (s->reply->qdd)
            unload(s, g, t, qdd);
    }
    s->finite[g] = finite;
}

static void correct_task(void *context, uint32_t part, uint32_t worker)
{
    (void)worker;
    correct(context, part);
}

/* ---- the answer ---- */

static int moves(const struct strips *s)
{
    const uint32_t n = s->m->v_count;
    const double *v = s->request->v ? s->request->v + (size_t)n * s->state : NULL;
    for (uint32_t j = 0; v && j < n; j++)
        if (v[j] != 0)
            return 1;
    return 0;
}

static int answer(struct strips *s, struct tfa_crew *crew, const tfa_request *request,
                  uint32_t state, double light, tfa_reply *reply)
{
    int finite = 1, safe = 1;
    s->request = request;
    s->reply = reply;
    s->state = state;
    s->moving = moves(s);
    crew_run(crew, open_task, s, s->groups);
    if (s->moving) {
        s->one->strips_travel(s->ends, 1);
        crew_run(crew, velocities_task, s, s->groups);
        s->one->strips_travel(s->ends, 0);
    }
    s->again = 0;
    crew_run(crew, inward_task, s, s->groups);
    s->again = s->one->strips_join(s->segments, s->ends, light);
    if (s->again) {
        crew_run(crew, inward_task, s, s->groups);
        (void)s->one->strips_join(s->segments, s->ends, DBL_MAX);
    }
    s->one->strips_pass(s->segments, s->ends, request->gravity ? request->gravity : s->m->gravity);
    crew_run(crew, outward_task, s, s->groups);
    s->one->strips_close(s->segments, s->ends);
    crew_run(crew, correct_task, s, s->groups);
    for (uint32_t g = 0; g < s->groups; g++) {
        finite &= num_all(s->finite[g]);
        safe &= num_all(s->margin[g] >= 0);
    }
    return !finite ? TFA_NOT_ANSWERED : safe ? TFA_ANSWERED : TFA_ANSWERED_ALARMED;
}

const struct tfa_strips_kernel TFA_V(strips) = {
    .size = strips_size,
    .init = strips_init,
    .answer = answer,
};
