/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Principal moments of inertia: eigenvalues of symmetric 3x3 matrices.
 */
#ifndef TFA_MODEL_EIGEN_H
#define TFA_MODEL_EIGEN_H

/* Relative rounding of inertias in files, which have about six significant digits. A larger deficit
 * is a wrong number. */
#define TFA_PSD_TOLERANCE 1e-6L

/**
 * Eigenvalues, ascending, of a symmetric matrix xx xy xz yy yz zz of finite numbers, by Jacobi's
 * rotations in extended precision. Eigenvectors are the columns of V (row major); V may be NULL.
 */
void tfa_eigen(const long double s[6], long double value[3], long double *V);

/* 1: an eigenvalue is negative beyond the rounding of a file. `value` ascends. */
int tfa_eigen_negative(const long double value[3]);

#endif
