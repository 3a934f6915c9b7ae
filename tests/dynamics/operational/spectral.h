/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Lambda by its definition in request.h: f(lambda_inv) in the metric of the tips, from an
 * eigendecomposition in quadruple precision.
 */
#ifndef TESTS_DYNAMICS_OPERATIONAL_SPECTRAL_H
#define TESTS_DYNAMICS_OPERATIONAL_SPECTRAL_H

#include <stdbool.h>
#include <totalforce/request.h>

#include "operational.h"

#define SPECTRAL_ROWS 24

typedef struct spectral {
    uint32_t m, rank;
    quad A[SPECTRAL_ROWS * SPECTRAL_ROWS]; /**< becomes diagonal */
    quad V[SPECTRAL_ROWS * SPECTRAL_ROWS]; /**< eigenvectors in columns */
    quad d[SPECTRAL_ROWS], f[SPECTRAL_ROWS];
    quad threshold, most, trace; /**< threshold: absolute; largest eigenvalue; sum of them */
    quad condition;              /**< trace times the sum of 1/d that are no rounding */
    double sensitivity; /**< relative error of f(B^T B) for a relative error 1 of B, at least 1 */
    quad L[SPECTRAL_ROWS * SPECTRAL_ROWS]; /**< f(A) */
} spectral;

/** The metric of the tips of a request. */
typedef struct spectral_metric {
    uint32_t tips, rows; /**< rows of each */
    double length;
    double arm[3 * OP_TIPS]; /**< of each tip, where the request's frame is the world's */
} spectral_metric;

/** Metric of state k: with the length and the poses of its answers. */
spectral_metric spectral_metric_of(const op_case *c, const op_answers *a, uint32_t k);
/** J of the oracle in the metric, of all tips; m x n. */
void spectral_jacobian(const op_case *c, const spectral_metric *metric, quad *J);
/** An acceleration to the metric, a force, a Lambda of the answers. */
void spectral_acceleration(const spectral_metric *metric, const quad *x, quad *out);
void spectral_force(const spectral_metric *metric, const double *F, quad *out);
void spectral_lambda(const spectral_metric *metric, const double *L, quad *out);

/** f(A) of a symmetric A, m x m, by the policy with a threshold relative to the trace. */
void spectral_of(spectral *s, const quad *A, uint32_t m, tfa_rank_loss policy, double threshold);
/** |L - s->L| / |s->L| in the metric, L a Lambda of the answers; 0 where s->L is. */
double spectral_error(const spectral *s, const spectral_metric *metric, const double *L);
/** |F - s->L y| in the metric, F a force of the answers, y an acceleration of the metric. *size:
 *  |s->L y|. */
double spectral_product_error(const spectral *s, const spectral_metric *metric, const quad *y,
                              const double *F, double *size);
/** Policy and threshold of a request. */
tfa_rank_loss spectral_policy(const tfa_request *r);
double spectral_threshold(const tfa_request *r, uint32_t rows);

/** Whether an eigenvalue is so close to the threshold that rounding decides its side */
bool spectral_in_doubt(const spectral *s);

#endif
