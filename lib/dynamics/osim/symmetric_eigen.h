/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Eigenvalues and eigenvectors of a dense symmetric matrix: Householder's tridiagonalisation, then
 * implicit QL with Wilkinson's shift (Golub and Van Loan, Matrix Computations, 8.3; EISPACK's tred2
 * and imtql2). Backward stable: the error of an eigenvalue is absolute, some eps |A|. About 9 n^3
 * operations.
 */
#ifndef TFA_DYNAMICS_OSIM_SYMMETRIC_EIGEN_H
#define TFA_DYNAMICS_OSIM_SYMMETRIC_EIGEN_H

#include "layout/state.h"

/* A = sum of d_k v_k v_k^T. On entry A, n x n, row major, both triangles; on return row k of V is
 * v_k, and A is overwritten. d and e hold n numbers; e is scratch. Returns 0 if an entry is not
 * finite or an eigenvalue does not converge. */
int TFA_V(symmetric_eigen)(num *A, uint32_t n, num *V, num *d, num *e);

#endif
