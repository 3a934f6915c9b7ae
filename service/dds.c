/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The DDS door of the daemon: joins the domain, opens and closes.
 */
#include "dds_internal.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#define DEFAULT_SLOTS 16
#define DEFAULT_SPIN_NS 50000

#define STOP_NS 500000000 /* what the worker has not answered by then, it will not answer */

static char last_error[128];

int64_t tfa_dds_monotonic(void)
{
    struct timespec now;

    clock_gettime(CLOCK_MONOTONIC, &now);
    return (int64_t)now.tv_sec * 1000000000 + now.tv_nsec;
}

const char *tfa_dds_error(void)
{
    return last_error;
}

/* Remembers what failed. @return whether `entity_or_code` is a failure */
static bool failed(dds_return_t entity_or_code, const char *step)
{
    if (entity_or_code >= 0)
        return false;
    snprintf(last_error, sizeof last_error, "%s: %s", step, dds_strretcode(entity_or_code));
    return true;
}

/* ---- create ---- */

static int make_robots(tfa_dds *door, const tfa_dds_options *options)
{
    door->robots = calloc(options->robot_count, sizeof *door->robots);
    if (door->robots == NULL)
        return TFA_E_MEMORY;
    door->robot_count = options->robot_count;
    for (uint32_t i = 0; i < options->robot_count; i++) {
        const tfa_dds_robot *from = &options->robots[i];
        dds_robot *robot = &door->robots[i];

        if (from->name == NULL || !tfa_dds_set_robot(robot->name, from->name)) {
            snprintf(last_error, sizeof last_error, "robot %u: a name has 1 to %d bytes", i,
                     totalforce_dds_ROBOT_NAME_MAX);
            return TFA_E_ARGUMENT;
        }
        robot->index = i;
        robot->shape.max_batch = from->max_batch > 0 ? from->max_batch : 1;
        tfa_dds_adopt(robot, from->model);
        robot->pending = calloc(door->slots, sizeof *robot->pending);
        if (robot->pending == NULL)
            return TFA_E_MEMORY;
    }
    return TFA_OK;
}

static dds_entity_t make_writer(const tfa_dds *door, tfa_dds_topic topic)
{
    return tfa_dds_create_writer(door->participant, door->topics[topic], topic, NULL);
}

/* Everything but the readers of requests and torques, which open the door. */
static int make_entities(tfa_dds *door, uint32_t domain)
{
    door->participant = dds_create_participant(domain, NULL, NULL);
    if (failed(door->participant, "participant (a bad CYCLONEDDS_URI? no free index?)"))
        return TFA_E_SYSTEM;
    for (tfa_dds_topic i = TFA_DDS_ROBOT_INFO; i <= TFA_DDS_ACCELERATIONS; i++) {
        door->topics[i] = tfa_dds_create_topic(door->participant, i);
        if (failed(door->topics[i], "topic"))
            return TFA_E_SYSTEM;
    }
    door->info_writer = make_writer(door, TFA_DDS_ROBOT_INFO);
    door->info_reader = tfa_dds_create_reader(door->participant, door->topics[TFA_DDS_ROBOT_INFO],
                                              TFA_DDS_ROBOT_INFO, NULL);
    door->reply_writer = make_writer(door, TFA_DDS_REPLY);
    if (failed(door->info_writer, "robot_info writer") ||
        failed(door->info_reader, "robot_info reader") ||
        failed(door->reply_writer, "reply writer"))
        return TFA_E_SYSTEM;
    if (door->streaming) {
        door->accelerations_writer = make_writer(door, TFA_DDS_ACCELERATIONS);
        if (failed(door->accelerations_writer, "joint_accelerations writer"))
            return TFA_E_SYSTEM;
    }
    return TFA_OK;
}

