/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Principal moments of inertia by Jacobi rotations (Golub and Van Loan, Matrix Computations, 8.5).
 */
#include "model/eigen.h"

#include <math.h>
#include <string.h>

#include "model/ext.h"

/* One rotation that makes a[p][q] zero: a <- G^T a G, V <- V G */
static void rotate(long double a[3][3], long double V[9], int p, int q)
{
    if (a[p][q] == 0)
        return;
    long double theta = (a[q][q] - a[p][p]) / (2 * a[p][q]);
    long double t = copysignl(1, theta) / (fabsl(theta) + hypotl(theta, 1));
    long double c = 1 / sqrtl(t * t + 1), s = t * c;
    int r = 3 - p - q;
    long double apr = a[p][r], aqr = a[q][r];
    a[p][p] -= t * a[p][q];
    a[q][q] += t * a[p][q];
    a[p][q] = a[q][p] = 0;
    a[p][r] = a[r][p] = c * apr - s * aqr;
    a[q][r] = a[r][q] = s * apr + c * aqr;
    for (int k = 0; k < 9; k += 3) {
        long double x = V[k + p], y = V[k + q];
        V[k + p] = c * x - s * y;
        V[k + q] = s * x + c * y;
    }
}

static void swap_columns(long double value[3], long double V[9], int p, int q)
{
    long double t = value[p];
    value[p] = value[q];
    value[q] = t;
    for (int k = 0; k < 9; k += 3) {
        t = V[k + p];
        V[k + p] = V[k + q];
        V[k + q] = t;
    }
}

void tfa_eigen(const long double s[6], long double value[3], long double *V)
{
    long double scratch[9], scale = 0;
    long double *W = V ? V : scratch;
    memset(W, 0, 9 * sizeof *W);
    W[0] = W[4] = W[8] = 1;
    for (int k = 0; k < 6; k++)
        scale = fmaxl(scale, fabsl(s[k]));
    long double a[3][3] = {{0}}; /* scaled: no finite input overflows */
    for (int k = 0; scale > 0 && k < 6; k++)
        a[ext_row[k]][ext_col[k]] = a[ext_col[k]][ext_row[k]] = s[k] / scale;
    for (int sweep = 0; sweep < 10; sweep++) { /* quadratic: six reach the last bit */
        rotate(a, W, 0, 1);
        rotate(a, W, 0, 2);
        rotate(a, W, 1, 2);
    }
    for (int k = 0; k < 3; k++)
        value[k] = a[k][k] * scale;
    if (value[0] > value[1])
        swap_columns(value, W, 0, 1);
    if (value[1] > value[2])
        swap_columns(value, W, 1, 2);
    if (value[0] > value[1])
        swap_columns(value, W, 0, 1);
}

int tfa_eigen_negative(const long double value[3])
{
    long double trace = value[0] + value[1] + value[2];
    return value[0] < -TFA_PSD_TOLERANCE * fmaxl(trace, 0) - 1e-300L;
}
