/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Velocity and velocity-product terms of one body.
 */
#ifndef TFA_DYNAMICS_CORE_VELOCITY_STEP_H
#define TFA_DYNAMICS_CORE_VELOCITY_STEP_H

#include "dynamics/core/revolute.h"
#include "layout/body.h"
#include "layout/parent_transfer.h"

/* A fused joint's subspace changes with q. Part by part, in the coordinates of the body:
 *   v <- v + H_k qd_k,  c <- c + v x H_k qd_k */
static inline svec fused_velocity(struct state *s, uint32_t i, const body_constants *b, svec v)
{
    const struct joint_nd *w = &s->joint_nd[b->joint_nd];
    svec c = sv_zero();
    for (uint32_t k = 0; k < b->n; k++) {
        const svec joint = sv_scale(joint_nd_axis(w, k), s->qd[b->v + k]);
        c = sv_add(c, cross_motion(v, joint));
        v = sv_add(v, joint);
    }
    s->c[i] = c;
    return v;
}

/* v = X_i v_parent is given:  v_i = X_i v_parent + H_i qd_i,  c_i = v_i x H_i qd_i */
static inline void velocity_step(struct state *s, uint32_t i, const body_constants *b, svec v)
{
    num qd = s->qd[b->v];
    if (is_revolute(b->kind)) {
        s->c[i] = revolute_velocity_product(v, qd);
        v.w.z += qd;
    } else if (is_prismatic(b->kind)) {
        s->c[i] = (svec){v3_zero(), v3(v.w.y * qd, -v.w.x * qd, num_of(0))};
        v.v.z += qd;
    } else if (b->base) {
        v = base_motion(s->qd + b->v);
        s->c[i] = sv_zero();
    } else if (is_fused(b->kind)) {
        v = fused_velocity(s, i, b, v);
    } else {
        svec joint = joint_nd_motion(&s->joint_nd[b->joint_nd], b->n, s->qd + b->v);
        s->c[i] = cross_motion(v, joint);
        v = sv_add(v, joint);
    }
    s->v[i] = v;
}

/* v x* I v */
TFA_INLINE svec gyroscopic(const struct state *s, uint32_t i)
{
    const body_constants *b = body_with_payload(s, i);
    return s6_rigid_bias(body_I(b), body_h(b), body_mass(b), s->v[i]);
}

#endif
