/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Iterative refinement and the error estimate, around any method with kept factors. The residual,
 * and the sum of the corrections, are those of this kernel or of a residual kernel
 * (s->residual_kernel).
 */
#include <float.h>
#include <math.h>
#include <string.h>

#include "dynamics/core/recursions.h"
#include "dynamics/solve/answer.h"
#include "dynamics/solve/load.h"
#include "dynamics/solve/method.h"
#include "dynamics/solve/norm.h"
#include "dynamics/solve/refine.h"
#include "interface/kernel_table.h"

#define ROUNDING_MIXED 1e-13

/* With a residual in higher precision an error shrinks in two steps by as much as in the two before
 * them, so that the remainder can be told. In one step it need not: an error in a stiff direction
 * leaves one of cond(M) epsilon in a weak direction, which the next step removes (flexible chain of
 * 128: errors 2e-6, 1e-7, 3e-13, 6e-14; 2026-11-28). Below this no step is made any more. */
#define REMAINDER_DONE 0x1p-57
/* An answer is as good as the residual arithmetic when no more is left than two units, or than a
 * part of the same method's loss there: its loss here, in proportion of the roundings.
 * Methods with I^-1 lose more than aba and get less. The cases of test_precision, 2026-11-22: so
 * all are within 5 times aba's error in double; with the units alone 8 of aba's 12 answers for
 * torques of a random qdd went to the residual kernel, which could do no better; with 1e-12 for
 * all, tfa had 37 times aba's error on a chain of 8. */
#define REMAINDER_ULPS 0x1p-51
#define REMAINDER_FRACTION 0x1p-4
#define REMAINDER_FRACTION_INVERTING 0x1p-7

/* s->res = tau - RNEA(s->qdd); or perturbed, and the difference, too: with the sign that cannot
 * cancel the rest. */
static void find_residual(struct state *s, int perturbed)
{
    const uint32_t n = s->m->freedoms;
    if (perturbed)
        TFA_V(rnea_perturbed)(s, s->qdd, s->res, 1);
    else
        TFA_V(rnea)(s, s->qdd, s->res, 1);
    for (uint32_t j = 0; j < n; j++)
        s->res[j] = s->tau[j] - s->res[j];
    for (uint32_t j = 0; perturbed && j < n; j++)
        s->res[j] +=
            num_select(s->res[j] < 0, num_of(-(double)NUM_EPSILON), num_of((double)NUM_EPSILON)) *
            num_abs(s->tau[j]);
    TFA_V(gather_on_leaders)
    (s, s->res); /* the forces between followers and leaders are no residual */
}

/* ---- exchange between kernels, as doubles; of one state at a time ---- */

void TFA_V(residual_kernel_add)(struct state *s, const double *dx, int fresh)
{
    const struct tfa_model *m = s->m;
    for (uint32_t j = 0; j < m->freedoms; j++)
        s->qdd[j] = (fresh ? num_of(0) : s->qdd[j]) + num_of(dx[j]);
    for (uint32_t k = 0; k < m->mimics; k++)
        s->qdd[m->mimic[k].follower] = num_of(m->mimic[k].multiplier) * s->qdd[m->mimic[k].leader];
}

double TFA_V(residual_kernel_residual)(struct state *s, double *residual, int perturbed)
{
    find_residual(s, perturbed);
    for (uint32_t j = 0; j < s->m->freedoms; j++)
        residual[j] = (double)num_lane(s->res[j], 0);
    return norm(s->qdd, s->m->freedoms).lane[0];
}

static void to_residual_kernel(struct state *s, const num *x, int fresh)
{
    for (uint32_t j = 0; j < s->m->freedoms; j++)
        s->residual_exchange[j] = (double)num_lane(x[j], 0);
    s->residual_kernel->kernel->add(s->residual_kernel->state, s->residual_exchange, fresh);
}

/* s->res = tau - RNEA(x) of the residual kernel. Returns |x|. */
static double from_residual_kernel(struct state *s, int perturbed)
{
    const double size = s->residual_kernel->kernel->residual(s->residual_kernel->state,
                                                             s->residual_exchange, perturbed);
    for (uint32_t j = 0; j < s->m->freedoms; j++)
        s->res[j] = num_of(s->residual_exchange[j]);
    return size;
}

/* ---- steps ---- */

/* dx = M^-1 (tau - RNEA(qdd)), and |dx| / |qdd| */
static num_doubles correction(struct state *s, tfa_method method, int perturbed)
{
    num_doubles size = {{0}}, change;
    if (s->residual_kernel)
        size.lane[0] = from_residual_kernel(s, perturbed);
    else
        find_residual(s, perturbed);
    TFA_V(solve)(s, method, s->res, s->dx);
    if (!s->residual_kernel) /* here, beside the other norm: 0.5 ns a body less (aba, 2026-11-22) */
        size = norm(s->qdd, s->m->freedoms);
    change = norm(s->dx, s->m->freedoms);
    for (int l = 0; l < NUM_LANES; l++)
        change.lane[l] = size.lane[l] > 0 ? change.lane[l] / size.lane[l] : change.lane[l];
    return change;
}

/* At least x; not a number stays so */
static void raise_to_at_least(double *estimate, double x)
{
    if (x > *estimate)
        *estimate = x;
}

/* The error of s->qdd: the larger of two corrections, by the perturbed residual, which shows what
 * rounding can do, and by the plain one, which goes to *plain. Along a single weak direction a
 * perturbation can cancel the error by chance (crba: error 1e-6, estimate 1e-7; aba, refined: 80
 * times the estimate; test_estimates, points of 0.93^k). Factors from inverse inertias may have
 * lost a direction for good, and then see nothing of it (hessenberg: error 340, estimate 2e-5, seed
 * 75 of test_estimates with TFA_ISA=base): those of aba give the estimate. */
