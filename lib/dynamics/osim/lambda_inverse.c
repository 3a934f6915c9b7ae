/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Lambda from factors of the tips' motion.
 */
#include "dynamics/osim/lambda_inverse.h"

#include <math.h>
#include <string.h>

#include "dynamics/kinematics/tip_motion.h"
#include "dynamics/osim/rank_revealing.h"
#include "spatial/dense.h"

/* ---- the metric ---- */

static void find_arms(struct state *s, const tfa_request *r)
{
    const int moved = !s->closings && tip_metric_frame(r) != r->frame;
    for (uint32_t t = 0; t < s->tips; t++) {
        struct tip at = {.p = vec3_simd_of(num_of(0), num_of(0), num_of(0))};
        if (moved)
            TFA_V(tip_locate)(s, t, TFA_FRAME_LOCAL_WORLD_ALIGNED, &at);
        for (int e = 0; e < 3; e++)
            s->arm[3 * t + (uint32_t)e] = vec3_simd_lane(&at.p, e);
    }
}

/* Acceleration to the metric: about the tip's point, angular rows times the length */
static void to_metric(const struct state *s, const num *x, num *out)
{
    const uint32_t rows = s->tip_rows;
    for (uint32_t j = 0; s->closings && j < s->closing_rows; j++)
        out[j] = scale_of(s, j) * x[j];
    if (s->closings)
        return;
    for (uint32_t t = 0; t < s->tips; t++, x += rows, out += rows) {
        const num *p = s->arm + 3 * t;
        for (uint32_t e = 0; e < 3; e++)
            out[e] = x[e];
        if (rows == 3)
            continue;
        for (uint32_t e = 0; e < 3; e++) {
            const uint32_t f = (e + 1) % 3, g = (e + 2) % 3;
            out[e] += x[3 + f] * p[g] - x[3 + g] * p[f];
            out[3 + e] = s->tip_length * x[3 + e];
        }
    }
}

/* Moments of forces y about the points of the request, in place: the transpose */
static void add_arms(const struct state *s, num *y)
{
    for (uint32_t t = 0; !s->closings && s->tip_rows == 6 && t < s->tips; t++, y += 6) {
        const num *p = s->arm + 3 * t;
        for (uint32_t e = 0; e < 3; e++) {
            const uint32_t f = (e + 1) % 3, g = (e + 2) % 3;
            y[3 + e] += p[f] * y[g] - p[g] * y[f];
        }
    }
}

/* A direction of the metric as an acceleration in the rows of the answer, in place */
static void direction_of(const struct state *s, num *v)
{
    for (uint32_t j = 0; s->closings && j < s->closing_rows; j++)
        v[j] /= scale_of(s, j);
    for (uint32_t t = 0; !s->closings && s->tip_rows == 6 && t < s->tips; t++, v += 6) {
        const num *p = s->arm + 3 * t;
        for (uint32_t e = 0; e < 3; e++)
            v[3 + e] /= s->tip_length;
        for (uint32_t e = 0; e < 3; e++) {
            const uint32_t f = (e + 1) % 3, g = (e + 2) % 3;
            v[e] -= v[3 + f] * p[g] - v[3 + g] * p[f];
        }
    }
}

/* ---- factors ---- */

/* Gains of the singular directions by the policy. Returns how many are inverted. */
static uint32_t choose_gains(struct state *s, tfa_rank_loss policy, num threshold)
{
    const uint32_t stride = tip_stride(s);
    uint32_t regular = 0;
    for (uint32_t k = 0; k < s->tip_rank; k++) {
        const num *v = s->direction + (size_t)stride * k;
        const num d = s->eigenvalue[k] = row_dot(v, v, stride);
        const int inverted = d > threshold;
        regular += inverted ? 1u : 0;
        s->gain[k] = inverted                  ? 1 / d
                     : policy == TFA_RANK_DAMP ? d / (threshold * threshold)
                                               : num_of(0);
        s->weight[k] = s->gain[k] / d;
    }
    return regular;
}

/* z -= a x of rows */
static void subtract_row(num *z, num a, const num *x, uint32_t stride)
{
    for (uint32_t c = 0; c < stride; c += NUM_VEC_LANES)
        row_store(z + c, row_load(z + c) - a * row_load(x + c));
}

/* U of rank below n: s->direction becomes U^+T = (U U^T)^-1 U, which is U^-T of rank n, and the sum
 * of 1/d, without singular directions. Pivots leave U well conditioned. */
