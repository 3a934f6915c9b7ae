/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Eigenvalues of a symmetric matrix of order three.
 */
#include "http/http_internal.h"
#include "spatial/symmetric3.h"

void eigen_symmetric3(const double matrix[9], double values[3], double vectors[3][3])
{
    long double a[3][3], v[3][3];
    int order[3] = {0, 1, 2};
    for (int i = 0; i < 9; i++)
        a[i / 3][i % 3] = matrix[i];
    symmetric3_diagonalise(a, v);
    for (int i = 1; i < 3; i++)
        for (int k = i; k > 0 && a[order[k]][order[k]] > a[order[k - 1]][order[k - 1]]; k--) {
            const int swapped = order[k];
            order[k] = order[k - 1];
            order[k - 1] = swapped;
        }
    for (int i = 0; i < 3; i++) {
        values[i] = (double)a[order[i]][order[i]];
        for (int k = 0; k < 3; k++)
            vectors[i][k] = (double)v[k][order[i]];
    }
}
