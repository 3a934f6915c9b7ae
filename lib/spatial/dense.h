/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Small dense solves: LDL^T of symmetric n x n (n <= 6) and LU of 6 x 6 with row exchanges done
 * by selection, so that they read the same for one number and for lanes.
 */
#ifndef TFA_SPATIAL_DENSE_H
#define TFA_SPATIAL_DENSE_H

#include <stddef.h>

#include "spatial/num.h"

static inline num dense_dot(const num *x, const num *y, size_t n)
{
    num sum = num_of(0);
    for (size_t j = 0; j < n; j++)
        sum += x[j] * y[j];
    return sum;
}

/* A = L D L^T in place: L below the diagonal (unit), 1/D on it. */
static inline void ldl_factor_rows(num *A, int n, size_t stride)
{
    for (int k = 0; k < n; k++) {
        num *row_k = A + stride * (size_t)k;
        num inv = 1 / row_k[k];
        for (int i = k + 1; i < n; i++) {
            num *row = A + stride * (size_t)i;
            num l = row[k] * inv;
            for (int j = k + 1; j <= i; j++)
                row[j] -= l * A[stride * (size_t)j + (size_t)k];
        }
        for (int i = k + 1; i < n; i++)
            A[stride * (size_t)i + (size_t)k] *= inv;
        row_k[k] = inv;
    }
}

/* x <- L^-1 x with those factors */
static inline void ldl_lower_rows(const num *L, int n, size_t stride, num *x)
{
    for (int i = 1; i < n; i++)
        for (int k = 0; k < i; k++)
            x[i] -= L[stride * (size_t)i + (size_t)k] * x[k];
}

/* x <- A^-1 x */
static inline void ldl_solve_rows(const num *L, int n, size_t stride, num *x)
{
    ldl_lower_rows(L, n, stride, x);
    for (int i = 0; i < n; i++)
        x[i] *= L[stride * (size_t)i + (size_t)i];
    for (int i = n - 2; i >= 0; i--)
        for (int k = i + 1; k < n; k++)
            x[i] -= L[stride * (size_t)k + (size_t)i] * x[k];
}

/* The same with rows of six */
static inline void ldl_factor(num *A, int n)
{
    ldl_factor_rows(A, n, 6);
}

/* x <- A^-1 x with the factors of ldl_factor */
static inline void ldl_solve(const num *L, int n, num *x)
{
    ldl_solve_rows(L, n, 6, x);
}

/* The same of 6 x 6, without a loop left: for a kernel that keeps the matrix in registers */
TFA_INLINE void ldl6_column(num *A, int k)
{
    const num inv = 1 / A[7 * k];
#pragma GCC unroll 6
    for (int i = 0; i < 6; i++) {
        const num l = i > k ? A[6 * i + k] * inv : num_of(0);
#pragma GCC unroll 6
        for (int j = 0; j < 6; j++)
            if (k < j && j <= i)
                A[6 * i + j] -= l * A[6 * j + k];
    }
#pragma GCC unroll 6
    for (int i = 0; i < 6; i++)
        if (i > k)
            A[6 * i + k] *= inv;
    A[7 * k] = inv;
}

TFA_INLINE void ldl6_factor(num *A)
{
    ldl6_column(A, 0);
    ldl6_column(A, 1);
    ldl6_column(A, 2);
    ldl6_column(A, 3);
    ldl6_column(A, 4);
    ldl6_column(A, 5);
}

TFA_INLINE void ldl6_solve(const num *L, num *x)
{
#pragma GCC unroll 6
    for (int i = 0; i < 6; i++)
#pragma GCC unroll 6
        for (int k = 0; k < 6; k++)
            if (k < i)
                x[i] -= L[6 * i + k] * x[k];
#pragma GCC unroll 6
    for (int i = 0; i < 6; i++)
        x[i] *= L[7 * i];
#pragma GCC unroll 6
    for (int e = 0; e < 6; e++)
#pragma GCC unroll 6
        for (int k = 0; k < 6; k++)
            if (k > 5 - e)
                x[5 - e] -= L[6 * k + 5 - e] * x[k];
}

/* LU factors of a 6 x 6 matrix with the exchanges that were made: exchange[e] of rows (k, i) in
 * the order k = 0..4, i = k+1..5 is 1 where they were exchanged, else 0. */
struct lu6 {
    num a[36];
    num exchange[15];
};

/* Partial pivoting by compare and exchange: after step k the largest candidate stands in row k. */
static inline void lu6_factor(struct lu6 *f)
{
    num *a = f->a;
    int e = 0;
    for (int k = 0; k < 6; k++) {
        for (int i = k + 1; i < 6; i++, e++) {
            num better =
                num_select(num_abs(a[6 * i + k]) > num_abs(a[6 * k + k]), num_of(1), num_of(0));
            f->exchange[e] = better;
            for (int j = 0; j < 6; j++) {
                num up = a[6 * k + j], down = a[6 * i + j];
                a[6 * k + j] = num_select(better > 0, down, up);
                a[6 * i + j] = num_select(better > 0, up, down);
            }
        }
        num inv = 1 / a[6 * k + k];
        for (int i = k + 1; i < 6; i++) {
            num l = a[6 * i + k] * inv;
            a[6 * i + k] = l;
            for (int j = k + 1; j < 6; j++)
                a[6 * i + j] -= l * a[6 * k + j];
        }
        a[6 * k + k] = inv;
    }
}

/* The columns of x (6 x n, row stride n) <- A^-1 x */
static inline void lu6_solve(const struct lu6 *f, num *x, int n)
{
    const num *a = f->a;
    int e = 0;
    for (int k = 0; k < 6; k++)
        for (int i = k + 1; i < 6; i++, e++)
            for (int j = 0; j < n; j++) {
                num up = x[n * k + j], down = x[n * i + j];
                x[n * k + j] = num_select(f->exchange[e] > 0, down, up);
                x[n * i + j] = num_select(f->exchange[e] > 0, up, down);
            }
    for (int k = 0; k < 6; k++)
        for (int i = k + 1; i < 6; i++)
            for (int j = 0; j < n; j++)
                x[n * i + j] -= a[6 * i + k] * x[n * k + j];
    for (int k = 5; k >= 0; k--)
        for (int j = 0; j < n; j++) {
            num s = x[n * k + j];
            for (int i = k + 1; i < 6; i++)
                s -= a[6 * k + i] * x[n * i + j];
            x[n * k + j] = s * a[6 * k + k];
        }
}

/* C = A B for a 6 x 6 A and the n columns of B, row major */
static inline void m6_columns(num *C, const num *A, const num *B, int n)
{
    for (int i = 0; i < 6; i++)
        for (int j = 0; j < n; j++) {
            num s = A[6 * i] * B[j];
            for (int k = 1; k < 6; k++)
                s += A[6 * i + k] * B[n * k + j];
            C[n * i + j] = s;
        }
}

static inline void m6_mul(num *C, const num *A, const num *B)
{
    m6_columns(C, A, B, 6);
}

/* y = A x */
static inline void m6_apply(num *y, const num *A, const num *x)
{
    m6_columns(y, A, x, 1);
}

/* C += psi^T phi for rows of six, upper triangle */
static inline void m6_add_outer_upper(num *C, const num *psi, const num *phi)
{
    for (int e = 0; e < 6; e++)
        for (int f = e; f < 6; f++)
            C[6 * e + f] += psi[e] * phi[f];
}

#endif
