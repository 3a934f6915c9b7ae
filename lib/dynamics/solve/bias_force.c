/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The terms of the bias force by passes of recursive Newton-Euler.
 */
#include "dynamics/solve/bias_force.h"

#include "dynamics/core/recursions.h"
#include "dynamics/core/velocity_step.h"
#include "spatial/friction.h"

static void zero(const struct state *s, num *x)
{
    for (uint32_t j = 0; j < s->freedoms; j++)
        x[j] = num_of(0);
}

void TFA_V(gravity_force)(struct state *s, num *out)
{
    const int moving = s->moving;
    zero(s, s->dx);
    s->moving = 0;
    TFA_V(rnea)(s, s->dx, out, 1);
    s->moving = moving;
}

void TFA_V(velocity_force)(struct state *s, num *out)
{
    const vec3 gravity = s->gravity;
    zero(s, out);
    if (!s->moving)
        return;
    zero(s, s->dx);
    s->gravity = v3_zero();
    for (uint32_t i = 0; s->wrenched && i < s->bodies; i++)
        s->p[i] = gyroscopic(s, i);
    TFA_V(rnea)(s, s->dx, out, 1);
    for (uint32_t i = 0; s->wrenched && i < s->bodies; i++)
        s->p[i] = sv_sub(gyroscopic(s, i), s->wrench[i]);
    s->gravity = gravity;
}

void TFA_V(damping_force)(const struct state *s, num *out)
{
    zero(s, out);
    for (uint32_t j = s->m->base_freedoms; s->m->damping && j < s->freedoms; j++)
        out[j] = num_of(s->m->damping[j]) * world_velocity(s, j);
}

static void add_friction(const struct state *s, num *out)
{
    const num scale = num_of(s->m->friction_velocity);
    for (uint32_t j = s->m->base_freedoms; s->m->friction && j < s->freedoms; j++)
        out[j] += num_of(s->m->friction[j]) * friction_sign(world_velocity(s, j), scale);
}

void TFA_V(friction_force)(const struct state *s, num *out)
{
    zero(s, out);
    add_friction(s, out);
}

void TFA_V(dissipative_force)(const struct state *s, num *out)
{
    TFA_V(damping_force)(s, out);
    add_friction(s, out);
}

/* The forces of the joints that wrenches inside fused joints cause are among the passive ones, with
 * the damping and the friction. */
void TFA_V(external_force)(struct state *s, num *out)
{
    zero(s, out);
    if (!s->wrenched)
        return;
    for (uint32_t i = 0; i < s->bodies; i++)
        s->f[i] = sv_neg(s->wrench[i]);
    for (uint32_t i = s->bodies; i-- > 0;) {
        const struct tfa_body *b = &s->body[i];
        joint_force(s, b, s->f[i], out + b->v);
        if (b->parent >= 0)
            s->f[b->parent] = sv_add(s->f[b->parent], xform_t_force(&s->X[i], s->f[i]));
    }
    TFA_V(dissipative_force)(s, s->dx);
    for (uint32_t j = 0; s->has_passive_force && j < s->freedoms; j++)
        out[j] -= s->passive_force[j] + s->dx[j];
}

static void subtract(const struct state *s, num *x, const num *y)
{
    for (uint32_t j = 0; j < s->freedoms; j++)
        x[j] -= y[j];
}

/* - H^T (v x* f) = (v x H)^T f of joint i: H is constant in its body, but each axis of fused joints
 * in the part that it moves, without the velocities of the axes behind. */
static void turning_force(const struct state *s, uint32_t i, num *out)
{
    const struct tfa_body *b = &s->body[i];
    svec v = s->a[i];
    joint_force(s, b, sv_neg(cross_force(v, s->f[i])), out);
    for (uint32_t k = is_fused(b->kind) ? b->n : 0; k-- > 0;) {
        const svec H = joint_nd_axis(&s->joint_nd[b->joint_nd], k);
        out[k] = -sv_dot(H, cross_force(v, s->f[i]));
        v = sv_sub(v, sv_scale(H, s->dx[b->v + k]));
    }
}

/* rnea of v for accelerations leaves velocities in s->a and the momenta of subtrees in s->f. p =
 * H^T f has the rate (v x H)^T f + H^T df/dt, and df/dt is what acts on the subtree: tau, damping,
 * friction, weight and wrenches. */
void TFA_V(generalised_momentum)(struct state *s, num *p, num *rate)
{
    num *term = s->qdd_unrefined;
    for (uint32_t j = 0; j < s->freedoms; j++)
        s->dx[j] = world_velocity(s, j);
    TFA_V(rnea)(s, s->dx, p, 0);
    for (uint32_t i = 0; i < s->bodies; i++)
        turning_force(s, i, rate + s->body[i].v);
    TFA_V(gravity_force)(s, term);
    subtract(s, rate, term);
    TFA_V(dissipative_force)(s, term);
    subtract(s, rate, term);
    TFA_V(external_force)(s, term);
    subtract(s, rate, term);
}
