/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Cyclic Jacobi rotations (Golub and Van Loan, Matrix Computations, 8.5.3) in quadruple precision.
 * See spectral.h.
 */
#include "spectral.h"

#include "test.h"

#define SWEEPS 14

static quad magnitude(quad x)
{
    return x < 0 ? -x : x;
}

static void rotate(spectral *s, uint32_t p, uint32_t q)
{
    const uint32_t m = s->m;
    quad *A = s->A, *V = s->V;
    const quad theta = (A[q * m + q] - A[p * m + p]) / (2 * A[p * m + q]);
    const quad t = (theta < 0 ? -1 : 1) / (magnitude(theta) + quad_sqrt(theta * theta + 1));
    const quad c = 1 / quad_sqrt(t * t + 1), sine = t * c;
    for (uint32_t k = 0; k < m; k++) {
        const quad x = A[k * m + p], y = A[k * m + q], vx = V[k * m + p], vy = V[k * m + q];
        A[k * m + p] = c * x - sine * y;
        A[k * m + q] = sine * x + c * y;
        V[k * m + p] = c * vx - sine * vy;
        V[k * m + q] = sine * vx + c * vy;
    }
    for (uint32_t k = 0; k < m; k++) {
        const quad x = A[p * m + k], y = A[q * m + k];
        A[p * m + k] = c * x - sine * y;
        A[q * m + k] = sine * x + c * y;
    }
}

static void diagonalise(spectral *s)
{
    const uint32_t m = s->m;
    quad size = 0;
    for (uint32_t i = 0; i < m * m; i++)
        size = magnitude(s->A[i]) > size ? magnitude(s->A[i]) : size;
    for (int sweep = 0; sweep < SWEEPS; sweep++) {
        quad off = 0;
        for (uint32_t p = 0; p < m; p++)
            for (uint32_t q = p + 1; q < m; q++)
                if (magnitude(s->A[p * m + q]) > (quad)1e-33 * size) {
                    off = magnitude(s->A[p * m + q]) > off ? magnitude(s->A[p * m + q]) : off;
                    rotate(s, p, q);
                }
        if (off == 0)
            return;
    }
}

/* f(d) of request.h */
static quad value(tfa_rank_loss policy, quad d, quad t)
{
    if (d > t)
        return 1 / d;
    return policy == TFA_RANK_DAMP && d > 0 ? d / (t * t) : 0;
}

static quad slope(tfa_rank_loss policy, quad d, quad t)
{
    if (d > t)
        return 1 / (d * d);
    return policy == TFA_RANK_DAMP ? 1 / (t * t) : 0;
}

/* |f(A + E) - f(A)| <= |E| times the largest divided difference of f. */
static double sensitivity_of(const spectral *s, tfa_rank_loss policy)
{
    quad steepest = 0, largest = 0;
    for (uint32_t i = 0; i < s->m; i++) {
        largest = s->f[i] > largest ? s->f[i] : largest;
        for (uint32_t j = 0; j <= i; j++) {
            const quad apart = magnitude(s->d[i] - s->d[j]);
            quad steep = slope(policy, s->d[i], s->threshold);
            if (apart > (quad)1e-20 * s->most)
                steep = magnitude(s->f[i] - s->f[j]) / apart;
            steepest = steep > steepest ? steep : steepest;
        }
    }
    return largest > 0 ? (double)(steepest * s->most / largest) : 0;
}

void spectral_of(spectral *s, const double *A, uint32_t m, tfa_rank_loss policy, double threshold)
{
    assert_true(m <= SPECTRAL_ROWS);
    memset(s, 0, sizeof *s);
    s->m = m;
    for (uint32_t i = 0; i < m; i++) {
        for (uint32_t j = 0; j < m; j++)
            s->A[i * m + j] = ((quad)A[i * m + j] + A[j * m + i]) / 2;
        s->V[i * m + i] = 1;
    }
    diagonalise(s);
    s->most = s->least = s->A[0];
    for (uint32_t i = 0; i < m; i++) {
        s->d[i] = s->A[i * m + i];
        s->most = s->d[i] > s->most ? s->d[i] : s->most;
        s->least = s->d[i] < s->least ? s->d[i] : s->least;
    }
    s->threshold = threshold * s->most;
    for (uint32_t i = 0; i < m; i++) {
        s->f[i] = value(policy, s->d[i], s->threshold);
        s->rank += s->d[i] > s->threshold;
    }
    s->sensitivity = sensitivity_of(s, policy);
    for (uint32_t i = 0; i < m; i++)
        for (uint32_t j = 0; j < m; j++)
            for (uint32_t k = 0; k < m; k++)
                s->L[i * m + j] += s->V[i * m + k] * s->f[k] * s->V[j * m + k];
}

bool spectral_in_doubt(const spectral *s)
{
    const quad rounding = (quad)(4 * 0x1p-52) * s->m * s->most;
    for (uint32_t i = 0; i < s->m; i++)
        if (magnitude(s->d[i] - s->threshold) < rounding)
            return true;
    return false;
}
