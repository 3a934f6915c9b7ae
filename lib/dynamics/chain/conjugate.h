/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Conjugate gradients for the symmetric positive definite systems of cyclic.h, preconditioned by
 * the inverses of the diagonal blocks (block Jacobi). Every solve starts from zero and sums in the
 * order of the rows: the same bits for a right-hand side whatever came before.
 */
#ifndef TFA_DYNAMICS_CHAIN_CONJUGATE_H
#define TFA_DYNAMICS_CHAIN_CONJUGATE_H

#include "dynamics/chain/cyclic.h"

/* Members of a row (cyclic.h) in use: D, L; P: the factors of D; x: the six vectors of a solve */
enum { CG_X = 0, CG_R = 6, CG_Z = 12, CG_DIRECTION = 18, CG_PRODUCT = 24 };

/* Iterations in exact arithmetic are at most the unknowns; of roundings a badly conditioned system
 * takes more. */
#define CG_ITERATIONS_PER_UNKNOWN 2
static inline void conjugate_factor(struct cyclic_row *row, size_t length)
{
    for (size_t k = 0; k < length; k++) {
        for (int e = 0; e < 36; e++)
            row[k].P[e] = row[k].D.a[e];
        ldl_factor(row[k].P, (int)row[k].size);
    }
}

/* z = D^-1 r of all rows; r^T z */
static inline num conjugate_precondition(struct cyclic_row *row, size_t length)
{
    num sum = num_of(0);
    for (size_t k = 0; k < length; k++) {
        num *r = row[k].x + CG_R, *z = row[k].x + CG_Z;
        for (uint32_t e = 0; e < row[k].size; e++)
            z[e] = r[e];
        ldl_solve(row[k].P, (int)row[k].size, z);
        for (uint32_t e = 0; e < row[k].size; e++)
            sum += r[e] * z[e];
    }
    return sum;
}

/* The product of the system with the directions; direction^T product */
static inline num conjugate_multiply(struct cyclic_row *row, size_t length)
{
    num sum = num_of(0);
    for (size_t k = 0; k < length; k++) {
        struct cyclic_row *r = &row[k];
        num *y = r->x + CG_PRODUCT;
        const num *x = r->x + CG_DIRECTION;
        for (uint32_t e = 0; e < r->size; e++) {
            y[e] = num_of(0);
            for (uint32_t f = 0; f < r->size; f++)
                y[e] += r->D.a[6 * e + f] * x[f];
            for (uint32_t f = 0; k > 0 && f < r[-1].size; f++)
                y[e] += r->L[6 * e + f] * r[-1].x[CG_DIRECTION + f];
            for (uint32_t f = 0; k + 1 < length && f < r[1].size; f++)
                y[e] += r[1].L[6 * f + e] * r[1].x[CG_DIRECTION + f];
            sum += x[e] * y[e];
        }
    }
    return sum;
}

/* x <- the solution for the right-hand side b in x, until the residual is `tolerance` times b in
 * the norm of the preconditioner. Returns the number of iterations, -1 where they did not
 * suffice. */
static inline int conjugate_solve(struct cyclic_row *row, size_t length, num tolerance)
{
    int unknowns = 0, iterations = 0;
    for (size_t k = 0; k < length; k++) {
        unknowns += (int)row[k].size;
        for (uint32_t e = 0; e < row[k].size; e++) {
            row[k].x[CG_R + e] = row[k].x[CG_X + e];
            row[k].x[CG_X + e] = row[k].x[CG_DIRECTION + e] = num_of(0);
        }
    }
    num rz = conjugate_precondition(row, length), beta = num_of(0);
    const num enough = rz * tolerance * tolerance;
    for (; !num_all(rz <= enough); iterations++) {
        if (iterations == CG_ITERATIONS_PER_UNKNOWN * unknowns)
            return -1;
        for (size_t k = 0; k < length; k++)
            for (uint32_t e = 0; e < row[k].size; e++) {
                num *direction = &row[k].x[CG_DIRECTION + e];
                *direction = row[k].x[CG_Z + e] + beta * *direction;
            }
        const num alpha = rz / conjugate_multiply(row, length);
        for (size_t k = 0; k < length; k++)
            for (uint32_t e = 0; e < row[k].size; e++) {
                row[k].x[CG_X + e] += alpha * row[k].x[CG_DIRECTION + e];
                row[k].x[CG_R + e] -= alpha * row[k].x[CG_PRODUCT + e];
            }
        beta = 1 / rz;
        rz = conjugate_precondition(row, length);
        beta *= rz;
    }
    return iterations;
}

#endif
