/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The oracle's operational space: motion of tips and of the centre of mass, dense, in quadruple
 * precision. Freedoms as in oracle.h, n = rows of the oracle's answers; `rows` is 6 or 3 for each
 * tip, three being the linear ones.
 */
#ifndef TESTS_SUPPORT_ORACLE_OPERATIONAL_H
#define TESTS_SUPPORT_ORACLE_OPERATIONAL_H

#include <stdbool.h>

#include "oracle.h"
#include "quad.h"

/** Tips of a request: links of the description. */
typedef struct oracle_tips {
    const uint32_t *links;
    uint32_t count, rows; /**< rows: of each, 6 or 3 */
    tfa_reference_frame frame;
} oracle_tips;

/** (rows count) x n: twist = J v. */
void oracle_jacobian(const oracle *o, const oracle_tips *tips, quad *J);
/** rows count: time derivative of the twist's components while those of all velocities are
 *  constant. */
void oracle_bias_acceleration(const oracle *o, const oracle_tips *tips, quad *a);
/** 6 count, whatever `rows` is. */
void oracle_twists(const oracle *o, const oracle_tips *tips, quad *twists);
/** J M^-1 J^T of an m x n J. */
void oracle_inverse_of_rows(const oracle *o, const quad *J, uint32_t m, quad *A);
/** x <- M^-1 x; 0 for rows to which nothing is tied. */
void oracle_accelerate(const oracle *o, quad *x);

/** n: forces at zero acceleration, of gravity, velocities, damping and wrenches of the state. */
void oracle_bias_force(const oracle *o, quad *h);

/** What a link's joint exerts on it, world axes, at the link's origin */
typedef struct oracle_wrench {
    vec3 force, moment;
    quad size; /**< sum of the sizes of what was added up */
} oracle_wrench;

/** F: of all links of the description, in the state that was set, which is `state` of r, with the
 *  accelerations qdd, base first: one for each row of the oracle's answers. What is absent pulls at
 *  no link. */
void oracle_joint_forces(const oracle *o, const tfa_request *r, uint32_t state, const quad *qdd,
                         const bool *absent, oracle_wrench *F);
/** The same in a frame of the link, linear first */
void oracle_wrench_in(const oracle *o, uint32_t link, tfa_reference_frame frame,
                      const oracle_wrench *F, quad out[6]);

/** Sums over everything that moves. */
typedef struct oracle_centroid {
    quad mass, kinetic, potential;
    quad com[3], velocity[3];
    quad momentum[6]; /**< linear; angular about the centre of mass */
} oracle_centroid;

oracle_centroid oracle_sums_of(const oracle *o);
/** 3 x n */
void oracle_com_jacobian(const oracle *o, quad *J);

/** Distance of a pose from the link's: of the position, relative to its distance from the origin
 *  beyond 1 m, of the axes, of the quaternion's norm from 1. INFINITY if w is negative. */
double oracle_pose_error(const oracle *o, uint32_t link, const double pose[7]);

#endif
