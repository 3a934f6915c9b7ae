/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The DDS door at work: samples become requests in the worker's ring, answers become samples.
 *
 * Latency first: Cyclone's receiving thread calls a listener, which puts the request into the ring,
 * spins for the answer and writes the reply itself, so that no thread is woken on the way (a
 * wake-up costs 23 us and more, the answer of a small robot takes 1). What takes longer than
 * spin_ns is handed over to the dds thread.
 */
#include "dds_internal.h"

#include <string.h>

#define TAKE_AT_ONCE 8
#define ANSWER_WAIT_NS 500000 /* while it waits for one robot, others may become ready, too */

static void add_one(_Atomic uint64_t *counter)
{
    atomic_fetch_add_explicit(counter, 1, memory_order_relaxed);
}

static dds_robot *find_robot(const tfa_dds *door, const char *name)
{
    for (uint32_t i = 0; i < door->robot_count; i++)
        if (strcmp(door->robots[i].name, name) == 0)
            return &door->robots[i];
    return NULL;
}

/* ---- answers ---- */

static void count_written(tfa_dds *door, dds_return_t code, int32_t status)
{
    add_one(code == DDS_RETCODE_OK ? &door->count.replies : &door->count.dropped);
    if (!tfa_dds_status_has_answers(status))
        add_one(&door->count.rejected);
}

static dds_return_t write_reply(tfa_dds *door, const dds_robot *robot, const dds_pending *to,
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
    return dds_write(door->reply_writer, &sample);
}

static dds_return_t write_accelerations(tfa_dds *door, const dds_robot *robot,
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
    return dds_write(door->accelerations_writer, &sample);
}

static dds_return_t write_answer(tfa_dds *door, const dds_robot *robot, const dds_pending *to,
                                 const dds_ring_answer *answer)
{
    return to->is_stream ? write_accelerations(door, robot, to, answer)
                         : write_reply(door, robot, to, answer);
}

/* Answers without the worker: hellos, and requests that are refused at the door. */
static void answer_at_once(tfa_dds *door, const dds_robot *robot, const dds_pending *to,
                           tfa_dds_culprit culprit)
{
    const dds_ring_answer answer = {
        .reply = {.status = culprit.status, .field = culprit.field, .index = culprit.index},
        .t_done = tfa_dds_monotonic(),
    };

    count_written(door, write_answer(door, robot, to, &answer), culprit.status);
}

/* Writes the answers that are there, oldest first. The door is locked.
 * @return whether none is under way any more */
static bool write_answers(tfa_dds *door, dds_robot *robot)
{
    dds_ring_answer answer;

    while (robot->first != robot->last && tfa_dds_ring_look(robot->ring, &answer)) {
        const dds_pending *to = &robot->pending[robot->first % door->slots];

        count_written(door, write_answer(door, robot, to, &answer), answer.reply.status);
        tfa_dds_ring_release(robot->ring);
        robot->first++;
    }
    return robot->first == robot->last;
}

/* ---- requests ---- */

/* Spins for the answers under way. @return whether all came in time */
static bool answer_soon(tfa_dds *door, dds_robot *robot)
{
    const int64_t spin_end = tfa_dds_monotonic() + (int64_t)door->spin_ns;

    while (!write_answers(door, robot))
        if (tfa_dds_monotonic() > spin_end)
            return false;
    return true;
}

/* Puts a request into the ring and answers it if that is quick. The door is locked. */
static int submit(tfa_dds *door, dds_robot *robot, const tfa_request *request,
                  const dds_pending *pending)
{
    if (robot->leaving || robot->last - robot->first == door->slots)
        return TFA_E_AGAIN;
    const int status = tfa_dds_ring_submit(robot->ring, request);
    if (status != TFA_OK)
        return status;
    robot->pending[robot->last++ % door->slots] = *pending;

    if (!robot->handed_over && !answer_soon(door, robot)) {
        robot->handed_over = true;
        add_one(&door->count.handovers);
        pthread_cond_signal(&door->handover);
    }
    return TFA_OK;
}

/* A request that fits the robot: through the worker, or refused for want of room. */
static void serve(tfa_dds *door, dds_robot *robot, const tfa_request *request, dds_pending *pending)
{
    tfa_dds_culprit culprit = {.status = TFA_OK};

    pending->sizes = tfa_dds_sizes_of_reply(request, &robot->shape);
    culprit.status = submit(door, robot, request, pending);
    if (culprit.status == TFA_E_SIZE) { /* more answers than a slot holds: ask for fewer states */
        culprit.field = TFA_FIELD_COUNT;
        culprit.index = request->count;
    } else if (culprit.status == TFA_E_UNSUPPORTED) { /* a mass matrix larger than any slot */
        culprit.field = TFA_FIELD_OP;
        culprit.index = (uint32_t)request->op;
    }
    if (culprit.status != TFA_OK)
        answer_at_once(door, robot, pending, culprit);
}

