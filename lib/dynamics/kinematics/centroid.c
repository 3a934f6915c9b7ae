/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Mass, centre of mass, momentum and energy by sums over bodies.
 */
#include "dynamics/kinematics/centroid.h"

#include "dynamics/core/modes.h"
#include "dynamics/kinematics/world_pose.h"

/* First moment of body i in its frame, deformed as it is */
static vec3 body_moment(const struct state *s, uint32_t i)
{
    const int32_t flexible = s->body[i].flexible;
    const vec3 h = body_h(&s->body[i]);
    return flexible < 0 ? h : v3_add(h, TFA_V(modes_moment)(s, i));
}

/* I v of body i, and what its modes add: B^T eta' */
static svec body_momentum(const struct state *s, uint32_t i)
{
    const svec h = rigid_mul(&s->body[i], s->v[i]);
    return s->body[i].flexible < 0 ? h : sv_add(h, TFA_V(modes_momentum)(s, i));
}

/* Mass of body i, and mass times its centre in the world */
static num first_moment(const struct state *s, uint32_t i, vec3 *moment)
{
    const struct world_pose *W = &s->world[i];
    const num m = body_mass(&s->body[i]);
    *moment = v3_add(v3_scale(vec3_of_simd(W->r), m),
                     vec3_of_simd(mat3_simd_apply_t(&W->E, body_moment(s, i))));
    return m;
}

/* The same of all bodies */
static num total_moment(const struct state *s, vec3 *moment)
{
    num mass = num_of(0);
    *moment = v3_zero();
    for (uint32_t i = 0; i < s->bodies; i++) {
        vec3 h;
        mass += first_moment(s, i, &h);
        *moment = v3_add(*moment, h);
    }
    return mass;
}

num TFA_V(centre_of_mass)(const struct state *s, vec3 *com)
{
    const num mass = total_moment(s, com);
    if (mass > 0)
        *com = v3_scale(*com, 1 / mass);
    return mass;
}

void TFA_V(return_boost)(struct state *s)
{
    for (uint32_t i = 0; i < s->bodies; i++) {
        const struct tfa_body *b = &s->body[i];
        const num *x = s->boost + b->v;
        vec3 boost = v3_zero();
        if (b->parent >= 0)
            boost = m3_mul(s->X[i].E, s->a[b->parent].v);
        else if (is_free(b->kind))
            boost = v3(x[0], x[1], x[2]);
        s->a[i].v = boost;
        s->v[i].v = v3_add(s->v[i].v, boost);
    }
}

svec TFA_V(momentum)(const struct state *s, vec3 about)
{
    svec sum = sv_zero();
    for (uint32_t i = 0; s->moving && i < s->bodies; i++) {
        const struct world_pose *W = &s->world[i];
        const svec h = body_momentum(s, i);
        const vec3 linear = vec3_of_simd(mat3_simd_apply_t(&W->E, h.v)),
                   angular = vec3_of_simd(mat3_simd_apply_t(&W->E, h.w)),
                   arm = v3_sub(vec3_of_simd(W->r), about);
        sum.v = v3_add(sum.v, linear);
        sum.w = v3_add(sum.w, v3_add(angular, v3_cross(arm, linear)));
    }
    return sum;
}

num TFA_V(kinetic_energy)(const struct state *s)
{
    num sum = num_of(0);
    for (uint32_t i = 0; s->moving && i < s->bodies; i++) {
        const struct tfa_body *b = &s->body[i];
        sum += sv_dot(s->v[i], rigid_mul(b, s->v[i]));
        if (b->flexible >= 0)
            sum += TFA_V(modes_kinetic)(s, i);
        for (uint32_t k = 0; k < b->n; k++)
            sum += joint_armature(s, b, k) * s->qd[b->v + k] * s->qd[b->v + k];
    }
    return sum / 2;
}

num TFA_V(potential_energy)(const struct state *s)
{
    vec3 moment;
    (void)total_moment(s, &moment);
    return -v3_dot(s->gravity, moment) + (HAS_MODES(s) ? TFA_V(modes_elastic)(s) : num_of(0));
}

/* Column k of the joint's motion subspace, in the coordinates of body i */
static svec joint_axis(const struct state *s, uint32_t i, uint32_t k)
{
    const struct tfa_body *b = &s->body[i];
    const num o = num_of(0), l = num_of(1);
    if (is_revolute(b->kind))
        return (svec){{o, o, l}, {o, o, o}};
    if (is_prismatic(b->kind))
        return (svec){{o, o, o}, {o, o, l}};
    return joint_nd_axis(&s->joint_nd[b->joint_nd], k);
}

/* s->f: mass (w.x) and first moment (v) of the subtree of each body, in its coordinates about its
 * origin: nothing cancels far from the origin of the world. Column of a freedom: its motion of the
 * subtree's centre, times mass over all mass. */
void TFA_V(com_jacobian)(struct state *s, double *out, size_t stride)
{
    num mass = num_of(0);
    for (uint32_t i = 0; i < s->bodies; i++) {
        s->f[i].w.x = body_mass(&s->body[i]);
        s->f[i].v = body_moment(s, i);
        mass += s->f[i].w.x;
    }
    for (uint32_t i = s->bodies; mass > 0 && i-- > 0;) {
        const struct tfa_body *b = &s->body[i];
        const num share = s->f[i].w.x / mass;
        const vec3 moment = v3_scale(s->f[i].v, 1 / mass);
        for (uint32_t k = 0; k < b->n; k++) {
            num multiplier;
            double *at = out + TFA_V(reduced_freedom)(s->m, b->v + k, &multiplier);
            const svec H = joint_axis(s, i, k);
            const vec3 c = vec3_of_simd(mat3_simd_apply_t(
                &s->world[i].E, v3_add(v3_scale(H.v, share), v3_cross(H.w, moment))));
            at[0] += (double)(multiplier * c.x);
            at[stride] += (double)(multiplier * c.y);
            at[2 * stride] += (double)(multiplier * c.z);
        }
        if (b->parent < 0)
            continue;
        svec *parent = &s->f[b->parent];
        parent->v = v3_add(parent->v,
                           v3_add(m3_tmul(s->X[i].E, s->f[i].v), v3_scale(s->X[i].r, s->f[i].w.x)));
        parent->w.x += s->f[i].w.x;
    }
}
