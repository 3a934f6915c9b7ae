/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Layout `scalar`: between the arrays of a request and the lanes of a state
 * (dynamics/solve/load.h).
 */
#ifndef TFA_LAYOUT_SCALAR_LOAD_H
#define TFA_LAYOUT_SCALAR_LOAD_H

#include "layout/state.h"

/* Changes of the robot by the request. Returns whether the results of the request before are of the
 * same one. */
int TFA_V(load_changes)(struct state *s, const tfa_request *r);

/* Bodies that the answer depends on, in ascending order. Returns how many spans there are. */
uint32_t TFA_V(load_spans)(const struct state *s, const tfa_request *r,
                           struct span out[TFA_MAX_TIPS]);

/* Wrench w of the request in the coordinates of its link's body or of the world. Needs the pose. */
svec TFA_V(wrench_of)(const struct state *s, const tfa_request *r, uint32_t w);

/* s->wrench, and the forces that follow from it. Needs the pose. */
void TFA_V(load_wrenches)(struct state *s, const tfa_request *r);

/* Modal coordinates. Returns whether they are unchanged. */
int TFA_V(load_modes)(struct state *s, const tfa_request *r);
/* Their velocities, and their forces - K eta - D eta'. Returns whether some velocity is not 0. */
int TFA_V(load_mode_velocities)(struct state *s, const tfa_request *r);

/* One number of an array of states, `stride` numbers each, from the state of every lane. */
static inline num gather_states(const struct state *s, const double *array, size_t stride,
                                size_t index)
{
    return num_gather(array + index, stride, s->lane);
}

static inline num gather_joint(const struct state *s, const double *array, size_t stride,
                               source from)
{
    return gather_states(s, array, stride, from);
}

/* Where body i of the model stands in the state */
static inline uint32_t body_at(const struct state *s, uint32_t i)
{
    (void)s;
    return i;
}

/* Damping and friction of freedom j */
static inline num load_damping_of(const struct state *s, uint32_t j)
{
    return num_of(s->m->damping[j]);
}

static inline num load_friction_of(const struct state *s, uint32_t j)
{
    return num_of(s->m->friction[j]);
}

/* A freedom of the joints; those that follow others are not public. */
static inline void scatter_joint(const struct state *s, num x, double *joints, const freedom *f)
{
    if (f->multiplier == 1)
        scatter_states(s, x, joints + f->from, s->m->v_count);
}

#endif
