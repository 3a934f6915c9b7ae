/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Rank-revealing factors of a dense matrix.
 */
#include "dynamics/osim/rank_revealing.h"

#include <stddef.h>

#include "spatial/row_vectors.h"

/* Sweeps end when no pair of rows turned: three to six are usual, for quadruple precision, too. */
#define SWEEPS_MAX 40

/* ---- Gram-Schmidt ---- */

/* Columns c .. in so many registers, which stay while the rows are gone through; their number and
 * n are constants of each call. Columns are independent of each other. */
#define BLOCK 3
typedef void block_step(const struct gram_schmidt *f, uint32_t n, uint32_t k, uint32_t c,
                        int registers);

TFA_INLINE void each_block(const struct gram_schmidt *f, uint32_t n, uint32_t k, block_step *step)
{
    const uint32_t stride = row_stride(n);
    for (uint32_t c = 0; c < stride; c += BLOCK * NUM_VEC_LANES) {
        const uint32_t left = (stride - c) / NUM_VEC_LANES;
        if (left >= 3)
            step(f, n, k, c, 3);
        else if (left == 2)
            step(f, n, k, c, 2);
        else
            step(f, n, k, c, 1);
    }
}
#define UNROLL _Pragma("GCC unroll 3")

TFA_INLINE void squares(const struct gram_schmidt *f, uint32_t n, uint32_t k, uint32_t c,
                        int registers)
{
    const num *b = f->B + c;
    num_vec sum[BLOCK];
    (void)k;
    UNROLL
    for (int v = 0; v < registers; v++)
        sum[v] = (num_vec){0};
    for (uint32_t i = 0; i < f->rows; i++, b += row_stride(n)) {
        UNROLL
        for (int v = 0; v < registers; v++)
            sum[v] += row_load(b + v * NUM_VEC_LANES) * row_load(b + v * NUM_VEC_LANES);
    }
    UNROLL
    for (int v = 0; v < registers; v++)
        row_store(f->square + c + v * NUM_VEC_LANES, sum[v]);
}

/* u = q^T B / q^T q of free columns, B -= q u, and the squares of what is left there, computed
 * afresh: those that are kept up to date cancel. */
TFA_INLINE void eliminate(const struct gram_schmidt *f, uint32_t n, uint32_t k, uint32_t c,
                          int registers)
{
    const uint32_t stride = row_stride(n);
    const num *q = f->B + f->pivot[k], *at = q;
    num *b = f->B + c, *out = f->U + (size_t)stride * k + c;
    num_vec u[BLOCK], square[BLOCK];
    UNROLL
    for (int v = 0; v < registers; v++)
        u[v] = square[v] = (num_vec){0};
#pragma GCC unroll 4
    for (uint32_t i = f->rows; i > 0; i--, at += stride, b += stride) {
        UNROLL
        for (int v = 0; v < registers; v++)
            u[v] += *at * row_load(b + v * NUM_VEC_LANES);
    }
    UNROLL
    for (int v = 0; v < registers; v++) {
        u[v] = f->weight[k] * u[v] * row_load(f->free + c + v * NUM_VEC_LANES);
        row_store(out + v * NUM_VEC_LANES, u[v]);
    }
    b = f->B + c;
    at = q;
#pragma GCC unroll 4
    for (uint32_t i = f->rows; i > 0; i--, at += stride, b += stride) {
        const num along = *at;
        UNROLL
        for (int v = 0; v < registers; v++) {
            const num_vec rest = row_load(b + v * NUM_VEC_LANES) - along * u[v];
            row_store(b + v * NUM_VEC_LANES, rest);
            square[v] += rest * rest;
        }
    }
    UNROLL
    for (int v = 0; v < registers; v++) {
        square[v] *= row_load(f->free + c + v * NUM_VEC_LANES);
        row_store(f->square + c + v * NUM_VEC_LANES, square[v]);
    }
}

/* Row k of U^-T: what the rows before it make of the unit vector that stands there */
TFA_INLINE void invert_row(const struct gram_schmidt *f, uint32_t n, uint32_t k, uint32_t c,
                           int registers)
{
    const uint32_t stride = row_stride(n);
    const num *u = f->U + f->pivot[k], *from = f->Z + c;
    num *out = f->Z + (size_t)stride * k + c;
    num_vec z[BLOCK];
    UNROLL
    for (int v = 0; v < registers; v++)
        z[v] = row_load(out + v * NUM_VEC_LANES);
    for (; from < out; u += stride, from += stride) {
        UNROLL
        for (int v = 0; v < registers; v++)
            z[v] -= *u * row_load(from + v * NUM_VEC_LANES);
    }
    UNROLL
    for (int v = 0; v < registers; v++)
        row_store(out + v * NUM_VEC_LANES, z[v]);
}

