/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Errors of answers against the exact ones.
 */
#include "chart.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

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
