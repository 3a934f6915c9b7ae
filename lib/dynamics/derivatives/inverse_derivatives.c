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

static svec inertia_mul(const struct subtree *t, svec m)
{
    return (svec){v3_add(s3_mul(t->I, m.w), v3_cross(t->h, m.v)),
                  v3_sub(v3_scale(m.v, t->m), v3_cross(t->h, m.w))};
}

/* The rigid inertia of a body about the reference point; A = -2 ([w] Sigma + [h] [u]), Sigma its
 * second moments, and linear momentum P: 2 B m = (A m.w, -2 P x m.w); f = I a + v x* I v */
static void body_terms(const struct state *s, uint32_t i, vec3 origin, struct subtree *t)
{
    const svec v = t->v;
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
    const svec momentum = inertia_mul(t, v);
    t->P = momentum.v;
    t->f = sv_add(inertia_mul(t, t->a), cross_force(v, momentum));
}

static void add_to_parent(struct subtree *p, const struct subtree *t)
{
    p->m += t->m;
    p->h = v3_add(p->h, t->h);
    p->I = s3_add(p->I, t->I);
    p->A = m3_add(p->A, t->A);
    p->P = v3_add(p->P, t->P);
    p->f = sv_add(p->f, t->f);
}

/* ---- freedoms ---- */

/* S of freedom j, with its multiplier */
static inline svec subspace(const struct freedom_terms *t)
{
    const quad *x = t->vector;
    return (svec){{quad_lane(&x[0], 2), quad_lane(&x[1], 2), quad_lane(&x[2], 2)},
                  {quad_lane(&x[3], 2), quad_lane(&x[4], 2), quad_lane(&x[5], 2)}};
}

/* The motions times x */
static inline void store_terms(struct freedom_terms *t, svec psi_dot, svec rate, svec S, vec3 psi,
                               num x)
{
    num a[6], b[6], c[6];
    const num d[3] = {psi.x, psi.y, psi.z}, o = num_of(0);
    sv_store(a, psi_dot);
    sv_store(b, rate);
    sv_store(c, S);
    for (int e = 0; e < 6; e++)
        t->vector[e] = quad_scale(x, quad_of(a[e], b[e], c[e], c[e]));
    for (int e = 0; e < 3; e++)
        t->angular[e] = quad_scale(x, quad_of(d[e], c[e], o, o));
}

/* Velocity of body i: v is that of the body before its joint. */
static svec velocity_behind(const struct state *s, uint32_t i, const svec *S, svec v)
{
    const struct tfa_body *b = &s->body[i];
    for (uint32_t k = 0; k < b->n; k++)
        v = sv_add_scaled(v, S[k], s->qd[b->v + k]);
    return v;
}

/* Velocity that is left out of qd of a root; s->qdd have w x that. */
static vec3 boost_of(const struct state *s, const struct tfa_body *b, const svec *S)
{
    vec3 boost = v3_zero();
    for (uint32_t k = 0; s->boosted && b->parent < 0 && is_free(b->kind) && k < 3; k++)
        boost = v3_add_scaled(boost, S[k].v, s->boost[b->v + k]);
    return boost;
}

/* Terms of the freedoms of body i, and its motion: a += S qdd + psi qd for each, where v and a are
 * those of the body before the joint; within a fused joint, of the part before each freedom. */
static void joint_terms(struct state *s, uint32_t i, svec v, svec a, vec3 origin, int of_world)
{
    const struct tfa_body *b = &s->body[i];
    const vec3_simd p = vec3_simd_of(origin.x, origin.y, origin.z);
    const int in_parts = b->n == 1 || is_fused(b->kind);
    svec S[6], v_behind, a_behind = a;
    for (uint32_t k = 0; k < b->n; k++)
        S[k] = motion_simd_store(joint_axis_at_point(s, i, k, p));
    v_behind = velocity_behind(s, i, S, v);
    const vec3 boost = of_world ? boost_of(s, b, S) : v3_zero();
    for (uint32_t k = 0; k < b->n; k++) {
        const uint32_t j = b->v + k;
        const svec psi = cross_motion(v, S[k]),
                   psi_dot = sv_add(cross_motion(a, S[k]), cross_motion(v, psi)),
                   behind = in_parts ? psi : cross_motion(v_behind, S[k]),
                   rate = sv_add(psi, (svec){behind.w, v3_add(behind.v, v3_cross(S[k].w, boost))});
        num x = num_of(1);
        if (!s->identity_map)
            (void)TFA_V(reduced_freedom)(s->m, j, &x);
        store_terms(&s->freedom_terms[j], psi_dot, rate, S[k], psi.w, x);
        a_behind = sv_add_scaled(sv_add_scaled(a_behind, S[k], s->qdd[j]), psi, s->qd[j]);
        if (in_parts) {
            a = a_behind;
            v = sv_add_scaled(v, S[k], s->qd[j]);
        }
    }
    s->subtree[i].v = v_behind;
    s->subtree[i].a = a_behind;
}

