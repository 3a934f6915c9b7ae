/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Derivatives of inverse dynamics in world axes about one reference point.
 */
#include "dynamics/derivatives/inverse_derivatives.h"

#include "dynamics/core/recursions.h"
#include "dynamics/derivatives/derivatives_step.h"
#include "dynamics/kinematics/centroid.h"
#include "dynamics/kinematics/world_pose.h"
#include "spatial/friction.h"

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

/* ---- outward ---- */

/* Velocity that is left out of qd of a root; s->qdd have w x that. */
static vec3 boost_of(const struct state *s, const struct tfa_body *b, const svec *S)
{
    vec3 boost = v3_zero();
    for (uint32_t k = 0; s->boosted && b->parent < 0 && is_free(b->kind) && k < 3; k++)
        boost = v3_add_scaled(boost, S[k].v, s->boost[b->v + k]);
    return boost;
}

/* Terms of the freedoms of body i, and its motion: before, that of the body before its joint */
static void terms_of_joint(struct state *s, uint32_t i, vec3 origin, int of_world)
{
    const struct tfa_body *b = &s->body[i];
    const vec3_simd p = vec3_simd_of(origin.x, origin.y, origin.z);
    struct joint_motion j;
    for (uint32_t k = 0; k < b->n; k++) {
        j.S[k] = motion_simd_store(joint_axis_at_point(s, i, k, p));
        j.multiplier[k] = num_of(1);
        if (!s->identity_map)
            (void)TFA_V(reduced_freedom)(s->m, b->v + k, &j.multiplier[k]);
    }
    j.qd = s->qd + b->v;
    j.qdd = s->qdd + b->v;
    j.n = b->n;
    j.in_parts = b->n == 1 || is_fused(b->kind);
    j.boost = of_world ? boost_of(s, b, j.S) : v3_zero();
    joint_terms(&j, s->freedom_terms + b->v, &s->subtree[i]);
}

/* Motions of all bodies; terms of freedoms and bodies, and f = I a + v x* I v - wrench */
static void outward(struct state *s, vec3 origin, int of_world)
{
    for (uint32_t i = 0; i < s->bodies; i++) {
        const int32_t parent = s->body[i].parent;
        struct subtree *t = &s->subtree[i];
        t->v = parent < 0 ? sv_zero() : s->subtree[parent].v;
        t->a = parent < 0 ? (svec){v3_zero(), v3_neg(s->gravity)} : s->subtree[parent].a;
        terms_of_joint(s, i, origin, of_world);
        body_terms(&s->body[i], &s->world[i], origin, t);
        if (s->wrenched)
            t->f = sv_sub(t->f, force_to_world(s, i, s->wrench[i], origin));
    }
}

/* ---- pairs ---- */

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

/* Freedoms of a body and all before them */
static void pairs_of_body(struct state *s, uint32_t i, const struct inverse_derivatives *d,
                          const struct derivative_pairs *p)
{
    const struct tfa_body *b = &s->body[i];
    const int fused = is_fused(b->kind);
    for (uint32_t j = b->v; j < b->v + b->n; j++) {
        const struct freedom_terms x =
            forces_of(&s->subtree[i], &s->freedom_terms[j], turning_force(s, i, j, d));
        add_pairs(p, &x, j, fused ? j : b->v, fused ? j + 1 : b->v + b->n);
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
                       const struct derivative_pairs *p)
{
    for (int32_t k = w->body; k >= 0; k = s->body[k].parent)
        for (uint32_t j = s->body[k].v; j < moving_end(s, w, k); j++) {
            svec turn = subspace(&s->freedom_terms[j]);
            if (w->frame == TFA_FRAME_LOCAL_WORLD_ALIGNED)
                turn.v = v3_cross(w->at, turn.w);
            const svec lag = cross_force(turn, w->wrench);
            for (int32_t l = w->body; l >= 0; l = s->body[l].parent)
                for (uint32_t i = s->body[l].v; i < moving_end(s, w, l); i++)
                    *entry(p, p->dq, i, j) += sv_dot(subspace(&s->freedom_terms[i]), lag);
        }
}

static void add_dissipation(const struct state *s, const struct derivative_pairs *p)
{
    const struct tfa_model *m = s->m;
    const num scale = num_of(m->friction_velocity);
    for (uint32_t j = m->base_freedoms; j < s->freedoms; j++) {
        num multiplier, slope = num_of(m->damping ? m->damping[j] : 0);
        (void)TFA_V(reduced_freedom)(m, j, &multiplier);
        if (m->friction)
            slope += num_of(m->friction[j]) * friction_slope(world_velocity(s, j), scale);
        *entry(p, p->dv, j, j) += multiplier * multiplier * slope;
    }
}

void TFA_V(inverse_derivatives)(struct state *s, const struct inverse_derivatives *d)
{
    const struct derivative_pairs p = {d->dq,         d->dv,           d->stride, s->freedom_terms,
                                       s->public_row, s->m->dof_parent};
    outward(s, d->origin, d->of_world);
    for (uint32_t i = s->bodies; i-- > 0;) {
        pairs_of_body(s, i, d, &p);
        if (s->body[i].parent >= 0)
            add_subtree(&s->subtree[s->body[i].parent], &s->subtree[i]);
    }
    for (uint32_t k = 0; k < d->held_count; k++)
        if (d->held[k].frame != TFA_FRAME_LOCAL)
            held_pairs(s, &d->held[k], &p);
    if (s->m->damping || s->m->friction)
        add_dissipation(s, &p);
}
