/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Iterative refinement and the error estimate, around any method with kept factors.
 */
#include <math.h>

#include "kernel/kernel.h"

/* A step that does not shrink the correction tenfold is not converging, unless it is already at
 * the level of rounding (methods.md section 4). */
#define SHRINK 10.0
#define ROUNDING 1e-13

static double norm(const num *x, uint32_t n)
{
    num sum = 0;
    for (uint32_t j = 0; j < n; j++)
        sum += x[j] * x[j];
    return sqrt((double)sum);
}

/* s->dx = M^-1 s->res, and |dx| / |qdd| */
static double correction(struct state *s, tfa_method method)
{
    const uint32_t n = s->m->freedoms;
    TFA_V(gather)(s, s->res); /* the forces between followers and leaders are no residual */
    TFA_V(solve)(s, method, s->res, s->dx);
    double size = norm(s->qdd, n), change = norm(s->dx, n);
    return size > 0 ? change / size : change;
}

static double correct(struct state *s, tfa_method method)
{
    TFA_V(rnea)(s, s->qdd, s->res, 1);
    for (uint32_t j = 0; j < s->m->freedoms; j++)
        s->res[j] = s->tau[j] - s->res[j];
    return correction(s, method);
}

/* The difference from tau is rounded, too: with the sign that cannot cancel the rest. */
double TFA_V(certify)(struct state *s, tfa_method method)
{
    TFA_V(rnea_shaken)(s, s->qdd, s->res, 1);
    for (uint32_t j = 0; j < s->m->freedoms; j++) {
        const num r = s->tau[j] - s->res[j], e = (num)NUM_EPSILON * num_abs(s->tau[j]);
        s->res[j] = r < 0 ? r - e : r + e;
    }
    return correction(s, method);
}

double TFA_V(refine)(struct state *s, tfa_method method, uint32_t steps, int *converging)
{
    double estimate = correct(s, method);
    *converging = estimate == estimate;
    for (uint32_t step = 0; step < steps; step++) {
        for (uint32_t j = 0; j < s->m->freedoms; j++)
            s->qdd[j] += s->dx[j];
        if (step + 1 == steps)
            break;
        double next = correct(s, method);
        if (!(next * SHRINK <= estimate || next < ROUNDING))
            *converging = 0;
        estimate = next;
    }
    return estimate;
}
