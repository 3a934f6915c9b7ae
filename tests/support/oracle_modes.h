/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The oracle of robots with flexible links, dense and in quadruple precision.
 *
 * Poses are Taylor series of the time, products of those of joints and handles. Momenta of links
 * follow from the kinetic energy of tfa_link_modes, in world axes; the forces are their rates,
 * carried to the freedoms by Jacobians; those of modes are Lagrange's. The columns of M are the
 * forces of unit accelerations. Nothing is recursive but the poses. Freedoms: base, joints, modes
 * (link by link in the order of the links).
 */
#ifndef TESTS_SUPPORT_ORACLE_MODES_H
#define TESTS_SUPPORT_ORACLE_MODES_H

#include "oracle.h"
#include "quad.h"

typedef struct oracle_modes oracle_modes;

/** `description` and `modes` must outlive it. */
oracle_modes *oracle_modes_create(const tfa_description *description, tfa_base base,
                                  const tfa_link_modes *modes, size_t count);
void oracle_modes_free(oracle_modes *o);
/** Freedoms, those of base and modes included */
uint32_t oracle_modes_freedoms(const oracle_modes *o);

/** Takes state `state` of the request (as oracle_set_state; modes and their rates, too) and builds
 *  M, its factors, and h. */
void oracle_modes_set_state(oracle_modes *o, const tfa_request *request, uint32_t state);

/* The answers below are for the state set last. */

/** M, n x n */
const quad *oracle_modes_mass_matrix(const oracle_modes *o);
/** x = M^-1 (tau - h), n numbers, base first; forces of modes are zero. NULL: zero. h: gravity,
 *  velocities, wrenches, stiffness and damping. */
void oracle_modes_forward(const oracle_modes *o, const double *tau, const double *base_wrench,
                          double *x);

/** A link's frame: pose, twist and, with all accelerations zero, the derivative of the twist's
 *  components in `frame`. */
typedef struct oracle_modes_tip {
    vec3 p;
    mat3 R;
    quad twist[6], bias[6];
} oracle_modes_tip;
oracle_modes_tip oracle_modes_tip_of(const oracle_modes *o, uint32_t link,
                                     tfa_reference_frame frame);
/** 6 x n: twist = J x', added to J */
void oracle_modes_jacobian(const oracle_modes *o, uint32_t link, tfa_reference_frame frame,
                           quad *J);
/** J M^-1 J^T, 6 count x 6 count */
void oracle_modes_lambda_inv(const oracle_modes *o, const uint32_t *tips, uint32_t count,
                             tfa_reference_frame frame, double *lambda_inv);

/** Sums over everything that moves; kinetic with rotors and modes, potential with springs. */
typedef struct oracle_modes_sums {
    quad mass, kinetic, potential;
    vec3 com, momentum, angular; /**< angular about the centre of mass */
} oracle_modes_sums;
oracle_modes_sums oracle_modes_sums_of(const oracle_modes *o);

/** A = L D L^T in place of a symmetric A, n x n; x <- A^-1 x */
void quad_factorise(quad *A, uint32_t n);
void quad_solve(const quad *A, uint32_t n, quad *x);

#endif
