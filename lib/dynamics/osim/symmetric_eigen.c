/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Eigenvalues and eigenvectors of a dense symmetric matrix.
 */
#include "dynamics/osim/symmetric_eigen.h"

/* Two or three steps for each eigenvalue are usual; EISPACK gives up after 30. */
#define STEPS_MAX 60

static num dot(const num *x, const num *y, uint32_t first, uint32_t n)
{
    num sum = num_of(0);
    for (uint32_t j = first; j < n; j++)
        sum += x[j] * y[j];
    return sum;
}

static num with_sign(num size, num of)
{
    return of < 0 ? -size : size;
}

/* sqrt(x^2 + y^2) of numbers whose squares are numbers */
static num norm2(num x, num y)
{
    return num_sqrt(x * x + y * y);
}

/* A <- H A H below and right of entry (k, k), H = 1 - beta v v^T with v = A[k][k + 1 ..]; w is
 * scratch. */
static void reflect_both(num *A, uint32_t n, uint32_t k, num beta, num *w)
{
    const num *v = A + (size_t)n * k;
    for (uint32_t i = k + 1; i < n; i++)
        w[i] = beta * dot(A + (size_t)n * i, v, k + 1, n);
    const num half = beta / 2 * dot(w, v, k + 1, n);
    for (uint32_t i = k + 1; i < n; i++)
        w[i] -= half * v[i];
    for (uint32_t i = k + 1; i < n; i++) {
        num *row = A + (size_t)n * i;
        for (uint32_t j = k + 1; j < n; j++)
            row[j] -= v[i] * w[j] + w[i] * v[j];
    }
}

/* A = Q T Q^T: diagonal d and subdiagonal e of T; row k of A keeps the Householder vector behind
 * entry k, entry (k, k) its beta. w is scratch. */
static void tridiagonalise(num *A, uint32_t n, num *d, num *e, num *w)
{
    for (uint32_t k = 0; k < n; k++) {
        num *v = A + (size_t)n * k;
        num beta = num_of(0);
        d[k] = v[k];
        e[k] = k + 1 < n ? v[k + 1] : num_of(0);
        const num square = k + 2 < n ? dot(v, v, k + 2, n) : num_of(0);
        if (square > 0) {
            const num size = with_sign(norm2(e[k], num_sqrt(square)), e[k]);
            v[k + 1] += size;
            e[k] = -size;
            beta = 2 / (square + v[k + 1] * v[k + 1]);
            reflect_both(A, n, k, beta, w);
        }
        v[k] = beta;
    }
}

/* V = Q^T, row by row: V <- V H_k for k = n - 3 .. 0 from V = 1 */
static void form_basis(const num *A, uint32_t n, num *V)
{
    for (uint32_t i = 0; i < n; i++)
        for (uint32_t j = 0; j < n; j++)
            V[(size_t)n * i + j] = num_of(i == j);
    for (uint32_t k = n; k-- > 0;) {
        const num *v = A + (size_t)n * k;
        for (uint32_t i = k + 1; v[k] > 0 && i < n; i++) {
            num *row = V + (size_t)n * i;
            const num x = v[k] * dot(row, v, k + 1, n);
            for (uint32_t j = k + 1; j < n; j++)
                row[j] -= x * v[j];
        }
    }
}

/* Rows i and i + 1 of V, turned */
static void rotate_rows(num *V, uint32_t n, uint32_t i, num c, num s)
{
    num *x = V + (size_t)n * i, *y = x + n;
    for (uint32_t j = 0; j < n; j++) {
        const num f = y[j];
        y[j] = s * x[j] + c * f;
        x[j] = c * x[j] - s * f;
    }
}

/* Where the block that begins at l ends: the first subdiagonal entry that is rounding, of its
 * neighbours or (floor) of rounding of the matrix */
static uint32_t block_end(const num *d, const num *e, uint32_t l, uint32_t n, num floor)
{
    uint32_t m = l;
    while (m + 1 < n && num_abs(e[m]) > floor &&
           num_abs(e[m]) > NUM_EPSILON * (num_abs(d[m]) + num_abs(d[m + 1])))
        m++;
    return m;
}

/* eps |T|. Rotations of large blocks leave this much in small ones next to them, which would never
 * end below rounding of their own (48 contact points on a humanoid's hands and feet). */
static num floor_of(const num *d, const num *e, uint32_t n)
{
    num most = num_of(0);
    for (uint32_t k = 0; k < n; k++) {
        most = num_abs(d[k]) > most ? num_abs(d[k]) : most;
        most = num_abs(e[k]) > most ? num_abs(e[k]) : most;
    }
    return NUM_EPSILON * most;
}

/* One implicit QL step over the block l .. m */
static void ql_step(num *d, num *e, uint32_t l, uint32_t m, uint32_t n, num *V)
{
    num g = (d[l + 1] - d[l]) / (2 * e[l]), c = num_of(1), s = num_of(1), p = num_of(0);
    g = d[m] - d[l] + e[l] / (g + with_sign(norm2(g, num_of(1)), g));
    for (uint32_t i = m; i-- > l;) {
        const num f = s * e[i], b = c * e[i], r = norm2(f, g);
        e[i + 1] = r;
        if (!(r > 0)) { /* the block falls apart */
            d[i + 1] -= p;
            e[m] = num_of(0);
            return;
        }
        s = f / r;
        c = g / r;
        g = d[i + 1] - p;
        const num x = (d[i] - g) * s + 2 * c * b;
        p = s * x;
        d[i + 1] = g + p;
        g = c * x - b;
        rotate_rows(V, n, i, c, s);
    }
    d[l] -= p;
    e[l] = g;
    e[m] = num_of(0);
}

int TFA_V(symmetric_eigen)(num *A, uint32_t n, num *V, num *d, num *e)
{
    num sum = num_of(0);
    for (size_t k = 0; k < (size_t)n * n; k++)
        sum += A[k] - A[k];
    if (!(sum == num_of(0)))
        return 0;
    tridiagonalise(A, n, d, e, V); /* V is scratch until the basis is formed */
    form_basis(A, n, V);
    const num floor = floor_of(d, e, n);
    for (uint32_t l = 0; l < n; l++)
        for (uint32_t steps = 0, m; (m = block_end(d, e, l, n, floor)) != l; steps++) {
            if (steps == STEPS_MAX)
                return 0;
            ql_step(d, e, l, m, n, V);
        }
    return 1;
}
