/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A small synchronous client of totalforced over DDS: waiting and calls.
 */
#include "dds_client_internal.h"

#include <stdlib.h>
#include <string.h>
#include <time.h>

#define DAEMON_CHECK_NS UINT64_C(20000000) /* a waiting caller checks the daemon this often */

/* ---- waiting ---- */

uint64_t tfa_dds_now(void)
{
    struct timespec now;

    clock_gettime(CLOCK_MONOTONIC, &now);
    return (uint64_t)now.tv_sec * 1000000000u + (uint64_t)now.tv_nsec;
}

uint64_t tfa_dds_deadline(uint64_t timeout_ns)
{
    return timeout_ns == 0 ? UINT64_MAX : tfa_dds_now() + timeout_ns;
}

bool tfa_dds_event_wait(tfa_dds_event *event, tfa_wait wait, uint64_t spin_ns, uint64_t deadline)
{
    const uint64_t spin = wait == TFA_WAIT_SPIN ? UINT64_MAX : wait == TFA_WAIT_BLOCK ? 0 : spin_ns;
    const uint64_t begin = tfa_dds_now();
    const uint64_t spin_end = spin > deadline - begin ? deadline : begin + spin;
    const struct timespec end = {.tv_sec = (time_t)(deadline / 1000000000u),
                                 .tv_nsec = (long)(deadline % 1000000000u)};

    if (begin >= deadline)
        return sem_trywait(&event->signals) == 0;
    do {
        if (sem_trywait(&event->signals) == 0)
            return true;
    } while (tfa_dds_now() < spin_end);
    while (sem_clockwait(&event->signals, CLOCK_MONOTONIC, &end) != 0)
        if (tfa_dds_now() >= deadline)
            return false;
    return true;
}

void tfa_dds_event_signal(dds_entity_t reader, void *event)
{
    tfa_dds_event *e = event;
    int pending = 0;

    (void)reader;
    /* One is enough: whoever consumes it looks at the readers afterwards. */
    if (sem_getvalue(&e->signals, &pending) != 0 || pending == 0)
        sem_post(&e->signals);
}

static void signal_match(dds_entity_t reader, const dds_subscription_matched_status_t status,
                         void *arg)
{
    tfa_dds_event *event = arg;

    (void)reader;
    atomic_store_explicit(&event->peers, (int32_t)status.current_count, memory_order_release);
    sem_post(&event->signals);
}

dds_listener_t *tfa_dds_event_listener(tfa_dds_event *event)
{
    dds_listener_t *listener = dds_create_listener(event);

    if (listener != NULL) {
        dds_lset_data_available(listener, tfa_dds_event_signal);
        dds_lset_subscription_matched(listener, signal_match);
    }
    return listener;
}

void tfa_dds_event_clear(tfa_dds_event *event)
{
    while (sem_trywait(&event->signals) == 0)
        ;
}

/* ---- calls ---- */

int tfa_dds_client_publish(tfa_dds_client *client, const tfa_request *request, uint64_t id)
{
    totalforce_dds_Request sample = {.id = id, .stamp = tfa_dds_ros_time()};

    memcpy(sample.robot, client->robot, sizeof sample.robot);
    memcpy(sample.client, client->guid, sizeof sample.client);
    if (request != NULL) {
        const int status = tfa_dds_request_fill(request, &client->shape, &sample);
        if (status != TFA_OK)
            return status;
    } /* else a hello: all zero */
    return dds_write(client->request_writer, &sample) == DDS_RETCODE_OK ? TFA_OK : TFA_E_SYSTEM;
}

totalforce_dds_Reply *tfa_dds_client_take(tfa_dds_client *client)
{
    dds_sample_info_t state;

    if (client->scratch == NULL) {
        client->scratch = totalforce_dds_Reply__alloc();
        if (client->scratch == NULL)
            return NULL;
        memset(client->scratch, 0, sizeof *client->scratch);
    }
    void *sample[1] = {client->scratch};
    while (dds_take(client->reply_reader, sample, &state, 1, 1) == 1)
        if (state.valid_data &&
            tfa_dds_client_is_from_leader(client, client->reply_reader, state.publication_handle,
                                          client->scratch->epoch, &client->replier))
            return client->scratch;
    return NULL;
}

int tfa_dds_client_send(tfa_dds_client *client, const tfa_request *request, uint64_t *id)
{
    const uint64_t now = tfa_dds_now();

    if (request == NULL || request->count > client->shape.max_batch)
        return request == NULL ? TFA_E_ARGUMENT : TFA_E_SIZE;
    if (client->last - client->first == TFA_DDS_OUTSTANDING)
        return TFA_E_AGAIN;
    if (atomic_load_explicit(&client->event.peers, memory_order_acquire) == 0)
        return TFA_E_DISCONNECTED;
    if (client->first == client->last) {
        tfa_dds_client_follow(client);
        client->changes = client->leader.changes;
    }
    const int status = tfa_dds_client_publish(client, request, client->next_id);
    if (status != TFA_OK)
        return status;
    client->pending[client->last++ % TFA_DDS_OUTSTANDING] = (tfa_dds_pending){
        .id = client->next_id,
        .t_sent = now,
        .reply_shape = tfa_wire_reply_shape_of(&client->shape, request),
    };
    *id = client->next_id++;
    return TFA_OK;
}