static num_doubles estimate_error(struct state *s, tfa_method method, num_doubles *plain)
{
    if (method_inverts(method)) {
        method = METHOD_OF_ESTIMATES;
        (void)TFA_V(factor)(s, method);
    }
    num_doubles estimate = correction(s, method, 1);
    *plain = correction(s, method, 0);
    for (int l = 0; l < NUM_LANES; l++) {
        raise_to_at_least(&estimate.lane[l], plain->lane[l]);
        estimate.lane[l] *= ESTIMATE_SAFETY;
    }
    return estimate;
}

/* Whether a method that lost `first` in this arithmetic may leave so much of its error */
static int remainder_is_small(const struct state *s, tfa_method method, double first,
                              double remainder)
{
    const double part = method_inverts(method) ? REMAINDER_FRACTION_INVERTING : REMAINDER_FRACTION;
    const int doubles = s->residual_kernel->kernel->precision == TFA_F64;
    const double there = doubles ? first * (0x1p-52 / (double)NUM_EPSILON) : 0;
    return remainder <= REMAINDER_ULPS || remainder <= part * there;
}

/* qdd += dx */
static void apply(struct state *s)
{
    if (s->residual_kernel)
        to_residual_kernel(s, s->dx, 0);
    else
        for (uint32_t j = 0; j < s->m->freedoms; j++)
            s->qdd[j] += s->dx[j];
}

/* Whether every correction is a tenth of the one before, or rounding */
static int converges(const num_doubles *next, const num_doubles *before, double rounding)
{
    int all = 1;
    for (int l = 0; l < NUM_LANES; l++)
        all &= next->lane[l] * SHRINK <= before->lane[l] || next->lane[l] < rounding;
    return all;
}

/* Where the step did not improve the answer the answer before it is estimated, too, and is restored
 * in s->qdd unless the refined one has a clearly smaller estimate. *estimate: of the answers
 * that stand. */
static void keep_better_solution(struct state *s, tfa_method method, const num_doubles *first,
                                 num_doubles plain, num_doubles *estimate)
{
    static const uint32_t lanes[] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};
    const uint32_t n = s->m->freedoms;
    num_doubles keep = {{0}};
    int stagnated[NUM_LANES];
    int any = 0;
    for (int l = 0; l < NUM_LANES; l++)
        any |= stagnated[l] = refinement_stagnated(first->lane[l], plain.lane[l]);
    if (!any)
        return;
    for (uint32_t j = 0; j < n; j++) {
        const num refined = s->qdd[j];
        s->qdd[j] = s->qdd_unrefined[j];
        s->qdd_unrefined[j] = refined;
    }
    const num_doubles unrefined = estimate_error(s, method, &plain);
    for (int l = 0; l < NUM_LANES; l++)
        if (stagnated[l] && !refined_is_better(unrefined.lane[l], estimate->lane[l])) {
            keep.lane[l] = 1;
            estimate->lane[l] = unrefined.lane[l];
        }
    const num kept = num_gather(keep.lane, 1, lanes);
    for (uint32_t j = 0; j < n; j++)
        s->qdd[j] = num_select(kept > 0, s->qdd[j], s->qdd_unrefined[j]);
}

struct refined TFA_V(refine)(struct state *s, tfa_method method, uint32_t steps,
                             int to_full_precision, enum estimation estimation)
{
    const double rounding = s->residual_kernel ? ROUNDING_MIXED : ROUNDING;
    if (s->residual_kernel)
        to_residual_kernel(s, s->qdd, 1);
    num_doubles plain = {{0}};
    const num_doubles first = steps ? correction(s, method, 0) : estimate_error(s, method, &plain);
    num_doubles estimate = first;
    /* With a residual kernel, whose states come one at a time: the corrections one and two steps
     * ago */
    double before = first.lane[0], twice_before = 1, remainder = 0;
    int converging = 1;
    if (steps > 0 && estimation && !s->residual_kernel)
        memcpy(s->qdd_unrefined, s->qdd, s->m->freedoms * sizeof *s->qdd);
    for (uint32_t step = 0; step < steps; step++) {
        apply(s);
        if (s->residual_kernel)
            remainder = estimate.lane[0] * before / twice_before;
        if (step + 1 == steps || (s->residual_kernel && remainder < REMAINDER_DONE))
            break;
        const num_doubles next = correction(s, method, 0);
        converging &= converges(&next, &estimate, rounding);
        twice_before = step ? before : 1;
        before = estimate.lane[0];
        estimate = next;
    }
    uint16_t fallback_reason = TFA_V(needs_fallback)(&estimate, converging && !s->stalled);
    if (to_full_precision && !fallback_reason &&
        !remainder_is_small(s, method, first.lane[0], remainder))
        fallback_reason = TFA_ANSWER_INACCURATE;
    const int in_doubt = estimation && fallback_reason && !s->residual_kernel;
    const int estimated = estimation == ESTIMATE || in_doubt;
    if (steps > 0 && estimated && fallback_reason != TFA_ANSWER_NOT_FINITE) {
        const num_doubles last = estimate;
        estimate = estimate_error(s, method, &plain);
        for (int l = 0; !converging && l < NUM_LANES; l++) /* shows rounding, too */
            raise_to_at_least(&estimate.lane[l], last.lane[l]);
        if (!s->residual_kernel)
            keep_better_solution(s, method, &first, plain, &estimate);
        fallback_reason =
            fallback_reason ? fallback_reason : TFA_V(needs_fallback)(&estimate, !s->stalled);
    }
    return (struct refined){estimate, estimated, fallback_reason};
}
