/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Eigenvalues and eigenvectors of symmetric 3 x 3 matrices by Jacobi's rotations (Golub and Van
 * Loan, Matrix Computations, 8.5) in extended precision.
 */
#ifndef TFA_SPATIAL_SYMMETRIC3_H
#define TFA_SPATIAL_SYMMETRIC3_H

#include <math.h>
#include <string.h>

/* One rotation that makes a[p][q] zero: a <- G^T a G, V <- V G */
static inline void symmetric3_rotate(long double a[3][3], long double V[3][3], int p, int q)
{
    if (a[p][q] == 0)
        return;
    const long double theta = (a[q][q] - a[p][p]) / (2 * a[p][q]);
    const long double t = copysignl(1, theta) / (fabsl(theta) + hypotl(theta, 1));
    const long double c = 1 / sqrtl(t * t + 1), s = t * c;
    const int r = 3 - p - q;
    const long double apr = a[p][r], aqr = a[q][r];
    a[p][p] -= t * a[p][q];
    a[q][q] += t * a[p][q];
    a[p][q] = a[q][p] = 0;
    a[p][r] = a[r][p] = c * apr - s * aqr;
    a[q][r] = a[r][q] = s * apr + c * aqr;
    for (int k = 0; k < 3; k++) {
        const long double x = V[k][p], y = V[k][q];
        V[k][p] = c * x - s * y;
        V[k][q] = s * x + c * y;
    }
}

/* a <- V^T a V, diagonal; squares of its numbers are finite. V is a rotation, its columns are the
 * eigenvectors, in no order. */
static inline void symmetric3_diagonalise(long double a[3][3], long double V[3][3])
{
    memset(V, 0, 9 * sizeof V[0][0]);
    V[0][0] = V[1][1] = V[2][2] = 1;
    for (int sweep = 0; sweep < 10; sweep++) { /* quadratic: six reach the last bit */
        symmetric3_rotate(a, V, 0, 1);
        symmetric3_rotate(a, V, 0, 2);
        symmetric3_rotate(a, V, 1, 2);
    }
}

#endif
