/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Principal moments of inertia.
 */
#include "model/eigen.h"

#include <math.h>

#include "model/ext.h"
#include "spatial/symmetric3.h"

static void swap_columns(long double value[3], long double V[3][3], int p, int q)
{
    long double t = value[p];
    value[p] = value[q];
    value[q] = t;
    for (int k = 0; k < 3; k++) {
        t = V[k][p];
        V[k][p] = V[k][q];
        V[k][q] = t;
    }
}

void tfa_eigen(const long double s[6], long double value[3], long double *V)
{
    long double W[3][3], scale = 0;
    for (int k = 0; k < 6; k++)
        scale = fmaxl(scale, fabsl(s[k]));
    long double a[3][3] = {{0}}; /* scaled: no finite input overflows */
    for (int k = 0; scale > 0 && k < 6; k++)
        a[ext_row[k]][ext_col[k]] = a[ext_col[k]][ext_row[k]] = s[k] / scale;
    symmetric3_diagonalise(a, W);
    for (int k = 0; k < 3; k++)
        value[k] = a[k][k] * scale;
    if (value[0] > value[1])
        swap_columns(value, W, 0, 1);
    if (value[1] > value[2])
        swap_columns(value, W, 1, 2);
    if (value[0] > value[1])
        swap_columns(value, W, 0, 1);
    if (V)
        memcpy(V, W, sizeof W);
}

int tfa_eigen_negative(const long double value[3])
{
    long double trace = value[0] + value[1] + value[2];
    return value[0] < -TFA_PSD_TOLERANCE * fmaxl(trace, 0) - 1e-300L;
}
