/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Random requests of one robot, and room for the replies to them.
 */
#include "states.h"

#include <totalforce/text.h>

#include <stdlib.h>
#include <string.h>

/* Requests that differ: enough that no branch predictor learns one by heart, few enough that they
 * stay in the second-level cache. */
enum { SETS = 64 };
static const uint64_t SEED = 0x9e3779b97f4a7c15u;

/* splitmix64, scaled to -1 .. 1 */
static double uniform(uint64_t *seed)
{
    uint64_t z = (*seed += 0x9e3779b97f4a7c15u);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return (double)((z ^ (z >> 31)) >> 11) * 0x1p-52 - 1.0;
}

static double *fill(double **at, size_t count, double scale, uint64_t *seed)
{
    double *first = *at;
    for (size_t i = 0; i < count; i++)
        first[i] = scale * uniform(seed);
    *at += count;
    return first;
}

static void set_unit(double *quaternion)
{
    memset(quaternion, 0, 3 * sizeof *quaternion);
    quaternion[3] = 1.0;
}

static void fill_request(tfa_request *request, const tfa_names *names, double **at, uint64_t *seed)
{
    size_t batch = request->count;
    double *q = fill(at, batch * names->q_count, 3.0, seed);
    for (size_t k = 0; k < batch; k++)
        for (uint32_t j = 0; j < names->joint_count; j++)
            if (names->joints[j].quaternion >= 0)
                set_unit(q + k * names->q_count + names->joints[j].q_index +
                         names->joints[j].quaternion);
    request->q = q;
    request->v = fill(at, batch * names->v_count, 1.0, seed);
    request->tau = fill(at, batch * names->v_count, 10.0, seed);
    if (names->base_freedoms == 0)
        return;
    double *pose = fill(at, batch * 7, 1.0, seed);
    for (size_t k = 0; k < batch; k++)
        set_unit(pose + 7 * k + 3);
    request->base_pose = pose;
    request->base_twist = fill(at, batch * 6, 1.0, seed);
    request->base_wrench = fill(at, batch * 6, 10.0, seed);
}

void latency_states_free(latency_states *states)
{
    free(states->requests);
    free(states->memory);
    *states = (latency_states){0};
}

int latency_states_init(latency_states *states, const latency_options *options,
                        const tfa_client_info *info)
{
    tfa_names names;
    int status = tfa_names_of_info(&names, options->daemon.robot, info);
    if (status != TFA_OK)
        return status;
    size_t numbers = (size_t)info->q_count + 2 * (size_t)info->v_count + 19;
    uint64_t seed = SEED;
    *states = (latency_states){.sets = SETS,
                               .requests = calloc(SETS, sizeof *states->requests),
                               .memory = calloc(SETS * numbers, options->batch * sizeof(double))};
    if (!states->requests || !states->memory) {
        latency_states_free(states);
        tfa_names_free(&names);
        return TFA_E_MEMORY;
    }
    double *at = states->memory;
    for (uint32_t i = 0; i < SETS; i++) {
        states->requests[i] = (tfa_request){.op = TFA_OP_FORWARD_DYNAMICS,
                                            .method = options->method,
                                            .estimate = options->estimate,
                                            .refine = TFA_REFINE_DEFAULT,
                                            .count = options->batch};
        fill_request(&states->requests[i], &names, &at, &seed);
    }
    tfa_names_free(&names);
    return TFA_OK;
}

int latency_reply_init(tfa_reply *reply, const latency_options *options,
                       const tfa_client_info *info)
{
    size_t batch = options->batch;
    *reply = (tfa_reply){.qdd = calloc(batch * ((size_t)info->v_count + 1), sizeof(double)),
                         .answers = calloc(batch, sizeof(tfa_answer))};
    if (info->base_freedoms)
        reply->base_acceleration = calloc(batch * 6, sizeof(double));
    int whole = reply->qdd && reply->answers && (reply->base_acceleration || !info->base_freedoms);
    return whole ? TFA_OK : TFA_E_MEMORY;
}

void latency_reply_free(tfa_reply *reply)
{
    free(reply->qdd);
    free(reply->base_acceleration);
    free(reply->answers);
}

static uint32_t cache_lines_of(size_t bytes)
{
    return (uint32_t)((bytes + 63) / 64);
}

pingpong_size latency_size(const latency_options *options, const tfa_client_info *info)
{
    const size_t base = info->base_freedoms ? 1 : 0, batch = options->batch;
    const size_t asked = info->q_count + 2 * (size_t)info->v_count + base * 19;
    const size_t reported = info->v_count + base * 6;
    return (pingpong_size){cache_lines_of(64 + batch * 8 * asked),
                           cache_lines_of(64 + batch * (sizeof(tfa_answer) + 8 * reported))};
}
