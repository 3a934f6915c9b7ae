/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The DDS gateway at work: samples become requests in the worker's ring, answers become samples.
 *
 * Latency first: Cyclone's receiving thread calls a listener, which puts the request into the ring,
 * spins for the answer and writes the reply itself, so that no thread is woken on the way (a
 * wake-up costs 23 us and more, the answer of a small robot takes 1). An answer that takes longer
 * than spin_ns is handed over to the dds thread.
 */
#include "dds_internal.h"

#include <string.h>

#define SAMPLES_PER_TAKE 8
#define ANSWER_WAIT_NS 500000 /* while it waits for one robot, others may become ready, too */

static void increment(_Atomic uint64_t *counter)
{
    atomic_fetch_add_explicit(counter, 1, memory_order_relaxed);
}

static dds_robot *find_robot(const tfa_dds *gateway, const char *name)
{
    for (uint32_t i = 0; i < gateway->robot_count; i++)
        if (strcmp(gateway->robots[i].name, name) == 0)
            return &gateway->robots[i];
    return NULL;
}

/* ---- answers ---- */

static void count_written(tfa_dds *gateway, dds_return_t code, int32_t status)
{
    increment(code == DDS_RETCODE_OK ? &gateway->count.replies : &gateway->count.dropped);
    if (!tfa_dds_status_has_answers(status))
        increment(&gateway->count.rejected);
}

static dds_return_t write_reply(tfa_dds *gateway, const dds_robot *robot, const dds_pending *to,
                                const dds_ring_answer *answer)
{
    const int64_t offset = tfa_dds_ros_offset();
    totalforce_dds_Reply sample = {
        .id = to->id,
        .stamp = to->stamp,
        .t_received = to->t_received,
        .t_start = answer->t_start != 0 ? answer->t_start + offset : 0,
        .t_done = answer->t_done + offset,
    };

    memcpy(sample.robot, robot->name, sizeof sample.robot);
    memcpy(sample.client, to->client, sizeof sample.client);
    tfa_dds_set_hash(sample.model_hash, tfa_dds_hash_of(robot, answer->reply.model),
                     answer->reply.model);
    tfa_dds_reply_fill(&answer->reply, &to->sizes, &sample);
    return dds_write(gateway->reply_writer, &sample);
}

static dds_return_t write_accelerations(tfa_dds *gateway, const dds_robot *robot,
                                        const dds_pending *to, const dds_ring_answer *answer)
{
    totalforce_dds_JointAccelerations sample = {
        .seq = to->id,
        .stamp = to->stamp,
        .t_done = answer->t_done + tfa_dds_ros_offset(),
    };

    memcpy(sample.robot, robot->name, sizeof sample.robot);
    tfa_dds_set_hash(sample.model_hash, tfa_dds_hash_of(robot, answer->reply.model),
                     answer->reply.model);
    tfa_dds_accelerations_fill(&answer->reply, &to->sizes, &sample);
    return dds_write(gateway->accelerations_writer, &sample);
}

static dds_return_t write_answer(tfa_dds *gateway, const dds_robot *robot, const dds_pending *to,
                                 const dds_ring_answer *answer)
{
    return to->is_stream ? write_accelerations(gateway, robot, to, answer)
                         : write_reply(gateway, robot, to, answer);
}

/* Answers without the worker: hellos, and requests that are refused by the gateway. */
static void reply_immediately(tfa_dds *gateway, const dds_robot *robot, const dds_pending *to,
                              tfa_dds_field_error field_error)
{
    const dds_ring_answer answer = {
        .reply = {.status = field_error.status,
                  .field = field_error.field,
                  .index = field_error.index},
        .t_done = tfa_dds_monotonic(),
    };

    count_written(gateway, write_answer(gateway, robot, to, &answer), field_error.status);
}

/* Writes the answers that are there, oldest first. The gateway is locked.
 * @return whether none is under way any more */
static bool write_answers(tfa_dds *gateway, dds_robot *robot)
{
    dds_ring_answer answer;

    while (robot->first != robot->last && tfa_dds_ring_peek(robot->ring, &answer)) {
        const dds_pending *to = &robot->pending[robot->first % gateway->slots];

        count_written(gateway, write_answer(gateway, robot, to, &answer), answer.reply.status);
        tfa_dds_ring_release(robot->ring);
        robot->first++;
    }
    return robot->first == robot->last;
}

/* ---- requests ---- */

/* Spins for the answers under way. @return whether all came in time */
static bool spin_for_answers(tfa_dds *gateway, dds_robot *robot)
{
    const int64_t spin_end = tfa_dds_monotonic() + (int64_t)gateway->spin_ns;

    while (!write_answers(gateway, robot))
        if (tfa_dds_monotonic() > spin_end)
            return false;
    return true;
}

/* Puts a request into the ring and answers it if that is quick. The gateway is locked. */
static int submit(tfa_dds *gateway, dds_robot *robot, const tfa_request *request,
                  const dds_pending *pending)
{
    if (robot->leaving || robot->last - robot->first == gateway->slots)
        return TFA_E_AGAIN;
    const int status = tfa_dds_ring_submit(robot->ring, request);
    if (status != TFA_OK)
        return status;
    robot->pending[robot->last++ % gateway->slots] = *pending;

    if (!robot->handed_over && !spin_for_answers(gateway, robot)) {
        robot->handed_over = true;
        increment(&gateway->count.handovers);
        pthread_cond_signal(&gateway->handover);
    }
    return TFA_OK;
}

