/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The generalised-momentum observer: one step of a first-order filter for each sample.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <totalforce/observer.h>

struct tfa_observer {
    tfa_observer_options options;
    uint32_t base, n; /* freedoms: of the base, all */
    int running;      /* `time`, `model`, `before` and `force` are those of the last sample */
    double time;
    uint64_t model;
    double *p, *rate;       /* of the answer */
    double *before, *force; /* p and tau + rate of the last sample */
    double *r;
    /* of the question for a wrench */
    double *acceleration, *jacobian, lambda[36], lambda_inv[36];
    double gravity[3];
    tfa_rank rank;
};

int tfa_observer_create(uint32_t base_freedoms, uint32_t v_count,
                        const tfa_observer_options *options, tfa_observer **observer)
{
    enum { VECTORS = 6, JACOBIAN = 6 };
    if (!observer)
        return TFA_E_ARGUMENT;
    *observer = NULL;
    if (!options || (base_freedoms != 0 && base_freedoms != 6))
        return TFA_E_ARGUMENT;
    if (!isfinite(options->gain) || !(options->gain > 0) || !isfinite(options->max_gap) ||
        options->max_gap < 0)
        return TFA_E_VALUE;
    const size_t n = (size_t)base_freedoms + v_count;
    tfa_observer *o = calloc(1, sizeof *o + (VECTORS + JACOBIAN) * n * sizeof(double));
    if (!o)
        return TFA_E_MEMORY;
    double *numbers = (double *)(o + 1),
           **const vectors[VECTORS] = {&o->p,     &o->rate, &o->before,
                                       &o->force, &o->r,    &o->acceleration};
    for (int k = 0; k < VECTORS; k++)
        *vectors[k] = numbers + n * (size_t)k;
    o->jacobian = numbers + n * VECTORS;
    o->options = *options;
    if (o->options.max_gap == 0)
        o->options.max_gap = 5 / options->gain;
    o->base = base_freedoms;
    o->n = (uint32_t)n;
    *observer = o;
    return TFA_OK;
}

void tfa_observer_free(tfa_observer *observer)
{
    free(observer);
}

void tfa_observer_restart(tfa_observer *observer)
{
    observer->running = 0;
    memset(observer->r, 0, observer->n * sizeof *observer->r);
}

const double *tfa_observer_torques(const tfa_observer *observer)
{
    return observer->r;
}

void tfa_observer_request(tfa_observer *observer, tfa_request *request, tfa_reply *reply)
{
    *request =
        (tfa_request){.op = TFA_OP_KINEMATICS, .flags = TFA_WANT_GENERALISED_MOMENTUM, .count = 1};
    *reply = (tfa_reply){.generalised_momentum = observer->p, .momentum_rate = observer->rate};
}

/* tau + rate of the sample in place of rate. Returns 1 when all of it is finite. */
static int add_torques(tfa_observer *o, const double *tau, const double *base_wrench)
{
    double rest = 0;
    for (uint32_t j = 0; j < o->n; j++) {
        const double *known = j < o->base ? base_wrench : tau;
        o->rate[j] += known ? known[j < o->base ? j : j - o->base] : 0;
        rest += (o->rate[j] - o->rate[j]) + (o->p[j] - o->p[j]);
    }
    return rest == 0;
}

static tfa_observer_event event_of(const tfa_observer *o, double time, uint64_t model)
{
    return !o->running                           ? TFA_OBSERVER_STARTED
           : model != o->model                   ? TFA_OBSERVER_MODEL
           : !(time > o->time)                   ? TFA_OBSERVER_TIME
           : time - o->time > o->options.max_gap ? TFA_OBSERVER_GAP
                                                 : TFA_OBSERVER_UPDATED;
}

tfa_observer_event tfa_observer_update(tfa_observer *o, double time, const double *tau,
                                       const double *base_wrench, const tfa_reply *reply)
{
    if (reply->status != TFA_OK || !isfinite(time) || !add_torques(o, tau, base_wrench)) {
        tfa_observer_restart(o);
        return TFA_OBSERVER_INVALID;
    }
    const tfa_observer_event event = event_of(o, time, reply->model);
    const double dt = time - o->time, share = -expm1(-o->options.gain * dt);
    if (event != TFA_OBSERVER_UPDATED)
        tfa_observer_restart(o);
    for (uint32_t j = 0; event == TFA_OBSERVER_UPDATED && j < o->n; j++) {
        const double external = (o->p[j] - o->before[j]) / dt - (o->force[j] + o->rate[j]) / 2;
        o->r[j] += share * (external - o->r[j]);
    }
    memcpy(o->before, o->p, o->n * sizeof *o->p);
    memcpy(o->force, o->rate, o->n * sizeof *o->rate);
    o->time = time;
    o->model = reply->model;
    o->running = 1;
    return event;
}

void tfa_observer_wrench_request(tfa_observer *o, uint32_t tip, tfa_request *request,
                                 tfa_reply *reply)
{
    *request = (tfa_request){.op = TFA_OP_FORWARD_DYNAMICS,
                             .flags = TFA_WANT_LAMBDA | TFA_WANT_JACOBIAN,
                             .refine = TFA_REFINE_DEFAULT,
                             .count = 1,
                             .tip_count = 1,
                             .tips = {tip},
                             .tau = o->r + o->base,
                             .base_wrench = o->base ? o->r : NULL,
                             .gravity = o->gravity};
    *reply = (tfa_reply){.qdd = o->acceleration + o->base,
                         .base_acceleration = o->base ? o->acceleration : NULL,
                         .lambda_inv = o->lambda_inv,
                         .lambda = o->lambda,
                         .jacobian = o->jacobian,
                         .rank = &o->rank};
}

int tfa_observer_wrench(const tfa_observer *o, const tfa_reply *reply, double wrench[6])
{
    double a[6];
    for (uint32_t e = 0; e < 6; e++) {
        a[e] = 0;
        for (uint32_t j = 0; j < o->n; j++)
            a[e] += o->jacobian[e * o->n + j] * o->acceleration[j];
    }
    for (uint32_t e = 0; e < 6; e++) {
        wrench[e] = reply->status == TFA_OK ? 0 : (double)NAN;
        for (uint32_t f = 0; f < 6; f++)
            wrench[e] += o->lambda[6 * e + f] * a[f];
    }
    return reply->status;
}