/* Motions of all bodies; terms of freedoms and bodies, and f = I a + v x* I v - wrench */
static void outward(struct state *s, vec3 origin, int of_world)
{
    for (uint32_t i = 0; i < s->bodies; i++) {
        const int32_t parent = s->body[i].parent;
        struct subtree *t = &s->subtree[i];
        joint_terms(s, i, parent < 0 ? sv_zero() : s->subtree[parent].v,
                    parent < 0 ? (svec){v3_zero(), v3_neg(s->gravity)} : s->subtree[parent].a,
                    origin, of_world);
        body_terms(s, i, origin, t);
        if (s->wrenched)
            t->f = sv_sub(t->f, force_to_world(s, i, s->wrench[i], origin));
    }
}

/* ---- pairs ---- */

/* dtau_i by j, public freedoms; their sum where mimics are projected */
static inline num *entry(const struct state *s, const struct inverse_derivatives *d, num *D,
                         uint32_t i, uint32_t j)
{
    return D + d->stride * s->public_row[i] + derivatives_column(s->public_row[j]);
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

/* I m of four motions at once, angular first */
TFA_INLINE void inertia_mul_quads(const struct subtree *t, const quad x[6], quad y[6])
{
    const sym3 I = t->I;
    const num m = t->m;
    const vec3 h = t->h;
    for (int k = 0; k < QUAD_VECS; k++) {
#define X(e) x[e].vec[k]
        y[0].vec[k] = I.xx * X(0) + I.xy * X(1) + I.xz * X(2) + h.y * X(5) - h.z * X(4);
        y[1].vec[k] = I.xy * X(0) + I.yy * X(1) + I.yz * X(2) + h.z * X(3) - h.x * X(5);
        y[2].vec[k] = I.xz * X(0) + I.yz * X(1) + I.zz * X(2) + h.x * X(4) - h.y * X(3);
        y[3].vec[k] = m * X(3) - h.y * X(2) + h.z * X(1);
        y[4].vec[k] = m * X(4) - h.z * X(0) + h.x * X(2);
        y[5].vec[k] = m * X(5) - h.x * X(1) + h.y * X(0);
#undef X
    }
}

/* y += 2 B m of four motions with rotations w */
TFA_INLINE void add_coriolis_quads(const struct subtree *t, const quad w[3], quad y[6])
{
    const mat3 A = t->A;
    const vec3 P = v3_scale(t->P, num_of(-2));
    for (int k = 0; k < QUAD_VECS; k++) {
#define W(e) w[e].vec[k]
        y[0].vec[k] += A.xx * W(0) + A.xy * W(1) + A.xz * W(2);
        y[1].vec[k] += A.yx * W(0) + A.yy * W(1) + A.yz * W(2);
        y[2].vec[k] += A.zx * W(0) + A.zy * W(1) + A.zz * W(2);
        y[3].vec[k] += P.y * W(2) - P.z * W(1);
        y[4].vec[k] += P.z * W(0) - P.x * W(2);
        y[5].vec[k] += P.x * W(1) - P.y * W(0);
#undef W
    }
}

/* Of freedom i, what the terms of a freedom before it are multiplied by. Vectors: r I twice, then
 * forces whose S_j^T are dtau_j by q and by v of i: by_q = I psi_dot + 2 B psi + S x* f,
 * by_v = I rate + 2 B S. Angular: r 2 B twice. */
static struct freedom_terms forces_of(const struct state *s, uint32_t body, uint32_t i,
                                      const struct inverse_derivatives *d)
{
    const struct subtree *t = &s->subtree[body];
    const struct freedom_terms *x = &s->freedom_terms[i];
    const svec S = subspace(x), turning = cross_force(S, turning_force(s, body, i, d));
    const vec3 rB = v3_sub(m3_tmul(t->A, S.w), v3_scale(v3_cross(S.v, t->P), num_of(2)));
    const num o = num_of(0);
    struct freedom_terms y;
    inertia_mul_quads(t, x->vector, y.vector);
    add_coriolis_quads(t, x->angular, y.vector);
    for (int e = 0; e < 6; e++)
        y.vector[e] = quad_swap_halves(y.vector[e]);
    num f[6];
    sv_store(f, turning);
    for (int e = 0; e < 6; e++)
        quad_lane(&y.vector[e], 2) += f[e];
    y.angular[0] = quad_of(rB.x, rB.x, o, o);
    y.angular[1] = quad_of(rB.y, rB.y, o, o);
    y.angular[2] = quad_of(rB.z, rB.z, o, o);
    return y;
}

/* dtau_i by q and by v of j, dtau_j by those of i */
static inline quad pair(const struct freedom_terms *i, const struct freedom_terms *j)
{
    quad sum = quad_of(num_of(0), num_of(0), num_of(0), num_of(0));
    for (int e = 0; e < 3; e++)
        sum = quad_add_product(sum, i->angular[e], j->angular[e]);
    for (int e = 0; e < 6; e++)
        sum = quad_add_product(sum, i->vector[e], j->vector[e]);
    return sum;
}

/* Freedom i and all before it: those of the same joint, where a joint that is not fused is one
 * part, then of the bodies inboard. */
static void freedom_pairs(struct state *s, uint32_t body, uint32_t i,
                          const struct inverse_derivatives *d)
{
    const struct tfa_body *b = &s->body[body];
    const struct freedom_terms x = forces_of(s, body, i, d);
    const uint32_t first = is_fused(b->kind) ? i : b->v,
                   end = is_fused(b->kind) ? i + 1 : b->v + b->n;
    for (uint32_t j = first; j < end; j++) {
        const quad by = pair(&x, &s->freedom_terms[j]);
        *entry(s, d, d->dq, i, j) += quad_lane(&by, 0);
        *entry(s, d, d->dv, i, j) += quad_lane(&by, 1);
    }
    for (int32_t k = s->m->dof_parent[first]; k >= 0; k = s->m->dof_parent[k]) {
        const uint32_t j = (uint32_t)k;
        const quad by = pair(&x, &s->freedom_terms[j]);
        *entry(s, d, d->dq, i, j) += quad_lane(&by, 0);
        *entry(s, d, d->dv, i, j) += quad_lane(&by, 1);
        *entry(s, d, d->dq, j, i) += quad_lane(&by, 2);
        *entry(s, d, d->dv, j, i) += quad_lane(&by, 3);
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
            svec turn = subspace(&s->freedom_terms[j]);
            if (w->frame == TFA_FRAME_LOCAL_WORLD_ALIGNED)
                turn.v = v3_cross(w->at, turn.w);
            const svec lag = cross_force(turn, w->wrench);
            for (int32_t l = w->body; l >= 0; l = s->body[l].parent)
                for (uint32_t i = s->body[l].v; i < moving_end(s, w, l); i++)
                    *entry(s, d, d->dq, i, j) += sv_dot(subspace(&s->freedom_terms[i]), lag);
        }
}

void TFA_V(inverse_derivatives)(struct state *s, const struct inverse_derivatives *d)
{
    outward(s, d->origin, d->of_world);
    for (uint32_t i = s->bodies; i-- > 0;) {
        for (uint32_t k = 0; k < s->body[i].n; k++)
            freedom_pairs(s, i, s->body[i].v + k, d);
        if (s->body[i].parent >= 0)
            add_to_parent(&s->subtree[s->body[i].parent], &s->subtree[i]);
    }
    for (uint32_t k = 0; k < d->held_count; k++)
        if (d->held[k].frame != TFA_FRAME_LOCAL)
            held_pairs(s, &d->held[k], d);
    for (uint32_t j = s->m->base_freedoms; s->m->damping && j < s->freedoms; j++) {
        num multiplier;
        (void)TFA_V(reduced_freedom)(s->m, j, &multiplier);
        *entry(s, d, d->dv, j, j) += multiplier * multiplier * num_of(s->m->damping[j]);
    }
}
