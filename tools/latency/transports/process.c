/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Transport within this process: the library solves in the call.
 */
#include "open.h"

#include "common/load_model.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <totalforce/totalforce.h>

typedef struct process_transport {
    transport base;
    tfa_model *model;
    tfa_workspace *workspace;
    const latency_states *states;
    tfa_reply reply;
    tfa_wait wait;
    transport_answer answer; /* of the request sent; id 0: none */
} process_transport;

static process_transport *own(transport *t)
{
    return (process_transport *)(void *)t;
}

static int call(transport *t, uint64_t id, uint64_t index, transport_answer *answer)
{
    process_transport *p = own(t);
    const uint64_t start = clock_ns();
    const int status =
        tfa_compute(p->workspace, &p->states->requests[index % p->states->sets], &p->reply);
    *answer = (transport_answer){.id = id,
                                 .status = status,
                                 .method = p->reply.answers[0].method,
                                 .t_received = start,
                                 .t_start = start,
                                 .t_done = clock_ns()};
    return TFA_OK;
}

/* One request at a time: the next one finds no room until the answer is taken. */
static int send_request(transport *t, uint64_t id, uint64_t index)
{
    process_transport *p = own(t);
    return p->answer.id ? TFA_E_AGAIN : call(t, id, index, &p->answer);
}

static int receive(transport *t, uint64_t until, transport_answer *answer)
{
    process_transport *p = own(t);
    if (p->answer.id == 0) {
        transport_sleep(p->wait, until);
        return TFA_E_TIMEOUT;
    }
    *answer = p->answer;
    p->answer.id = 0;
    return TFA_OK;
}

static void idle(transport *t, uint64_t until)
{
    transport_sleep(own(t)->wait, until);
}

static int reconnect(transport *t)
{
    (void)t;
    return TFA_E_SYSTEM; /* nothing is ever lost */
}

static void close_transport(transport *t)
{
    process_transport *p = own(t);
    latency_reply_free(&p->reply);
    tfa_workspace_free(p->workspace);
    tfa_model_free(p->model);
    free(p);
}

static const transport_operations operations = {.now = transport_clock,
                                                .send = send_request,
                                                .receive = receive,
                                                .call = call,
                                                .idle = idle,
                                                .reconnect = reconnect,
                                                .close = close_transport};

/* Description of the robot as a daemon gives it. */
static int describe(const tfa_model *model, tfa_client_info *info, const char ***names,
                    uint32_t **types)
{
    const uint32_t count = tfa_model_joint_count(model);
    *names = calloc(count + 1, sizeof **names);
    *types = calloc(count + 1, sizeof **types);
    if (!*names || !*types)
        return TFA_E_MEMORY;
    for (uint32_t i = 0; i < count; i++) {
        const tfa_joint_info joint = tfa_model_joint(model, i);
        (*names)[i] = joint.name;
        (*types)[i] = (uint32_t)joint.type;
    }
    *info = (tfa_client_info){.q_count = tfa_model_q_count(model),
                              .v_count = tfa_model_v_count(model),
                              .base_freedoms = tfa_model_base_freedoms(model),
                              .slots = 1,
                              .joint_count = count,
                              .joint_names = *names,
                              .joint_types = *types};
    return TFA_OK;
}

static int prepare(process_transport *p, const latency_options *options, latency_states *states,
                   transport_facts *facts)
{
    tfa_model_options model_options = {.base = options->known.base_freedoms ? TFA_BASE_FLOATING
                                                                            : TFA_BASE_FIXED};
    tfa_report report = {0};
    const char **names = NULL;
    uint32_t *types = NULL;
    if (!options->urdf) {
        fprintf(stderr, "totalforce latency: --via process: needs --urdf\n");
        return TFA_E_ARGUMENT;
    }
    p->model = load_model(options->urdf, &model_options, NULL, 0, TFA_ERROR, &report);
    tfa_report_free(&report);
    if (!p->model)
        return TFA_E_MODEL;
    int status = describe(p->model, &facts->info, &names, &types);
    if (status == TFA_OK && !states->requests)
        status = latency_states_init(states, options, &facts->info);
    facts->info.joint_names = NULL;
    facts->info.joint_types = NULL;
    free(names);
    free(types);
    snprintf(facts->hash, sizeof facts->hash, "%s", tfa_model_hash_text(p->model));
    facts->info.wait = p->wait = options->daemon.wait ? options->daemon.wait : TFA_WAIT_SPIN;
    if (status == TFA_OK)
        status = tfa_workspace_create(p->model, NULL, &p->workspace);
    if (status == TFA_OK)
        status = latency_reply_init(&p->reply, options, &facts->info);
    if (status != TFA_OK)
        fprintf(stderr, "totalforce latency: --via process: %s: %s\n", tfa_status_text(status),
                tfa_status_cause(status));
    return status;
}

int transport_process_open(const latency_options *options, latency_states *states, transport **t,
                           transport_facts *facts)
{
    process_transport *p = calloc(1, sizeof *p);
    if (!p)
        return TFA_E_MEMORY;
    *p = (process_transport){.base.ops = &operations, .states = states};
    const int status = prepare(p, options, states, facts);
    if (status == TFA_OK)
        *t = &p->base;
    else
        close_transport(&p->base);
    return status;
}
