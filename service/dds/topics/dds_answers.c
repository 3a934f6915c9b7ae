/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The DDS gateway: from answers to samples; and the dds thread, which writes those of the worker.
 */
#include "dds/topics/dds_internal.h"

#include <string.h>

#define ANSWER_WAIT_NS 500000 /* while it waits for one robot, others may become ready, too */
#define STOP_NS 500000000     /* requests without an answer by then stay unanswered */

static dds_return_t write_reply(tfa_dds *gateway, const dds_robot *robot, const dds_pending *to,
                                const tfa_worker_call *call)
{
    const int64_t offset = tfa_dds_ros_offset();
    totalforce_dds_Reply sample = {
        .id = to->id,
        .epoch = to->epoch,
        .stamp = to->stamp,
        .t_received = to->t_received,
        .t_start = call->t_start != 0 ? (int64_t)call->t_start + offset : 0,
        .t_done = (int64_t)call->t_done + offset,
    };

    memcpy(sample.robot, robot->name, sizeof sample.robot);
    memcpy(sample.client, to->client, sizeof sample.client);
    tfa_dds_set_hash(sample.model_hash, tfa_dds_hash_of(robot, call->reply.model),
                     call->reply.model);
    tfa_dds_reply_fill(&call->reply, &robot->shape, &to->reply_shape, &sample);
    return dds_write(gateway->reply_writer, &sample);
}

static dds_return_t write_accelerations(tfa_dds *gateway, const dds_robot *robot,
                                        const dds_pending *to, const tfa_worker_call *call)
{
    totalforce_dds_JointAccelerations sample = {
        .seq = to->id,
        .epoch = to->epoch,
        .stamp = to->stamp,
        .t_done = (int64_t)call->t_done + tfa_dds_ros_offset(),
    };

    memcpy(sample.robot, robot->name, sizeof sample.robot);
    tfa_dds_set_hash(sample.model_hash, tfa_dds_hash_of(robot, call->reply.model),
                     call->reply.model);
    tfa_dds_accelerations_fill(&call->reply, &robot->shape, &sample);
    return dds_write(gateway->accelerations_writer, &sample);
}

void tfa_dds_answer(tfa_dds *gateway, const dds_robot *robot, const dds_pending *to,
                    const tfa_worker_call *call)
{
    const dds_return_t code = to->is_stream ? write_accelerations(gateway, robot, to, call)
                                            : write_reply(gateway, robot, to, call);

    tfa_dds_increment(code == DDS_RETCODE_OK ? &gateway->count->replies : &gateway->count->dropped);
    if (!tfa_wire_has_answers(call->reply.status))
        tfa_dds_increment(&gateway->count->rejected);
    if (call->reply.status == TFA_E_LATE)
        tfa_dds_increment(&gateway->count->late);
}

/* ---- the dds thread ---- */

/* A kind of request that turns out to be short is answered in the receiving thread from now on. */
static void record_cost(dds_robot *robot, const tfa_worker_call *call)
{
    tfa_cost_record(tfa_cost_find(&robot->costs, tfa_cost_kind(&call->request)), &call->reply, 0,
                    call->request.count, call->t_done - call->t_start);
}

/* Writes the answers of a robot that are there. @return how many */
static uint32_t write_ready(tfa_dds *gateway, dds_robot *robot)
{
    uint32_t written = 0;

    for (dds_slot *slot; (slot = tfa_dds_ring_oldest(robot->ring)) != NULL; written++) {
        tfa_dds_answer(gateway, robot, &slot->to, &slot->call);
        robot->stream_under_way -= slot->to.is_stream;
        record_cost(robot, &slot->call);
        gateway_publish_state(&robot->own, &slot->call.request, &slot->call);
        tfa_dds_ring_release(robot->ring);
    }
    return written;
}

/* The same for all robots. @return one that still has requests under way: its ring stays until this
 * thread has released the last of them */
static const dds_robot *write_all_ready(tfa_dds *gateway, uint32_t *written)
{
    const dds_robot *waiting = NULL;

    *written = 0;
    for (uint32_t i = 0; i < gateway->robot_count; i++) {
        dds_robot *robot = &gateway->robots[i];
        pthread_mutex_lock(&robot->mutex);
        if (robot->ring != NULL) {
            *written += write_ready(gateway, robot);
            waiting = tfa_dds_ring_is_empty(robot->ring) ? waiting : robot;
        }
        pthread_mutex_unlock(&robot->mutex);
    }
    return waiting;
}

/* Waits for a request that goes to the worker. @return false: the gateway stops */
static bool await_handover(tfa_dds *gateway, uint32_t written)
{
    pthread_mutex_lock(&gateway->mutex);
    gateway->under_way -= written;
    while (gateway->under_way == 0 && !gateway->stopping)
        pthread_cond_wait(&gateway->handover, &gateway->mutex);
    const bool stopping = gateway->stopping;
    pthread_mutex_unlock(&gateway->mutex);
    return !stopping;
}

void *tfa_dds_thread(void *arg)
{
    tfa_dds *gateway = arg;
    int64_t stop = 0;
    uint32_t written = 0;

    for (;;) {
        if (!await_handover(gateway, written) && stop == 0)
            stop = tfa_dds_monotonic() + STOP_NS;
        const dds_robot *waiting = write_all_ready(gateway, &written);
        if (stop != 0 && (waiting == NULL || tfa_dds_monotonic() > stop))
            return NULL;
        if (waiting != NULL)
            tfa_dds_ring_wait(waiting->ring, ANSWER_WAIT_NS);
    }
}
