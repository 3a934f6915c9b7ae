/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Refinement with kept factors, and the errors of refined answers.
 */
#ifndef TFA_DYNAMICS_SOLVE_REFINE_H
#define TFA_DYNAMICS_SOLVE_REFINE_H

#include "layout/state.h"

/* When the error of a refined answer is estimated: never, where a correction asks for another
 * method, always */
enum estimation { ESTIMATE_NOT, ESTIMATE_IN_DOUBT, ESTIMATE };

/* Refinement of s->qdd; in the residual kernel where there is one, which has loaded the request.
 * Steps 0: one correction computed and not applied. `to_full_precision`: to full digits of the
 * residual arithmetic, or it counts as inaccurate (s->residual_kernel only). An estimate is that of
 * the refined answer, from a perturbed residual; a step for the worse is taken back then. */
struct refined {
    num_doubles estimate; /* |dx|/|x|; of the last step where the answer is not estimated */
    int estimated;
    uint16_t
        /* 0, or why the answer is not to be given (TFA_ANSWER_*), that of some lane */
        fallback_reason;
};
struct refined TFA_V(refine)(struct state *s, tfa_method method, uint32_t steps,
                             int to_full_precision, enum estimation estimation);
/* As the residual kernel of another, see kernel_table.h. */
void TFA_V(residual_kernel_add)(struct state *s, const double *dx, int fresh);
double TFA_V(residual_kernel_residual)(struct state *s, double *residual, int perturbed);

/* s->qdd = M^-1 s->tau with refinement steps: r = tau - M x, x += M^-1 r; `perturbed`: the last
 * residual is that of an estimate (rnea.c). */
void TFA_V(solve_refined)(struct state *s, tfa_method method, uint32_t steps, int perturbed);

/* By columns: Lambda^-1 = J (M^-1 J^T) with kept factors and refinement steps. */
void TFA_V(lambda_columns)(struct state *s, tfa_reference_frame frame, tfa_method method,
                           uint32_t refine);

/* Relative error of s->lambda, which came from the method's factors with so many refinement steps:
 * |error| / |Lambda^-1|, sums of squares of all entries. Needs the method's factors. */
num_doubles TFA_V(lambda_error)(struct state *s, tfa_reference_frame frame, tfa_method method,
                                uint32_t steps);

/* Relative error of M's factors in those of lambda_factor, which had `directions`. Writes s->tau,
 * s->qdd, s->res and s->dx. */
double TFA_V(lambda_inverse_error)(struct state *s, const tfa_request *r);

#endif
