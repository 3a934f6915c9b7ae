/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * 6 x 6 matrices of one number at a time, by rows: a row is one vector of the compiler's, or as
 * many as the instruction set needs. A matrix is an array of 36, row major, padded for what a
 * vector reads and writes behind the last row. Rows are stored in ascending order, each repairs
 * what the one before wrote behind itself; what stands there in a register is of no account.
 */
#ifndef TFA_SPATIAL_MAT6_ROWS_H
#define TFA_SPATIAL_MAT6_ROWS_H

#include <string.h>

#include "spatial/num.h"

#if defined(__AVX512F__)
enum { ROW6_ISA_LANES = 8 };
#elif defined(__AVX2__)
enum { ROW6_ISA_LANES = 4 };
#else
enum { ROW6_ISA_LANES = 2 };
#endif

/* Numbers of a padded matrix */
#define MAT6_PADDED 38

#ifdef NUM_NO_VECTORS
typedef num row6_vec;
#else
typedef num row6_vec __attribute__((vector_size(ROW6_ISA_LANES * sizeof(num))));
#endif
enum {
    ROW6_VEC_LANES = sizeof(row6_vec) / sizeof(num),
    ROW6_VECS = (5 + ROW6_VEC_LANES) / ROW6_VEC_LANES
};

struct row6 {
    row6_vec vec[ROW6_VECS];
};

static inline struct row6 row6_load(const num *p)
{
    struct row6 r;
    memcpy(&r, p, sizeof r);
    return r;
}

static inline void row6_store(num *p, const struct row6 *r)
{
    memcpy(p, r, sizeof *r);
}

/* r + x s */
static inline struct row6 row6_add_scaled(struct row6 r, struct row6 x, num s)
{
    for (int k = 0; k < ROW6_VECS; k++)
        r.vec[k] += x.vec[k] * s;
    return r;
}

static inline struct row6 row6_scale(struct row6 x, num s)
{
    for (int k = 0; k < ROW6_VECS; k++)
        x.vec[k] *= s;
    return x;
}

/* A number of a row in memory */
static inline num *row6_at(struct row6 *r, uint32_t k)
{
    return (num *)(void *)r + k;
}

static inline void mat6_rows_load(struct row6 x[6], const num *A)
{
    for (int i = 0; i < 6; i++)
        x[i] = row6_load(A + 6 * i);
}

static inline void mat6_rows_store(num *A, const struct row6 x[6])
{
    for (int i = 0; i < 6; i++)
        row6_store(A + 6 * i, &x[i]);
}

/* c = A b and c = A^T b */
static inline void mat6_rows_mul(struct row6 c[6], const num *A, const struct row6 b[6])
{
    for (int i = 0; i < 6; i++) {
        c[i] = row6_scale(b[0], A[6 * i]);
        for (int k = 1; k < 6; k++)
            c[i] = row6_add_scaled(c[i], b[k], A[6 * i + k]);
    }
}

static inline void mat6_rows_tmul(struct row6 c[6], const num *A, const struct row6 b[6])
{
    for (int i = 0; i < 6; i++) {
        c[i] = row6_scale(b[0], A[i]);
        for (int k = 1; k < 6; k++)
            c[i] = row6_add_scaled(c[i], b[k], A[6 * k + i]);
    }
}

/* LU factors with partial pivoting: row i of L U is row order[i] of the matrix. */
struct mat6_rows_lu {
    struct row6 U[6]; /* on and above the diagonal */
    struct row6 L[6]; /* below the diagonal */
    num inverse[6];   /* of U's diagonal */
    uint32_t order[6];
};

static inline void row6_swap(struct row6 *a, struct row6 *b)
{
    const struct row6 swap = *a;
    *a = *b;
    *b = swap;
}

/* The matrix stands in f->U. */
static inline void mat6_rows_lu_factor(struct mat6_rows_lu *f)
{
    for (uint32_t i = 0; i < 6; i++)
        f->order[i] = i;
    for (uint32_t k = 0; k < 6; k++) {
        uint32_t best = k;
        num most = num_abs(*row6_at(&f->U[k], k));
        for (uint32_t i = k + 1; i < 6; i++) {
            const num here = num_abs(*row6_at(&f->U[i], k));
            best = here > most ? i : best;
            most = here > most ? here : most;
        }
        if (best != k) {
            const uint32_t other = f->order[best];
            f->order[best] = f->order[k];
            f->order[k] = other;
            row6_swap(&f->U[best], &f->U[k]);
            row6_swap(&f->L[best], &f->L[k]);
        }
        const num inverse = 1 / *row6_at(&f->U[k], k);
        f->inverse[k] = inverse;
        for (uint32_t i = k + 1; i < 6; i++) {
            const num l = *row6_at(&f->U[i], k) * inverse;
            *row6_at(&f->L[i], k) = l;
            f->U[i] = row6_add_scaled(f->U[i], f->U[k], -l);
        }
    }
}

static inline num mat6_rows_entry(const struct row6 *rows, int i, int k)
{
    return ((const num *)(const void *)&rows[i])[k];
}

/* x <- A^-1 x for six columns */
static inline void mat6_rows_lu_solve(const struct mat6_rows_lu *f, struct row6 x[6])
{
    struct row6 y[6];
    for (int i = 0; i < 6; i++)
        y[i] = x[f->order[i]];
    for (int k = 0; k < 6; k++)
        for (int i = k + 1; i < 6; i++)
            y[i] = row6_add_scaled(y[i], y[k], -mat6_rows_entry(f->L, i, k));
    for (int k = 5; k >= 0; k--) {
        x[k] = row6_scale(y[k], f->inverse[k]);
        for (int i = 0; i < k; i++)
            y[i] = row6_add_scaled(y[i], x[k], -mat6_rows_entry(f->U, i, k));
    }
}

/* x <- A^-1 x for one column */
static inline void mat6_rows_lu_solve_vec(const struct mat6_rows_lu *f, num x[6])
{
    num y[6];
    for (int i = 0; i < 6; i++)
        y[i] = x[f->order[i]];
    for (int k = 0; k < 6; k++)
        for (int i = k + 1; i < 6; i++)
            y[i] -= mat6_rows_entry(f->L, i, k) * y[k];
    for (int k = 5; k >= 0; k--) {
        x[k] = y[k] * f->inverse[k];
        for (int i = 0; i < k; i++)
            y[i] -= mat6_rows_entry(f->U, i, k) * x[k];
    }
}

#endif
