/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Iterative refinement and the error estimate, around any method with kept factors.
 */
#include <math.h>

#include "kernel/kernel.h"

/* A step that does not shrink the correction tenfold is not converging, unless it is already at
 * the level of rounding, 450 units of the answer (methods.md section 4). */
#define SHRINK 10.0
#define ROUNDING (1e-13 * (ANSWER_EPSILON / 0x1p-52))

static double norm(const num *x, uint32_t n)
{
    num sum = 0;
    for (uint32_t j = 0; j < n; j++)
        sum += x[j] * x[j];
    return sqrt((double)sum);
}

/* dx = M^-1 (tau - RNEA(qdd)), and |dx| / |qdd| */
static double correction(struct state *s, tfa_method method)
{
    const uint32_t n = s->m->freedoms;
    TFA_V(rnea)(s, s->qdd, s->res, 1);
    for (uint32_t j = 0; j < n; j++)
        s->res[j] = s->tau[j] - s->res[j];
    TFA_V(gather)(s, s->res); /* the forces between followers and leaders are no residual */
    TFA_V(solve)(s, method, s->res, s->dx);
    double size = norm(s->qdd, n), change = norm(s->dx, n);
    return size > 0 ? change / size : change;
}

double TFA_V(refine)(struct state *s, tfa_method method, uint32_t steps, int *converging)
{
    double estimate = correction(s, method);
    *converging = estimate == estimate;
    for (uint32_t step = 0; step < steps; step++) {
        for (uint32_t j = 0; j < s->m->freedoms; j++)
            s->qdd[j] += s->dx[j];
        if (step + 1 == steps)
            break;
        double next = correction(s, method);
        if (!(next * SHRINK <= estimate || next < ROUNDING))
            *converging = 0;
        estimate = next;
    }
    return estimate;
}
