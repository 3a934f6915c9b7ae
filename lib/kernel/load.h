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

#if NUM_LANES == 1
/* What the request changes about the robot, and what it depends on. `same`: its coordinates are
 * those of the request before. Returns whether what was computed then is still good. */
int TFA_V(load_changes)(struct state *s, const tfa_request *r, int same);

/* s->wrench, and the forces that follow from it. Needs the pose. */
void TFA_V(load_wrenches)(struct state *s, const tfa_request *r);
#else
/* Requests that come in several states at a time change nothing about the robot (lanes.c). */
static inline int TFA_V(load_changes)(struct state *s, const tfa_request *r, int same)
{
    (void)r;
    s->spans = 1;
    s->span[0] = (struct span){0, s->m->bodies};
    return same;
}

static inline void TFA_V(load_wrenches)(struct state *s, const tfa_request *r)
{
    (void)s;
    (void)r;
}
#endif

/* One number of an array of states, `stride` numbers each, from the state of every lane. */
static inline num take(const struct state *s, const double *array, size_t stride, size_t index)
{
    return num_gather(array + index, stride, s->lane);
}

/* Writes freedoms as doubles to the base's and the joints' arrays of state k (either may be NULL),
 * those of the other lanes behind. Returns 1 when all are finite. */
int TFA_V(unload)(const struct state *s, const num *x, double *base, double *joints);

#endif
