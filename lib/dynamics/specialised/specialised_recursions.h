/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The walks over the bodies of one robot, written out: ROBOT_OUTWARD(DO) is DO(0) DO(1) .., so that
 * every step of the algorithms (aba_step.h, rnea_step.h ..) sees the constants of its body, and
 * what they make zero, one, or never happen is not in the code.
 */
#ifndef TFA_DYNAMICS_SPECIALISED_SPECIALISED_RECURSIONS_H
#define TFA_DYNAMICS_SPECIALISED_SPECIALISED_RECURSIONS_H

#include <string.h>

#include "dynamics/core/pose_step.h"
#include "dynamics/core/rnea_step.h"
#include "dynamics/core/sentinel.h"
#include "dynamics/core/velocity_step.h"
#include "interface/specialised_abi.h"
#include "layout/parent_transfer.h"
#include "layout_inputs.h"

/* Whether body i is on the path from body `tip` to the world */
TFA_INLINE int is_on_path(int32_t i, int32_t tip)
{
    return (int)(robot_path[tip][i / 64] >> (i % 64) & 1);
}

/* States whose numbers are finite: answers of a singular robot are none, or too large. */
TFA_INLINE num_mask finite_states(const num *x, size_t count)
{
    num_mask finite = num_is_moderate(x[0]);
#pragma GCC unroll 64
    for (size_t k = 1; k < count; k++)
        finite &= num_is_moderate(x[k]);
    return finite;
}

#ifdef ROBOT_PAYLOADS
/* Bodies with the payloads of the request */
TFA_INLINE void add_request_payloads(struct state *s, struct robot_inputs *in,
                                     const struct tfa_host_api *host, const tfa_request *r)
{
    const struct tfa_model *m = host->model;
    memcpy(in->loaded_bodies, m->body, sizeof in->loaded_bodies);
    for (uint32_t k = 0; k < r->payload_count; k++) {
        const struct tfa_frame *f = &m->frame[r->payload_frames[k]];
        if (f->body >= 0) /* or the world carries it */
            host->add_payload(&in->loaded_bodies[f->body], f,
                              r->payloads + TFA_PAYLOAD_NUMBERS * (size_t)k);
    }
    s->loaded = in->loaded_bodies;
    host->payload_size(m, r->payload_count, r->payloads, s->payload_size);
}
#endif

TFA_INLINE void init_state(struct state *s, struct robot_inputs *in,
                           const struct tfa_host_api *host, const tfa_request *r)
{
    s->m = host->model;
    s->q = in->angle;
    s->sine = in->sine;
    s->cosine = in->cosine;
    s->qd = in->qd;
    s->base = in->base;
    s->locked = 0;
    sentinel_reset(s);
#ifdef ROBOT_PAYLOADS
    add_request_payloads(s, in, host, r);
#endif
    s->gravity = v3_load(r->gravity ? r->gravity : host->model->gravity);
}

#define ROBOT_POSE(i) pose_body(s, i);
#define ROBOT_VELOCITY(i)                                                                          \
    velocity_step(s, i, &robot_unit[i], velocity_from_parent(s, i, &robot_unit[i]));               \
    s->p[i] = gyroscopic(s, i);
#define ROBOT_RNEA_FORWARD(i)                                                                      \
    euler_out(                                                                                     \
        s, i,                                                                                      \
        sv_add(motion_to_child(s, i, &robot_unit[i], parent_motion(&robot_unit[i], s->a, ground)), \
               s->c[i]),                                                                           \
        qdd, &s->p[i]);
#define ROBOT_RNEA_BACKWARD(i)                                                                     \
    add_total_forces_of_children(s, i);                                                            \
    euler_joint(s, i, qdd, tau);                                                                   \
    if (robot_unit[i].parent >= 0)                                                                 \
        add_total_force_to_parent(s, i, force_to_parent(s, i, &robot_unit[i], s->f[i]));

/* Recursive Newton-Euler: tau = M qdd + h */
TFA_INLINE void inverse_rnea(struct state *s, const num *qdd, num *tau)
{
    const svec ground = {v3_zero(), v3_neg(s->gravity)};
    ROBOT_UNITS_OUTWARD(ROBOT_POSE)
    ROBOT_UNITS_OUTWARD(ROBOT_VELOCITY)
    ROBOT_UNITS_OUTWARD(ROBOT_RNEA_FORWARD)
    ROBOT_UNITS_INWARD(ROBOT_RNEA_BACKWARD)
}

#endif