/* Keeps a reply that overtook the oldest request's: the daemon refuses bad requests at once. A
 * late reply, whose request was given up, belongs to no pending one and is dropped. */
static void store_early(tfa_dds_client *client)
{
    for (uint64_t at = client->first + 1; at < client->last; at++) {
        const uint64_t slot = at % TFA_DDS_OUTSTANDING;
        if (client->pending[slot].id == client->scratch->id && client->early[slot] == NULL) {
            client->early[slot] = client->scratch;
            client->scratch = NULL;
            return;
        }
    }
}

int tfa_dds_client_wait(tfa_dds_client *client, tfa_dds_event *event, uint64_t deadline)
{
    const uint64_t now = tfa_dds_now();
    const uint64_t check_endpoints =
        deadline - now > DAEMON_CHECK_NS ? now + DAEMON_CHECK_NS : deadline;

    if (now >= deadline)
        return TFA_E_TIMEOUT;
    if (!tfa_dds_event_wait(event, client->wait, client->spin_ns, check_endpoints) &&
        tfa_dds_client_daemon_is_gone(client))
        return TFA_E_DISCONNECTED;
    tfa_dds_client_follow(client);
    return TFA_OK;
}

/* The reply to the oldest request if it has come, or NULL. Belongs to the client, until the next
 * call of this function. */
static const totalforce_dds_Reply *pop_oldest(tfa_dds_client *client)
{
    const uint64_t slot = client->first % TFA_DDS_OUTSTANDING;

    if (client->early[slot] != NULL) {
        totalforce_dds_Reply_free(client->scratch, DDS_FREE_ALL);
        client->scratch = client->early[slot];
        client->early[slot] = NULL;
        return client->scratch;
    }
    while (tfa_dds_client_take(client) != NULL) {
        if (client->scratch->id == client->pending[slot].id)
            return client->scratch;
        store_early(client);
    }
    return NULL;
}

/* Another daemon leads, which may not know the requests under way. A call's is sent again; those of
 * tfa_dds_client_send are lost. */
static int send_again(tfa_dds_client *client)
{
    if (client->changes == client->leader.changes)
        return TFA_OK;
    client->changes = client->leader.changes;
    if (client->again == NULL)
        return TFA_E_DISCONNECTED;
    return tfa_dds_client_publish(client, client->again,
                                  client->pending[client->first % TFA_DDS_OUTSTANDING].id);
}

/* Gives up all requests under way. */
static void forget_pending(tfa_dds_client *client)
{
    for (uint32_t i = 0; i < TFA_DDS_OUTSTANDING; i++) {
        totalforce_dds_Reply_free(client->early[i], DDS_FREE_ALL);
        client->early[i] = NULL;
    }
    client->first = client->last;
}

/* Times of the daemon are ROS times: on one machine they become CLOCK_MONOTONIC. */
static void fill_exchange(const totalforce_dds_Reply *reply, const tfa_dds_pending *pending,
                          tfa_exchange *exchange)
{
    const int64_t offset = tfa_dds_ros_offset();

    *exchange = (tfa_exchange){
        .id = reply->id,
        .t_sent = pending->t_sent,
        .t_received = (uint64_t)(reply->t_received - offset),
        .t_start = reply->t_start != 0 ? (uint64_t)(reply->t_start - offset) : 0,
        .t_done = (uint64_t)(reply->t_done - offset),
    };
}

int tfa_dds_client_receive(tfa_dds_client *client, tfa_reply *reply, uint64_t timeout_ns,
                           tfa_exchange *exchange)
{
    const uint64_t deadline = tfa_dds_deadline(timeout_ns);
    const totalforce_dds_Reply *sample;

    if (reply == NULL || client->first == client->last)
        return TFA_E_ARGUMENT;
    reply->model = 0;
    tfa_dds_event_clear(&client->event);
    while ((sample = pop_oldest(client)) == NULL) {
        int status = tfa_dds_client_wait(client, &client->event, deadline);
        if (status == TFA_OK)
            status = send_again(client);
        if (status == TFA_E_DISCONNECTED)
            forget_pending(client);
        if (status != TFA_OK)
            return status;
    }
    const uint64_t t_reply = tfa_dds_now();
    const tfa_dds_pending *pending = &client->pending[client->first++ % TFA_DDS_OUTSTANDING];
    if (exchange != NULL) {
        fill_exchange(sample, pending, exchange);
        exchange->t_reply = t_reply;
    }
    const int status = tfa_dds_reply_read(sample, &client->shape, &pending->reply_shape, reply);
    return status == TFA_OK ? reply->status : status;
}

int tfa_dds_client_call(tfa_dds_client *client, const tfa_request *request, tfa_reply *reply,
                        uint64_t timeout_ns, tfa_exchange *exchange)
{
    uint64_t id;

    if (client->first != client->last)
        return TFA_E_AGAIN;
    int status = tfa_dds_client_send(client, request, &id);
    if (status != TFA_OK)
        return status;
    client->again = request;
    status = tfa_dds_client_receive(client, reply, timeout_ns, exchange);
    client->again = NULL;
    forget_pending(client); /* a call that timed out does not come back to it */
    return status;
}
