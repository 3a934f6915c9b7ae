/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Derivatives of inverse dynamics in world axes about one reference point.
 */
#include "dynamics/derivatives/inverse_derivatives.h"

#include "dynamics/core/recursions.h"
#include "dynamics/kinematics/centroid.h"
#include "dynamics/kinematics/world_pose.h"

vec3 TFA_V(derivatives_origin)(struct state *s)
{
    TFA_V(world_poses)(s);
    return s->bodies ? vec3_of_simd(s->world[0].r) : v3_zero();
}

static svec motion_to_world(const struct state *s, uint32_t i, svec m, vec3 origin)
{
    const vec3_simd p = vec3_simd_of(origin.x, origin.y, origin.z);
    return motion_simd_store(motion_at_point(&s->world[i], m, p));
}

static svec force_to_world(const struct state *s, uint32_t i, svec f, vec3 origin)
{
    const struct world_pose *W = &s->world[i];
    const vec3 force = vec3_of_simd(mat3_simd_apply_t(&W->E, f.v)),
               moment = vec3_of_simd(mat3_simd_apply_t(&W->E, f.w)),
               arm = v3_sub(vec3_of_simd(W->r), origin);
    return (svec){v3_add(moment, v3_cross(arm, force)), force};
}

/* ---- bodies ---- */

/* Rotation from the axes of a body to those of the world */
static mat3 world_rotation(const struct world_pose *W)
{
    const vec3 x = vec3_of_simd(W->E.row[0]), y = vec3_of_simd(W->E.row[1]),
               z = vec3_of_simd(W->E.row[2]);
    return (mat3){x.x, y.x, z.x, x.y, y.y, z.y, x.z, y.z, z.z};
}

/* From the origin of a body to a point from where that origin is at r: 2 r.h - r h^T - h r^T
 * + m (r.r - r r^T), h the first moment about the body's origin */
static sym3 shift_inertia(vec3 r, vec3 h, num m)
{
    const vec3 g = v3_add(v3_scale(h, num_of(2)), v3_scale(r, m));
    const num d = v3_dot(r, g);
    return (sym3){d - r.x * g.x, -(r.x * g.y + r.y * g.x) / 2, -(r.x * g.z + r.z * g.x) / 2,
                  d - r.y * g.y, -(r.y * g.z + r.z * g.y) / 2, d - r.z * g.z};
}

static mat3 skew(vec3 a)
{
    const num o = num_of(0);
    return (mat3){o, -a.z, a.y, a.z, o, -a.x, -a.y, a.x, o};
}

/* The rigid inertia of a body about the reference point; A = -2 ([w] Sigma + [h] [u]), Sigma its
 * second moments, and linear momentum P: 2 B m = (A m.w, -2 P x m.w) */
static void body_terms(const struct state *s, uint32_t i, svec v, vec3 origin, struct subtree *t)
{
    const struct tfa_body *b = &s->body[i];
    const struct world_pose *W = &s->world[i];
    const mat3 E = world_rotation(W);
    const vec3 r = v3_sub(vec3_of_simd(W->r), origin);
    const sym3 I = s3_congruence(E, body_I(b));
    const vec3 h = m3_mul(E, body_h(b));
    const num m = body_mass(b), two = num_of(2);
    t->m = m;
    t->h = v3_add(h, v3_scale(r, m));
    t->I = s3_add(I, shift_inertia(r, h, m));
    const num trace = s3_trace(t->I) / two;
    const mat3 sigma = {trace - t->I.xx, -t->I.xy, -t->I.xz, -t->I.xy,       trace - t->I.yy,
                        -t->I.yz,        -t->I.xz, -t->I.yz, trace - t->I.zz};
    const mat3 A = m3_add(cross_m3(v.w, sigma), cross_m3(t->h, skew(v.v)));
    t->A = (mat3){-two * A.xx, -two * A.xy, -two * A.xz, -two * A.yx, -two * A.yy,
                  -two * A.yz, -two * A.zx, -two * A.zy, -two * A.zz};
    t->P = v3_add(v3_scale(v.v, m), v3_cross(v.w, t->h));
}