/* A request that fits the robot: through the worker, or refused for want of room. */
static void serve(tfa_dds *gateway, dds_robot *robot, const tfa_request *request,
                  dds_pending *pending)
{
    tfa_dds_field_error field_error = {.status = TFA_OK};

    pending->sizes = tfa_dds_sizes_of_reply(request, &robot->shape);
    field_error.status = submit(gateway, robot, request, pending);
    if (field_error.status ==
        TFA_E_SIZE) { /* more answers than a slot holds: ask for fewer states */
        field_error.field = TFA_FIELD_COUNT;
        field_error.index = request->count;
    } else if (field_error.status == TFA_E_UNSUPPORTED) { /* a mass matrix larger than any slot */
        field_error.field = TFA_FIELD_OP;
        field_error.index = (uint32_t)request->op;
    }
    if (field_error.status != TFA_OK)
        reply_immediately(gateway, robot, pending, field_error);
}

/* Silent when another daemon of the domain serves the robot: the question was for that one. */
static void refuse_unknown_robot(tfa_dds *gateway, const char *name, const dds_pending *pending)
{
    dds_robot unknown_robot = {.name = ""};

    if (tfa_dds_served_elsewhere(gateway, name))
        return;
    (void)tfa_dds_set_robot(unknown_robot.name, name);
    reply_immediately(gateway, &unknown_robot, pending,
                      (tfa_dds_field_error){.status = TFA_E_ROBOT});
}

static void handle_request(tfa_dds *gateway, const void *taken)
{
    const totalforce_dds_Request *sample = taken;
    dds_robot *robot = find_robot(gateway, sample->robot);
    dds_pending pending = {
        .id = sample->id, .stamp = sample->stamp, .t_received = tfa_dds_ros_time()};
    tfa_dds_field_error field_error = {.status = TFA_OK};
    tfa_request request;

    memcpy(pending.client, sample->client, sizeof pending.client);
    if (robot == NULL)
        refuse_unknown_robot(gateway, sample->robot, &pending);
    else if (sample->op == totalforce_dds_OP_HELLO ||
             tfa_dds_request_view(sample, &robot->shape, &request, &field_error) != TFA_OK)
        reply_immediately(gateway, robot, &pending, field_error);
    else
        serve(gateway, robot, &request, &pending);
}

static void handle_torques(tfa_dds *gateway, const void *taken)
{
    const totalforce_dds_JointTorques *sample = taken;
    dds_robot *robot = find_robot(gateway, sample->robot);
    dds_pending pending = {.is_stream = true, .id = sample->seq, .stamp = sample->stamp};
    tfa_dds_field_error field_error = {.status = TFA_OK};
    tfa_request request;

    if (robot == NULL)
        refuse_unknown_robot(gateway, sample->robot, &pending);
    else if (tfa_dds_torques_view(sample, &robot->shape, &request, &field_error) != TFA_OK)
        reply_immediately(gateway, robot, &pending, field_error);
    else
        serve(gateway, robot, &request, &pending);
}

/* Takes the samples that are there and hands each on, counted, under the gateway's mutex. */
static void take_samples(tfa_dds *gateway, dds_entity_t reader, _Atomic uint64_t *counter,
                         void (*handle)(tfa_dds *, const void *))
{
    void *samples[SAMPLES_PER_TAKE] = {NULL};
    dds_sample_info_t infos[SAMPLES_PER_TAKE];
    dds_return_t count;

    while ((count = dds_take(reader, samples, infos, SAMPLES_PER_TAKE, SAMPLES_PER_TAKE)) > 0) {
        pthread_mutex_lock(&gateway->mutex);
        for (dds_return_t i = 0; i < count; i++)
            if (infos[i].valid_data) {
                increment(counter);
                handle(gateway, samples[i]);
            }
        pthread_mutex_unlock(&gateway->mutex);
        (void)dds_return_loan(reader, samples, count);
    }
}

void tfa_dds_on_request(dds_entity_t reader, void *arg)
{
    tfa_dds *gateway = arg;
    take_samples(gateway, reader, &gateway->count.requests, handle_request);
}

void tfa_dds_on_torques(dds_entity_t reader, void *arg)
{
    tfa_dds *gateway = arg;
    take_samples(gateway, reader, &gateway->count.torques, handle_torques);
}

/* ---- the dds thread ---- */

/* Writes the answers that are ready of the robots handed over. @return one that still has
 * requests under way */
static const dds_robot *write_handed_over(tfa_dds *gateway)
{
    const dds_robot *waiting = NULL;

    for (uint32_t i = 0; i < gateway->robot_count; i++) {
        dds_robot *robot = &gateway->robots[i];
        if (robot->handed_over && write_answers(gateway, robot))
            robot->handed_over = false;
        if (robot->handed_over)
            waiting = robot;
    }
    return waiting;
}

void *tfa_dds_thread(void *arg)
{
    tfa_dds *gateway = arg;

    pthread_mutex_lock(&gateway->mutex);
    for (;;) {
        const dds_robot *waiting = write_handed_over(gateway);

        if (gateway->stopping && (waiting == NULL || tfa_dds_monotonic() > gateway->stop_deadline))
            break;
        if (waiting == NULL) {
            pthread_cond_wait(&gateway->handover, &gateway->mutex);
            continue;
        }
        const uint64_t oldest = waiting->first;
        pthread_mutex_unlock(&gateway->mutex);
        tfa_dds_ring_wait(waiting->ring, oldest, ANSWER_WAIT_NS);
        pthread_mutex_lock(&gateway->mutex);
    }
    pthread_mutex_unlock(&gateway->mutex);
    return NULL;
}
