/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Forward dynamics of a long chain by its pieces: what the rest of the library sees of them.
 */
#include <math.h>
#include <string.h>

#include "kernel/answer.h"
#include "kernel/pieces.h"
#include "kernel/table.h"

static size_t size(const tfa_model *model)
{
    struct pieces *none;
    return TFA_V(pieces_walk)(model, NULL, &none);
}

static const double *state_of(const double *array, uint32_t stride, uint32_t k)
{
    return array ? array + (size_t)stride * k : NULL;
}

static void load(struct pieces *p, const tfa_request *r, uint32_t k)
{
    const struct tfa_model *m = p->m;
    p->q = state_of(r->q, m->q_count, k);
    p->qd = state_of(r->v, m->v_count, k);
    p->tau = state_of(r->tau, m->v_count, k);
    p->gravity = v3_load(r->gravity ? r->gravity : m->gravity);
    p->moving = 0;
    for (uint32_t j = 0; p->qd && !p->moving && j < m->v_count; j++)
        p->moving = p->qd[j] != 0;
}

/* Sum over lanes and groups, piece by piece */
static double sum_of(const struct pieces *p, const num *x)
{
    double sum = 0;
    for (uint32_t g = 0; g < p->groups; g++)
        for (uint32_t l = 0; l < NUM_LANES; l++)
            sum += num_lane(x[g], l);
    return sum;
}

/* Do sums of squares keep their digits? Otherwise the kernel of one state answers, whose norms are scaled. */
static int is_in_range(double sum)
{
    return sum == 0 || (sum > 1e-280 && sum < 1e300);
}

/* One step of refinement: |dx| / |qdd| before it */
static double refine(struct pieces *p)
{
    TFA_V(pieces_residual)(p, 0);
    TFA_V(pieces_correct)(p);
    return sqrt(sum_of(p, p->sum_dx) / sum_of(p, p->sum_qdd));
}

/* The relative correction of qdd by factors that know no inverse inertia; not a number where there is none */
static double correction(struct pieces *p, struct tfa_judge *judge, int perturbed)
{
    double sum = 0;
    TFA_V(pieces_residual)(p, perturbed);
    if (!judge->solve(judge, p->residual, p->change))
        return (double)NAN;
    for (uint32_t j = 0; j < p->m->v_count; j++)
        sum += p->change[j] * p->change[j];
    for (uint32_t g = 0; g < p->groups; g++) {
        const struct piece_row *r = piece_rows(p, g);
        p->sum_qdd[g] = num_of(0);
        for (uint32_t row = 1; row <= p->rows; row++)
            p->sum_qdd[g] += r[row].qdd * r[row].qdd;
    }
    return sqrt(sum / sum_of(p, p->sum_qdd));
}

/* The error of qdd, by a perturbed residual and a plain one (refine.c), whose correction goes to *plain */
static double judge(struct pieces *p, struct tfa_judge *judge, double *plain)
{
    const double perturbed = correction(p, judge, 1);
    *plain = correction(p, judge, 0);
    return ESTIMATE_SAFETY * (*plain > perturbed ? *plain : perturbed);
}

/* ---- the solution before its corrections ---- */

/* qdd, and where the residual of each piece starts */
static void keep_unrefined(struct pieces *p)
{
    const size_t six = (size_t)6 * p->width;
    for (uint32_t g = 0; g < p->groups; g++)
        for (uint32_t row = 1; row <= p->rows; row++)
            piece_rows(p, g)[row].unrefined = piece_rows(p, g)[row].qdd;
    memcpy(p->unrefined, border_at(p, BORDER_V, 0), six * sizeof *p->border);
    memcpy(p->unrefined + six, border_at(p, BORDER_FORCE, 0), six * sizeof *p->border);
}

static void exchange(double *a, double *b, size_t count)
{
    for (size_t k = 0; k < count; k++) {
        const double x = a[k];
        a[k] = b[k];
        b[k] = x;
    }
}