static void add_to_parent(struct subtree *p, const struct subtree *t)
{
    p->m += t->m;
    p->h = v3_add(p->h, t->h);
    p->I = s3_add(p->I, t->I);
    p->A = m3_add(p->A, t->A);
    p->P = v3_add(p->P, t->P);
}

static svec inertia_mul(const struct subtree *t, svec m)
{
    return (svec){v3_add(s3_mul(t->I, m.w), v3_cross(t->h, m.v)),
                  v3_sub(v3_scale(m.v, t->m), v3_cross(t->h, m.w))};
}

/* 2 B m */
static svec coriolis_mul(const struct subtree *t, svec m)
{
    return (svec){m3_mul(t->A, m.w), v3_scale(v3_cross(t->P, m.w), num_of(-2))};
}

/* ---- freedoms ---- */

/* S, Psi', Psi'' and Psi' + S' of the freedoms of body i. v and a: of the body before the joint;
 * within a fused joint, of the part before each freedom */
static void freedom_terms(struct state *s, uint32_t i, svec v, svec a, svec own, vec3 origin)
{
    const struct tfa_body *b = &s->body[i];
    const vec3_simd p = vec3_simd_of(origin.x, origin.y, origin.z);
    for (uint32_t k = 0; k < b->n; k++) {
        struct freedom_terms *t = &s->freedom_terms[b->v + k];
        t->S = motion_simd_store(joint_axis_at_point(s, i, k, p));
        t->psi = cross_motion(v, t->S);
        t->psi_dot = sv_add(cross_motion(a, t->S), cross_motion(v, t->psi));
        if (!is_fused(b->kind)) {
            t->rate = sv_add(t->psi, b->n > 1 ? cross_motion(own, t->S) : t->psi);
            continue;
        }
        t->rate = sv_add(t->psi, t->psi);
        a = sv_add(a, sv_add(sv_scale(t->S, s->qdd[b->v + k]), sv_scale(t->psi, s->qd[b->v + k])));
        v = sv_add(v, sv_scale(t->S, s->qd[b->v + k]));
    }
}

/* Motions of all bodies, and terms of freedoms and bodies */
static void outward(struct state *s, vec3 origin)
{
    for (uint32_t i = 0; i < s->bodies; i++) {
        const int32_t parent = s->body[i].parent;
        const svec none = sv_zero(), ground = {v3_zero(), v3_neg(s->gravity)};
        struct subtree *t = &s->subtree[i];
        const svec v = s->moving ? motion_to_world(s, i, s->v[i], origin) : none;
        const svec before = parent < 0 ? none : s->subtree[parent].v;
        const svec a = parent < 0 ? ground : s->subtree[parent].a;
        freedom_terms(s, i, before, a, v, origin);
        body_terms(s, i, v, origin, t);
        t->v = v;
        t->a = motion_to_world(s, i, s->a[i], origin);
        t->f = force_to_world(s, i, s->f[i], origin);
    }
}

/* ---- pairs ---- */

/* Entry of inner freedoms i and j; public ones where mimics are projected */
static inline void add_entry(const struct state *s, num *D, size_t stride, uint32_t i, uint32_t j,
                             num x)
{
    num row, column;
    if (s->identity_map) {
        D[stride * i + j] += x;
        return;
    }
    const size_t r = TFA_V(reduced_freedom)(s->m, i, &row),
                 c = TFA_V(reduced_freedom)(s->m, j, &column);
    D[stride * r + c] += row * column * x;
}

/* Force of the subtree that turns with freedom i of a body: without wrenches on links inside its
 * joint that are before this freedom */
static svec turning_force(const struct state *s, uint32_t body, uint32_t i,
                          const struct inverse_derivatives *d)
{
    svec f = s->subtree[body].f;
    if (is_fused(s->body[body].kind))
        for (uint32_t k = 0; k < d->held_count; k++)
            if (d->held[k].body == (int32_t)body && i - s->body[body].v >= d->held[k].freedoms)
                f = sv_add(f, d->held[k].wrench);
    return f;
}

