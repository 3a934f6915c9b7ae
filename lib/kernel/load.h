/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * From the caller's arrays to the state and back.
 */
#ifndef TFA_KERNEL_LOAD_H
#define TFA_KERNEL_LOAD_H

#include "kernel/state.h"

/* Reads states k .. k + count - 1 (at most NUM_LANES) of a checked request, the last one into the
 * lanes that are left over: pose and velocity terms are computed too. */
void TFA_V(load)(struct state *s, const tfa_request *r, uint32_t k, uint32_t count);

/* Which states these are and which tips they ask for: what load does first. */
static inline void load_names(struct state *s, const tfa_request *r, uint32_t k, uint32_t count)
{
    s->lanes = count;
    for (uint32_t l = 0; l < NUM_LANES; l++)
        s->lane[l] = k + (l < count ? l : count - 1);
    s->tips = r->tip_count;
    for (uint32_t t = 0; t < r->tip_count; t++)
        s->tip[t] = r->tips[t];
}

/* A number of the lanes that count into the arrays of as many states, `stride` numbers each */
static inline void give(const struct state *s, num x, double *array, size_t stride)
{
#if NUM_LANES == 1
    (void)s;
    (void)stride;
    array[0] = (double)x;
#else
    for (uint32_t l = 0; l < s->lanes; l++)
        array[stride * l] = (double)num_lane(x, l);
#endif
}

/* Inner freedoms of the states at hand from public arrays, those of the base (NULL: 0) and those of the joints
 * (NULL: 0). Returns whether some is not 0. */
int TFA_V(load_freedoms)(const struct state *s, num *out, const double *base, const double *joints);

#ifdef TFA_PACKED
#include "kernel/packed_load.h"
#else

/* What the request changes about the robot. Returns whether what was computed before is of the same
 * one. */
int TFA_V(load_changes)(struct state *s, const tfa_request *r);

/* Bodies that the answer depends on, in ascending order. Returns how many spans there are. */
uint32_t TFA_V(load_spans)(const struct state *s, const tfa_request *r,
                           struct span out[TFA_MAX_TIPS]);

/* s->wrench, and the forces that follow from it. Needs the pose. */
void TFA_V(load_wrenches)(struct state *s, const tfa_request *r);

/* One number of an array of states, `stride` numbers each, from the state of every lane. */
static inline num take(const struct state *s, const double *array, size_t stride, size_t index)
{
    return num_gather(array + index, stride, s->lane);
}

static inline num take_joint(const struct state *s, const double *array, size_t stride, source from)
{
    return take(s, array, stride, from);
}

/* Damping of freedom j */
static inline num load_friction(const struct state *s, uint32_t j)
{
    return num_of(s->m->damping[j]);
}

/* A freedom of the joints; those that follow others are not public. */
static inline void give_joint(const struct state *s, num x, double *joints, const freedom *f)
{
    if (f->multiplier == 1)
        give(s, x, joints + f->from, s->m->v_count);
}

#endif

/* Writes freedoms as doubles to the base's and the joints' arrays of state k (either may be NULL),
 * those of the other lanes behind. Returns 1 when all are finite. */
int TFA_V(unload)(const struct state *s, const num *x, double *base, double *joints);

#endif
