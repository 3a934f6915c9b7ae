/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Articulated bodies with locked joints, which have no acceleration. Three savings over a joint
 * that is free: bodies that no freedom moves are not computed; everything outboard of the last
 * freedom is one rigid composite of ten numbers instead of 21; and a joint between needs no
 * projection.
 */
#include "dynamics/core/lock.h"

#include "dynamics/core/aba_step.h"

/* ---- the plan ---- */

static inline int is_locked(const struct state *s, const struct tfa_body *b)
{
    for (uint32_t k = 0; k < b->n; k++)
        if (!s->lock[b->v + k])
            return 0;
    return 1;
}

static void lock_parts(struct state *s)
{
    for (uint32_t i = 0; i < s->m->bodies; i++) {
        const struct tfa_body *b = &s->body[i];
        if (b->joint_nd < 0)
            continue;
        struct joint_nd *w = &s->joint_nd[b->joint_nd];
        w->locked = 0;
        for (uint32_t k = 0; k < b->n; k++)
            w->locked |= (uint32_t)s->lock[b->v + k] << k;
    }
}

void TFA_V(lock_plan)(struct state *s, int may_skip_unused)
{
    lock_parts(s);
    if (!s->locked)
        return;
    for (uint32_t i = 0; i < s->m->bodies; i++) {
        const struct tfa_body *b = &s->body[i];
        const int ground = b->parent < 0 || s->constraint[b->parent] & CONSTRAINT_GROUNDED;
        s->constraint[i] = CONSTRAINT_RIGID | (ground && is_locked(s, b) ? CONSTRAINT_GROUNDED : 0);
    }
    for (uint32_t i = s->m->bodies; i-- > 0;) {
        const struct tfa_body *b = &s->body[i];
        const int is_rigid = s->constraint[i] & CONSTRAINT_RIGID;
        if (b->parent >= 0 && !(is_rigid && is_locked(s, b)))
            s->constraint[b->parent] &= (uint8_t)~CONSTRAINT_RIGID;
        if (may_skip_unused && is_rigid && s->constraint[i] & CONSTRAINT_GROUNDED)
            s->constraint[i] |= CONSTRAINT_SKIPPED;
    }
}

/* ---- rigid composites ---- */

static inline struct composite composite_of(const struct tfa_body *b)
{
    return (struct composite){body_mass(b), body_h(b), body_I(b)};
}

static inline sym6 composite_inertia(const struct composite *c)
{
    const vec3 h = c->h;
    const num o = num_of(0);
    return (sym6){c->I, {o, -h.z, h.y, h.z, o, -h.x, -h.y, h.x, o}, {c->m, o, o, c->m, o, c->m}};
}

/* I a */
static inline svec composite_mul(const struct composite *c, svec a)
{
    return (svec){v3_add(s3_mul(c->I, a.w), v3_cross(c->h, a.v)),
                  v3_sub(v3_scale(a.v, c->m), v3_cross(c->h, a.w))};
}

/* About the parent's origin: h + m r,  I + (2 r.h + m r.r) 1 - (r h^T + h r^T + m r r^T) */
static inline struct composite composite_to_parent(const xform *X, const struct composite *c)
{
    const vec3 r = X->r, h = m3_tmul(X->E, c->h);
    const sym3 I = s3_congruence_t(X->E, c->I);
    const vec3 g = v3_add(h, v3_scale(r, c->m)); /* r h^T + h r^T + m r r^T = r g^T + h r^T */
    const num d = v3_dot(r, h) + v3_dot(r, g);
    return (struct composite){c->m,
                              g,
                              {I.xx + d - r.x * g.x - h.x * r.x, I.xy - r.x * g.y - h.x * r.y,
                               I.xz - r.x * g.z - h.x * r.z, I.yy + d - r.y * g.y - h.y * r.y,
                               I.yz - r.y * g.z - h.y * r.z, I.zz + d - r.z * g.z - h.z * r.z}};
}

static inline void composite_add(struct composite *c, const struct composite *other)
{
    c->m += other->m;
    c->h = v3_add(c->h, other->h);
    c->I = s3_add(c->I, other->I);
}

/* ---- inward ---- */

static inline void start(struct state *s, uint32_t i, int flags)
{
    const struct tfa_body *b = &s->body[i];
    aba_backward_start(s, i, flags & ~(s->constraint[i] & CONSTRAINT_RIGID ? ABA_INERTIA : 0));
    if (flags & ABA_INERTIA && s->constraint[i] & CONSTRAINT_RIGID)
        s->rigid[i] = composite_of(b);
}

