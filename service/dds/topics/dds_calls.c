/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The DDS gateway: samples become requests.
 *
 * Latency first: Cyclone's receiving thread calls a listener, which answers a short request by
 * itself, with a solver of the gateway's own: no thread is woken on the way (a wake-up costs 23 us
 * and more, the answer of a small robot 1 us). A request that takes longer than DIRECT_NS, by the
 * cost model or its bound, goes to the worker, where it is one of many; the dds thread writes its
 * answer. The samples of a stream stay in order: none overtakes one that is at the worker.
 */
#include "dds/topics/dds_internal.h"

#include "ipc/wire_reply.h"
#include "worker/cost_bound.h"

#include <stdlib.h>
#include <string.h>

/* A listener that takes longer delays the samples of others: about what waking a thread costs. */
#define DIRECT_NS 50000
#define PAGE_BYTES 4096 /* holds one state of most answers */

dds_robot *tfa_dds_find_robot(const tfa_dds *gateway, const char *name)
{
    for (uint32_t i = 0; i < gateway->robot_count; i++)
        if (strcmp(gateway->robots[i].name, name) == 0)
            return &gateway->robots[i];
    return NULL;
}

/* ---- filters ---- */

static bool is_ours(tfa_dds *gateway, const char *robot)
{
    if (tfa_dds_find_robot(gateway, robot) != NULL)
        return true;
    tfa_dds_increment(&gateway->count->unknown);
    return false;
}

bool tfa_dds_request_is_ours(const void *sample, void *gateway)
{
    return is_ours(gateway, ((const totalforce_dds_Request *)sample)->robot);
}

bool tfa_dds_torques_are_ours(const void *sample, void *gateway)
{
    return is_ours(gateway, ((const totalforce_dds_JointTorques *)sample)->robot);
}

/* ---- samples ---- */

static dds_taken *borrow_sample(tfa_dds *gateway)
{
    pthread_mutex_lock(&gateway->mutex);
    dds_taken *taken = gateway->free_samples;
    if (taken != NULL)
        gateway->free_samples = taken->next;
    pthread_mutex_unlock(&gateway->mutex);
    return taken != NULL ? taken : calloc(1, sizeof *taken);
}

static void return_sample(tfa_dds *gateway, dds_taken *taken)
{
    pthread_mutex_lock(&gateway->mutex);
    taken->next = gateway->free_samples;
    gateway->free_samples = taken;
    pthread_mutex_unlock(&gateway->mutex);
}

void tfa_dds_free_sample(dds_taken *taken)
{
    if (taken == NULL)
        return;
    totalforce_dds_Request_free(&taken->request, DDS_FREE_CONTENTS);
    totalforce_dds_JointTorques_free(&taken->torques, DDS_FREE_CONTENTS);
    free(taken->reply);
    free(taken);
}

void tfa_dds_free_samples(tfa_dds *gateway)
{
    for (dds_taken *taken = gateway->free_samples, *next; taken != NULL; taken = next) {
        next = taken->next;
        tfa_dds_free_sample(taken);
    }
}

/* ---- requests; the robot is locked ---- */

static gateway_stamps stamps_of(const dds_pending *pending)
{
    const int64_t offset = tfa_dds_ros_offset();

    return (gateway_stamps){.id = pending->id,
                            .sent = (uint64_t)(pending->stamp - offset),
                            .received = (uint64_t)(pending->t_received - offset)};
}

/* Answers without computing: hellos and refusals. */
static void reply_immediately(tfa_dds *gateway, const dds_robot *robot, const dds_pending *to,
                              tfa_dds_field_error field_error)
{
    const tfa_worker_call call = {
        .reply = {.status = field_error.status,
                  .field = field_error.field,
                  .index = field_error.index},
        .t_done = (uint64_t)tfa_dds_monotonic(),
    };

    const gateway_stamps stamps = stamps_of(to);

    tfa_dds_answer(gateway, robot, to, &call);
    if (field_error.status != TFA_OK) /* no hello */
        gateway_count(&robot->own, TFA_SOURCE_DDS, NULL, &stamps, &call);
}

/* Memory for a reply, beside the sample. Once it holds the largest reply that is asked for, nothing
 * is allocated any more. */
