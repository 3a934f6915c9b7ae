/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Lambda from Lambda^-1 by its eigenvalues.
 */
#include "dynamics/osim/lambda_inverse.h"

#include <math.h>

#include "dynamics/osim/symmetric_eigen.h"

static uint32_t size_of(const struct state *s)
{
    return s->tip_rows * s->tips;
}

/* Both triangles of Lambda^-1, by the rows of the answer, from the upper one with six rows a tip */
static void gather_rows(const struct state *s, num *out)
{
    const uint32_t n = size_of(s);
    for (uint32_t i = 0; i < n; i++)
        for (uint32_t j = i; j < n; j++) {
            const size_t row = 6 * (i / s->tip_rows) + i % s->tip_rows,
                         column = 6 * (j / s->tip_rows) + j % s->tip_rows;
            out[(size_t)n * i + j] = out[(size_t)n * j + i] = s->lambda[row * 6 * s->tips + column];
        }
}

static double default_threshold(tfa_rank_loss policy, uint32_t n)
{
    return policy == TFA_RANK_DAMP ? TFA_RANK_THRESHOLD_DAMP : TFA_RANK_THRESHOLD(n);
}

int TFA_V(lambda_factor)(struct state *s, tfa_rank_loss policy, double relative, tfa_rank *rank)
{
    const uint32_t n = size_of(s);
    gather_rows(s, s->lambda_rows); /* to be overwritten */
    if (!TFA_V(symmetric_eigen)(s->lambda_rows, n, s->eigenvectors, s->eigenvalues, s->gain))
        return 0;
    gather_rows(s, s->lambda_rows);
    num least = s->eigenvalues[0], most = s->eigenvalues[0];
    for (uint32_t k = 1; k < n; k++) {
        least = s->eigenvalues[k] < least ? s->eigenvalues[k] : least;
        most = s->eigenvalues[k] > most ? s->eigenvalues[k] : most;
    }
    const num t = num_of(relative > 0 ? relative : default_threshold(policy, n)) * most;
    const num rounding = num_of(TFA_RANK_THRESHOLD(n)) * most;
    *rank = (tfa_rank){.threshold = (double)t,
                       .condition = least > rounding ? (double)(most / least) : (double)INFINITY};
    for (uint32_t k = 0; k < n; k++) {
        const num d = s->eigenvalues[k];
        const int regular = d > t && d > 0;
        rank->rank += regular ? 1u : 0;
        s->gain[k] = regular ? 1 / d : num_of(0);
        if (!regular && policy == TFA_RANK_DAMP && d > rounding)
            s->gain[k] = d / (t * t);
    }
    return 1;
}

/* y += V diag(g) V^T x; g of eigenvalues that are not inverted counts where `damped`. */
static void add_inverse(const struct state *s, uint32_t n, const num *x, num *y, int damped)
{
    for (uint32_t k = 0; k < n; k++) {
        const num *v = s->eigenvectors + (size_t)n * k;
        const num g = s->gain[k], inverted = g * s->eigenvalues[k];
        num sum = num_of(0);
        if (!(g > 0) || (!damped && inverted < 1 - 16 * NUM_EPSILON))
            continue;
        for (uint32_t j = 0; j < n; j++)
            sum += v[j] * x[j];
        sum *= g;
        for (uint32_t j = 0; j < n; j++)
            y[j] += sum * v[j];
    }
}

void TFA_V(lambda_mul)(const struct state *s, const num *x, num *y, num *scratch)
{
    const uint32_t n = size_of(s);
    for (uint32_t j = 0; j < n; j++)
        y[j] = num_of(0);
    add_inverse(s, n, x, y, 1);
    for (uint32_t i = 0; i < n; i++) {
        const num *row = s->lambda_rows + (size_t)n * i;
        num sum = x[i];
        for (uint32_t j = 0; j < n; j++)
            sum -= row[j] * y[j];
        scratch[i] = sum;
    }
    add_inverse(s, n, scratch, y, 0);
}

int TFA_V(lambda_dense)(const struct state *s, double *out)
{
    const uint32_t n = size_of(s);
    double nonfinite = 0;
    for (uint32_t i = 0; i < n; i++)
        for (uint32_t j = i; j < n; j++) {
            num sum = num_of(0);
            for (uint32_t k = 0; k < n; k++)
                sum += s->eigenvectors[(size_t)n * k + i] * s->gain[k] *
                       s->eigenvectors[(size_t)n * k + j];
            const double x = (double)sum;
            nonfinite += x - x;
            out[(size_t)n * i + j] = out[(size_t)n * j + i] = x;
        }
    return nonfinite == 0;
}