int tfa_dds_create(const tfa_dds_options *options, tfa_dds **result)
{
    *result = NULL;
    last_error[0] = '\0';
    if (options->robot_count == 0)
        return TFA_E_ARGUMENT;
    tfa_dds *door = calloc(1, sizeof *door);
    if (door == NULL)
        return TFA_E_MEMORY;
    pthread_mutex_init(&door->mutex, NULL);
    pthread_cond_init(&door->handover, NULL);
    door->slots = options->slots > 0 ? options->slots : DEFAULT_SLOTS;
    door->spin_ns = options->spin_ns > 0 ? options->spin_ns : DEFAULT_SPIN_NS;
    door->streaming = !options->no_streaming;

    int status = make_robots(door, options);
    if (status == TFA_OK)
        status = make_entities(door, options->domain);
    if (status == TFA_OK)
        *result = door;
    else
        tfa_dds_stop(door);
    return status;
}

/* ---- start ---- */

static dds_entity_t make_listening_reader(tfa_dds *door, tfa_dds_topic topic,
                                          dds_on_data_available_fn on_data)
{
    dds_listener_t *listener = dds_create_listener(door);

    if (listener == NULL)
        return DDS_RETCODE_OUT_OF_RESOURCES;
    dds_lset_data_available(listener, on_data);
    const dds_entity_t reader =
        tfa_dds_create_reader(door->participant, door->topics[topic], topic, listener);
    dds_delete_listener(listener);
    return reader;
}

/* The robots are announced last: who sees one finds the topics behind it. */
static int open_door(tfa_dds *door)
{
    if (door->streaming) {
        door->torques_reader = make_listening_reader(door, TFA_DDS_TORQUES, tfa_dds_on_torques);
        if (failed(door->torques_reader, "joint_torques reader"))
            return TFA_E_SYSTEM;
    }
    door->request_reader = make_listening_reader(door, TFA_DDS_REQUEST, tfa_dds_on_request);
    if (failed(door->request_reader, "request reader"))
        return TFA_E_SYSTEM;
    for (uint32_t i = 0; i < door->robot_count; i++)
        if (failed(tfa_dds_write_info(door, &door->robots[i]), "robot_info"))
            return TFA_E_SYSTEM;
    return TFA_OK;
}

int tfa_dds_start(tfa_dds *door, struct tfa_worker *worker)
{
    door->worker = worker;
    for (uint32_t i = 0; i < door->robot_count; i++) {
        dds_robot *robot = &door->robots[i];
        const int status = tfa_dds_ring_open(worker, robot, door->slots, &robot->ring);
        if (status != TFA_OK)
            return status;
    }
    const int code = pthread_create(&door->thread, NULL, tfa_dds_thread, door);
    if (code != 0) {
        snprintf(last_error, sizeof last_error, "dds thread: %s", strerror(code));
        return TFA_E_SYSTEM;
    }
    door->running = true;
    (void)pthread_setname_np(door->thread, "tfa-dds");
    return open_door(door);
}

/* ---- stop ---- */

/* No new requests; those under way are answered: the worker still runs. */
static void close_door(tfa_dds *door)
{
    tfa_dds_withdraw_all(door);
    if (door->torques_reader > 0)
        (void)dds_delete(door->torques_reader); /* waits for a listener at work */
    if (door->request_reader > 0)
        (void)dds_delete(door->request_reader);
    pthread_mutex_lock(&door->mutex);
    door->stopping = true;
    door->stop_deadline = tfa_dds_monotonic() + STOP_NS;
    pthread_cond_signal(&door->handover);
    pthread_mutex_unlock(&door->mutex);
    pthread_join(door->thread, NULL);
    (void)dds_wait_for_acks(door->reply_writer, DDS_MSECS(100));
}

void tfa_dds_stop(tfa_dds *door)
{
    if (door == NULL)
        return;
    if (door->running)
        close_door(door);
    if (door->participant > 0)
        (void)dds_delete(door->participant);
    for (uint32_t i = 0; door->robots != NULL && i < door->robot_count; i++) {
        tfa_dds_ring_close(door->robots[i].ring);
        free(door->robots[i].pending);
    }
    free(door->robots);
    pthread_cond_destroy(&door->handover);
    pthread_mutex_destroy(&door->mutex);
    free(door);
}

tfa_dds_counters tfa_dds_count(const tfa_dds *door)
{
#define READ(counter) atomic_load_explicit(&door->count.counter, memory_order_relaxed)
    return (tfa_dds_counters){READ(requests), READ(torques), READ(replies),
                              READ(rejected), READ(dropped), READ(handovers)};
#undef READ
}