static int reserve_reply(dds_taken *taken, size_t bytes)
{
    const size_t pages = (bytes + PAGE_BYTES - 1) / PAGE_BYTES * PAGE_BYTES;

    if (bytes <= taken->reply_bytes)
        return TFA_OK;
    free(taken->reply);
    taken->reply = aligned_alloc(TFA_CACHE_LINE, pages);
    taken->reply_bytes = taken->reply != NULL ? pages : 0;
    if (taken->reply == NULL)
        return TFA_E_MEMORY;
    memset(taken->reply, 0, pages); /* no byte of other memory leaves the daemon */
    return TFA_OK;
}

/* Buffers for the answers to a request, beside its sample. @return TFA_OK; why there are none */
static tfa_dds_field_error lay_out_reply(const dds_robot *robot, const tfa_request *request,
                                         const tfa_wire_reply_shape *shape, dds_taken *taken,
                                         tfa_reply *reply)
{
    tfa_dds_field_error error = {.status = TFA_OK};

    *reply = (tfa_reply){.status = TFA_OK};
    error.status = tfa_wire_check_reply_shape(&robot->shape, shape, &error.field);
    if (error.status != TFA_OK)
        error.index = tfa_wire_refused_index(request, error.field);
    else
        error.status = reserve_reply(taken, tfa_wire_reply_bytes(&robot->shape, shape));
    if (error.status == TFA_OK)
        tfa_wire_reply_buffers(&robot->shape, shape, taken->reply, reply);
    return error;
}

static void solve_here(tfa_dds *gateway, dds_robot *robot, tfa_request *request,
                       const dds_pending *pending, dds_taken *taken, tfa_cost *cost)
{
    const gateway_stamps stamps = stamps_of(pending);
    tfa_worker_call call;
    const tfa_dds_field_error error =
        lay_out_reply(robot, request, &pending->reply_shape, taken, &call.reply);

    if (error.status != TFA_OK) {
        reply_immediately(gateway, robot, pending, error);
        return;
    }
    (void)gateway_solve(&robot->own, request, &stamps, &call);
    tfa_cost_record(cost, &call.reply, 0, request->count, call.t_done - call.t_start);
    tfa_dds_answer(gateway, robot, pending, &call);
    gateway_count(&robot->own, TFA_SOURCE_DDS, request, &stamps, &call);
}

/* The sample changes places with the one of the slot: the request's arrays stay where they are. */
static void send_to_worker(tfa_dds *gateway, dds_robot *robot, const tfa_request *request,
                           const dds_pending *pending, dds_taken **taken)
{
    dds_slot *slot = tfa_dds_ring_next(robot->ring);
    tfa_dds_field_error error = {.status = TFA_E_AGAIN};

    if (slot != NULL)
        error = lay_out_reply(robot, request, &pending->reply_shape, *taken, &slot->call.reply);
    if (error.status != TFA_OK) {
        reply_immediately(gateway, robot, pending, error);
        return;
    }
    dds_taken *const other = slot->taken;
    slot->taken = *taken;
    *taken = other;
    slot->to = *pending;
    slot->call.request = *request;
    slot->call.deadline =
        pending->deadline != 0 ? (uint64_t)(pending->deadline - tfa_dds_ros_offset()) : 0;
    robot->stream_under_way += pending->is_stream;
    tfa_dds_ring_send(robot->ring);
    tfa_dds_increment(&gateway->count->handovers);
    pthread_mutex_lock(&gateway->mutex);
    gateway->under_way++;
    pthread_cond_signal(&gateway->handover);
    pthread_mutex_unlock(&gateway->mutex);
}

/* A kind that was not measured may be long: its clients choose among thousands of kinds. */
static bool is_short(const dds_robot *robot, const tfa_request *request, const tfa_cost *cost)
{
    const uint32_t limit = robot->own.solver.max_state_ns; /* beyond, the worker refuses it */
    const uint32_t most = limit && limit < DIRECT_NS ? limit : DIRECT_NS;
    if (cost->state_ns == 0)
        return request->count == 1 && tfa_cost_bound(robot->own.solver.parts, request) <= most;
    return request->count <= tfa_cost_states(cost, most) && cost->state_ns <= most;
}

