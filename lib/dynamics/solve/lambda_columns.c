/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Lambda^-1 by columns: M^-1 J^T with the kept factors of any method.
 */
#include "dynamics/core/recursions.h"
#include "dynamics/osim/lambda.h"
#include "dynamics/solve/load.h"
#include "dynamics/solve/method.h"
#include "dynamics/solve/refine.h"

void TFA_V(solve_refined)(struct state *s, tfa_method method, uint32_t steps, int perturbed)
{
    const uint32_t nv = s->m->freedoms;
    TFA_V(solve)(s, method, s->tau, s->qdd);
    for (uint32_t step = 0; step < steps; step++) {
        if (perturbed && step + 1 == steps)
            TFA_V(rnea_perturbed)(s, s->qdd, s->res, 0);
        else
            TFA_V(rnea)(s, s->qdd, s->res, 0);
        for (uint32_t j = 0; j < nv; j++)
            s->res[j] = s->tau[j] - s->res[j];
        TFA_V(gather_on_leaders)(s, s->res);
        TFA_V(solve)(s, method, s->res, s->dx);
        for (uint32_t j = 0; j < nv; j++)
            s->qdd[j] += s->dx[j];
    }
}

void TFA_V(lambda_columns)(struct state *s, tfa_reference_frame frame, tfa_method method,
                           uint32_t refine)
{
    const uint32_t nv = s->m->freedoms;
    const size_t n = 6 * s->tips;
    TFA_V(jacobian)(s, frame);
    for (size_t e = 0; e < n; e++) {
        for (uint32_t j = 0; j < nv; j++)
            s->tau[j] = tip_columns(s, s->psi, j, 0)[e];
        TFA_V(solve_refined)(s, method, refine, 0);
        for (uint32_t j = 0; j < nv; j++)
            tip_columns(s, s->phi, j, 0)[e] = s->qdd[j];
    }
    for (size_t e = 0; e < n; e++)
        for (size_t f = e; f < n; f++) {
            num one = num_of(0),
                other = num_of(0); /* J M^-1 J^T is symmetric: the mean of both sums */
            for (uint32_t j = 0; j < nv; j++) {
                one += tip_columns(s, s->psi, j, 0)[e] * tip_columns(s, s->phi, j, 0)[f];
                other += tip_columns(s, s->psi, j, 0)[f] * tip_columns(s, s->phi, j, 0)[e];
            }
            s->lambda[e * n + f] = (one + other) / 2;
        }
    TFA_V(lambda_mirror)(s);
}