/* The free column with the largest square */
TFA_INLINE uint32_t choose_pivot(const struct gram_schmidt *f, uint32_t n, num *most)
{
    uint32_t best = 0;
    *most = num_of(-1);
    for (uint32_t j = 0; j < n; j++)
        if (f->square[j] > *most)
            *most = f->square[best = j];
    return best;
}

/* Column p is not free any more; in row k unit vector p of U^-T, and nothing of U yet. Single
 * numbers are written long before a register of them is read, or the load waits. */
TFA_INLINE void take_column(const struct gram_schmidt *f, uint32_t n, uint32_t k, uint32_t p)
{
    const uint32_t stride = row_stride(n);
    const size_t row = (size_t)stride * k;
    for (uint32_t c = 0; c < stride; c += NUM_VEC_LANES) {
        row_store(f->U + row + c, (num_vec){0});
        row_store(f->Z + row + c, (num_vec){0});
    }
    f->Z[row + p] = num_of(1);
    f->free[p] = num_of(0);
}

TFA_INLINE uint32_t factor(struct gram_schmidt *f, uint32_t n, num ratio)
{
    const uint32_t stride = row_stride(n);
    f->trace = f->inverse_trace = num_of(0);
    each_block(f, n, 0, squares);
    for (uint32_t j = 0; j < stride; j++)
        f->free[j] = num_of(j < n);
    for (uint32_t j = 0; j < n; j++)
        f->trace += f->square[j];
    const num least = ratio * (f->size > 0 ? f->size : f->trace);
    for (uint32_t k = 0; k < n; k++) {
        num square, *z = f->Z + (size_t)stride * k;
        f->pivot[k] = choose_pivot(f, n, &square);
        if (k == f->rows || !(square > least))
            return k;
        f->S[k] = square;
        f->weight[k] = 1 / square;
        take_column(f, n, k, f->pivot[k]);
        if (k + 1 < n)
            each_block(f, n, k, eliminate);
        f->U[(size_t)stride * k + f->pivot[k]] = num_of(1);
        each_block(f, n, k, invert_row);
        f->inverse_trace += f->weight[k] * row_dot(z, z, stride);
    }
    return n;
}

/* One tip: without loops over columns. The copy is in registers, whatever rows are written. */
uint32_t TFA_V(pivoted_gram_schmidt)(struct gram_schmidt *f, num ratio)
{
    struct gram_schmidt own = *f;
    const uint32_t rank = own.n == 6 ? factor(&own, 6, ratio) : factor(&own, own.n, ratio);
    f->trace = own.trace;
    f->inverse_trace = own.inverse_trace;
    return rank;
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
static int turn_pair(num *x, num *y, uint32_t stride, num *jx, num *jy, uint32_t rank)
{
    const num a = row_dot(x, x, stride), b = row_dot(y, y, stride), p = row_dot(x, y, stride);
    if (!(num_abs(p) > NUM_EPSILON * num_sqrt(a) * num_sqrt(b)))
        return 0;
    const num zeta = (b - a) / (2 * p), root = num_sqrt(1 + zeta * zeta);
    const num t = zeta < 0 ? -1 / (root - zeta) : 1 / (root + zeta);
    const num c = 1 / num_sqrt(1 + t * t);
    rotate(x, y, stride, c, c * t);
    rotate(jx, jy, rank, c, c * t);
    return 1;
}

void TFA_V(singular_directions)(const num *U, const num *S, uint32_t n, uint32_t rank, num *X,
                                num *J)
{
    const uint32_t stride = row_stride(n);
    for (uint32_t k = 0; k < rank; k++) {
        const num scale = num_sqrt(S[k]);
        for (uint32_t j = 0; j < stride; j++)
            X[(size_t)stride * k + j] = scale * U[(size_t)stride * k + j];
    }
    for (uint32_t k = 0; k < rank; k++)
        for (uint32_t j = 0; j < rank; j++)
            J[(size_t)rank * k + j] = num_of(j == k);
    for (int sweep = 0, turned = 1; turned && sweep < SWEEPS_MAX; sweep++) {
        turned = 0;
        for (uint32_t p = 0; p + 1 < rank; p++)
            for (uint32_t q = p + 1; q < rank; q++)
                turned |= turn_pair(X + (size_t)stride * p, X + (size_t)stride * q, stride,
                                    J + (size_t)rank * p, J + (size_t)rank * q, rank);
    }
}
