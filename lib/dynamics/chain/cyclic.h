/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Block cyclic reduction of a block tridiagonal system of any length:
 *
 *   L_k x_{k-1} + D_k x_k + U_k x_{k+1} = b_k,   k = 0 .. length - 1
 *
 * Level h = 1, 2, 4 .. < length eliminates every second of the rows that are left, those at odd
 * multiples of h: ceil(log2 length) levels, after which row 0 stands alone. Each row is eliminated
 * once, so that its factors stay in it for any number of right-hand sides:
 *
 *   eliminate k:  GL = D_k^-1 L_k,  GU = D_k^-1 U_k      row k sees rows k - h and k + h
 *   reduce i:     D_i -= P_{i+h} GL_{i+h} + Q_{i-h} GU_{i-h}
 *                 L_i  = -Q_{i-h} GL_{i-h},  U_i = -P_{i+h} GU_{i+h}
 *
 * where P_k = U_{k-h} and Q_k = L_{k+h} are the couplings of the neighbours to row k. All rows of
 * one step of one level are independent of each other. A symmetric system (U_k = L_{k+1}^T) is
 * given by D and L; its D are factored as LDL^T and may have fewer than six rows.
 */
#ifndef TFA_DYNAMICS_CHAIN_CYCLIC_H
#define TFA_DYNAMICS_CHAIN_CYCLIC_H

#include "spatial/dense.h"

enum cyclic_kind { CYCLIC_GENERAL, CYCLIC_SYMMETRIC };

/* One block row. Blocks have rows of six; of a row with fewer unknowns only the first count. */
struct cyclic_row {
    struct lu6 D;  /* given: the diagonal block; then its factors. LDL^T are in D.a */
    num L[36];     /* given: L_k; then GL */
    num U[36];     /* given unless symmetric: U_k; then GU */
    num P[36];     /* coupling of row k - h to row k */
    num Q[36];     /* coupling of row k + h to row k */
    num x[36];     /* given: b_k; then x_k; size x n for n right-hand sides */
    uint32_t size; /* given: unknowns of the row, 0 to 6; 6 unless symmetric */
};

static inline uint32_t cyclic_size(const struct cyclic_row *r, enum cyclic_kind kind)
{
    return kind == CYCLIC_GENERAL ? 6 : r->size;
}

/* The first `columns` columns of x <- D^-1 x */
static inline void cyclic_divide(const struct cyclic_row *r, num *x, uint32_t columns,
                                 enum cyclic_kind kind)
{
    if (kind == CYCLIC_GENERAL) {
        lu6_solve(&r->D, x, 6);
        return;
    }
    for (uint32_t j = 0; j < columns; j++) {
        num column[6];
        for (uint32_t e = 0; e < r->size; e++)
            column[e] = x[6 * e + j];
        ldl_solve(r->D.a, (int)r->size, column);
        for (uint32_t e = 0; e < r->size; e++)
            x[6 * e + j] = column[e];
    }
}

/* C -= A B; A is rows x inner, B inner x columns */
static inline void cyclic_sub_mul(num *C, const num *A, const num *B, uint32_t rows, uint32_t inner,
                                  uint32_t columns)
{
    for (uint32_t e = 0; e < rows; e++)
        for (uint32_t f = 0; f < columns; f++) {
            num sum = num_of(0);
            for (uint32_t k = 0; k < inner; k++)
                sum += A[6 * e + k] * B[6 * k + f];
            C[6 * e + f] -= sum;
        }
}

static inline void cyclic_transpose(num *T, const num *A)
{
    for (int e = 0; e < 36; e++)
        T[e] = A[6 * (e % 6) + e / 6];
}

static inline void cyclic_clear(num *A)
{
    for (int e = 0; e < 36; e++)
        A[e] = num_of(0);
}

/* Y -= A X for `n` columns, row stride n */
static inline void cyclic_sub_columns(num *Y, const num *A, const num *X, uint32_t rows,
                                      uint32_t inner, uint32_t n)
{
    for (uint32_t e = 0; e < rows; e++)
        for (uint32_t j = 0; j < n; j++) {
            num sum = num_of(0);
            for (uint32_t k = 0; k < inner; k++)
                sum += A[6 * e + k] * X[n * k + j];
            Y[n * e + j] -= sum;
        }
}

static inline void cyclic_factor_diagonal(struct cyclic_row *r, enum cyclic_kind kind)
{
    if (kind == CYCLIC_GENERAL)
        lu6_factor(&r->D);
    else
        ldl_factor(r->D.a, (int)r->size);
}

