/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Error of Lambda^-1: with E its error and random f of variance 1 the mean of |E f|^2 is |E|^2, the
 * sum of the squares of all entries (Hutchinson 1989). Lambda^-1 f is compared with J x, where
 * x = M^-1 J^T f is refined once more often than the answer was.
 */
#include <math.h>

#include "dynamics/osim/lambda.h"
#include "dynamics/solve/answer.h"
#include "dynamics/solve/method.h"
#include "dynamics/solve/refine.h"

/* Wrenches that are tried: one alone may by chance lie across the error. */
#define PROBES 3

/* Component e of a wrench: uniform, variance 1 */
static num component(uint32_t probe, size_t e)
{
    const uint32_t bits = ((uint32_t)e + 64 * probe + 1) * 2654435761u;
    return num_of((int32_t)(bits >> 16) - 32768) * num_of(1.7320508 / 32768);
}

/* |Lambda^-1 f - J x|^2 in units of `unit` */
static num difference(struct state *s, tfa_method method, uint32_t steps, uint32_t probe, num unit)
{
    const uint32_t nv = s->m->freedoms;
    const size_t n = 6 * s->tips;
    num sum = num_of(0);
    for (uint32_t j = 0; j < nv; j++) {
        s->tau[j] = num_of(0);
        for (size_t e = 0; e < n; e++)
            s->tau[j] += component(probe, e) * s->psi[(size_t)j * n + e];
    }
    TFA_V(solve_refined)(s, method, steps, 1);
    for (size_t e = 0; e < n; e++) {
        num y = num_of(0);
        for (uint32_t j = 0; j < nv; j++)
            y -= s->psi[(size_t)j * n + e] * s->qdd[j];
        for (size_t f = 0; f < n; f++)
            y += component(probe, f) * s->lambda[e * n + f];
        y /= unit;
        sum += y * y;
    }
    return sum;
}

num_doubles TFA_V(lambda_error)(struct state *s, tfa_reference_frame frame, tfa_method method,
                                uint32_t steps)
{
    const size_t entries = 36 * (size_t)s->tips * s->tips;
    num error = num_of(0), size = num_of(0), unit = num_of(0);
    num_doubles estimate;
    /* M of bodies of very different size has lost some of them, so that its factors see nothing of
     * it: their estimate was 1/1000 of the error (test_light_bodies, 2026-11-26). */
    if (method == TFA_METHOD_CRBA && !s->m->mimics)
        method = METHOD_OF_ESTIMATES;
    method = method_of_estimates(method);
    (void)TFA_V(factor)(s, method);
    TFA_V(jacobian)(s, frame);
    TFA_V(lambda_mirror)(s);
    for (size_t e = 0; e < entries; e++) /* squares of anything else may under- or overflow */
        unit = num_select(num_abs(s->lambda[e]) > unit, num_abs(s->lambda[e]), unit);
    unit = num_select(unit > 0, unit, num_of(1));
    for (uint32_t probe = 0; probe < PROBES; probe++)
        error += difference(s, method, steps + 1, probe, unit);
    for (size_t e = 0; e < entries; e++)
        size += s->lambda[e] / unit * (s->lambda[e] / unit);
    const num ratio = error / (PROBES * size);
    for (int l = 0; l < NUM_LANES; l++)
        estimate.lane[l] =
            num_lane(size, l) > 0 ? ESTIMATE_SAFETY * sqrt((double)num_lane(ratio, l)) : 0;
    return estimate;
}
