/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Error of the factors that Lambda is made of, in the metric of the kinetic energy: a force on the
 * tips whose parts along all directions that are inverted have the same energy must accelerate them
 * by what the factors say, as a refined solution of M finds. Neither side is multiplied by more
 * than the condition of B.
 */
#include <math.h>

#include "dynamics/core/recursions.h"
#include "dynamics/kinematics/tip_motion.h"
#include "dynamics/osim/constraint_rows.h"
#include "dynamics/osim/lambda_inverse.h"
#include "dynamics/solve/answer.h"
#include "dynamics/solve/load.h"
#include "dynamics/solve/method.h"
#include "dynamics/solve/refine.h"
#include "spatial/dense.h"

static int is_inverted(const struct state *s, uint32_t k)
{
    return s->eigenvalue[k] > s->tip_threshold;
}

static num sign_of(uint32_t k)
{
    return num_of(k * 2654435761u >> 31 ? 1 : -1);
}

/* F = sum of +-v / sigma, out of the metric: B F has a part of size 1 along each direction */
static void probe(const struct state *s, num *F)
{
    const uint32_t n = all_tip_rows(s);
    for (uint32_t j = 0; j < n; j++)
        F[j] = num_of(0);
    for (uint32_t k = 0; k < s->tip_rank; k++)
        for (uint32_t j = 0; is_inverted(s, k) && j < n; j++)
            F[j] += sign_of(k) * s->direction[(size_t)tip_stride(s) * k + j] / s->eigenvalue[k];
    for (uint32_t j = 0; j < n; j++)
        F[j] *= scale_of(s, j);
}

/* tau = J^T F */
static void force_of_tips(struct state *s, const tfa_request *r, const num *F, num *tau)
{
    if (!s->closings) {
        TFA_V(tips_jacobian_tmul)(s, tip_metric_frame(r), F, tau);
        return;
    }
    for (uint32_t j = 0; j < s->freedoms; j++)
        tau[j] = num_of(0);
    TFA_V(constraint_force)(s, F, tau);
}

/* x = J qdd */
static void motion_of_tips(struct state *s, const tfa_request *r, num *x)
{
    const uint32_t rows = s->tip_rows;
    if (s->closings) {
        TFA_V(constraint_motion)(s, s->qdd, x);
        return;
    }
    for (uint32_t t = 0; t < s->tips; t++) {
        struct tip at;
        num a[6];
        TFA_V(tip_locate)(s, t, tip_metric_frame(r), &at);
        TFA_V(tip_jacobian_mul)(s, &at, s->qdd, a);
        for (uint32_t e = 0; e < rows; e++)
            x[rows * t + e] = a[e];
    }
}

/* x = J M^-1 J^T F in the metric, refined */
static void accelerate(struct state *s, const tfa_request *r, const num *F, num *x)
{
    force_of_tips(s, r, F, s->tau);
    TFA_V(gather_on_leaders)(s, s->tau);
    TFA_V(solve_refined)(s, TFA_V(last_resort)(s), 1, 1);
    motion_of_tips(s, r, x);
    for (uint32_t j = 0; j < all_tip_rows(s); j++)
        x[j] *= scale_of(s, j);
}

double TFA_V(lambda_inverse_error)(struct state *s, const tfa_request *r)
{
    const uint32_t n = all_tip_rows(s);
    num *F = s->task + 2 * (size_t)n, *x = s->task + 3 * (size_t)n;
    num error = num_of(0), size = num_of(0);
    probe(s, F);
    (void)TFA_V(factor)(s, TFA_V(last_resort)(s));
    accelerate(s, r, F, x);
    for (uint32_t k = 0; k < s->tip_rank; k++) {
        const num along = dense_dot(s->direction + (size_t)tip_stride(s) * k, x, n);
        const num d = along / s->eigenvalue[k] - sign_of(k);
        error += is_inverted(s, k) ? d * d : num_of(0);
        size += is_inverted(s, k) ? num_of(1) : num_of(0);
    }
    return size > 0 ? ESTIMATE_SAFETY * sqrt((double)(error / size)) : 0;
}
