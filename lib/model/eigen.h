/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Principal moments of inertia.
 */
#ifndef TFA_MODEL_EIGEN_H
#define TFA_MODEL_EIGEN_H

/* Written inertias carry a handful of digits: a relative deficit below this is rounding of the
 * file (six significant digits in most of 190 real URDFs), above it is a wrong number. */
#define TFA_PSD_TOLERANCE 1e-6L

/**
 * Eigenvalues, ascending, of a symmetric matrix xx xy xz yy yz zz of finite numbers, by Jacobi's
 * rotations in extended precision. Eigenvectors are the columns of V (row major); V may be NULL.
 */
void tfa_eigen(const long double s[6], long double value[3], long double *V);

/* Is an eigenvalue negative beyond what the rounding of a file explains? `value` ascends. */
int tfa_eigen_negative(const long double value[3]);

#endif