static num invert_wide(struct state *s)
{
    const uint32_t rank = s->tip_rank, stride = tip_stride(s);
    const num *U = s->triangle;
    num *G = s->lambda, *Z = s->direction, sum = num_of(0);
    for (uint32_t k = 0; k < rank; k++)
        for (uint32_t j = 0; j <= k; j++)
            G[(size_t)rank * k + j] =
                row_dot(U + (size_t)stride * k, U + (size_t)stride * j, stride);
    ldl_factor_rows(G, (int)rank, rank);
    for (uint32_t k = 0; k < rank; k++) {
        memcpy(Z + (size_t)stride * k, U + (size_t)stride * k, stride * sizeof *Z);
        for (uint32_t j = 0; j < k; j++)
            subtract_row(Z + (size_t)stride * k, G[(size_t)rank * k + j], Z + (size_t)stride * j,
                         stride);
    }
    for (uint32_t k = rank; k-- > 0;) {
        num *z = Z + (size_t)stride * k;
        for (uint32_t c = 0; c < stride; c += NUM_VEC_LANES)
            row_store(z + c, G[(size_t)rank * k + k] * row_load(z + c));
        for (uint32_t j = k + 1; j < rank; j++)
            subtract_row(z, G[(size_t)rank * j + k], Z + (size_t)stride * j, stride);
        sum += s->weight[k] * row_dot(z, z, stride);
    }
    return sum;
}

/* Sum of 1/d of the directions that are no rounding */
static num trace_of_inverse(const struct state *s)
{
    num sum = num_of(0);
    for (uint32_t k = 0; k < s->tip_rank; k++)
        sum += 1 / s->eigenvalue[k];
    return sum;
}

/* Rounding of B by these recursions, in units of eps times its condition
 * (tests/dynamics/operational/lambda.c measures 4). A damped direction counts as one at the
 * threshold. */
#define ROUNDINGS 8

static double rounding_of(const struct state *s, num trace, num inverse_trace)
{
    const num least = 1 / inverse_trace;
    const int damped = s->spectral && least < s->tip_threshold;
    return ROUNDINGS *
           (double)(NUM_EPSILON * num_sqrt(trace / (damped ? s->tip_threshold : least)));
}

static tfa_rank_loss policy_of(const tfa_request *r)
{
    if (r->rank_loss != TFA_RANK_DEFAULT)
        return r->rank_loss;
    return TFA_OP_BIT(r->op) & (TFA_OPS_TASK | TFA_OPS_CONSTRAINED) ? TFA_RANK_DAMP
                                                                    : TFA_RANK_TRUNCATE;
}

static double default_threshold(tfa_rank_loss policy, uint32_t n)
{
    return policy == TFA_RANK_DAMP ? TFA_RANK_THRESHOLD_DAMP : TFA_RANK_THRESHOLD(n);
}

void TFA_V(metric_load)(struct state *s, const tfa_request *r)
{
    s->tip_length = num_of(r->characteristic_length ? *r->characteristic_length : s->m->length);
    find_arms(s, r);
}

int TFA_V(lambda_factor)(struct state *s, const tfa_request *r, int directions, tfa_rank *rank)
{
    TFA_V(metric_load)(s, r);
    TFA_V(tip_rows)(s, tip_metric_frame(r));
    return TFA_V(factor_rows)(s, r, directions, num_of(0), rank);
}

int TFA_V(factor_rows)(struct state *s, const tfa_request *r, int directions, num size,
                       tfa_rank *rank)
{
    const uint32_t n = all_tip_rows(s);
    const tfa_rank_loss policy = policy_of(r);
    struct gram_schmidt f = {.rows = s->tip_freedoms,
                             .n = n,
                             .B = s->phi,
                             .U = s->triangle,
                             .Z = s->direction,
                             .S = s->pivot_square,
                             .weight = s->weight,
                             .pivot = s->pivot,
                             .square = s->coefficient,
                             .free = s->coefficient + tip_stride(s),
                             .size = size};
    s->tip_rank = TFA_V(pivoted_gram_schmidt)(&f, num_of(TFA_RANK_THRESHOLD(n)));
    const num trace = size > 0 ? size : f.trace,
              threshold = trace * num_of(r->rank_threshold ? *r->rank_threshold
                                                           : default_threshold(policy, n));
    if (!(f.trace - f.trace == 0))
        return 0;
    s->tip_threshold = threshold;
    num inverse = s->tip_rank < n && !directions ? invert_wide(s) : f.inverse_trace;
    uint32_t regular = s->tip_rank;
    s->spectral = directions || !(inverse * threshold < 1);
    if (s->spectral) {
        TFA_V(singular_directions)
        (s->triangle, s->pivot_square, n, s->tip_rank, s->direction, s->triangle);
        regular = choose_gains(s, policy, threshold);
        inverse = trace_of_inverse(s);
    }
    *rank = (tfa_rank){.rank = regular,
                       .lost = n - regular,
                       .threshold = (double)threshold,
                       .condition = s->tip_rank > 0 ? (double)(trace * inverse) : (double)INFINITY,
                       .length = (double)s->tip_length,
                       .error_estimate = rounding_of(s, trace, inverse)};
    return 1;
}

