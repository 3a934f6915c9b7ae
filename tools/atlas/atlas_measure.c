/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The error of one method in one cell: alone, refined once, and as the service answers.
 */
#include "atlas.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* dx = M^-1 (tau - RNEA(qdd)), qdd += dx, by requests of their own: refinement asked for in one
 * request ends in a fallback where it fails, and here the failure is what is wanted. */
static int refine_by_hand(chart_case *c, const chart_data *d, tfa_request request, double *scratch)
{
    static const double weightless[3];
    double *tau = scratch, *first = scratch + d->v;
    tfa_request inverse = request;
    tfa_answer answer;
    memcpy(first, d->found, d->v * sizeof *first);
    inverse.op = TFA_OP_INVERSE_DYNAMICS;
    inverse.method = TFA_METHOD_AUTO;
    inverse.qdd = first;
    tfa_reply reply = {.tau = tau, .answers = &answer};
    int status = tfa_compute(c->f64, &inverse, &reply);
    for (uint32_t k = 0; k < d->v; k++)
        tau[k] = request.tau[k] - tau[k];
    request.tau = tau;
    request.v = NULL;
    request.gravity = weightless;
    reply = chart_reply(d, &answer);
    if (status == TFA_OK)
        status = tfa_compute(c->f64, &request, &reply);
    for (uint32_t k = 0; k < d->v; k++)
        d->found[k] += first[k];
    return status;
}

static tfa_request request_of(const atlas_row *row, const chart_data *d, uint32_t state)
{
    tfa_request request = chart_request(d, state);
    request.method = (tfa_method)row->method;
    if (row->mode == ATLAS_SERVICE || row->mode == ATLAS_ESTIMATED) {
        request.refine = TFA_REFINE_DEFAULT;
        request.estimate = row->mode == ATLAS_SERVICE ? TFA_ESTIMATE_DEFAULT : TFA_ESTIMATE_ALWAYS;
    }
    return request;
}

static void count_answer(atlas_row *row, const tfa_answer *answer, double error)
{
    if (error >= row->worst) {
        row->worst = error;
        row->worst_by = answer->method;
    }
    if (answer->flags & TFA_ANSWER_FALLBACK) {
        if (row->fallback++ == 0) {
            row->answered_by = answer->method;
            row->reason = answer->flags;
        }
    } else {
        row->by_method++;
    }
    if (!(answer->flags & TFA_ANSWER_ESTIMATED)) {
        row->unreported += error > ATLAS_FAILED;
        return;
    }
    row->estimated++;
    if (error > ATLAS_ROUNDING)
        row->over = fmax(row->over, error / answer->error_estimate);
    row->silent += error > 1e-6 && answer->error_estimate < 1e-7;
}

void atlas_measure(atlas_row *row, chart_case *c, const chart_data *d)
{
    double errors[CHART_STATES], estimates[CHART_STATES], component;
    double *scratch = malloc((2 * (size_t)d->v + 1) * sizeof *scratch);
    row->answered_by = row->method;
    row->floor = d->floor;
    row->bits = CHART_HASH_START;
    for (uint32_t s = 0; s < d->states; s++) {
        tfa_answer answer = {0};
        tfa_request request = request_of(row, d, s);
        tfa_reply reply = chart_reply(d, &answer);
        int status =
            scratch ? tfa_compute(c->f64, &request, &reply) : TFA_E_MEMORY;
        errors[s] = INFINITY;
        estimates[s] = answer.flags & TFA_ANSWER_ESTIMATED ? answer.error_estimate : NAN;
        if (status == TFA_OK && row->mode == ATLAS_REFINED)
            status = refine_by_hand(c, d, request, scratch);
        if (status == TFA_OK) {
            errors[s] = chart_error(d, s, &component);
            count_answer(row, &answer, errors[s]);
            row->bits = chart_hash_answer(row->bits, d);
        } else if (row->refused++ == 0) {
            row->status = status;
            chart_name_invalid_field(row->field, sizeof row->field, c, &reply);
        }
    }
    free(scratch);
    row->error = row->error_low = row->error_high = chart_median(errors, d->states);
    row->estimate = isnan(estimates[0]) ? NAN : chart_median(estimates, d->states);
}

/* Adds another seed to sums and extremes */
static void add_seed(atlas_row *row, const atlas_row *other)
{
    if (row->fallback == 0 && other->fallback) {
        row->answered_by = other->answered_by;
        row->reason = other->reason;
    }
    if (row->refused == 0 && other->refused) {
        row->status = other->status;
        memcpy(row->field, other->field, sizeof row->field);
    }
    if (other->worst > row->worst) {
        row->worst = other->worst;
        row->worst_by = other->worst_by;
    }
    row->bits = row->bits * CHART_HASH_PRIME ^ other->bits;
    row->by_method += other->by_method;
    row->fallback += other->fallback;
    row->refused += other->refused;
    row->estimated += other->estimated;
    row->unreported += other->unreported;
    row->silent += other->silent;
    row->over = fmax(row->over, other->over);
    row->error_low = fmin(row->error_low, other->error_low);
    row->error_high = fmax(row->error_high, other->error_high);
}

void atlas_combine_seeds(atlas_row *first, size_t stride, uint32_t seeds)
{
    double errors[CHART_SEEDS], estimates[CHART_SEEDS], floors[CHART_SEEDS];
    uint32_t estimated = 0;
    for (uint32_t s = 0; s < seeds; s++) {
        const atlas_row *row = first + s * stride;
        errors[s] = row->error;
        floors[s] = row->floor;
        if (!isnan(row->estimate))
            estimates[estimated++] = row->estimate;
        if (s > 0)
            add_seed(first, row);
    }
    first->error = chart_median(errors, seeds);
    first->floor = chart_median(floors, seeds);
    first->estimate = estimated ? chart_median(estimates, estimated) : NAN;
}

static int is_answered_by_method(const atlas_row *row)
{
    return row->by_method && !row->fallback && !row->refused;
}

void atlas_find_same(atlas_row *rows, size_t count)
{
    for (size_t i = 0; i < count; i++)
        for (size_t k = 0; k < i && !rows[i].same_as; k++)
            if (rows[k].mode == rows[i].mode && rows[k].bits == rows[i].bits && !rows[k].same_as &&
                is_answered_by_method(&rows[k]) && is_answered_by_method(&rows[i]))
                rows[i].same_as = rows[k].method;
}

int atlas_fell_back(const atlas_row *row)
{
    return !atlas_refused(row) && row->fallback >= row->by_method;
}

int atlas_refused(const atlas_row *row)
{
    return row->refused > row->by_method + row->fallback;
}

int atlas_failed(const atlas_row *row)
{
    if (row->by_method + row->fallback == 0)
        return row->status == TFA_E_NOT_COMPUTED;
    return row->error > ATLAS_FAILED && row->error > ATLAS_FAR_FROM_FLOOR * row->floor;
}
