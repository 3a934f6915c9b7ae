/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * One block row of a symmetric block tridiagonal system, blocks of five: it is eliminated between a
 * row on its left and one on its right, and found again from them. In whatever order rows are
 * eliminated, each costs the same.
 *
 *   L x_left + D x + U x_right = b,   D = M diag M^T
 *   left:   D -= ZL^T diag^-1 ZL,   b -= ZL^T diag^-1 y        ZL = M^-1 L, ZU = M^-1 U, y = M^-1 b
 *   right:  D -= ZU^T diag^-1 ZU,   b -= ZU^T diag^-1 y,   coupling to left = -ZU^T diag^-1 ZL
 */
#ifndef TFA_DYNAMICS_SIMD_BLOCK_ROW_H
#define TFA_DYNAMICS_SIMD_BLOCK_ROW_H

#include "dynamics/simd/partition.h"

/* A row as it stands: its own block, its coupling to the row on its left, its right-hand side */
struct block_equation {
    sym5 D;
    mat5 L;
    vec5 b;
};

/* Diagonal block and right-hand side of a row, or their increments */
struct block_update {
    sym5 D;
    vec5 b;
};

static inline void update_clear(struct block_update *s)
{
    for (int k = 0; k < 15; k++)
        s->D.x[k] = num_of(0);
    for (int k = 0; k < 5; k++)
        s->b.x[k] = num_of(0);
}

/* Factors of a row whose coupling to the right is U; with kept factors (without
 * PARTITION_FACTOR) y only */
static inline __attribute__((always_inline)) void
row_factor(const struct block_equation *row, const mat5 *U, struct block_factors *f, int flags)
{
    if (flags & PARTITION_FACTOR) {
        f->M = row->D;
        s5_factor(&f->M);
        f->ZL = row->L;
        f->ZU = *U;
        s5_lower_rows(&f->M, &f->ZL);
        s5_lower_rows(&f->M, &f->ZU);
    }
    f->y = row->b;
    s5_lower(&f->M, &f->y);
}

/* Update of its neighbours by its elimination */
static inline __attribute__((always_inline)) void row_update(const struct block_factors *f,
                                                             struct block_update *left,
                                                             struct block_equation *right,
                                                             int flags)
{
    if (flags & PARTITION_FACTOR) {
        const mat5 scaled = s5_scaled_rows(&f->M, &f->ZU), other = s5_scaled_rows(&f->M, &f->ZL);
        right->L = m5_minus_tmm(&scaled, &f->ZL);
        s5_sub_tmm(&right->D, &f->ZU, &scaled);
        s5_sub_tmm(&left->D, &f->ZL, &other);
    }
    vec5 scaled = f->y;
    s5_scale(&f->M, &scaled);
    v5_sub_tmul(&right->b, &f->ZU, &scaled);
    v5_sub_tmul(&left->b, &f->ZL, &scaled);
}

/* x of an eliminated row */
static inline vec5 row_back(const struct block_factors *f, const vec5 *left, const vec5 *right)
{
    vec5 x = f->y;
    v5_sub_mul(&x, &f->ZL, left);
    v5_sub_mul(&x, &f->ZU, right);
    s5_scale(&f->M, &x);
    s5_upper(&f->M, &x);
    return x;
}

#endif
