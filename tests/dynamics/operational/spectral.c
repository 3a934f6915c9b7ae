/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Cyclic Jacobi rotations (Golub and Van Loan, Matrix Computations, 8.5.3) in quadruple precision.
 * See spectral.h.
 */
#include "spectral.h"

#include <math.h>
#include <string.h>

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

static quad root(quad d)
{
    return d > 0 ? quad_sqrt(d) : 0;
}

/* In the basis of V an error E of B with |E| = |B| changes entry i, j of B^T B by at most
 * (sigma_i + sigma_j) |B|, and that of f by the divided difference of f times as much. */
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
            steep *= root(s->d[i]) + root(s->d[j]);
            steepest = steep > steepest ? steep : steepest;
        }
    }
    return largest > 0 ? fmax(1, (double)(steepest * root(s->most) / largest)) : 1;
}

/* ---- the metric ---- */

spectral_metric spectral_metric_of(const op_case *c, const op_answers *a, uint32_t k)
{
    spectral_metric metric = {
        .tips = a->tips, .rows = a->rows / a->tips, .length = a->rank[k].length};
    assert_true(a->tips <= OP_TIPS);
    for (uint32_t t = 0; c->r.frame == TFA_FRAME_WORLD && metric.rows == 6 && t < a->tips; t++)
        memcpy(metric.arm + 3 * t, a->poses + 7 * ((size_t)a->tips * k + t), 3 * sizeof(double));
    return metric;
}

void spectral_jacobian(const op_case *c, const spectral_metric *metric, quad *J)
{
    oracle_tips tips = op_tips(c);
    if (tips.frame == TFA_FRAME_WORLD && metric->rows == 6)
        tips.frame = TFA_FRAME_LOCAL_WORLD_ALIGNED;
    oracle_jacobian(c->o, &tips, J);
    for (uint32_t i = 0; i < metric->tips * metric->rows; i++)
        for (uint32_t j = 0; i % metric->rows >= 3 && j < c->n; j++)
            J[(size_t)i * c->n + j] *= (quad)metric->length;
}

void spectral_acceleration(const spectral_metric *metric, const quad *x, quad *out)
{
    for (uint32_t t = 0; t < metric->tips; t++, x += metric->rows, out += metric->rows) {
        const double *p = metric->arm + 3 * t;
        for (uint32_t e = 0; e < metric->rows; e++)
            out[e] = e < 3 ? x[e] : (quad)metric->length * x[e];
        for (uint32_t e = 0; metric->rows == 6 && e < 3; e++) /* x + w x p */
            out[e] += x[3 + (e + 1) % 3] * p[(e + 2) % 3] - x[3 + (e + 2) % 3] * p[(e + 1) % 3];
    }
}

/* The force and the moment about the tip's point, n - p x f */
static void to_tip(const spectral_metric *metric, const quad *F, quad *out)
{
    for (uint32_t t = 0; t < metric->tips; t++, F += metric->rows, out += metric->rows) {
        const double *p = metric->arm + 3 * t;
        quad moved[6];
        for (uint32_t e = 0; e < metric->rows; e++)
            moved[e] = F[e];
        for (uint32_t e = 0; metric->rows == 6 && e < 3; e++)
            moved[3 + e] =
                (F[3 + e] - (p[(e + 1) % 3] * F[(e + 2) % 3] - p[(e + 2) % 3] * F[(e + 1) % 3])) /
                (quad)metric->length;
        memcpy(out, moved, metric->rows * sizeof *out);
    }
}

void spectral_force(const spectral_metric *metric, const double *F, quad *out)
{
    quad exact[SPECTRAL_ROWS];
    for (uint32_t i = 0; i < metric->tips * metric->rows; i++)
        exact[i] = (quad)F[i];
    to_tip(metric, exact, out);
}

void spectral_lambda(const spectral_metric *metric, const double *L, quad *out)
{
    const uint32_t m = metric->tips * metric->rows;
    quad column[SPECTRAL_ROWS];
    for (uint32_t i = 0; i < m; i++)
        spectral_force(metric, L + (size_t)m * i, out + (size_t)m * i);
    for (uint32_t j = 0; j < m; j++) {
        for (uint32_t i = 0; i < m; i++)
            column[i] = out[(size_t)m * i + j];
        to_tip(metric, column, column);
        for (uint32_t i = 0; i < m; i++)
            out[(size_t)m * i + j] = column[i];
    }
}

