/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The terms of the equation of motion apart.
 */
#include "dynamics/core/recursions.h"
#include "dynamics/solve/answer.h"
#include "dynamics/solve/bias_force.h"
#include "dynamics/solve/load.h"

/* Forces to row k of an answer, base first. Returns 1 when all of it is finite. */
static int unload_to(struct state *s, num *force, uint32_t k, double *out)
{
    const uint32_t nb = s->m->base_freedoms;
    double *row = out ? out + (size_t)(nb + s->m->v_count) * k : NULL;
    return TFA_V(unload_force)(s, force, row, row ? row + nb : NULL);
}

static int unload_row(struct state *s, uint32_t k, double *out)
{
    return unload_to(s, s->res, k, out);
}

int TFA_V(answer_momentum)(struct state *s, uint32_t k, tfa_reply *reply)
{
    TFA_V(generalised_momentum)(s, s->res, s->tau);
    int finite = unload_row(s, k, reply->generalised_momentum);
    finite &= unload_to(s, s->tau, k, reply->momentum_rate);
    return finite;
}

int TFA_V(answer_bias)(struct state *s, uint32_t k, tfa_reply *reply, tfa_answer *out)
{
    int finite;
    out->method = (uint16_t)s->by.method;
    TFA_V(gravity_force)(s, s->res);
    finite = unload_row(s, k, reply->gravity_force);
    TFA_V(velocity_force)(s, s->res);
    if (s->boosted) /* of qdd = 0 in the world */
        TFA_V(rnea)(s, s->boost_rate, s->dx, 0);
    for (uint32_t j = 0; s->boosted && j < s->freedoms; j++)
        s->res[j] += s->dx[j];
    finite &= unload_row(s, k, reply->velocity_force);
    TFA_V(damping_force)(s, s->res);
    finite &= unload_row(s, k, reply->damping_force);
    TFA_V(friction_force)(s, s->res);
    finite &= unload_row(s, k, reply->friction_force);
    TFA_V(external_force)(s, s->res);
    finite &= unload_row(s, k, reply->external_force);
    for (uint32_t j = 0; j < s->freedoms; j++)
        s->res[j] = num_of(s->m->armature[j]) * s->qdd[j];
    finite &= unload_row(s, k, reply->armature_force);
    return finite ? TFA_OK : TFA_E_NOT_COMPUTED;
}
