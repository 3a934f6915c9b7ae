/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Measures one method on one case: errors against the exact answers, and time against aba's.
 */
#include "chart.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { SAMPLES_MAX = 101, SAMPLES_MIN = 3 };

/* Reading the thread's clock is a system call of some 0.3 us: a sample must be long against it. */
#define SAMPLE_SECONDS 50e-6

double chart_error(const chart_data *d, uint32_t state, double *worst_component)
{
    const uint32_t n = d->v + d->base;
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

static tfa_request request_of(const chart_data *d, uint32_t state, uint32_t method, uint32_t refine)
{
    tfa_request request = chart_request(d, state);
    request.method = (tfa_method)method;
    request.refine = refine;
    return request;
}

void chart_name_culprit(char *text, size_t size, const chart_case *c, const tfa_reply *reply)
{
    const char *what = tfa_field_name(reply->field);
    if (reply->field == TFA_FIELD_BODY && reply->index < tfa_model_frame_count(c->model))
        snprintf(text, size, "%s %.50s", what, tfa_model_frame(c->model, reply->index).name);
    else
        snprintf(text, size, "%s", what);
}

static void measure_errors(chart_row *row, chart_case *c, const chart_data *d)
{
    double errors[CHART_STATES], estimates[CHART_STATES];
    for (uint32_t s = 0; s < d->states; s++) {
        double worst;
        tfa_answer answer;
        tfa_request request = request_of(d, s, row->method, row->refine);
        tfa_reply reply = chart_reply(d, &answer);
        row->status = tfa_compute(c->f64, &request, &reply);
        if (row->status != TFA_OK) {
            chart_name_culprit(row->field, sizeof row->field, c, &reply);
            return;
        }
        errors[s] = chart_error(d, s, &worst);
        row->worst = fmax(row->worst, worst);
        estimates[s] = answer.error_estimate;
        if (s == 0 || answer.flags & TFA_ANSWER_FALLBACK)
            row->answered_by = answer.method;
    }
    row->error = chart_median(errors, d->states);
    row->estimate = chart_median(estimates, d->states);
}

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* Which state comes next: every call, whatever its method, has another q than the one before, since
 * the factors of the same q would be kept. */
typedef struct turns {
    tfa_workspace *workspace;
    const chart_data *data;
    uint32_t next;
} turns;

/* Seconds for each of `calls` calls. */
static double sample(turns *t, uint32_t method, uint32_t refine, uint32_t calls)
{
    tfa_answer answer;
    tfa_request requests[CHART_STATES];
    tfa_reply reply = chart_reply(t->data, &answer);
    for (uint32_t s = 0; s < t->data->states; s++)
        requests[s] = request_of(t->data, s, method, refine);
    const double start = now();
    for (uint32_t k = 0; k < calls; k++)
        (void)tfa_compute(t->workspace, &requests[t->next++ % t->data->states], &reply);
    return (now() - start) / calls;
}

static uint32_t calls_for(double seconds)
{
    const double calls = seconds > 0.0 ? ceil(SAMPLE_SECONDS / seconds) : 1000.0;
    return (uint32_t)fmin(calls, 1000.0);
}

/* The method and aba in turns, so that what the machine does to one it does to the other. */
static void measure_times(chart_row *row, chart_case *c, const chart_data *d, uint32_t budget_ms)
{
    double times[SAMPLES_MAX], aba[SAMPLES_MAX], ratios[SAMPLES_MAX];
    turns t = {.workspace = c->f64, .data = d};
    const double first = sample(&t, row->method, row->refine, 1);
    const double first_aba = sample(&t, TFA_METHOD_ABA, 0, d->states);
    const uint32_t calls = calls_for(first), aba_calls = calls_for(first_aba);
    const double end = now() + 1e-3 * budget_ms;
    uint32_t n = 0;
    while (n < SAMPLES_MIN || (n < SAMPLES_MAX && now() < end)) {
        times[n] = 1e6 * sample(&t, row->method, row->refine, calls);
        aba[n] = 1e6 * sample(&t, TFA_METHOD_ABA, 0, aba_calls);
        ratios[n] = aba[n] > 0.0 ? times[n] / aba[n] : NAN;
        n++;
    }
    row->samples = n;
    row->time = chart_median(times, n);
    row->aba_time = chart_median(aba, n);
    row->ratio = chart_median(ratios, n);
}

void chart_measure(chart_row *row, chart_case *c, const chart_data *d, uint32_t budget_ms)
{
    snprintf(row->subject, sizeof row->subject, "%s", c->name);
    row->bodies = c->bodies;
    row->rhs = d->rhs;
    row->floor = d->floor;
    row->error = row->worst = row->estimate = row->time = row->aba_time = row->ratio = NAN;
    measure_errors(row, c, d);
    if (row->status == TFA_OK)
        measure_times(row, c, d, budget_ms);
}

int chart_row_good(const chart_row *row)
{
    return row->status == TFA_OK && row->answered_by == row->method && isfinite(row->error);
}

/* Another is as good as this one and takes less time. Twice the error counts as equal: errors of
 * few states tell digits, not percents. */
static int is_beaten(const chart_row *row, const chart_row *other)
{
    const double error = fmax(row->error, row->floor);
    const double other_error = fmax(other->error, other->floor);
    return chart_row_good(other) && other->time < row->time && other_error <= 2.0 * error;
}

void chart_mark_front(chart_row *rows, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        rows[i].front = chart_row_good(&rows[i]);
        for (size_t k = 0; rows[i].front && k < count; k++)
            if (is_beaten(&rows[i], &rows[k]))
                rows[i].front = 0;
    }
}