/* ---- the definition ---- */

tfa_rank_loss spectral_policy(const tfa_request *r)
{
    if (r->rank_loss != TFA_RANK_DEFAULT)
        return r->rank_loss;
    return r->op == TFA_OP_TASK_TORQUES ? TFA_RANK_DAMP : TFA_RANK_TRUNCATE;
}

double spectral_threshold(const tfa_request *r, uint32_t rows)
{
    if (r->rank_threshold)
        return *r->rank_threshold;
    return spectral_policy(r) == TFA_RANK_DAMP ? TFA_RANK_THRESHOLD_DAMP : TFA_RANK_THRESHOLD(rows);
}

void spectral_of(spectral *s, const quad *A, uint32_t m, tfa_rank_loss policy, double threshold)
{
    assert_true(m <= SPECTRAL_ROWS);
    memset(s, 0, sizeof *s);
    s->m = m;
    for (uint32_t i = 0; i < m; i++) {
        for (uint32_t j = 0; j < m; j++)
            s->A[i * m + j] = (A[i * m + j] + A[j * m + i]) / 2;
        s->V[i * m + i] = 1;
    }
    diagonalise(s);
    for (uint32_t i = 0; i < m; i++) {
        s->d[i] = s->A[i * m + i];
        s->most = s->d[i] > s->most ? s->d[i] : s->most;
        s->trace += s->d[i];
    }
    s->threshold = (quad)threshold * s->trace;
    for (uint32_t i = 0; i < m; i++) {
        s->f[i] = value(policy, s->d[i], s->threshold);
        s->rank += s->d[i] > s->threshold;
        if (s->d[i] > (quad)TFA_RANK_THRESHOLD(m) * s->trace)
            s->condition += s->trace / s->d[i];
    }
    s->sensitivity = sensitivity_of(s, policy);
    for (uint32_t i = 0; i < m; i++)
        for (uint32_t j = 0; j < m; j++)
            for (uint32_t k = 0; k < m; k++)
                s->L[i * m + j] += s->V[i * m + k] * s->f[k] * s->V[j * m + k];
}

double spectral_error(const spectral *s, const spectral_metric *metric, const double *L)
{
    quad got[SPECTRAL_ROWS * SPECTRAL_ROWS], error = 0;
    const size_t count = (size_t)s->m * s->m;
    const double size = op_norm_quad(s->L, count);
    spectral_lambda(metric, L, got);
    for (size_t i = 0; i < count; i++)
        error += (got[i] - s->L[i]) * (got[i] - s->L[i]);
    return size > 0 ? (double)quad_sqrt(error) / size : 0;
}

double spectral_product_error(const spectral *s, const spectral_metric *metric, const quad *y,
                              const double *F, double *size)
{
    quad want[SPECTRAL_ROWS], got[SPECTRAL_ROWS], error = 0;
    spectral_force(metric, F, got);
    for (uint32_t i = 0; i < s->m; i++) {
        want[i] = 0;
        for (uint32_t j = 0; j < s->m; j++)
            want[i] += s->L[i * s->m + j] * y[j];
        error += (got[i] - want[i]) * (got[i] - want[i]);
    }
    *size = op_norm_quad(want, s->m);
    return (double)quad_sqrt(error);
}

bool spectral_in_doubt(const spectral *s)
{
    const quad rounding = (quad)(4 * 0x1p-52) * s->m * root(s->most);
    for (uint32_t i = 0; i < s->m; i++) {
        const quad sigma = root(s->d[i]), limit = root(s->threshold);
        if (magnitude(sigma - limit) < rounding + (quad)1e-6 * limit)
            return true;
        const quad noise = (quad)TFA_RANK_ROUNDING(s->m) * root(s->trace);
        if (sigma > noise / 8 && sigma < 8 * noise)
            return true;
    }
    return false;
}
