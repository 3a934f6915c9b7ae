/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Rank-revealing factors of a dense matrix B (rows x n), never of B^T B:
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

/* All matrices by rows of row_stride(n) numbers (row_vectors.h), their columns those of B */
struct gram_schmidt {
    uint32_t rows, n;
    num *B;            /* becomes Q */
    num *U;            /* row k has its 1 at pivot[k], 0 at pivot[0] .. pivot[k - 1] */
    num *Z;            /* U^-T: row k has its 1 at pivot[k], 0 at pivot[k + 1] .. */
    num *S, *weight;   /* S, 1 / S */
    uint32_t *pivot;   /* order of the columns, up to the rank */
    num *square;       /* scratch, a row: of the free columns of what is left of B */
    num *free;         /* scratch, a row */
    num trace;         /* of B^T B */
    num size;          /* what `ratio` is relative to; 0: the trace */
    num inverse_trace; /* of its inverse, if the rank is n */
};

/* Stops where no column has a square above `ratio` times the size. Returns the rank, 0 where the
 * trace is not finite. 2 rows n^2 operations */
uint32_t TFA_V(pivoted_gram_schmidt)(struct gram_schmidt *f, num ratio);

/* X = V Sigma J^T for X^T = S^1/2 U of that rank: row k of X becomes v_k sigma_k, row k of J (rank
 * numbers) the other side's direction. Any order. J may be the memory of U. */
void TFA_V(singular_directions)(const num *U, const num *S, uint32_t n, uint32_t rank, num *X,
                                num *J);

#endif
