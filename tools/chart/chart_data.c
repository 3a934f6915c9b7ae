/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The states of a case and their exact answers.
 */
#include "chart.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* One walk for sizes and pointers: the arrays stand one behind the other. */
static int allocate(chart_data *d, const chart_case *c, chart_rhs rhs, uint32_t states)
{
    *d = (chart_data){.op = c->op,
                      .rhs = rhs,
                      .exact_method = chart_exact_method(c->op, c->bodies),
                      .tip = c->tip,
                      .states = states,
                      .q = tfa_model_q_count(c->model),
                      .v = tfa_model_v_count(c->model),
                      .base = tfa_model_base_freedoms(c->model)};
    d->answer = d->op == CHART_LAMBDA ? CHART_LAMBDA_NUMBERS : d->v + d->base;
    /* room for a random qdd, too */
    const size_t found = (size_t)d->answer + d->v, answers = (size_t)states * d->answer;
    const size_t sizes[] = {(size_t)states * d->q,
                            (size_t)states * d->v,
                            (size_t)states * d->v,
                            (size_t)states * 7,
                            answers,
                            found};
    double **const arrays[] = {&d->coordinates, &d->velocity, &d->tau,
                               &d->pose,        &d->exact,    &d->found};
    size_t total = 0;
    for (int i = 0; i < 6; i++)
        total += sizes[i];
    d->block = calloc(total + 1, sizeof(double));
    double *at = d->block;
    for (int i = 0; at && i < 6; at += sizes[i++])
        *arrays[i] = at;
    return d->block ? TFA_OK : TFA_E_MEMORY;
}

/* A rotation that is not special, its quaternion normalised. */
static void draw_quaternion(uint64_t *random, double *quat)
{
    double square = 0.0;
    for (int i = 0; i < 4; i++) {
        quat[i] = mechanism_random_normal(random);
        square += quat[i] * quat[i];
    }
    for (int i = 0; i < 4; i++)
        quat[i] /= sqrt(square);
}

static void draw_coordinates(chart_case *c, double *q)
{
    for (uint32_t j = 0; j < tfa_model_joint_count(c->model); j++) {
        const tfa_joint_info joint = tfa_model_joint(c->model, j);
        const double range = joint.type == TFA_JOINT_PRISMATIC ? 0.1 * c->turn : c->turn;
        for (uint32_t k = 0; k < joint.q_count; k++)
            q[joint.q_index + k] = mechanism_random_uniform(&c->random, -range, range);
        const int32_t quaternion = tfa_joint_type_describe(joint.type).quaternion;
        if (quaternion >= 0)
            draw_quaternion(&c->random, q + joint.q_index + quaternion);
    }
}

/* tau = RNEA(qdd) in f128, rounded: the exact answer is close to this qdd, whatever the size of
 * the robot. */
static int torques_of_motion(chart_data *d, chart_case *c, uint32_t state)
{
    tfa_request request = chart_request(d, state);
    tfa_answer answer;
    tfa_reply reply = {.tau = d->tau + (size_t)state * d->v, .answers = &answer};
    for (uint32_t k = 0; k < d->v; k++)
        d->found[k] = mechanism_random_normal(&c->random);
    request.op = TFA_OP_INVERSE_DYNAMICS;
    request.method = TFA_METHOD_RNEA;
    request.qdd = d->found;
    return tfa_compute(c->f128, &request, &reply);
}

static int draw_state(chart_data *d, chart_case *c, uint32_t state)
{
    double *tau = d->tau + (size_t)state * d->v, *velocity = d->velocity + (size_t)state * d->v;
    draw_coordinates(c, d->coordinates + (size_t)state * d->q);
    if (d->base)
        draw_quaternion(&c->random, d->pose + 7 * (size_t)state + 3);
    for (uint32_t k = 0; d->rhs != CHART_GRAVITY && k < d->v; k++)
        velocity[k] = mechanism_random_normal(&c->random);
    for (uint32_t k = 0; d->rhs == CHART_TAU && k < d->v; k++)
        tau[k] = mechanism_random_normal(&c->random);
    return d->op == CHART_FORWARD && d->rhs == CHART_QDD ? torques_of_motion(d, c, state) : TFA_OK;
}

tfa_request chart_request(const chart_data *d, uint32_t state)
{
    const int forward = d->op == CHART_FORWARD;
    return (tfa_request){.op = chart_ops[d->op],
                         .method = d->exact_method,
                         .estimate = TFA_ESTIMATE_NEVER,
                         .count = 1,
                         .tip_count = !forward,
                         .tips = {d->tip},
                         .q = d->coordinates + (size_t)state * d->q,
                         .v = forward ? d->velocity + (size_t)state * d->v : NULL,
                         .tau = forward ? d->tau + (size_t)state * d->v : NULL,
                         .base_pose = d->base ? d->pose + 7 * (size_t)state : NULL};
}

tfa_reply chart_reply(const chart_data *d, tfa_answer *answer)
{
    if (d->op == CHART_LAMBDA)
        return (tfa_reply){.lambda_inv = d->found, .answers = answer};
    return (tfa_reply){
        .qdd = d->found, .base_acceleration = d->base ? d->found + d->v : NULL, .answers = answer};
}

/* The exact answer to a state, into d->found. */
static int solve_exactly(chart_data *d, chart_case *c, uint32_t state)
{
    tfa_answer answer;
    tfa_request request = chart_request(d, state);
    tfa_reply reply = chart_reply(d, &answer);
    return tfa_compute(c->f128, &request, &reply);
}

int chart_data_make(chart_data *d, chart_case *c, chart_rhs rhs, uint32_t states)
{
    int status = allocate(d, c, rhs, states);
    for (uint32_t s = 0; status == TFA_OK && s < states; s++) {
        status = draw_state(d, c, s);
        if (status == TFA_OK)
            status = solve_exactly(d, c, s);
        if (status == TFA_OK)
            memcpy(d->exact + (size_t)s * d->answer, d->found, d->answer * sizeof(double));
    }
    if (status == TFA_OK)
        status = chart_floor_find(d, c);
    if (status != TFA_OK)
        chart_data_free(d);
    return status;
}

void chart_data_free(chart_data *d)
{
    free(d->block);
    d->block = NULL;
}
