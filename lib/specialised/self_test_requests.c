/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Requests with random states of one robot.
 */
#include <math.h>
#include <stdlib.h>

#include "specialised/self_test.h"

/* ---- random states, the same each time ---- */

/* xorshift64* (Vigna 2016); numbers that floats hold, so that errors in float are those of the
 * arithmetic */
static double uniform(uint64_t *seed, double lowest, double highest)
{
    *seed ^= *seed >> 12;
    *seed ^= *seed << 25;
    *seed ^= *seed >> 27;
    return (float)(lowest +
                   (highest - lowest) * (double)(*seed * 0x2545f4914f6cdd1dull >> 11) * 0x1p-53);
}

static double *fill(double **at, size_t n, uint64_t *seed, double most)
{
    double *x = *at;
    *at += n;
    for (size_t k = 0; k < n; k++)
        x[k] = uniform(seed, -most, most);
    return x;
}

static const double *fill_poses(double **at, uint64_t *seed)
{
    const double *all = *at;
    for (int k = 0; k < SELF_TEST_STATES; k++) {
        double *pose = fill(at, 7, seed, 1), norm = 0;
        for (int e = 3; e < 7; e++)
            norm += pose[e] * pose[e];
        for (int e = 3; e < 7; e++)
            pose[e] = norm > 0.01 ? pose[e] / sqrt(norm) : e == 6;
    }
    return all;
}

static void fill_inputs(struct self_test *t)
{
    const struct tfa_model *m = t->model;
    uint64_t seed = 0x9e3779b97f4a7c15ull;
    double *at = t->inputs;
    tfa_request *r = &t->request;
    r->q = fill(&at, (size_t)SELF_TEST_STATES * m->q_count, &seed, 3);
    r->v = fill(&at, (size_t)SELF_TEST_STATES * m->v_count, &seed, 2);
    r->tau = fill(&at, (size_t)SELF_TEST_STATES * m->v_count, &seed, 10);
    r->qdd = fill(&at, (size_t)SELF_TEST_STATES * m->v_count, &seed, 5);
    r->wrenches = fill(&at, (size_t)SELF_TEST_STATES * 6, &seed, 10);
    r->gravity = fill(&at, 3, &seed, 9.81);
    if (!m->base_freedoms)
        return;
    r->base_twist = fill(&at, (size_t)SELF_TEST_STATES * 6, &seed, 1);
    r->base_wrench = fill(&at, (size_t)SELF_TEST_STATES * 6, &seed, 10);
    r->base_acceleration = fill(&at, (size_t)SELF_TEST_STATES * 6, &seed, 5);
    r->base_pose = fill_poses(&at, &seed);
}

/* ---- outputs ---- */

static void set_reply_buffers(struct self_test_reply *a, const tfa_model *m, double **at)
{
    const struct {
        double **array;
        size_t width;
    } arrays[] = {{&a->reply.qdd, m->v_count},
                  {&a->reply.tau, m->v_count},
                  {&a->reply.base_acceleration, 6},
                  {&a->reply.base_wrench, 6},
                  {&a->reply.lambda_inv, 144},
                  {&a->reply.poses, 14},
                  {&a->reply.mass_matrix, self_test_mass(m)},
                  {&a->reply.dqdd_dq, self_test_derivatives(m)},
                  {&a->reply.dqdd_dv, self_test_derivatives(m)},
                  {&a->reply.dqdd_dtau, self_test_derivatives(m)}};
    for (size_t k = 0; k < sizeof arrays / sizeof *arrays; k++) {
        *arrays[k].array = *at;
        *at += SELF_TEST_STATES * arrays[k].width + SELF_TEST_GUARD;
    }
    a->reply.dtau_dq = a->reply.dqdd_dq;
    a->reply.dtau_dv = a->reply.dqdd_dv;
    a->reply.answers = a->answers;
}

static size_t outputs_of(const tfa_model *m)
{
    return (size_t)SELF_TEST_STATES * (2 * m->v_count + 6 + 6 + 144 + 14 + self_test_mass(m) +
                                       3 * self_test_derivatives(m)) +
           10 * SELF_TEST_GUARD;
}

/* ---- requests ---- */

int self_test_open(struct self_test *t, const tfa_model *model)
{
    const tfa_workspace_options options = {.states = TFA_STATES_ONE,
                                           .methods = TFA_METHOD_BIT(TFA_METHOD_ABA) |
                                                      TFA_METHOD_BIT(TFA_METHOD_CRBA)};
    const size_t inputs = (size_t)SELF_TEST_STATES * (model->q_count + 3 * model->v_count + 31) + 3;
    *t = (struct self_test){.model = model,
                            .host = specialised_host_api(model),
                            .outputs_count = 2 * outputs_of(model)};
    t->inputs = malloc(inputs * sizeof(double));
    t->outputs = malloc(t->outputs_count * sizeof(double));
    if (!t->inputs || !t->outputs)
        return TFA_E_MEMORY;
    double *at = t->outputs;
    set_reply_buffers(&t->tested, model, &at);
    set_reply_buffers(&t->reference, model, &at);
    return tfa_workspace_create(model, &options, &t->generic);
}

void self_test_close(struct self_test *t)
{
    tfa_workspace_free(t->generic);
    free(t->outputs);
    free(t->inputs);
}

static void add_options(tfa_request *r, unsigned options, uint32_t frame)
{
    static const double payload[TFA_PAYLOAD_NUMBERS] = {1.5,   0.02,  -0.03, 0.05, 0.004,
                                                        0.001, 0.002, 0.005, 0,    0.006};
    static const uint32_t first[1];
    if (options & SELF_TEST_PAYLOAD) {
        r->payload_count = 1;
        r->payload_frames[0] = frame;
        r->payloads = payload;
    }
    if (options & SELF_TEST_LOCKED) {
        r->locked_count = 1;
        r->locked = first;
    }
    if (options & SELF_TEST_AT_REST)
        r->v = r->tau = r->qdd = r->base_twist = r->base_wrench = r->base_acceleration = NULL;
    if (options & SELF_TEST_WRENCH) {
        r->wrench_count = 1;
        r->wrench_frames[0] = frame;
    } else {
        r->wrenches = NULL;
    }
    if (!(options & SELF_TEST_GRAVITY))
        r->gravity = NULL;
}

void self_test_request(struct self_test *t, const struct self_test_case *q, uint32_t tip)
{
    const struct tfa_model *m = t->model;
    /* lambda_inv is tested on each body: fewer states for each */
    const uint32_t states_per_tip = 2 * SELF_TEST_STATES / m->bodies;
    tfa_request *r = &t->request;
    *r = (tfa_request){.op = q->op,
                       .refine = TFA_REFINE_DEFAULT,
                       .frame = q->frame,
                       .flags = q->flags,
                       .count = !q->tips                            ? SELF_TEST_STATES
                                : states_per_tip < 2                ? 2
                                : states_per_tip > SELF_TEST_STATES ? SELF_TEST_STATES
                                                                    : states_per_tip,
                       .tip_count = q->tips,
                       .tips = {m->body[tip].link, m->body[m->bodies - 1].link}};
    fill_inputs(t);
    add_options(r, q->options, m->body[tip].link);
}
