/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Between the arrays of one state and lanes that hold its bodies (load.h).
 */
#ifndef TFA_LAYOUT_BODY_LANES_LOAD_H
#define TFA_LAYOUT_BODY_LANES_LOAD_H

#include "layout/state.h"

/* Requests that are answered with several bodies in lanes change nothing about the robot
 * (body_lanes.c). */
static inline int TFA_V(load_changes)(struct state *s, const tfa_request *r)
{
    (void)s;
    (void)r;
    return 1;
}

static inline uint32_t TFA_V(load_spans)(const struct state *s, const tfa_request *r,
                                         struct span out[TFA_MAX_TIPS])
{
    (void)r;
    out[0] = (struct span){0, s->bodies};
    return 1;
}

static inline void TFA_V(load_wrenches)(struct state *s, const tfa_request *r)
{
    (void)s;
    (void)r;
}

static inline int TFA_V(load_modes)(const struct state *s, const tfa_request *r)
{
    (void)s;
    (void)r;
    return 1;
}

static inline int TFA_V(load_mode_velocities)(const struct state *s, const tfa_request *r)
{
    (void)s;
    (void)r;
    return 0;
}

/* One number of an array of states, `stride` numbers each, the same in every lane; */
static inline num gather_states(const struct state *s, const double *array, size_t stride,
                                size_t index)
{
    return num_of(array[stride * s->lane[0] + index]);
}

/* and that of every lane's joint. */
static inline num gather_joint(const struct state *s, const double *array, size_t stride,
                               source from)
{
    return num_gather(array + stride * s->lane[0], 1, from.lane);
}

static inline uint32_t body_at(const struct state *s, uint32_t i)
{
    return s->step_of[i];
}

static inline num load_damping_of(const struct state *s, uint32_t j)
{
    return s->lane_damping[j];
}

static inline num load_friction_of(const struct state *s, uint32_t j)
{
    return s->lane_friction[j];
}

/* A freedom of the joints, of every lane that holds one */
static inline void scatter_joint(const struct state *s, num x, double *joints, const freedom *f)
{
    (void)s;
    for (uint32_t l = 0; l < NUM_LANES; l++)
        if (f->lane_mask >> l & 1)
            joints[f->from.lane[l]] = num_lane(x, l);
}

#endif
