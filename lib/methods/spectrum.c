/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Eigenvalues of small symmetric matrices by Jacobi rotations: slow, but the small eigenvalues
 * of a nearly singular Lambda^-1 come out with the accuracy that the matrix has.
 */
#include <float.h>
#include <math.h>

#include "methods/methods.h"

/* Jacobi converges quadratically: 6 x 6 takes 5 to 7 sweeps, 48 x 48 at most 10. */
#define MAX_SWEEPS 30

/* Rotates rows and columns p, q so that a[p][q] becomes zero. */
static void rotate(double *a, uint32_t n, uint32_t p, uint32_t q)
{
    double theta = (a[q * n + q] - a[p * n + p]) / (2 * a[p * n + q]);
    double t = (theta < 0 ? -1 : 1) / (fabs(theta) + sqrt(theta * theta + 1));
    double c = 1 / sqrt(t * t + 1), s = t * c;
    for (uint32_t k = 0; k < n; k++) {
        double x = a[k * n + p], y = a[k * n + q];
        a[k * n + p] = c * x - s * y;
        a[k * n + q] = s * x + c * y;
    }
    for (uint32_t k = 0; k < n; k++) {
        double x = a[p * n + k], y = a[q * n + k];
        a[p * n + k] = c * x - s * y;
        a[q * n + k] = s * x + c * y;
    }
}

static double off_diagonal(const double *a, uint32_t n)
{
    double sum = 0;
    for (uint32_t i = 0; i < n; i++)
        for (uint32_t j = 0; j < i; j++)
            sum += a[i * n + j] * a[i * n + j];
    return sum;
}

tfa_spectrum tfa_spectrum_of(const double *matrix, uint32_t n, double *scratch)
{
    double size = 0;
    for (uint32_t k = 0; k < n * n; k++) {
        scratch[k] = matrix[k];
        size += matrix[k] * matrix[k];
    }
    for (int sweep = 0; sweep < MAX_SWEEPS; sweep++) {
        if (!(off_diagonal(scratch, n) > size * DBL_EPSILON * DBL_EPSILON * 1e-4))
            break;
        for (uint32_t p = 0; p + 1 < n; p++)
            for (uint32_t q = p + 1; q < n; q++)
                if (scratch[p * n + q] != 0)
                    rotate(scratch, n, p, q);
    }
    tfa_spectrum out = {0, 0, scratch[0], scratch[0]};
    for (uint32_t k = 1; k < n; k++) {
        out.eig_min = fmin(out.eig_min, scratch[k * n + k]);
        out.eig_max = fmax(out.eig_max, scratch[k * n + k]);
    }
    for (uint32_t k = 0; k < n; k++)
        out.rank += scratch[k * n + k] > n * 64 * DBL_EPSILON * out.eig_max;
    return out;
}
