/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Motion of one tip by the bodies of its support: twist, Jacobian, acceleration.
 *
 *     twist = sum over the support of H qd,   acceleration = sum of H qdd + c
 *
 * in world axes at the tip's point: sums of independent terms. The pose is needed, and for twists
 * and accelerations s->qd.
 */
#ifndef TFA_DYNAMICS_KINEMATICS_TIP_MOTION_H
#define TFA_DYNAMICS_KINEMATICS_TIP_MOTION_H

#include "layout/state.h"

struct tip {
    tfa_reference_frame frame;
    uint32_t length; /* bodies of its support, in s->tip_path, root first; 0: fixed to the world */
    uint32_t moved;  /* freedoms of the last body's joint that move it */
    mat3 axes;       /* of the frame in the world, by columns */
    vec3 origin;     /* of the frame in the world */
    vec3_simd p;     /* point that its motion is about, world */
};

/* World poses of the supports of all tips, for the request under way: where motion of tips is
 * asked for, Lambda^-1 takes its axes from them. */
void TFA_V(locate_tips)(struct state *s);

/* Finds support and point of tip t; writes s->tip_path and the world poses of its support. */
void TFA_V(tip_locate)(struct state *s, uint32_t t, tfa_reference_frame mode, struct tip *out);

/* Velocities and velocity products of the support, unless s->body_velocity says that all bodies
 * have theirs. Before the two functions below. */
void TFA_V(tip_velocities)(struct state *s, const struct tip *t);

/* Linear, then angular velocity in the frame asked for */
void TFA_V(tip_twist)(const struct state *s, const struct tip *t, num twist[6]);

/* Time derivative of these components: J-dot v, and J qdd unless qdd is NULL */
void TFA_V(tip_acceleration)(const struct state *s, const struct tip *t, const num *qdd,
                             num acceleration[6]);

/* J x without velocities */
void TFA_V(tip_jacobian_mul)(const struct state *s, const struct tip *t, const num *x, num out[6]);

/* tau += J^T F, inner freedoms */
void TFA_V(tip_jacobian_tmul)(const struct state *s, const struct tip *t, const num F[6], num *tau);

/* The first `rows` rows of J into rows of `stride` doubles that are zero: public columns */
void TFA_V(tip_jacobian)(const struct state *s, const struct tip *t, uint32_t rows, double *out,
                         size_t stride);

#endif
