/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Velocities and velocity-product terms, outward.
 */
#include "kernel/body.h"
#include "kernel/kernel.h"

/* A fused joint's subspace changes with q. Part by part, in the coordinates of the body:
 *   v <- v + H_k qd_k,  c <- c + v x H_k qd_k */
static svec move_fused(struct state *s, uint32_t i, const struct tfa_body *b, svec v)
{
    const struct multi *w = &s->multi[b->multi];
    svec c = sv_zero();
    for (uint32_t k = 0; k < b->n; k++) {
        const svec joint = sv_scale(multi_axis(w, k), s->qd[b->v + k]);
        c = sv_add(c, cross_motion(v, joint));
        v = sv_add(v, joint);
    }
    s->c[i] = c;
    return v;
}

/* v_i = X_i v_parent + H_i qd_i,  c_i = v_i x H_i qd_i */
static inline void move(struct state *s, uint32_t i, const struct tfa_body *b)
{
    svec v = b->parent < 0 ? sv_zero() : x_motion(&s->X[i], s->v[b->parent]);
    num qd = s->qd[b->v];
    if (b->kind == TFA_KIND_REVOLUTE) {
        s->c[i] =
            (svec){v3(v.w.y * qd, -v.w.x * qd, num_of(0)), v3(v.v.y * qd, -v.v.x * qd, num_of(0))};
        v.w.z += qd;
    } else if (b->kind == TFA_KIND_PRISMATIC) {
        s->c[i] = (svec){v3_zero(), v3(v.w.y * qd, -v.w.x * qd, num_of(0))};
        v.v.z += qd;
    } else if (b->kind == TFA_KIND_FUSED) {
        v = move_fused(s, i, b, v);
    } else {
        svec joint = multi_motion(&s->multi[b->multi], b->n, s->qd + b->v);
        s->c[i] = cross_motion(v, joint);
        v = sv_add(v, joint);
    }
    s->v[i] = v;
}

void TFA_V(velocity)(struct state *s)
{
    const struct tfa_model *m = s->m;
    if (!s->moving)
        return;
    for (uint32_t i = 0; i < m->bodies; i++) {
        const struct tfa_body *b = &s->body[i];
        if (s->holding && s->posture[i] & POSTURE_SILENT)
            continue;
        move(s, i, b);
        s->p[i] = sv_sub(cross_force(s->v[i], rigid_mul(b, s->v[i])), s->wrench[i]);
    }
}