static inline void add_composite_to_parent(struct state *s, uint32_t i, const struct tfa_body *b)
{
    const struct composite up = composite_to_parent(&s->X[i], &s->rigid[i]);
    if (s->constraint[b->parent] & CONSTRAINT_RIGID) {
        composite_add(&s->rigid[b->parent], &up);
    } else {
        const sym6 I = composite_inertia(&up);
        s6_add(&s->IA[b->parent], &I);
    }
}

/* Factors of a locked joint: zero. */
static inline void zero_joint(struct state *s, uint32_t i, const struct tfa_body *b)
{
    if (b->n > 1) {
        TFA_V(joint_nd_factor)(s, &s->joint_nd[b->joint_nd], &s->IA[i], b);
        return;
    }
    s->U[i] = sv_zero();
    s->Dinv[i] = num_of(0);
}

/* A locked joint: IA_parent += X^T IA X,  pA_parent += X^T (pA + IA c) */
static inline void backward_locked(struct state *s, uint32_t i, const struct tfa_body *b, int flags)
{
    const int is_rigid = s->constraint[i] & CONSTRAINT_RIGID;
    if (flags & ABA_FORCE) {
        svec pa = s->pA[i];
        if (flags & ABA_BIAS && is_rigid)
            pa = sv_add(pa, composite_mul(&s->rigid[i], s->c[i]));
        else if (flags & ABA_BIAS)
            pa = sv_add(pa, s6_mul(&s->IA[i], s->c[i]));
        add_force_to_parent(s, i, xform_t_force(&s->X[i], pa), 0);
    }
    if (!(flags & ABA_INERTIA))
        return;
    zero_joint(s, i, b);
    if (is_rigid) {
        add_composite_to_parent(s, i, b);
    } else {
        const sym6 up = s6_to_parent(&s->X[i], &s->IA[i]);
        s6_add(&s->IA[b->parent], &up);
    }
}

static inline void inward(struct state *s, const num *tau, int flags)
{
    const struct tfa_model *m = s->m;
    if (flags & ABA_INERTIA)
        sentinel_reset(s);
    for (uint32_t i = 0; i < m->bodies; i++)
        if (!(s->constraint[i] & CONSTRAINT_SKIPPED))
            start(s, i, flags);
    for (uint32_t i = m->bodies; i-- > 0;) {
        const struct tfa_body *b = &s->body[i];
        if (s->constraint[i] & CONSTRAINT_GROUNDED) {
            if (flags & ABA_INERTIA)
                zero_joint(s, i, b);
        } else if (is_locked(s, b)) {
            backward_locked(s, i, b, flags);
        } else {
            if (flags & ABA_INERTIA && s->constraint[i] & CONSTRAINT_RIGID)
                s->IA[i] = composite_inertia(&s->rigid[i]);
            TFA_V(aba_backward_body)(s, i, tau, flags | ABA_SENTINEL);
        }
    }
}

/* ---- outward ---- */

static inline void outward(struct state *s, svec ground, num *qdd, int bias)
{
    const struct tfa_model *m = s->m;
    for (uint32_t i = 0; i < m->bodies; i++) {
        const struct tfa_body *b = &s->body[i];
        const svec parent = b->parent < 0 ? ground : s->a[b->parent];
        if (!is_locked(s, b)) {
            aba_forward_step(s, i, parent, qdd, bias);
            continue;
        }
        for (uint32_t k = 0; k < b->n; k++)
            qdd[b->v + k] = num_of(0);
        if (s->constraint[i] & CONSTRAINT_RIGID)
            continue; /* nothing below asks for its acceleration */
        const svec a = xform_motion(&s->X[i], parent);
        s->a[i] = bias ? sv_add(a, s->c[i]) : a;
    }
}

static void have_locked(struct state *s)
{
    s->have = (s->have | HAVE_LOCKED) & ~(uint32_t)(HAVE_CHAIN | HAVE_ABA);
}

void TFA_V(lock)(struct state *s, const num *tau, num *qdd)
{
    const svec ground = {v3_zero(), v3_neg(s->gravity)};
    aba_backward_pass(s, tau, s->moving, s->have & HAVE_LOCKED, inward);
    have_locked(s);
    outward(s, ground, qdd, s->moving);
}

void TFA_V(lock_factor)(struct state *s)
{
    if (!(s->have & HAVE_LOCKED))
        inward(s, NULL, ABA_INERTIA);
    have_locked(s);
}

void TFA_V(lock_solve)(struct state *s, const num *tau, num *qdd)
{
    inward(s, tau, ABA_FORCE);
    outward(s, sv_zero(), qdd, 0);
}
