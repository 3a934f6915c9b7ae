/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Time against aba's: state after state, or batch after batch.
 */
#include "chart.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { SAMPLES_MAX = 101, SAMPLES_MIN = 3 };

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

typedef struct turns {
    chart_case *c;
    const chart_data *data;
    clockid_t clock;
    chart_batch *batch; /* without a block: one state a request */
    int status;         /* of the first call that failed */
} turns;

/* A solver, and what it is asked for. Each call has another q than its own one before, since the
 * factors of the same q would be kept. */
typedef struct contestant {
    const chart_solver *solver; /* unused for peers */
    chart_choice choice;
    uint32_t next; /* state */
} contestant;

static int call(turns *t, contestant *who, tfa_reply *reply)
{
    if (t->batch->block)
        return chart_solve(who->solver, &t->batch->request, &t->batch->reply);
    return chart_answer(t->c, who->solver, &who->choice, t->data, who->next++ % t->data->states,
                        reply);
}

/* Seconds for a state, from so many calls */
static double sample(turns *t, contestant *who, uint32_t calls)
{
    tfa_answer answer;
    tfa_reply reply = chart_reply(t->data, &answer);
    t->batch->request.method = (tfa_method)who->choice.method;
    t->batch->request.refine = who->choice.refine;
    if (t->c->threads > 1) /* those of the pool fell asleep in the turn of the other */
        t->status = call(t, who, &reply);
    const double start = read_clock(t->clock);
    for (uint32_t k = 0; k < calls && t->status == TFA_OK; k++)
        t->status = call(t, who, &reply);
    return (read_clock(t->clock) - start) / calls / (t->batch->block ? t->batch->request.count : 1);
}

/* How many calls make a sample, from one that is thrown away. */
static uint32_t calls_for(turns *t, contestant *who)
{
    const uint32_t states = t->batch->block ? t->batch->request.count : 1;
    const double seconds = sample(t, who, t->batch->block ? 1 : t->data->states) * states;
    const double calls = seconds > 0.0 ? ceil(SAMPLE_SECONDS / seconds) : 1000.0;
    return (uint32_t)fmin(calls, 1000.0);
}

/* The choice and aba in turns, so that disturbances of the machine meet both. */
static void measure_in_turns(chart_row *row, turns *t, double seconds)
{
    contestant who = {&t->c->solvers[row->choice.precision], row->choice, 0};
    contestant aba_alone = {&t->c->baseline, {.method = TFA_METHOD_ABA}, 0};
    double times[SAMPLES_MAX], aba[SAMPLES_MAX], ratios[SAMPLES_MAX];
    const uint32_t calls = calls_for(t, &who), aba_calls = calls_for(t, &aba_alone);
    const double end = read_clock(t->clock) + seconds;
    uint32_t n = 0;
    while (n < SAMPLES_MIN || (n < SAMPLES_MAX && read_clock(t->clock) < end)) {
        times[n] = 1e6 * sample(t, &who, calls);
        aba[n] = 1e6 * sample(t, &aba_alone, aba_calls);
        ratios[n] = aba[n] > 0.0 ? times[n] / aba[n] : NAN;
        n++;
    }
    row->samples = n;
    row->time = row->time_low = row->time_high = chart_median(times, n);
    row->aba_time = chart_median(aba, n);
    row->ratio = chart_median(ratios, n);
}

int chart_measure_times(chart_row *row, chart_batch *batch, chart_case *c, const chart_data *d,
                        double seconds)
{
    turns t = {.c = c,
               .data = d,
               .batch = batch,
               .clock = c->threads > 1 ? CLOCK_MONOTONIC : CLOCK_THREAD_CPUTIME_ID};
    measure_in_turns(row, &t, seconds);
    return t.status;
}