/* A request that fits the robot. */
static void serve(tfa_dds *gateway, dds_robot *robot, tfa_request *request, dds_pending *pending,
                  dds_taken **taken)
{
    tfa_cost *cost = tfa_cost_find(&robot->costs, tfa_cost_kind(request));

    if (robot->leaving || robot->ring == NULL)
        reply_immediately(gateway, robot, pending, (tfa_dds_field_error){.status = TFA_E_AGAIN});
    else if (is_short(robot, request, cost) &&
             !(pending->is_stream && robot->stream_under_way > 0)) /* answers stay in order */
        solve_here(gateway, robot, request, pending, *taken, cost);
    else
        send_to_worker(gateway, robot, request, pending, taken);
}

static void handle(tfa_dds *gateway, dds_robot *robot, dds_pending *pending, dds_taken **taken)
{
    const totalforce_dds_Request *sample = &(*taken)->request;
    tfa_dds_field_error field_error = {.status = TFA_OK};
    tfa_request request;

    if (!pending->is_stream && sample->op == totalforce_dds_OP_HELLO) {
        reply_immediately(gateway, robot, pending, field_error);
        return;
    }
    if (pending->deadline != 0 && pending->t_received > pending->deadline)
        field_error.status = TFA_E_LATE;
    else if (pending->is_stream)
        (void)tfa_dds_torques_view(&(*taken)->torques, &robot->shape, &request, &field_error);
    else
        (void)tfa_dds_request_view(sample, &robot->shape, &request, &field_error);
    if (field_error.status != TFA_OK) {
        reply_immediately(gateway, robot, pending, field_error);
        return;
    }
    pending->reply_shape = tfa_wire_reply_shape_of(&robot->shape, &request);
    serve(gateway, robot, &request, pending, taken);
}

/* ---- listeners ---- */

static void handle_locked(tfa_dds *gateway, const char *name, dds_pending *pending,
                          dds_taken **taken)
{
    dds_robot *robot = tfa_dds_find_robot(gateway, name);

    if (robot == NULL)
        return;
    pthread_mutex_lock(&robot->mutex);
    const int64_t now = tfa_dds_monotonic();
    tfa_dds_tick_election(gateway, robot, now);
    if (!robot->electing || !tfa_election_may_answer(&robot->election, now)) {
        tfa_dds_increment(&gateway->count->standby); /* another daemon answers */
    } else {
        pending->epoch = robot->election.self.epoch;
        tfa_shared_robot *statistics = robot->own.statistics;
        if (statistics != NULL)
            atomic_store_explicit(pending->is_stream ? &statistics->dds_torques
                                                     : &statistics->dds_request,
                                  (uint64_t)now, memory_order_relaxed);
        handle(gateway, robot, pending, taken);
    }
    pthread_mutex_unlock(&robot->mutex);
}

void tfa_dds_on_request(dds_entity_t reader, void *arg)
{
    tfa_dds *gateway = arg;
    dds_taken *taken = borrow_sample(gateway);
    dds_sample_info_t info;

    while (taken != NULL && dds_take(reader, (void *[]){&taken->request}, &info, 1, 1) > 0) {
        const totalforce_dds_Request *sample = &taken->request;
        if (!info.valid_data)
            continue;
        tfa_dds_increment(&gateway->count->requests);
        dds_pending pending = {
            .id = sample->id, .stamp = sample->stamp, .t_received = tfa_dds_ros_time()};
        if (sample->deadline_us != 0)
            pending.deadline = sample->stamp + INT64_C(1000) * sample->deadline_us;
        memcpy(pending.client, sample->client, sizeof pending.client);
        handle_locked(gateway, sample->robot, &pending, &taken);
    }
    if (taken != NULL)
        return_sample(gateway, taken);
}

void tfa_dds_on_torques(dds_entity_t reader, void *arg)
{
    tfa_dds *gateway = arg;
    dds_taken *taken = borrow_sample(gateway);
    dds_sample_info_t info;

    while (taken != NULL && dds_take(reader, (void *[]){&taken->torques}, &info, 1, 1) > 0) {
        const totalforce_dds_JointTorques *sample = &taken->torques;
        if (!info.valid_data)
            continue;
        tfa_dds_increment(&gateway->count->torques);
        dds_pending pending = {.is_stream = true,
                               .id = sample->seq,
                               .stamp = sample->stamp,
                               .t_received = tfa_dds_ros_time()};
        if (gateway->max_age_ns != 0)
            pending.deadline = sample->stamp + gateway->max_age_ns;
        handle_locked(gateway, sample->robot, &pending, &taken);
    }
    if (taken != NULL)
        return_sample(gateway, taken);
}
