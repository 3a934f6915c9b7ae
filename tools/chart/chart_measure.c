/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Measures one method on one case: its errors against the exact answers, and those of a
 * row.
 */
#include "chart.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

double chart_error(const chart_data *d, uint32_t state, double *worst_component)
{
    const uint32_t n = d->answer;
    const double *exact = d->exact + (size_t)state * n;
    double error = 0.0, size = 0.0, worst = 0.0;
    for (uint32_t i = 0; i < n; i++) {
        const double change = d->found[i] - exact[i];
        error += change * change;
        size += exact[i] * exact[i];
        if (exact[i] != 0.0 && !(fabs(change / exact[i]) <= worst))
            worst = fabs(change / exact[i]);
    }
    *worst_component = worst;
    return size > 0.0 ? sqrt(error / size) : sqrt(error);
}

static int compare(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

double chart_median(double *values, uint32_t count)
{
    qsort(values, count, sizeof *values, compare);
    return count % 2 ? values[count / 2] : 0.5 * (values[count / 2 - 1] + values[count / 2]);
}

int chart_answer(const chart_case *c, const chart_solver *solver, const chart_choice *choice,
                 const chart_data *d, uint32_t state, tfa_reply *reply)
{
    tfa_request request = chart_request(d, state);
    if (choice->method >= CHART_PEER) {
        chart_peer_answer(c, choice->method, d, state);
        *reply->answers = (tfa_answer){.method = (uint16_t)choice->method, .error_estimate = NAN};
        return TFA_OK;
    }
    request.method = (tfa_method)choice->method;
    request.refine = choice->refine;
    return chart_solve(solver, &request, reply);
}

void chart_name_invalid_field(char *text, size_t size, const chart_case *c, const tfa_reply *reply)
{
    const char *what = tfa_field_name(reply->field);
    if (reply->field == TFA_FIELD_BODY && reply->index < tfa_model_frame_count(c->model))
        snprintf(text, size, "%s %.50s", what, tfa_model_frame(c->model, reply->index).name);
    else
        snprintf(text, size, "%s", what);
}

uint64_t chart_hash_answer(uint64_t hash, const chart_data *d)
{
    const unsigned char *at = (const unsigned char *)d->found;
    const size_t size = d->answer * sizeof(double);
    for (size_t i = 0; i < size; i++)
        hash = (hash ^ at[i]) * CHART_HASH_PRIME;
    return hash;
}

/* All states at once: before the first is looked at. */
static int solve_batch(chart_batch *b, chart_row *row, chart_case *c, const chart_data *d)
{
    const int status = chart_batch_make(b, d, c->bodies);
    if (status != TFA_OK)
        return status;
    b->request.method = (tfa_method)row->choice.method;
    b->request.refine = row->choice.refine;
    return chart_solve(&c->solvers[row->choice.precision], &b->request, &b->reply);
}

/* The answer to one state, into d->found: from the batch, if there is one. */
static int answer_state(const chart_batch *b, chart_row *row, chart_case *c, const chart_data *d,
                        uint32_t state, tfa_answer *answer)
{
    tfa_reply reply = chart_reply(d, answer);
    if (b->block) {
        chart_batch_answer(b, d, state);
        *answer = b->reply.answers[state];
        return TFA_OK;
    }
    const int status =
        chart_answer(c, &c->solvers[row->choice.precision], &row->choice, d, state, &reply);
    if (status != TFA_OK)
        chart_name_invalid_field(row->field, sizeof row->field, c, &reply);
    return status;
}

/* The method has no kernel in the precision of the row: the answer is one of double. */
static int is_of_double(const chart_row *row, const tfa_answer *answer)
{
    return chart_precisions[row->choice.precision].residual == TFA_RESIDUAL_SAME &&
           answer->flags & TFA_ANSWER_RESIDUAL_PRECISION && !(answer->flags & TFA_ANSWER_FALLBACK);
}

/* Errors of all states, unless the first takes too long. */
static void measure_errors(chart_row *row, const chart_batch *b, chart_case *c, const chart_data *d,
                           uint32_t budget_ms)
{
    double errors[CHART_STATES], estimates[CHART_STATES];
    const double start = chart_now();
    row->bits = CHART_HASH_START;
    for (uint32_t s = 0; s < d->states; s++) {
        double worst;
        tfa_answer answer;
        row->status = answer_state(b, row, c, d, s, &answer);
        if (row->status == TFA_OK && is_of_double(row, &answer)) {
            row->status = TFA_E_UNSUPPORTED;
            snprintf(row->field, sizeof row->field, CHART_FIELD_PRECISION);
        }
        if (row->status != TFA_OK)
            return;
        if (s == 0 && chart_now() - start > 1e-3 * CHART_OVER_BUDGET * budget_ms) {
            row->skipped = CHART_SKIPPED_OVER_BUDGET;
            return;
        }
        errors[s] = chart_error(d, s, &worst);
        row->bits = chart_hash_answer(row->bits, d);
        row->worst = fmax(row->worst, worst);
        estimates[s] = answer.error_estimate;
        if (s == 0 || answer.flags & TFA_ANSWER_FALLBACK)
            row->answered_by = answer.method;
    }
    row->error = row->error_low = row->error_high = chart_median(errors, d->states);
    row->estimate = chart_median(estimates, d->states);
}

/* Facts known without a request */
static void probe_time(chart_row *row, const chart_case *c)
{
    const chart_choice *choice = &row->choice;
    if (choice->method >= CHART_PEER)
        row->skipped = chart_peer_refusal(c, choice->method, row->field, sizeof row->field);
    else if (chart_is_specialised(c->strategy) && !c->kernel) {
        row->status = TFA_E_UNSUPPORTED;
        snprintf(row->field, sizeof row->field, CHART_FIELD_KERNEL);
    } else if (c->solvers[choice->precision].status != TFA_OK) {
        row->status = c->solvers[choice->precision].status;
        snprintf(row->field, sizeof row->field, CHART_FIELD_PRECISION);
    }
}

void chart_row_begin(chart_row *row, const chart_case *c, const chart_data *d)
{
    snprintf(row->target, sizeof row->target, "%s", c->name);
    row->bodies = c->bodies;
    row->rhs = d->rhs;
    row->floor = d->floor;
    row->error = row->worst = row->estimate = row->time = row->aba_time = row->ratio = NAN;
    row->error_low = row->error_high = row->time_low = row->time_high = NAN;
}

void chart_measure(chart_row *row, chart_case *c, const chart_data *d, uint32_t budget_ms,
                   double seconds)
{
    chart_batch batch = {0};
    probe_time(row, c);
    if (row->status == TFA_OK && !row->skipped && chart_is_batch(c->strategy)) {
        row->status = solve_batch(&batch, row, c, d);
        if (row->status != TFA_OK)
            chart_name_invalid_field(row->field, sizeof row->field, c, &batch.reply);
    }
    if (row->status == TFA_OK && !row->skipped)
        measure_errors(row, &batch, c, d, budget_ms);
    if (row->status == TFA_OK && !row->skipped)
        row->status = chart_measure_times(row, &batch, c, d, seconds);
    chart_batch_free(&batch);
}

/* Another is as good as this one and takes less time. Twice the error counts as equal: errors of
 * few states tell digits, not percents. */
static int is_beaten(const chart_row *row, const chart_row *other)
{
    const double error = fmax(row->error, row->floor);
    const double other_error = fmax(other->error, other->floor);
    return chart_row_drawn(other) && other->time < row->time && other_error <= 2.0 * error;
}

void chart_mark_front(chart_row *rows, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        rows[i].front = chart_row_drawn(&rows[i]) && rows[i].error < CHART_NO_DIGIT;
        for (size_t k = 0; rows[i].front && k < count; k++)
            if (is_beaten(&rows[i], &rows[k]))
                rows[i].front = 0;
    }
}
