/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Lambda = (B^T B)^-1 from factors of B (tip_rows.h), with Lambda^-1 never formed: errors grow with
 * the condition of B, not with its square.
 *
 * B is taken about each tip's point, also where the request's frame is the world's, and a radian
 * counts as tip_length metres: singular values have one unit, 1/sqrt(kg), whatever the units of the
 * model and the axes of the tip. With B = Q U, Q^T Q = S, Lambda = U^-1 S^-1 U^-T where all
 * eigenvalues d of B^T B are above the threshold t; else it is V diag(g) V^T of singular directions
 * v with gains g by the request's policy (tfa_rank_loss). Either is a sum of weighted squares of
 * rows, s->direction and s->weight, which all products share.
 */
#ifndef TFA_DYNAMICS_OSIM_LAMBDA_INVERSE_H
#define TFA_DYNAMICS_OSIM_LAMBDA_INVERSE_H

#include "dynamics/osim/tip_rows.h"

/* Rows of the world's frame mix linear with angular motion by the distance of its origin: they are
 * taken about the tip's point. Three rows alone cannot be. */
static inline tfa_reference_frame tip_metric_frame(const tfa_request *r)
{
    return r->frame == TFA_FRAME_WORLD && r->rows != TFA_ROWS_POINT ? TFA_FRAME_LOCAL_WORLD_ALIGNED
                                                                    : r->frame;
}

/* Factors for the tips of the request; rank->error_estimate: rounding. Needs what tip_rows needs.
 * Returns 0 if B is not finite. `directions`: singular ones in any case, for
 * lambda_inverse_error. */
int TFA_V(lambda_factor)(struct state *s, const tfa_request *r, int directions, tfa_rank *rank);

/* Its two steps. The metric of the request: length, arms */
void TFA_V(metric_load)(struct state *s, const tfa_request *r);
/* Factors of any s->tip_freedoms rows in s->phi, in the metric; thresholds are relative to `size`,
 * 0: the sum of their squares */
int TFA_V(factor_rows)(struct state *s, const tfa_request *r, int directions, num size,
                       tfa_rank *rank);

/* y = Lambda (J M^-1 tau - x), x in rows of the answer or NULL, without J M^-1 tau: as accurate as
 * Lambda itself. Takes tau and needs what force_rows does. */
void TFA_V(lambda_force)(struct state *s, const num *tau, const num *x, num *y);

/* Least squares with factors of any rows B: y = B^+ z - (B^T B)^+ x, out of the metric, by the
 * policy. z is used up; x may be NULL. */
void TFA_V(least_squares)(struct state *s, num *z, const num *x, num *y);

/* z = B y of that answer */
void TFA_V(least_squares_image)(const struct state *s, num *z);

/* Lambda itself. Returns 1 when all of it is finite. */
int TFA_V(lambda_dense)(struct state *s, double *out);

/* What is left out of the acceleration x by directions at or below the threshold: rows as in
 * tfa_reply.lost, at most TFA_LOST_MAX, by ascending singular value. */
void TFA_V(lambda_lost)(struct state *s, const num *x, double *out);

#endif