/* Row k of level h, k an odd multiple of h. Reads L of row k + h, U of row k - h. */
static inline void cyclic_eliminate(struct cyclic_row *row, size_t length, size_t k, size_t h,
                                    enum cyclic_kind kind)
{
    struct cyclic_row *r = &row[k];
    const int last = k + h >= length;
    if (last)
        cyclic_clear(r->Q);
    else
        for (int e = 0; e < 36; e++)
            r->Q[e] = row[k + h].L[e];
    if (kind == CYCLIC_GENERAL) {
        for (int e = 0; e < 36; e++)
            r->P[e] = row[k - h].U[e];
    } else {
        cyclic_transpose(r->P, r->L);
        cyclic_transpose(r->U, r->Q);
    }
    cyclic_factor_diagonal(r, kind);
    cyclic_divide(r, r->L, cyclic_size(&row[k - h], kind), kind);
    if (!last)
        cyclic_divide(r, r->U, cyclic_size(&row[k + h], kind), kind);
}

/* Row i of level h, i an even multiple of h. Reads the eliminated rows i - h and i + h. */
static inline void cyclic_reduce(struct cyclic_row *row, size_t length, size_t i, size_t h,
                                 enum cyclic_kind kind)
{
    struct cyclic_row *r = &row[i];
    const uint32_t n = cyclic_size(r, kind);
    if (i >= h) {
        const struct cyclic_row *o = &row[i - h];
        const uint32_t inner = cyclic_size(o, kind);
        cyclic_sub_mul(r->D.a, o->Q, o->U, n, inner, n);
        cyclic_clear(r->L);
        cyclic_sub_mul(r->L, o->Q, o->L, n, inner, cyclic_size(&row[i - 2 * h], kind));
    }
    if (i + h < length) {
        const struct cyclic_row *o = &row[i + h];
        const uint32_t inner = cyclic_size(o, kind);
        cyclic_sub_mul(r->D.a, o->P, o->L, n, inner, n);
        if (kind == CYCLIC_GENERAL) {
            cyclic_clear(r->U);
            if (i + 2 * h < length)
                cyclic_sub_mul(r->U, o->P, o->U, 6, 6, 6);
        }
    }
}

/* Factors the system that D, L, U and size give. */
static inline void cyclic_factor(struct cyclic_row *row, size_t length, enum cyclic_kind kind)
{
    for (size_t h = 1; h < length; h *= 2) {
        for (size_t k = h; k < length; k += 2 * h)
            cyclic_eliminate(row, length, k, h, kind);
        for (size_t i = 0; i < length; i += 2 * h)
            cyclic_reduce(row, length, i, h, kind);
    }
    cyclic_factor_diagonal(&row[0], kind);
}

/* Symmetric systems have one right-hand side only. */
static inline void cyclic_divide_x(struct cyclic_row *r, enum cyclic_kind kind, uint32_t n)
{
    if (kind == CYCLIC_GENERAL)
        lu6_solve(&r->D, r->x, (int)n);
    else
        ldl_solve(r->D.a, (int)r->size, r->x);
}

/* b of row i of level h less the multiples of the rows eliminated at this level */
static inline void cyclic_reduce_x(struct cyclic_row *row, size_t length, size_t i, size_t h,
                                   enum cyclic_kind kind, uint32_t n)
{
    const uint32_t size = cyclic_size(&row[i], kind);
    if (i >= h)
        cyclic_sub_columns(row[i].x, row[i - h].Q, row[i - h].x, size,
                           cyclic_size(&row[i - h], kind), n);
    if (i + h < length)
        cyclic_sub_columns(row[i].x, row[i + h].P, row[i + h].x, size,
                           cyclic_size(&row[i + h], kind), n);
}

/* x of row k of level h from those of its neighbours, which are solutions */
static inline void cyclic_substitute_x(struct cyclic_row *row, size_t length, size_t k, size_t h,
                                       enum cyclic_kind kind, uint32_t n)
{
    struct cyclic_row *r = &row[k];
    const uint32_t size = cyclic_size(r, kind);
    cyclic_sub_columns(r->x, r->L, row[k - h].x, size, cyclic_size(&row[k - h], kind), n);
    if (k + h < length)
        cyclic_sub_columns(r->x, r->U, row[k + h].x, size, cyclic_size(&row[k + h], kind), n);
}

/* x <- the solution for the n right-hand sides in x, row stride n */
static inline void cyclic_solve(struct cyclic_row *row, size_t length, enum cyclic_kind kind,
                                uint32_t n)
{
    size_t h = 1;
    for (; h < length; h *= 2) {
        for (size_t k = h; k < length; k += 2 * h)
            cyclic_divide_x(&row[k], kind, n);
        for (size_t i = 0; i < length; i += 2 * h)
            cyclic_reduce_x(row, length, i, h, kind, n);
    }
    cyclic_divide_x(&row[0], kind, n);
    for (h /= 2; h > 0; h /= 2)
        for (size_t k = h; k < length; k += 2 * h)
            cyclic_substitute_x(row, length, k, h, kind, n);
}

#endif