static void exchange_unrefined(struct pieces *p)
{
    const size_t six = (size_t)6 * p->width;
    for (uint32_t g = 0; g < p->groups; g++)
        for (uint32_t row = 1; row <= p->rows; row++) {
            struct piece_row *r = &piece_rows(p, g)[row];
            const num x = r->qdd;
            r->qdd = r->unrefined;
            r->unrefined = x;
        }
    exchange(p->unrefined, border_at(p, BORDER_V, 0), six);
    exchange(p->unrefined + six, border_at(p, BORDER_FORCE, 0), six);
}

static void write_qdd(const struct pieces *p)
{
    for (uint32_t g = 0; p->qdd && g < p->groups; g++)
        for (uint32_t row = 1; row <= p->rows; row++)
            for (uint32_t l = 0; l < NUM_LANES; l++)
                if (piece_bodies(p, g)[row].real[l])
                    p->qdd[piece_bodies(p, g)[row].v[l]] = num_lane(piece_rows(p, g)[row].qdd, l);
}

/* As in refine.c: the solution before its corrections, unless the refined one has a clearly smaller
 * estimate. Returns the estimate of the one that stands. */
static double better_of_both(struct pieces *p, struct tfa_judge *by, double refined)
{
    double plain;
    exchange_unrefined(p);
    const double unrefined = judge(p, by, &plain);
    if (refined_is_better(unrefined, refined)) {
        exchange_unrefined(p);
        return refined;
    }
    write_qdd(p);
    return unrefined;
}

static int answer(struct pieces *p, struct tfa_crew *crew, const tfa_request *r, uint32_t k,
                  struct tfa_judge *by, tfa_reply *reply, tfa_answer *out)
{
    const uint32_t steps = r->refine == TFA_REFINE_DEFAULT ? 1 : r->refine;
    const int bare = r->estimate == TFA_ESTIMATE_NEVER;
    double estimate = (double)NAN, first = (double)NAN, plain = (double)NAN;
    load(p, r, k);
    p->crew = crew;
    p->qdd = reply->qdd ? reply->qdd + (size_t)p->m->v_count * k : NULL;
    TFA_V(pieces_forward)(p);
    if (!bare && steps > 0)
        keep_unrefined(p);
    for (uint32_t step = 0; step < steps; step++) {
        const double before = estimate;
        estimate = refine(p);
        first = step > 0 ? first : estimate;
        if (step > 0 && !bare && !(estimate * SHRINK <= before || estimate < ROUNDING))
            return 0;
    }
    if (!bare && steps > 0 && !(estimate <= FALLBACK_ESTIMATE))
        return 0;
    if (!bare)
        estimate = judge(p, by, &plain);
    if (!bare && steps > 0 && refinement_is_in_vain(first, plain))
        estimate = better_of_both(p, by, estimate);
    *out = (tfa_answer){.method = (uint16_t)r->method,
                        .flags = bare ? 0 : (uint16_t)TFA_ANSWER_ESTIMATED,
                        .error_estimate = bare ? (double)NAN : estimate};
    return sum_of(p, p->finite) == 0 &&
           (bare || (is_in_range(sum_of(p, p->sum_qdd)) && estimate <= FALLBACK_ESTIMATE));
}

static int answer_lambda(struct pieces *p, struct tfa_crew *crew, const tfa_request *r, uint32_t k,
                         tfa_reply *reply, tfa_answer *out)
{
    const struct tfa_frame *f = &p->m->frame[r->tips[0]];
    double lambda[36], check = 0;
    if (f->body + 1 != (int32_t)p->length || f->part)
        return 0;
    load(p, r, k);
    p->qd = p->tau = NULL;
    p->moving = 0;
    p->crew = crew;
    TFA_V(pieces_lambda)(p, r, lambda);
    for (size_t e = 0; e < 36; e++) {
        check += lambda[e] - lambda[e];
        if (reply->lambda_inv)
            reply->lambda_inv[36 * (size_t)k + e] = lambda[e];
    }
    *out = (tfa_answer){.method = (uint16_t)r->method, .error_estimate = (double)NAN};
    return check == 0;
}

const struct tfa_pieces TFA_V(pieces) = {
    .size = size,
    .init = TFA_V(pieces_init),
    .answer = answer,
    .answer_lambda = answer_lambda,
};
