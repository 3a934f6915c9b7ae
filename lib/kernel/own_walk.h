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

#ifdef OWN_LOADED
/* Bodies with the payloads of the request */
TFA_INLINE void own_carry_payloads(struct state *s, struct own_inputs *in,
                                   const struct tfa_own_host *host, const tfa_request *r)
{
    const struct tfa_model *m = host->model;
    memcpy(in->carried, m->body, sizeof in->carried);
    for (uint32_t k = 0; k < r->payload_count; k++) {
        const struct tfa_frame *f = &m->frame[r->payload_frames[k]];
        if (f->body >= 0) /* or the world carries it */
            host->add_payload(&in->carried[f->body], f,
                              r->payloads + TFA_PAYLOAD_NUMBERS * (size_t)k);
    }
    s->loaded = in->carried;
    s->payload_bound = num_of(host->payload_bound(m, r->payload_count, r->payloads));
}
#endif

TFA_INLINE void own_start(struct state *s, struct own_inputs *in, const struct tfa_own_host *host,
                          const tfa_request *r)
{
    s->m = host->model;
    s->q = in->angle;
    s->sine = in->sine;
    s->cosine = in->cosine;
    s->qd = in->qd;
    s->base = in->base;
    s->locked = 0;
    sentinel_reset(s);
    s->payload_bound = num_of(0);
#ifdef OWN_LOADED
    own_carry_payloads(s, in, host, r);
#endif
    s->gravity = v3_load(r->gravity ? r->gravity : host->model->gravity);
}

#define OWN_POSE(i) pose_body(s, i);
#define OWN_MOVE(i)                                                                                \
    move(s, i, &own_unit[i]);                                                                      \
    s->p[i] = gyroscopic(s, i);
#define OWN_FOLD(i)                                                                                \
    fold(s, i, tau, FOLD_INERTIA | FOLD_FORCE | FOLD_BIAS | FOLD_FRESH | FOLD_WATCH);
#define OWN_UNFOLD(i) unfold(s, i, parent_motion(&own_unit[i], s->a, ground), qdd, 1);

/* Articulated bodies: qdd = M^-1 (tau - h) */
TFA_INLINE void own_forward(struct state *s, const num *tau, num *qdd)
{
    const svec ground = {v3_zero(), v3_neg(s->gravity)};
    OWN_UNITS_OUTWARD(OWN_POSE)
    OWN_UNITS_OUTWARD(OWN_MOVE)
    OWN_UNITS_INWARD(OWN_FOLD)
    OWN_UNITS_OUTWARD(OWN_UNFOLD)
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
