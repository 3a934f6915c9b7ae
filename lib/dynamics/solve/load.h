/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * From the caller's arrays to the state and back.
 */
#ifndef TFA_DYNAMICS_SOLVE_LOAD_H
#define TFA_DYNAMICS_SOLVE_LOAD_H

#include <float.h>
#include <math.h>

#include "interface/traits.h"
#include "layout/state.h"

/* Reads states k .. k + count - 1 (at most NUM_LANES) of a checked request, the last one into the
 * lanes that are left over: pose and velocity terms are computed too. */
void TFA_V(load)(struct state *s, const tfa_request *r, uint32_t k, uint32_t count);

/* The tips of the request */
static inline void load_tips(struct state *s, const tfa_request *r)
{
    s->tips = r->tip_count;
    s->closings = 0;
    s->located = 0;
    s->path_body = -1;
    s->tip_rows = rows_of(r);
    for (uint32_t t = 0; t < r->tip_count; t++)
        s->tip[t] = r->tips[t];
}

/* First part of load: the indices of states and tips, and gravity. */
static inline void load_indices(struct state *s, const tfa_request *r, uint32_t k, uint32_t count)
{
    s->lanes = count;
    for (uint32_t l = 0; l < NUM_LANES; l++)
        s->lane[l] = k + (l < count ? l : count - 1);
    s->gravity = v3_load(r->gravity ? r->gravity : s->m->gravity);
    load_tips(s, r);
    s->keeps_psi = r->op == TFA_OP_TASK_TORQUES || (r->flags & FLAGS_LAMBDA) != 0;
    s->psi_frame = -1;
    s->keeps_force = 0;
}

/* A number of the lanes that count into the arrays of as many states, `stride` numbers each */
static inline void scatter_states(const struct state *s, num x, double *array, size_t stride)
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

/* 0, or not a number where x is not finite as a double: x - x; a wider number may be too large
 * for one */
static inline num nonfinite(num x)
{
    if (NUM_EPSILON < 0x1p-60) {
        num_mask small = x <= num_of(DBL_MAX);
        small &= x >= num_of(-DBL_MAX);
        x = num_select(small, x, num_of(INFINITY));
    }
    return x - x;
}

/* Inner freedoms of the states at hand from public arrays, those of the base (NULL: 0) and those of
 * the joints (NULL: 0). Returns whether some is not 0. */
int TFA_V(load_freedoms)(const struct state *s, num *out, const double *base, const double *joints);

/* s->tau from public forces alone: a follower's is part of its leader's already. */
void TFA_V(load_forces)(struct state *s, const double *base, const double *joints);
/* The same of the request, with passive forces, which are there */
void TFA_V(load_tau)(struct state *s, const tfa_request *r);

/* Galilei's transformation. In an observer's frame that has the velocity V of a root body's origin
 * all forces and accelerations of joints are the same, and no product of a large V can cost digits
 * of them. The body's linear velocity is 0 there; its acceleration, by components in its own axes,
 * is larger by w x V, as V turns in these axes. Every free root body, the floating base among them,
 * has such a frame for its tree. s->qd -> qd and boost = V; s->qdd is in the frame from here on. A
 * locked joint and a rotor act on the components themselves: such a body keeps its velocity. */
void TFA_V(leave_boost)(struct state *s);

/* s->qdd as load_accelerations makes it of what unload_qdd wrote */
void TFA_V(round_accelerations)(struct state *s);

/* s->qdd from public accelerations. Needs leave_boost. */
void TFA_V(load_accelerations)(struct state *s, const double *base, const double *joints);

/* s->qdd in the frame of the world: itself, or in s->dx. */
const num *TFA_V(world_accelerations)(const struct state *s);

#include "layout_load.h"

/* Writes freedoms as doubles to the base's and the joints' arrays of state k (either may be NULL),
 * those of the other lanes behind. Returns 1 when all are finite. */
int TFA_V(unload)(const struct state *s, const num *x, double *base, double *joints);

/* Forces with the same T^T tau (mimic.c), all of them on leaders. */
void TFA_V(gather_on_leaders)(struct state *s, num *tau);

/* A force of inner freedoms to public arrays, followers' on their leaders. Returns 1 when all of it
 * is finite. */
int TFA_V(unload_force)(struct state *s, num *x, double *base, double *joints);

/* Inverse dynamics of s->qdd to the reply. Returns 1 when all of it is finite. */
int TFA_V(inverse_dynamics)(struct state *s, uint32_t k, tfa_reply *reply);

/* Writes s->qdd out; returns 1 when all of it is finite. */
int TFA_V(unload_qdd)(const struct state *s, uint32_t k, tfa_reply *reply);

#endif
