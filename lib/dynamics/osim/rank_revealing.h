/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Rank-revealing factors of a dense matrix B (rows x n, by columns), never of B^T B:
 *
 *     B = Q U,  Q^T Q = S diagonal, U unit upper triangular but for the order of its columns
 *
 * by modified Gram-Schmidt with column pivoting (Bierman 1977, the UD form; Golub and Van Loan,
 * Matrix Computations, 5.2.9), and the singular directions of S^1/2 U by one-sided Jacobi
 * rotations, which have high relative accuracy on graded factors (Demmel and Veselic 1992; Drmac
 * and Veselic 2008).
 */
#ifndef TFA_DYNAMICS_OSIM_RANK_REVEALING_H
#define TFA_DYNAMICS_OSIM_RANK_REVEALING_H

#include <stdint.h>

#include "spatial/num.h"

/* Columns of B become those of Q in their places; row k of U (n numbers, by the columns of B) has
 * its 1 at pivot[k], 0 at pivot[0] .. pivot[k - 1]. Stops where no column has a square above
 * `floor`. Returns the rank. 2 rows n^2 operations */
uint32_t TFA_V(pivoted_gram_schmidt)(num *B, uint32_t rows, uint32_t n, num floor, num *U, num *S,
                                     uint32_t *pivot);

/* X = V Sigma J^T for X^T = S^1/2 U of that rank: row k of X (n numbers) becomes v_k sigma_k, row k
 * of J (rank numbers) the other side's direction. Any order. J: NULL, or the memory of U. */
void TFA_V(singular_directions)(const num *U, const num *S, uint32_t n, uint32_t rank, num *X,
                                num *J);

#endif