/* ---- products ---- */

/* y = sum of coefficients times directions, out of the metric */
static void add_directions(const struct state *s, num *y)
{
    const uint32_t stride = tip_stride(s);
    num *row = s->coefficient + stride;
    for (uint32_t c = 0; c < stride; c += NUM_VEC_LANES) {
        num_vec sum = {0};
        for (uint32_t k = 0; k < s->tip_rank; k++)
            sum += s->coefficient[k] * row_load(s->direction + (size_t)stride * k + c);
        row_store(row + c, sum);
    }
    for (uint32_t j = 0; j < all_tip_rows(s); j++)
        y[j] = scale_of(s, j) * row[j];
    add_arms(s, y);
}

/* The coefficients less those of Lambda x */
static void subtract_product(const struct state *s, const num *x)
{
    const uint32_t stride = tip_stride(s);
    num *row = s->coefficient + stride;
    row_store(row + stride - NUM_VEC_LANES, (num_vec){0});
    to_metric(s, x, row);
    for (uint32_t k = 0; k < s->tip_rank; k++)
        s->coefficient[k] -= s->weight[k] * row_dot(s->direction + (size_t)stride * k, row, stride);
}

void TFA_V(lambda_force)(struct state *s, const num *tau, const num *x, num *y)
{
    TFA_V(force_rows)(s, tau, s->force_row);
    TFA_V(least_squares)(s, s->force_row, x, y);
}

/* The projections on the columns of Q, in the order in which they became orthogonal */
void TFA_V(least_squares)(struct state *s, num *z, const num *x, num *y)
{
    const uint32_t rows = s->tip_freedoms, stride = tip_stride(s);
    num *a = s->coefficient;
    for (uint32_t k = 0; k < s->tip_rank; k++) {
        const num *q = s->phi + s->pivot[k];
        num sum = num_of(0);
        for (uint32_t i = 0; i < rows; i++)
            sum += q[(size_t)stride * i] * z[i];
        a[k] = sum / s->pivot_square[k];
        for (uint32_t i = 0; i < rows; i++)
            z[i] -= a[k] * q[(size_t)stride * i];
    }
    if (s->spectral) {
        for (uint32_t k = 0; k < s->tip_rank; k++)
            z[k] = a[k] * num_sqrt(s->pivot_square[k]);
        for (uint32_t k = 0; k < s->tip_rank; k++)
            a[k] = s->gain[k] * dense_dot(s->triangle + (size_t)s->tip_rank * k, z, s->tip_rank);
    }
    if (x)
        subtract_product(s, x);
    add_directions(s, y);
}

/* Q times what the coefficients are in its columns: themselves, as U U^-1 is one; of singular
 * directions S^-1/2 J Sigma^2 a. */
void TFA_V(least_squares_image)(const struct state *s, num *z)
{
    const uint32_t stride = tip_stride(s), rank = s->tip_rank;
    num *a = s->coefficient + stride;
    for (uint32_t k = 0; k < rank; k++)
        a[k] = s->spectral ? num_of(0) : s->coefficient[k];
    for (uint32_t k = 0; s->spectral && k < rank; k++)
        for (uint32_t e = 0; e < rank; e++)
            a[e] += s->triangle[(size_t)rank * k + e] * s->eigenvalue[k] * s->coefficient[k];
    for (uint32_t k = 0; s->spectral && k < rank; k++)
        a[k] /= num_sqrt(s->pivot_square[k]);
    for (uint32_t i = 0; i < s->tip_freedoms; i++) {
        const num *row = s->phi + (size_t)stride * i;
        num sum = num_of(0);
        for (uint32_t k = 0; k < rank; k++)
            sum += row[s->pivot[k]] * a[k];
        z[i] = sum;
    }
}

/* Directions out of the metric times the roots of their weights, by rows: x^T x is Lambda. */
TFA_INLINE void root_of_lambda(const struct state *s, uint32_t rank, uint32_t n, num *x)
{
    const uint32_t stride = row_stride(n);
    num *scale = s->coefficient, away = num_of(0);
    for (uint32_t j = 0; j < stride; j++)
        scale[j] = scale_of(s, j);
    for (uint32_t j = 0; j < 3 * s->tips; j++)
        away += num_abs(s->arm[j]);
    for (uint32_t k = 0; k < rank; k++, x += stride) {
        const num root = num_sqrt(s->weight[k]);
        for (uint32_t c = 0; c < stride; c += NUM_VEC_LANES)
            row_store(x + c,
                      root * row_load(scale + c) * row_load(s->direction + (size_t)stride * k + c));
        if (away > 0)
            add_arms(s, x);
    }
}

