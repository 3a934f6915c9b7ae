/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Transports to a daemon: shared memory and DDS.
 */
#include "open.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

/* A daemon that restarts is back in this time, or the run ends. */
static const uint64_t away_ns = 2000000000;
static const uint64_t pause_ns = 10000000;

typedef struct daemon_transport {
    transport base;
    const daemon_options *options;
    daemon_via via;
    daemon_link *link;
    const latency_states *states;
    tfa_reply reply;
    tfa_wait wait;                            /* granted */
    uint64_t offset;                          /* our ids less those of the connection */
    uint32_t q_count, v_count, base_freedoms; /* that requests and reply are made for */
} daemon_transport;

static daemon_transport *own(transport *t)
{
    return (daemon_transport *)(void *)t;
}

static const tfa_request *request_of(const daemon_transport *d, uint64_t index)
{
    return &d->states->requests[index % d->states->sets];
}

static void answer_from(daemon_transport *d, const tfa_exchange *x, int status,
                        transport_answer *answer)
{
    *answer = (transport_answer){.id = x->id + d->offset,
                                 .status = status,
                                 .method = d->reply.answers[0].method,
                                 .t_received = x->t_received,
                                 .t_start = x->t_start,
                                 .t_done = x->t_done};
}

static int send_request(transport *t, uint64_t id, uint64_t index)
{
    daemon_transport *d = own(t);
    uint64_t theirs = 0;
    const int status = daemon_send(d->link, request_of(d, index), &theirs);
    if (status == TFA_OK)
        d->offset = id - theirs;
    return status;
}

static int receive(transport *t, uint64_t until, transport_answer *answer)
{
    daemon_transport *d = own(t);
    const uint64_t at = clock_ns();
    tfa_exchange x = {0};
    const int status = daemon_receive(d->link, &d->reply, until > at ? until - at : 1, &x);
    if (x.id == 0)
        return status;
    answer_from(d, &x, status, answer);
    return TFA_OK;
}

static int call(transport *t, uint64_t id, uint64_t index, transport_answer *answer)
{
    daemon_transport *d = own(t);
    tfa_exchange x = {0};
    const int status = daemon_call(d->link, request_of(d, index), &d->reply, &x);
    if (daemon_lost(status))
        return status;
    d->offset = id - x.id;
    answer_from(d, &x, status, answer);
    return TFA_OK;
}

static void idle(transport *t, uint64_t until)
{
    transport_sleep(own(t)->wait, until);
}

/* Requests and the buffers of the reply have the sizes of the robot of the first connection. */
static int check_shape(const daemon_transport *d)
{
    const tfa_client_info *info = daemon_info(d->link);
    const int same = info->q_count == d->q_count && info->v_count == d->v_count &&
                     info->base_freedoms == d->base_freedoms;
    return same ? TFA_OK : TFA_E_SIZE;
}

static int reconnect(transport *t)
{
    daemon_transport *d = own(t);
    const uint64_t end = clock_ns() + away_ns;
    for (;;) {
        daemon_close(d->link);
        const int status = daemon_connect(d->options, d->via, &d->link);
        if (status == TFA_OK)
            return check_shape(d);
        if (clock_ns() + pause_ns > end)
            return status;
        transport_sleep(TFA_WAIT_BLOCK, clock_ns() + pause_ns);
    }
}

static void close_transport(transport *t)
{
    daemon_transport *d = own(t);
    daemon_close(d->link);
    latency_reply_free(&d->reply);
    free(d);
}

static const transport_operations operations = {.now = transport_clock,
                                                .send = send_request,
                                                .receive = receive,
                                                .call = call,
                                                .idle = idle,
                                                .reconnect = reconnect,
                                                .close = close_transport};

static int prepare(daemon_transport *d, const latency_options *options, latency_states *states,
                   transport_facts *facts)
{
    const tfa_client_info *info = daemon_info(d->link);
    facts->info = *info;
    snprintf(facts->hash, sizeof facts->hash, "%s", info->model_hash ? info->model_hash : "");
    facts->info.joint_names = facts->info.frame_names = NULL;
    facts->info.joint_types = NULL;
    facts->info.model_hash = NULL;
    d->q_count = info->q_count;
    d->v_count = info->v_count;
    d->base_freedoms = info->base_freedoms;
    d->wait = info->wait ? info->wait : options->daemon.wait;
    int status = states->requests ? TFA_OK : latency_states_init(states, options, info);
    if (status == TFA_OK)
        status = latency_reply_init(&d->reply, options, info);
    return status;
}

int transport_daemon_open(const latency_options *options, latency_via via, latency_states *states,
                          transport **t, transport_facts *facts)
{
    char text[512];
    daemon_transport *d = calloc(1, sizeof *d);
    if (!d)
        return TFA_E_MEMORY;
    *d = (daemon_transport){.base.ops = &operations,
                            .options = &options->daemon,
                            .via = via == VIA_DDS ? DAEMON_DDS : DAEMON_SHM,
                            .states = states};
    int status = daemon_connect(&options->daemon, d->via, &d->link);
    if (status != TFA_OK) {
        daemon_explain(&options->daemon, d->via, status, text, sizeof text);
        fprintf(stderr, "totalforce latency: %s\n", text);
    } else if ((status = prepare(d, options, states, facts)) != TFA_OK)
        fprintf(stderr, "totalforce latency: %s\n", tfa_status_text(status));
    if (status == TFA_OK)
        *t = &d->base;
    else
        close_transport(&d->base);
    return status;
}
