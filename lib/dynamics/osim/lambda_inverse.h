/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Lambda from Lambda^-1 = V diag(d) V^T, rank-revealing: Lambda = V diag(g) V^T, g = 1/d above a
 * threshold, below it by the request's policy (tfa_rank_loss).
 */
#ifndef TFA_DYNAMICS_OSIM_LAMBDA_INVERSE_H
#define TFA_DYNAMICS_OSIM_LAMBDA_INVERSE_H

#include "layout/state.h"

/* Factors s->lambda (upper triangle, six rows a tip) in the s->tip_rows of each tip. `relative`: of
 * the threshold; 0: the default. Returns 0 if Lambda^-1 is not finite. */
int TFA_V(lambda_factor)(struct state *s, tfa_rank_loss policy, double relative, tfa_rank *rank);

/* y = Lambda x, refined once in the directions above the threshold. x and y differ; scratch: as
 * many numbers twice. */
void TFA_V(lambda_mul)(const struct state *s, const num *x, num *y, num *scratch);

/* Lambda itself. Returns 1 when all of it is finite. */
int TFA_V(lambda_dense)(const struct state *s, double *out);

#endif
