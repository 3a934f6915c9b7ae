/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Iterative refinement and the error estimate, around any method with kept factors. The residual,
 * and the sum of the corrections, are those of this kernel or of a wider one (s->wider).
 */
#include <math.h>

#include "kernel/answer.h"
#include "kernel/chain.h"
#include "kernel/kernel.h"
#include "kernel/table.h"

/* A step that does not shrink the correction tenfold is not converging, unless it is already at
 * the level of rounding, 450 units of the answer (methods.md section 4). */
#define SHRINK 10.0
#define ROUNDING (1e-13 * (ANSWER_EPSILON / 0x1p-52))
#define ROUNDING_WIDER 1e-13

/* With a wider residual each correction shrinks by as much as the one before did, so that what is
 * left can be told. Below this no step is made any more. */
#define LEFT_ENOUGH 0x1p-57
/* An answer is as good as the wider arithmetic when no more is left than two units, or than a part
 * of what the same method would lose there: what it lost here, in proportion of the roundings. Methods
 * with I^-1 lose more than aba and get less. The cases of test_precision, 2026-11-22: so all are
 * within 5 times aba's error in double; with the units alone 8 of aba's 12 answers for torques of a
 * random qdd went to the wider kernel, which could do no better; with 1e-12 for all, tfa had 37 times
 * aba's error on a chain of 8. */
#define LEFT_UNITS 0x1p-51
#define LEFT_PART 0x1p-4
#define LEFT_PART_INVERTING 0x1p-7

static double norm(const num *x, uint32_t n)
{
    double sum = 0;
    for (uint32_t j = 0; j < n; j++)
        sum += (double)x[j] * (double)x[j];
    return sqrt(sum);
}

/* Shaken, the difference from tau is rounded, too: with the sign that cannot cancel the rest. */
double TFA_V(residual)(struct state *s, int shaken)
{
    const uint32_t n = s->m->freedoms;
    if (shaken)
        TFA_V(rnea_shaken)(s, s->qdd, s->res, 1);
    else
        TFA_V(rnea)(s, s->qdd, s->res, 1);
    for (uint32_t j = 0; j < n; j++) {
        const num r = s->tau[j] - s->res[j];
        const num e = shaken ? (num)NUM_EPSILON * num_abs(s->tau[j]) : 0;
        s->res[j] = r < 0 ? r - e : r + e;
    }
    TFA_V(gather)(s, s->res); /* the forces between followers and leaders are no residual */
    return norm(s->qdd, n);
}

/* ---- what crosses from one kernel to another, as doubles ---- */

void TFA_V(wider_add)(struct state *s, const double *dx, int fresh)
{
    const struct tfa_model *m = s->m;
    for (uint32_t j = 0; j < m->freedoms; j++)
        s->qdd[j] = (fresh ? 0 : s->qdd[j]) + (num)dx[j];
    for (uint32_t k = 0; k < m->mimics; k++)
        s->qdd[m->mimic[k].follower] = (num)m->mimic[k].multiplier * s->qdd[m->mimic[k].leader];
}

double TFA_V(wider_residual)(struct state *s, double *residual, int shaken)
{
    const double size = TFA_V(residual)(s, shaken);
    for (uint32_t j = 0; j < s->m->freedoms; j++)
        residual[j] = (double)s->res[j];
    return size;
}

static void hand_over(struct state *s, const num *x, int fresh)
{
    for (uint32_t j = 0; j < s->m->freedoms; j++)
        s->carry[j] = (double)x[j];
    s->wider->kernel->add(s->wider->state, s->carry, fresh);
}

static double fetch_residual(struct state *s, int shaken)
{
    if (!s->wider)
        return TFA_V(residual)(s, shaken);
    const double size = s->wider->kernel->residual(s->wider->state, s->carry, shaken);
    for (uint32_t j = 0; j < s->m->freedoms; j++)
        s->res[j] = (num)s->carry[j];
    return size;
}

/* ---- steps ---- */

/* dx = M^-1 (tau - RNEA(qdd)), and |dx| / |qdd| */
static double correction(struct state *s, tfa_method method, int shaken)
{
    const double size = fetch_residual(s, shaken);
    TFA_V(solve)(s, method, s->res, s->dx);
    const double change = norm(s->dx, s->m->freedoms);
    return size > 0 ? change / size : change;
}

/* What a method that lost `first` in this arithmetic may leave of its error */
static double allowed(const struct state *s, tfa_method method, double first)
{
    const double part = method_inverts(method) ? LEFT_PART_INVERTING : LEFT_PART;
    const int doubles = s->wider && s->wider->kernel->precision == TFA_F64;
    const double wider = doubles ? first * (0x1p-52 / (double)NUM_EPSILON) : 0;
    return fmax(LEFT_UNITS, part * wider);
}

/* qdd += dx */
static void apply(struct state *s)
{
    if (s->wider)
        hand_over(s, s->dx, 0);
    else
        for (uint32_t j = 0; j < s->m->freedoms; j++)
            s->qdd[j] += s->dx[j];
}

struct refined TFA_V(refine)(struct state *s, tfa_method method, uint32_t steps, int fully,
                             int certified)
{
    const double rounding = s->wider ? ROUNDING_WIDER : ROUNDING;
    if (s->wider)
        hand_over(s, s->qdd, 1);
    double estimate = correction(s, method, steps == 0), left = 0;
    const double enough = allowed(s, method, estimate);
    int converging = 1;
    double before = 1;
    for (uint32_t step = 0; step < steps; step++) {
        apply(s);
        left = s->wider ? estimate * estimate / before : 0;
        if (step + 1 == steps || (s->wider && left < LEFT_ENOUGH))
            break;
        const double next = correction(s, method, 0);
        if (!(next * SHRINK <= estimate || next < rounding))
            converging = 0;
        before = estimate;
        estimate = next;
    }
    uint16_t doubt = TFA_V(doubt)(estimate, converging);
    if (fully && !doubt && left > enough)
        doubt = TFA_ANSWER_INACCURATE;
    if (steps > 0 && certified && doubt != TFA_ANSWER_NOT_FINITE) {
        estimate = correction(s, method, 1); /* one more step, which is not made */
        doubt = doubt ? doubt : TFA_V(doubt)(estimate, 1);
    }
    return (struct refined){estimate, doubt};
}
