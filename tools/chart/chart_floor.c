/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Accuracy that the data allow: the floor is how far the exact answer moves when every number
 * that a computation in double starts from is rounded. Each number of the robot and of the request
 * goes to its upper or lower neighbour or stays; a number that is 0 stays 0. Sines and cosines of
 * the joint angles are rounded to double, each on its own: next to q = 0 the rounding of the cosine
 * is much more than that of the angle, and cos^2 + sin^2 is no longer 1.
 */
#include "chart.h"
#include "mechanism/move.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

int chart_floor_open(chart_case *c, tfa_description *description, const tfa_model_options *options)
{
    uint64_t random = c->random ^ UINT64_C(0x9e3779b97f4a7c15); /* states stay as they were */
    move_description(&random, description);
    const tfa_workspace_options rounded = {.precision = TFA_F128, .round_sincos = 1};
    const int status = tfa_model_create(description, options, NULL, &c->neighbour);
    return status == TFA_OK ? tfa_workspace_create(c->neighbour, &rounded, &c->neighbour_f128)
                            : status;
}

void chart_floor_close(chart_case *c)
{
    tfa_workspace_free(c->neighbour_f128);
    tfa_model_free(c->neighbour);
}

/* All numbers of all requests stand one behind the other: q, v, tau, poses. */
static size_t request_numbers(const chart_data *d)
{
    return (size_t)d->states * ((size_t)d->q + 2 * (size_t)d->v + 7);
}

int chart_floor_find(chart_data *d, chart_case *c)
{
    double errors[CHART_STATES], worst, gravity[3] = {0.0, 0.0, -9.80665};
    const size_t count = request_numbers(d);
    double *kept = malloc((count + 1) * sizeof(double));
    if (!kept)
        return TFA_E_MEMORY;
    memcpy(kept, d->coordinates, count * sizeof(double));
    move_numbers(&c->random, d->coordinates, count);
    move_numbers(&c->random, gravity, 3);
    int status = TFA_OK;
    for (uint32_t s = 0; status == TFA_OK && s < d->states; s++) {
        tfa_answer answer;
        tfa_request request = chart_request(d, s);
        tfa_reply reply = chart_reply(d, &answer);
        request.gravity = gravity;
        status = tfa_compute(c->neighbour_f128, &request, &reply);
        errors[s] = chart_error(d, s, &worst);
    }
    memcpy(d->coordinates, kept, count * sizeof(double));
    free(kept);
    /* and the answer is rounded */
    d->floor = status == TFA_OK ? fmax(chart_median(errors, d->states), 0x1p-53) : NAN;
    return status;
}
