/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Time against aba's: state after state on this thread, or batches of states on a pool.
 */
#include "chart.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

/* States of a batch: enough for eight lanes on each of eight threads. */
enum { SAMPLES_MAX = 101, SAMPLES_MIN = 3, BATCH = 64 };

/* Reading the thread's clock is a system call of some 0.3 us: a sample must be long against it. */
#define SAMPLE_SECONDS 50e-6

static double read_clock(clockid_t clock)
{
    struct timespec t;
    clock_gettime(clock, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

double chart_now(void)
{
    return read_clock(CLOCK_THREAD_CPUTIME_ID);
}

/* Which state comes next: every call, whatever its method, has another q than the one before, since
 * the factors of the same q would be kept. */
typedef struct turns {
    chart_case *c;
    const chart_data *data;
    uint32_t next;
    clockid_t clock;
    tfa_request batch; /* with a pool: the states of the data over and over */
    tfa_reply reply;
    double *block; /* the arrays of both */
    int status;    /* of the first call that failed */
} turns;

/* `rows` rows of `width` numbers, those of `from` over and over. */
static double *repeat(double **at, const double *from, size_t width, uint32_t states)
{
    double *start = *at;
    for (uint32_t s = 0; from && s < BATCH; s++, *at += width)
        memcpy(*at, from + s % states * width, width * sizeof(double));
    return from ? start : NULL;
}

static int make_batch(turns *t)
{
    const chart_data *d = t->data;
    const size_t width = (size_t)d->q + 3 * (size_t)d->v + 7 + 6;
    double *at = t->block = calloc(BATCH * width, sizeof(double));
    if (!at)
        return TFA_E_MEMORY;
    t->batch = chart_request(d, 0);
    t->batch.count = BATCH;
    t->batch.q = repeat(&at, t->batch.q, d->q, d->states);
    t->batch.v = repeat(&at, t->batch.v, d->v, d->states);
    t->batch.tau = repeat(&at, t->batch.tau, d->v, d->states);
    t->batch.base_pose = repeat(&at, t->batch.base_pose, 7, d->states);
    t->reply = (tfa_reply){.qdd = at, .base_acceleration = d->base ? at + BATCH * d->v : NULL};
    return TFA_OK;
}

/* Seconds for each of `calls` states, or on a pool of `calls` batches. */
static double sample(turns *t, const chart_choice *choice, uint32_t calls)
{
    tfa_answer answer;
    tfa_reply reply = chart_reply(t->data, &answer);
    t->batch.method = (tfa_method)choice->method;
    t->batch.refine = choice->refine;
    const double start = read_clock(t->clock);
    for (uint32_t k = 0; k < calls && t->status == TFA_OK; k++)
        t->status = t->block
                        ? tfa_batch_pool_compute(t->c->pool, &t->batch, &t->reply)
                        : chart_answer(t->c, choice, t->data, t->next++ % t->data->states, &reply);
    return (read_clock(t->clock) - start) / calls / (t->block ? BATCH : 1);
}

/* How many calls make a sample, from one that is thrown away. */
static uint32_t calls_for(turns *t, const chart_choice *choice)
{
    const double seconds =
        sample(t, choice, t->block ? 1 : t->data->states) * (t->block ? BATCH : 1);
    const double calls = seconds > 0.0 ? ceil(SAMPLE_SECONDS / seconds) : 1000.0;
    return (uint32_t)fmin(calls, 1000.0);
}

/* The choice and aba in turns, so that disturbances of the machine meet both. */
static void measure_in_turns(chart_row *row, turns *t, double seconds)
{
    const chart_choice aba_alone = {.method = TFA_METHOD_ABA, .threads = row->choice.threads};
    double times[SAMPLES_MAX], aba[SAMPLES_MAX], ratios[SAMPLES_MAX];
    const uint32_t calls = calls_for(t, &row->choice), aba_calls = calls_for(t, &aba_alone);
    const double end = read_clock(t->clock) + seconds;
    uint32_t n = 0;
    while (n < SAMPLES_MIN || (n < SAMPLES_MAX && read_clock(t->clock) < end)) {
        times[n] = 1e6 * sample(t, &row->choice, calls);
        aba[n] = 1e6 * sample(t, &aba_alone, aba_calls);
        ratios[n] = aba[n] > 0.0 ? times[n] / aba[n] : NAN;
        n++;
    }
    row->samples = n;
    row->time = row->time_low = row->time_high = chart_median(times, n);
    row->aba_time = chart_median(aba, n);
    row->ratio = chart_median(ratios, n);
}

int chart_measure_times(chart_row *row, chart_case *c, const chart_data *d, double seconds)
{
    turns t = {.c = c, .data = d, .clock = c->pool ? CLOCK_MONOTONIC : CLOCK_THREAD_CPUTIME_ID};
    t.status = c->pool ? make_batch(&t) : TFA_OK;
    if (t.status == TFA_OK)
        measure_in_turns(row, &t, seconds);
    free(t.block);
    return t.status;
}