/* Silent when another daemon of the domain serves the robot: the question was for that one. */
static void refuse_stranger(tfa_dds *door, const char *name, const dds_pending *pending)
{
    dds_robot stranger = {.name = ""};

    if (tfa_dds_served_elsewhere(door, name))
        return;
    (void)tfa_dds_set_robot(stranger.name, name);
    answer_at_once(door, &stranger, pending, (tfa_dds_culprit){.status = TFA_E_ROBOT});
}

static void handle_request(tfa_dds *door, const void *taken)
{
    const totalforce_dds_Request *sample = taken;
    dds_robot *robot = find_robot(door, sample->robot);
    dds_pending pending = {
        .id = sample->id, .stamp = sample->stamp, .t_received = tfa_dds_ros_time()};
    tfa_dds_culprit culprit = {.status = TFA_OK};
    tfa_request request;

    memcpy(pending.client, sample->client, sizeof pending.client);
    if (robot == NULL)
        refuse_stranger(door, sample->robot, &pending);
    else if (sample->op == totalforce_dds_OP_HELLO ||
             tfa_dds_request_view(sample, &robot->shape, &request, &culprit) != TFA_OK)
        answer_at_once(door, robot, &pending, culprit);
    else
        serve(door, robot, &request, &pending);
}

static void handle_torques(tfa_dds *door, const void *taken)
{
    const totalforce_dds_JointTorques *sample = taken;
    dds_robot *robot = find_robot(door, sample->robot);
    dds_pending pending = {.is_stream = true, .id = sample->seq, .stamp = sample->stamp};
    tfa_dds_culprit culprit = {.status = TFA_OK};
    tfa_request request;

    if (robot == NULL)
        refuse_stranger(door, sample->robot, &pending);
    else if (tfa_dds_torques_view(sample, &robot->shape, &request, &culprit) != TFA_OK)
        answer_at_once(door, robot, &pending, culprit);
    else
        serve(door, robot, &request, &pending);
}

/* Takes what is there and hands each sample on, counted, under the door's mutex. */
static void take_all(tfa_dds *door, dds_entity_t reader, _Atomic uint64_t *counter,
                     void (*handle)(tfa_dds *, const void *))
{
    void *samples[TAKE_AT_ONCE] = {NULL};
    dds_sample_info_t infos[TAKE_AT_ONCE];
    dds_return_t count;

    while ((count = dds_take(reader, samples, infos, TAKE_AT_ONCE, TAKE_AT_ONCE)) > 0) {
        pthread_mutex_lock(&door->mutex);
        for (dds_return_t i = 0; i < count; i++)
            if (infos[i].valid_data) {
                add_one(counter);
                handle(door, samples[i]);
            }
        pthread_mutex_unlock(&door->mutex);
        (void)dds_return_loan(reader, samples, count);
    }
}

void tfa_dds_on_request(dds_entity_t reader, void *arg)
{
    tfa_dds *door = arg;
    take_all(door, reader, &door->count.requests, handle_request);
}

void tfa_dds_on_torques(dds_entity_t reader, void *arg)
{
    tfa_dds *door = arg;
    take_all(door, reader, &door->count.torques, handle_torques);
}

/* ---- the dds thread ---- */

/* Writes what is ready of the robots handed over. @return one that still has requests under way */
static const dds_robot *look_around(tfa_dds *door)
{
    const dds_robot *waiting = NULL;

    for (uint32_t i = 0; i < door->robot_count; i++) {
        dds_robot *robot = &door->robots[i];
        if (robot->handed_over && write_answers(door, robot))
            robot->handed_over = false;
        if (robot->handed_over)
            waiting = robot;
    }
    return waiting;
}

void *tfa_dds_thread(void *arg)
{
    tfa_dds *door = arg;

    pthread_mutex_lock(&door->mutex);
    for (;;) {
        const dds_robot *waiting = look_around(door);

        if (door->stopping && (waiting == NULL || tfa_dds_monotonic() > door->stop_deadline))
            break;
        if (waiting == NULL) {
            pthread_cond_wait(&door->handover, &door->mutex);
            continue;
        }
        const uint64_t oldest = waiting->first;
        pthread_mutex_unlock(&door->mutex);
        tfa_dds_ring_wait(waiting->ring, oldest, ANSWER_WAIT_NS);
        pthread_mutex_lock(&door->mutex);
    }
    pthread_mutex_unlock(&door->mutex);
    return NULL;
}
