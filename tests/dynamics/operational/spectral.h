/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Lambda by its definition in request.h: f(lambda_inv) from an eigendecomposition in quadruple
 * precision.
 */
#ifndef TESTS_DYNAMICS_OPERATIONAL_SPECTRAL_H
#define TESTS_DYNAMICS_OPERATIONAL_SPECTRAL_H

#include <stdbool.h>
#include <totalforce/request.h>

#include "support/quad.h"

#define SPECTRAL_ROWS 24

typedef struct spectral {
    uint32_t m, rank;
    quad A[SPECTRAL_ROWS * SPECTRAL_ROWS]; /**< becomes diagonal */
    quad V[SPECTRAL_ROWS * SPECTRAL_ROWS]; /**< eigenvectors in columns */
    quad d[SPECTRAL_ROWS], f[SPECTRAL_ROWS];
    quad threshold, most, least; /**< threshold: absolute; extreme eigenvalues */
    double sensitivity;          /**< relative error of f(A) for a relative error 1 of A */
    quad L[SPECTRAL_ROWS * SPECTRAL_ROWS]; /**< f(A) */
} spectral;

/** f(A) of a symmetric A, m x m, by the policy with a relative threshold. */
void spectral_of(spectral *s, const double *A, uint32_t m, tfa_rank_loss policy, double threshold);

/** Is an eigenvalue so close to the threshold that rounding decides its side? */
bool spectral_in_doubt(const spectral *s);

#endif