/* x^T x of rows of n numbers. Returns 1 when all of it is finite. */
TFA_INLINE int square_of_rows(const num *x, uint32_t rows, uint32_t n, num *row, double *out)
{
    const uint32_t stride = row_stride(n);
    double nonfinite = 0;
    for (uint32_t i = 0; i < n; i++) {
        for (uint32_t c = i / NUM_VEC_LANES * NUM_VEC_LANES; c < stride; c += NUM_VEC_LANES) {
            num_vec sum = {0};
#pragma GCC unroll 6
            for (uint32_t k = 0; k < rows; k++)
                sum += x[(size_t)stride * k + i] * row_load(x + (size_t)stride * k + c);
            row_store(row + c, sum);
        }
        for (uint32_t j = i; j < n; j++) {
            out[n * i + j] = out[n * j + i] = (double)row[j];
            nonfinite += out[n * i + j] - out[n * i + j];
        }
    }
    return nonfinite == 0;
}

TFA_INLINE int dense(const struct state *s, uint32_t rank, uint32_t n, double *out)
{
    root_of_lambda(s, rank, n, s->lambda);
    return square_of_rows(s->lambda, rank, n, s->coefficient, out);
}

int TFA_V(lambda_dense)(struct state *s, double *out)
{
    const uint32_t n = all_tip_rows(s), rank = s->tip_rank;
    return n == 6 && rank == 6 ? dense(s, 6, 6, out) : dense(s, rank, n, out);
}

/* ---- directions that are lost ---- */

/* Row of the reply: singular value, acceleration given up along the direction, direction */
static double *put_lost(const struct state *s, num sigma, num given_up, num *v, double *out)
{
    const uint32_t n = all_tip_rows(s);
    direction_of(s, v);
    out[0] = (double)sigma;
    out[1] = (double)given_up;
    for (uint32_t j = 0; j < n; j++)
        out[2 + j] = (double)v[j];
    return out + 2 + n;
}

/* The direction at or below the threshold with the smallest eigenvalue above `last`; -1: none */
static int32_t next_lost(const struct state *s, num last)
{
    int32_t best = -1;
    for (uint32_t k = 0; s->spectral && k < s->tip_rank; k++) {
        const num d = s->eigenvalue[k];
        if (!(d > s->tip_threshold) && d > last && (best < 0 || d < s->eigenvalue[best]))
            best = (int32_t)k;
    }
    return best;
}

/* What is left of x beside all directions of B, which the tips cannot follow at all: x - V V^T x
 * or x - U^+ U x */
static num outside(const struct state *s, const num *x, num *rest)
{
    const uint32_t n = all_tip_rows(s), stride = tip_stride(s);
    for (uint32_t j = 0; j < n; j++)
        rest[j] = x[j];
    for (uint32_t k = 0; k < s->tip_rank; k++) {
        const num *v = s->direction + (size_t)stride * k;
        const num a = s->spectral ? dense_dot(v, x, n) / s->eigenvalue[k]
                                  : dense_dot(s->triangle + (size_t)stride * k, x, n);
        for (uint32_t j = 0; j < n; j++)
            rest[j] -= a * v[j];
    }
    return num_sqrt(dense_dot(rest, rest, n));
}

void TFA_V(lambda_lost)(struct state *s, const num *x, double *out)
{
    const uint32_t n = all_tip_rows(s);
    num *in = s->task + 2 * (size_t)n, *v = s->task + 3 * (size_t)n;
    uint32_t count = 0;
    to_metric(s, x, in);
    const num size = num_sqrt(dense_dot(in, in, n));
    if (s->tip_rank < n) {
        const num rest = outside(s, in, v);
        for (uint32_t j = 0; j < n; j++)
            v[j] /= rest > 0 ? rest : num_of(1);
        if (rest > num_of(0x1p-26) * size) { /* else half of the direction's digits are rounding */
            out = put_lost(s, num_of(0), rest, v, out);
            count++;
        }
    }
    int32_t k;
    for (num last = num_of(-1); count < TFA_LOST_MAX && (k = next_lost(s, last)) >= 0; count++) {
        const num sigma = num_sqrt(last = s->eigenvalue[k]);
        for (uint32_t j = 0; j < n; j++)
            v[j] = s->direction[(size_t)tip_stride(s) * (uint32_t)k + j] / sigma;
        const num along = dense_dot(v, in, n);
        out = put_lost(s, sigma, along * (1 - s->gain[k] * last), v, out);
    }
}
