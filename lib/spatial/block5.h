/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Blocks of five: a spatial vector without the component of a revolute joint's axis, where that
 * is known. Order: wx wy vx vy vz. Sizes are constants, so that loops unroll and blocks stay in
 * registers.
 */
#ifndef TFA_SPATIAL_BLOCK5_H
#define TFA_SPATIAL_BLOCK5_H

#include "spatial/spatial.h"

#define BLOCK5_UNROLL _Pragma("GCC unroll 5")

typedef struct vec5 {
    num x[5];
} vec5;

/* Row major */
typedef struct mat5 {
    num x[5][5];
} mat5;

/* Symmetric: lower triangle by rows, entry (i, j) at i (i + 1) / 2 + j. As factors L D L^T: L below
 * the diagonal, 1/D on it. */
typedef struct sym5 {
    num x[15];
} sym5;

#define SYM5(i, j) ((i) * ((i) + 1) / 2 + (j))

static inline vec5 v5_of(svec a)
{
    return (vec5){{a.w.x, a.w.y, a.v.x, a.v.y, a.v.z}};
}

/* The spatial vector with this component along the axis */
static inline svec v5_with(vec5 a, num axis)
{
    return (svec){{a.x[0], a.x[1], axis}, {a.x[2], a.x[3], a.x[4]}};
}

/* S without row and column of the axis */
static inline sym5 s5_of(const sym6 *S)
{
    return (sym5){{S->A.xx, S->A.xy, S->A.yy, S->B.xx, S->B.yx, S->M.xx, S->B.xy, S->B.yy, S->M.xy,
                   S->M.yy, S->B.xz, S->B.yz, S->M.xz, S->M.yz, S->M.zz}};
}

/* A = L D L^T in place */
static inline void s5_factor(sym5 *A)
{
    BLOCK5_UNROLL
    for (int k = 0; k < 5; k++) {
        const num inv = 1 / A->x[SYM5(k, k)];
        num l[5];
        BLOCK5_UNROLL
        for (int i = k + 1; i < 5; i++)
            l[i] = A->x[SYM5(i, k)] * inv;
        BLOCK5_UNROLL
        for (int i = k + 1; i < 5; i++) {
            BLOCK5_UNROLL
            for (int j = k + 1; j <= i; j++)
                A->x[SYM5(i, j)] -= l[i] * A->x[SYM5(j, k)];
        }
        BLOCK5_UNROLL
        for (int i = k + 1; i < 5; i++)
            A->x[SYM5(i, k)] = l[i];
        A->x[SYM5(k, k)] = inv;
    }
}

/* x <- L^-1 x */
static inline void s5_lower(const sym5 *L, vec5 *x)
{
    BLOCK5_UNROLL
    for (int i = 1; i < 5; i++) {
        BLOCK5_UNROLL
        for (int k = 0; k < i; k++)
            x->x[i] -= L->x[SYM5(i, k)] * x->x[k];
    }
}

/* x <- L^-T x */
static inline void s5_upper(const sym5 *L, vec5 *x)
{
    BLOCK5_UNROLL
    for (int i = 3; i >= 0; i--) {
        BLOCK5_UNROLL
        for (int k = i + 1; k < 5; k++)
            x->x[i] -= L->x[SYM5(k, i)] * x->x[k];
    }
}

/* x <- D^-1 x */
static inline void s5_scale(const sym5 *L, vec5 *x)
{
    BLOCK5_UNROLL
    for (int i = 0; i < 5; i++)
        x->x[i] *= L->x[SYM5(i, i)];
}

/* Z <- L^-1 Z */
static inline void s5_lower_rows(const sym5 *L, mat5 *Z)
{
    BLOCK5_UNROLL
    for (int i = 1; i < 5; i++) {
        BLOCK5_UNROLL
        for (int k = 0; k < i; k++) {
            BLOCK5_UNROLL
            for (int j = 0; j < 5; j++)
                Z->x[i][j] -= L->x[SYM5(i, k)] * Z->x[k][j];
        }
    }
}

/* D^-1 Z */
static inline mat5 s5_scaled_rows(const sym5 *L, const mat5 *Z)
{
    mat5 R;
    BLOCK5_UNROLL
    for (int i = 0; i < 5; i++) {
        BLOCK5_UNROLL
        for (int j = 0; j < 5; j++)
            R.x[i][j] = L->x[SYM5(i, i)] * Z->x[i][j];
    }
    return R;
}

/* S -= A^T B, known to be symmetric */
static inline void s5_sub_tmm(sym5 *S, const mat5 *A, const mat5 *B)
{
    BLOCK5_UNROLL
    for (int i = 0; i < 5; i++) {
        BLOCK5_UNROLL
        for (int j = 0; j <= i; j++) {
            BLOCK5_UNROLL
            for (int k = 0; k < 5; k++)
                S->x[SYM5(i, j)] -= A->x[k][i] * B->x[k][j];
        }
    }
}

/* - A^T B */
static inline mat5 m5_minus_tmm(const mat5 *A, const mat5 *B)
{
    mat5 R;
    BLOCK5_UNROLL
    for (int i = 0; i < 5; i++) {
        BLOCK5_UNROLL
        for (int j = 0; j < 5; j++) {
            num sum = A->x[0][i] * B->x[0][j];
            BLOCK5_UNROLL
            for (int k = 1; k < 5; k++)
                sum += A->x[k][i] * B->x[k][j];
            R.x[i][j] = -sum;
        }
    }
    return R;
}

/* x -= A y */
static inline void v5_sub_mul(vec5 *x, const mat5 *A, const vec5 *y)
{
    BLOCK5_UNROLL
    for (int i = 0; i < 5; i++) {
        BLOCK5_UNROLL
        for (int k = 0; k < 5; k++)
            x->x[i] -= A->x[i][k] * y->x[k];
    }
}

/* x -= A^T y */
static inline void v5_sub_tmul(vec5 *x, const mat5 *A, const vec5 *y)
{
    BLOCK5_UNROLL
    for (int i = 0; i < 5; i++) {
        BLOCK5_UNROLL
        for (int k = 0; k < 5; k++)
            x->x[i] -= A->x[k][i] * y->x[k];
    }
}

static inline mat5 m5_t(const mat5 *A)
{
    mat5 R;
    for (int i = 0; i < 5; i++)
        for (int j = 0; j < 5; j++)
            R.x[i][j] = A->x[j][i];
    return R;
}

#endif
