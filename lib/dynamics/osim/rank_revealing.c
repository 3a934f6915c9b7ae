/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Rank-revealing factors of a dense matrix.
 */
#include "dynamics/osim/rank_revealing.h"

#include <stddef.h>

#include "spatial/dense.h"

/* Sweeps end when no pair of rows turned: three to six are usual, for quadruple precision, too. */
#define SWEEPS_MAX 40

/* ---- Gram-Schmidt ---- */

/* Moves the column with the largest square among order[k] .. order[n - 1] to place k. Returns the
 * square, computed afresh: one that is kept up to date cancels. */
static num choose_pivot(const num *B, uint32_t rows, uint32_t n, uint32_t k, uint32_t *order)
{
    uint32_t best = k;
    num most = num_of(-1);
    for (uint32_t j = k; j < n; j++) {
        const num *b = B + (size_t)rows * order[j];
        const num square = dense_dot(b, b, rows);
        if (square > most) {
            most = square;
            best = j;
        }
    }
    const uint32_t swapped = order[k];
    order[k] = order[best];
    order[best] = swapped;
    return most;
}

uint32_t TFA_V(pivoted_gram_schmidt)(num *B, uint32_t rows, uint32_t n, num floor, num *U, num *S,
                                     uint32_t *pivot)
{
    for (uint32_t j = 0; j < n; j++)
        pivot[j] = j;
    for (uint32_t k = 0; k < n; k++) {
        if (k == rows || !((S[k] = choose_pivot(B, rows, n, k, pivot)) > floor))
            return k;
        const num *q = B + (size_t)rows * pivot[k];
        num *u = U + (size_t)n * k;
        for (uint32_t j = 0; j < k; j++)
            u[pivot[j]] = num_of(0);
        u[pivot[k]] = num_of(1);
        for (uint32_t j = k + 1; j < n; j++) {
            num *b = B + (size_t)rows * pivot[j];
            const num factor = u[pivot[j]] = dense_dot(q, b, rows) / S[k];
            for (uint32_t i = 0; i < rows; i++)
                b[i] -= factor * q[i];
        }
    }
    return n;
}

/* ---- Jacobi ---- */

/* x, y <- c x - s y, s x + c y */
static void rotate(num *x, num *y, uint32_t n, num c, num s)
{
    for (uint32_t j = 0; j < n; j++) {
        const num a = x[j], b = y[j];
        x[j] = c * a - s * b;
        y[j] = s * a + c * b;
    }
}

/* Makes two rows orthogonal. Returns 1 if they turned. */
static int turn_pair(num *x, num *y, uint32_t n, num *jx, num *jy, uint32_t rank)
{
    const num a = dense_dot(x, x, n), b = dense_dot(y, y, n), p = dense_dot(x, y, n);
    if (!(num_abs(p) > NUM_EPSILON * num_sqrt(a) * num_sqrt(b)))
        return 0;
    const num zeta = (b - a) / (2 * p), root = num_sqrt(1 + zeta * zeta);
    const num t = zeta < 0 ? -1 / (root - zeta) : 1 / (root + zeta);
    const num c = 1 / num_sqrt(1 + t * t);
    rotate(x, y, n, c, c * t);
    if (jx)
        rotate(jx, jy, rank, c, c * t);
    return 1;
}

void TFA_V(singular_directions)(const num *U, const num *S, uint32_t n, uint32_t rank, num *X,
                                num *J)
{
    for (uint32_t k = 0; k < rank; k++) {
        const num scale = num_sqrt(S[k]);
        for (uint32_t j = 0; j < n; j++)
            X[(size_t)n * k + j] = scale * U[(size_t)n * k + j];
    }
    for (uint32_t k = 0; J && k < rank; k++)
        for (uint32_t j = 0; j < rank; j++)
            J[(size_t)rank * k + j] = num_of(j == k);
    for (int sweep = 0, turned = 1; turned && sweep < SWEEPS_MAX; sweep++) {
        turned = 0;
        for (uint32_t p = 0; p + 1 < rank; p++)
            for (uint32_t q = p + 1; q < rank; q++)
                turned |= turn_pair(X + (size_t)n * p, X + (size_t)n * q, n,
                                    J ? J + (size_t)rank * p : NULL,
                                    J ? J + (size_t)rank * q : NULL, rank);
    }
}
