/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Lambda = (B^T B)^-1 from factors of B (tip_rows.h), with Lambda^-1 never formed: errors grow with
 * the condition of B, not with its square.
 *
 * B is taken about each tip's point, also where the request's frame is the world's, and a radian
 * counts as tip_length metres: singular values have one unit, 1/sqrt(kg), whatever the units of the
 * model and the axes of the tip. Where all eigenvalues d of B^T B are above the threshold t, Lambda
 * comes from triangular factors; else from singular directions v with gains g by the request's
 * policy (tfa_rank_loss): Lambda = V diag(g) V^T.
 */
#ifndef TFA_DYNAMICS_OSIM_LAMBDA_INVERSE_H
#define TFA_DYNAMICS_OSIM_LAMBDA_INVERSE_H

#include "layout/state.h"

/* Factors for the tips of the request. Needs the pose. Returns 0 if B is not finite. With
 * `estimate` the error of M's factors is measured: writes s->tau, s->qdd, s->res and s->dx. */
int TFA_V(lambda_factor)(struct state *s, const tfa_request *r, int estimate, tfa_rank *rank);

/* y = Lambda x, rows of the answer; x and y differ. */
void TFA_V(lambda_mul)(struct state *s, const num *x, num *y);

/* y = Lambda J M^-1 tau, without J M^-1 tau: as accurate as Lambda itself. */
void TFA_V(lambda_force)(struct state *s, const num *tau, num *y);

/* Lambda itself. Returns 1 when all of it is finite. */
int TFA_V(lambda_dense)(struct state *s, double *out);

/* What is left out of the acceleration x by directions at or below the threshold: rows as in
 * tfa_reply.lost, at most TFA_LOST_MAX, by ascending singular value. Returns how many directions
 * there are. */
uint32_t TFA_V(lambda_lost)(struct state *s, const num *x, double *out);

#endif
