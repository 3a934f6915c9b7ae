/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Constraints between frames (tfa_constraint): the rows that the active ones hold, of the relative
 * motion w = J_c v of their frames. Each side on a link takes the place of a tip, whose wrenches
 * act at the frame's origin by axes of the first frame, those of the first side reversed: J_c is
 * the sum of both sides' Jacobians.
 */
#ifndef TFA_DYNAMICS_OSIM_CONSTRAINT_ROWS_H
#define TFA_DYNAMICS_OSIM_CONSTRAINT_ROWS_H

#include "dynamics/osim/tip_rows.h"

/* Sides of the constraints become the tips of the state; numbers of their rows. */
void TFA_V(constraints_activate)(struct state *s, uint32_t constraints);

/* Where their frames are, and how they move: s->relative. Needs the pose and s->qd. */
void TFA_V(constraints_locate)(struct state *s);

/* Axes, by columns, and point of tip t in its body's coordinates. Needs constraints_locate. */
void TFA_V(closing_at)(const struct state *s, uint32_t t, mat3 *R, vec3 *p);

/* J_c^T by freedoms in s->psi, held row r in its column constraint_column. */
void TFA_V(constraint_jacobian)(struct state *s);
uint32_t TFA_V(constraint_column)(const struct state *s, uint32_t row);

/* S Lambda^-1 S^T = B^T B, all six rows of each active constraint, 0 where it holds none. Needs
 * tip_rows before Gram-Schmidt. Returns 1 when all of it is finite. */
int TFA_V(delassus)(const struct state *s, double *out);

/* out = J_c x, in held rows */
void TFA_V(constraint_motion)(struct state *s, const num *x, num *out);

/* tau += J_c^T F of forces in held rows */
void TFA_V(constraint_force)(struct state *s, const num *F, num *tau);

#endif
