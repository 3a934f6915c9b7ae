/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Motion of one tip by the bodies of its support: twist, Jacobian, acceleration.
 *
 *     twist = sum over the support of H qd,   acceleration = sum of H qdd + v x H qd
 *     and of Phi eta',                        and of Phi eta'' + Phi-dot eta' + v x Phi eta'
 *
 * in world axes at the tip's point. The pose is needed, and for twists and accelerations s->qd.
 */
#ifndef TFA_DYNAMICS_KINEMATICS_TIP_MOTION_H
#define TFA_DYNAMICS_KINEMATICS_TIP_MOTION_H

#include "dynamics/kinematics/world_pose.h"

struct tip {
    tfa_reference_frame frame;
    uint32_t length; /* bodies of its support, in s->tip_path, root first; 0: fixed to the world */
    uint32_t moved;  /* freedoms of the last body's joint that move it */
    int32_t handle;  /* of the last body, a flexible one, on which it rides; or -1 */
    mat3 axes;       /* of the frame, by columns: in the world if they are asked for */
    vec3_simd p;     /* point that its motion is about, world */
};

/* World poses of the supports of all tips, for the request under way: where motion of tips is
 * asked for, Lambda^-1 takes its axes from them. */
void TFA_V(locate_tips)(struct state *s);

/* Finds support and point of tip t; writes s->tip_path and the world poses of its support. */
void TFA_V(tip_locate)(struct state *s, uint32_t t, tfa_reference_frame mode, struct tip *out);

/* Of a tip about its point, in world axes */
struct tip_velocity {
    struct motion_simd twist;   /* sum of H qd over the support */
    struct motion_simd product; /* sum of v x H qd, v that of the bodies before */
    int boosted;                /* both are those in the frame that moves along (load.h) */
    vec3_simd boost;            /* its velocity */
};

/* From s->qd, joint by joint: needs no velocities of bodies */
void TFA_V(tip_velocity)(const struct state *s, const struct tip *t, struct tip_velocity *out);

/* Linear, then angular velocity in the frame asked for */
void TFA_V(tip_twist)(const struct tip *t, const struct tip_velocity *motion, num twist[6]);

/* Time derivative of these components: J-dot v, and J qdd unless qdd is NULL. Where the state is
 * boosted, with qdd as in s->qdd, or s->boost_rate for qdd = 0 in the world. */
void TFA_V(tip_acceleration)(const struct state *s, const struct tip *t,
                             const struct tip_velocity *motion, const num *qdd,
                             num acceleration[6]);

/* J x without velocities */
void TFA_V(tip_jacobian_mul)(const struct state *s, const struct tip *t, const num *x, num out[6]);

/* tau += J^T F, inner freedoms */
void TFA_V(tip_jacobian_tmul)(const struct state *s, const struct tip *t, const num F[6], num *tau);

/* tau = J^T F of all tips; F has s->tip_rows numbers for each. */
void TFA_V(tips_jacobian_tmul)(struct state *s, tfa_reference_frame frame, const num *F, num *tau);

/* The first `rows` rows of J into rows of `stride` doubles that are zero: public columns. In the
 * same pass the velocity, unless `motion` is NULL. Returns 1 when all columns are finite. */
int TFA_V(tip_jacobian)(const struct state *s, const struct tip *t, uint32_t rows, double *J,
                        size_t stride, struct tip_velocity *motion);

#endif
