/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Statistics of the answers of a chunk.
 */
#include "sweep_block.h"

#include <math.h>

static double square(const double *x, uint32_t count)
{
    double sum = 0;
    for (uint32_t k = 0; k < count; k++)
        sum += x[k] * x[k];
    return sum;
}

/* 2-norm of the answer of one state; of a matrix that of Frobenius */
static double norm(const sweep_worker *w, uint32_t at)
{
    const sweep_plan *p = w->plan;
    return sqrt(square(w->base + (size_t)at * p->base, p->base) +
                square(w->joint + (size_t)at * p->joint, p->joint) +
                square(w->matrix + (size_t)at * p->matrix, p->matrix));
}

static void count_flags(statistics *s, const tfa_answer *answer)
{
    s->fallbacks += (answer->flags & TFA_ANSWER_FALLBACK) != 0;
    s->sentinels += (answer->flags & TFA_ANSWER_SENTINEL) != 0;
    s->wider += (answer->flags & TFA_ANSWER_RESIDUAL_PRECISION) != 0;
}

void sweep_worker_count(sweep_worker *w, uint64_t state, uint32_t count)
{
    statistics *s = &w->statistics;
    s->states += count;
    for (uint32_t at = 0; at < count; at++) {
        const tfa_answer *answer = &w->answers[at];
        const uint32_t status = (uint32_t)-answer->status;
        s->status[status < STATISTICS_STATUSES ? status : STATISTICS_STATUSES - 1]++;
        if (answer->status != TFA_OK)
            continue;
        s->method[answer->method < STATISTICS_METHODS ? answer->method : 0]++;
        if (answer->flags)
            count_flags(s, answer);
        series_add(&s->series[SERIES_ANSWER], &w->groups[SERIES_ANSWER], norm(w, at), state + at);
        if (answer->flags & TFA_ANSWER_ESTIMATED)
            series_add(&s->series[SERIES_ESTIMATE], &w->groups[SERIES_ESTIMATE],
                       answer->error_estimate, state + at);
    }
}