/* Freedom i and all before it: those of the same joint, then of the bodies inboard. */
static void freedom_pairs(struct state *s, uint32_t body, uint32_t i,
                          const struct inverse_derivatives *d)
{
    const struct subtree *t = &s->subtree[body];
    const struct freedom_terms *x = &s->freedom_terms[i];
    const svec rI = inertia_mul(t, x->S);
    const vec3 rB = v3_sub(m3_tmul(t->A, x->S.w), v3_scale(v3_cross(x->S.v, t->P), num_of(2)));
    const svec by_q = sv_add(sv_add(coriolis_mul(t, x->psi), inertia_mul(t, x->psi_dot)),
                             cross_force(x->S, turning_force(s, body, i, d)));
    const svec by_v = sv_add(coriolis_mul(t, x->S), inertia_mul(t, x->rate));
    for (int32_t k = (int32_t)body; k >= 0; k = s->body[k].parent) {
        const struct tfa_body *b = &s->body[k];
        const int same = (uint32_t)k == body, block = same && !is_fused(b->kind);
        for (uint32_t j = b->v; j < b->v + b->n; j++) {
            const struct freedom_terms *y = &s->freedom_terms[j];
            if (same && !block && j > i)
                continue; /* that one meets this one */
            if (d->dq)
                add_entry(s, d->dq, d->stride, i, j, v3_dot(rB, y->psi.w) + sv_dot(rI, y->psi_dot));
            if (d->dv)
                add_entry(s, d->dv, d->stride, i, j, v3_dot(rB, y->S.w) + sv_dot(rI, y->rate));
            if (block || j == i)
                continue;
            if (d->dq)
                add_entry(s, d->dq, d->stride, j, i, sv_dot(y->S, by_q));
            if (d->dv)
                add_entry(s, d->dv, d->stride, j, i, sv_dot(y->S, by_v));
        }
    }
}

/* Freedoms of body k, an ancestor of the wrench's or the same, that move it: end of those from
 * s->body[k].v on */
static uint32_t moving_end(const struct state *s, const struct held_wrench *w, int32_t k)
{
    return s->body[k].v + (k == w->body ? w->freedoms : s->body[k].n);
}

/* A wrench that does not turn with its body: against one that did, it lags behind by S x* wrench,
 * S without the motion of its point where that moves along. */
static void held_pairs(struct state *s, const struct held_wrench *w,
                       const struct inverse_derivatives *d)
{
    for (int32_t k = w->body; k >= 0; k = s->body[k].parent)
        for (uint32_t j = s->body[k].v; j < moving_end(s, w, k); j++) {
            svec turn = s->freedom_terms[j].S;
            if (w->frame == TFA_FRAME_LOCAL_WORLD_ALIGNED)
                turn.v = v3_cross(w->at, turn.w);
            const svec lag = cross_force(turn, w->wrench);
            for (int32_t l = w->body; l >= 0; l = s->body[l].parent)
                for (uint32_t i = s->body[l].v; i < moving_end(s, w, l); i++)
                    add_entry(s, d->dq, d->stride, i, j, sv_dot(s->freedom_terms[i].S, lag));
        }
}

void TFA_V(inverse_derivatives)(struct state *s, const struct inverse_derivatives *d)
{
    TFA_V(rnea)(s, s->qdd, s->res, 1);
    outward(s, d->origin);
    for (uint32_t i = s->bodies; i-- > 0;) {
        for (uint32_t k = 0; k < s->body[i].n; k++)
            freedom_pairs(s, i, s->body[i].v + k, d);
        if (s->body[i].parent >= 0)
            add_to_parent(&s->subtree[s->body[i].parent], &s->subtree[i]);
    }
    for (uint32_t k = 0; d->dq && k < d->held_count; k++)
        if (d->held[k].frame != TFA_FRAME_LOCAL)
            held_pairs(s, &d->held[k], d);
    for (uint32_t j = s->m->base_freedoms; d->dv && s->m->damping && j < s->freedoms; j++)
        add_entry(s, d->dv, d->stride, j, j, num_of(s->m->damping[j]));
}
