/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The walks over the bodies of one robot, written out: OWN_OUTWARD(DO) is DO(0) DO(1) .., so that every
 * step of the algorithms (aba_step.h, rnea_step.h ..) sees the constants of its body, and what they
 * make zero, one, or never happen is not in the code.
 */
#ifndef TFA_KERNEL_OWN_WALK_H
#define TFA_KERNEL_OWN_WALK_H

#include "kernel/aba_step.h"
#include "kernel/own_load.h"
#include "kernel/pose_step.h"
#include "kernel/rnea_step.h"
#include "kernel/velocity_step.h"

/* Bodies with what a request hangs on them */
TFA_INLINE const struct tfa_body *
own_carry_payloads(struct own_inputs *in, const struct tfa_own_host *host, const tfa_request *r)
{
    const struct tfa_model *m = host->model;
    if (!(OWN_KEEPS & TFA_OWN_KEEPS_PAYLOAD) || !r->payload_count)
        return m->body;
    memcpy(in->carried, m->body, sizeof in->carried);
    for (uint32_t k = 0; k < r->payload_count; k++) {
        const struct tfa_frame *f = &m->frame[r->payload_frames[k]];
        if (f->body >= 0) /* or the world carries it */
            host->add_payload(&in->carried[f->body], f,
                              r->payloads + TFA_PAYLOAD_NUMBERS * (size_t)k);
    }
    return in->carried;
}

TFA_INLINE void own_start(struct state *s, struct own_inputs *in, const struct tfa_own_host *host,
                          const tfa_request *r)
{
    s->m = host->model;
    s->loaded = own_carry_payloads(in, host, r);
    s->q = in->angle;
    s->sine = in->sine;
    s->cosine = in->cosine;
    s->qd = in->qd;
    s->base = in->base;
    s->locked = 0;
    sentinel_reset(s);
    s->payload_bound = num_of(OWN_KEEPS & TFA_OWN_KEEPS_PAYLOAD && r->payload_count
                                  ? host->payload_bound(host->model, r->payload_count, r->payloads)
                                  : 0);
    const int given = OWN_KEEPS & TFA_OWN_KEEPS_GRAVITY;
    s->gravity = v3_load(given && r->gravity ? r->gravity
                         : given             ? host->model->gravity
                                             : own_gravity);
}

/* Does the joint of a root turn about the direction of gravity? Accelerations are the same at any of its
 * angles then, and it is taken to stand at 0. */
TFA_INLINE int own_upright(const struct tfa_body *b)
{
    const double *E = b->E, *g = own_gravity;
    return b->parent < 0 && b->kind == TFA_KIND_REVOLUTE && !(OWN_KEEPS & TFA_OWN_KEEPS_GRAVITY) &&
           E[0] * g[0] + E[1] * g[1] + E[2] * g[2] == 0 &&
           E[3] * g[0] + E[4] * g[1] + E[5] * g[2] == 0;
}

TFA_INLINE void own_pose(struct state *s, uint32_t i)
{
#ifndef TFA_PACKED
    if (own_upright(&own_body[i]))
        s->X[i] = (place){m3_load(own_body[i].E), v3_load(own_body[i].r)};
    else
#endif
        pose_body(s, i);
}

#define OWN_POSE(i) own_pose(s, i);
#define OWN_POSE_WHOLE(i) pose_body(s, i);
#define OWN_MOVE(i)                                                                                \
    move(s, i, &own_unit[i]);                                                                      \
    s->p[i] = gyroscopic(s, i);
#define OWN_FOLD(i)                                                                                \
    fold(s, i, tau, FOLD_INERTIA | FOLD_FORCE | FOLD_BIAS | FOLD_FRESH | FOLD_WATCH);
#define OWN_UNFOLD(i) unfold(s, i, parent_motion(&own_unit[i], s->a, ground), qdd, 1);

/* Articulated bodies, once they stand: qdd = M^-1 (tau - h) */
TFA_INLINE void own_aba(struct state *s, const num *tau, num *qdd)
{
    const svec ground = {v3_zero(), v3_neg(s->gravity)};
    OWN_UNITS_OUTWARD(OWN_MOVE)
    OWN_UNITS_INWARD(OWN_FOLD)
    OWN_UNITS_OUTWARD(OWN_UNFOLD)
}

/* For accelerations alone; and with poses that are right for more than these */
TFA_INLINE void own_forward(struct state *s, const num *tau, num *qdd)
{
    OWN_UNITS_OUTWARD(OWN_POSE)
    own_aba(s, tau, qdd);
}

TFA_INLINE void own_forward_whole(struct state *s, const num *tau, num *qdd)
{
    OWN_UNITS_OUTWARD(OWN_POSE_WHOLE)
    own_aba(s, tau, qdd);
}

#ifndef TFA_PACKED
#define OWN_EULER(i)                                                                               \
    euler_out(s, i,                                                                                \
              sv_add(motion_down(s, i, &own_unit[i], parent_motion(&own_unit[i], s->a, ground)),   \
                     s->c[i]),                                                                     \
              qdd, &s->p[i]);
#define OWN_GATHER(i)                                                                              \
    euler_joint(s, i, qdd, tau);                                                                   \
    if (own_unit[i].parent >= 0)                                                                   \
        s->f[own_unit[i].parent] = sv_add(s->f[own_unit[i].parent < 0 ? 0 : own_unit[i].parent],   \
                                          force_up(s, i, &own_unit[i], s->f[i]));

/* Recursive Newton-Euler: tau = M qdd + h */
TFA_INLINE void own_inverse(struct state *s, const num *qdd, num *tau)
{
    const svec ground = {v3_zero(), v3_neg(s->gravity)};
    OWN_UNITS_OUTWARD(OWN_POSE)
    OWN_UNITS_OUTWARD(OWN_MOVE)
    OWN_UNITS_OUTWARD(OWN_EULER)
    OWN_UNITS_INWARD(OWN_GATHER)
}
#endif

#endif
