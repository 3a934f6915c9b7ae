/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The DDS gateway of the daemon: joins the domain, opens and closes.
 */
#include "dds_internal.h"

#include "dds_domain.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#define DEFAULT_SLOTS 16
#define DEFAULT_LEASE_MS 200
/* A listener that takes longer delays the samples of others: about what waking a thread costs. */
#define DEFAULT_DIRECT_NS 50000
/* Samples of this size are taken whatever the robots: discovery of large domains is small. */
#define SAMPLE_BYTES_MIN 65536

static char last_error[192];

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

/* Remembers the failure. @return whether `entity_or_code` is a failure */
static bool failed(dds_return_t entity_or_code, const char *step)
{
    if (entity_or_code >= 0)
        return false;
    snprintf(last_error, sizeof last_error, "%s: %s%s", step, dds_strretcode(entity_or_code),
             entity_or_code == DDS_RETCODE_NOT_ALLOWED_BY_SECURITY
                 ? ": the permissions of this identity (CYCLONEDDS_URI) do not let it serve robots"
                 : "");
    return true;
}

/* ---- create ---- */

static int make_robots(tfa_dds *gateway, const tfa_dds_options *options)
{
    gateway->robots = calloc(options->robot_count, sizeof *gateway->robots);
    if (gateway->robots == NULL)
        return TFA_E_MEMORY;
    gateway->robot_count = options->robot_count;
    for (uint32_t i = 0; i < options->robot_count; i++)
        pthread_mutex_init(&gateway->robots[i].mutex, NULL);
    for (uint32_t i = 0; i < options->robot_count; i++) {
        const tfa_robot *from = &options->robots[i];
        dds_robot *robot = &gateway->robots[i];

        if (!tfa_dds_set_robot(robot->name, from->name)) {
            snprintf(last_error, sizeof last_error, "robot %u: a name has 1 to %d bytes", i,
                     totalforce_dds_ROBOT_NAME_MAX);
            return TFA_E_ARGUMENT;
        }
        robot->index = i;
        robot->statistics = options->statistics ? &options->statistics[i] : NULL;
        robot->state = options->states ? &options->states[i] : NULL;
        robot->shape.max_batch = from->shape.max_batch > 0 ? from->shape.max_batch : 1;
        robot->shape.max_tips = from->shape.max_tips > 0 ? from->shape.max_tips : TFA_MAX_TIPS;
        tfa_dds_set_model(robot, from->model);
    }
    return TFA_OK;
}

static dds_entity_t make_writer(const tfa_dds *gateway, tfa_dds_topic topic)
{
    return tfa_dds_create_writer(gateway->participant, gateway->topics[topic], topic, NULL);
}

/* The largest sample that means anything to the robots, with room for names and lists. */
static size_t largest_sample(const tfa_dds *gateway, size_t least)
{
    size_t most = least > SAMPLE_BYTES_MIN ? least : SAMPLE_BYTES_MIN;

    for (uint32_t i = 0; i < gateway->robot_count; i++) {
        const tfa_wire_shape *shape = &gateway->robots[i].shape;
        const size_t request = 2 * tfa_wire_request_capacity(shape);
        const size_t reply = 2 * tfa_wire_reply_capacity(shape);
        most = request > most ? request : most;
        most = reply > most ? reply : most;
    }
    return most;
}

static int make_domain(tfa_dds *gateway, const tfa_dds_options *options)
{
    gateway->domain = tfa_dds_make_domain(options->domain, options->settings,
                                          largest_sample(gateway, options->sample_bytes));
    return failed(gateway->domain, "domain (a bad CYCLONEDDS_URI?)") ? TFA_E_SYSTEM : TFA_OK;
}

/* Samples about other robots leave no instance behind. */
static dds_return_t set_filter(const tfa_dds *gateway, tfa_dds_topic topic,
                               dds_topic_filter_sample_arg_fn is_ours)
{
    const struct dds_topic_filter ours = {.mode = DDS_TOPIC_FILTER_SAMPLE_ARG,
                                          .f.sample_arg = is_ours,
                                          .arg = (void *)(uintptr_t)gateway};

    return dds_set_topic_filter_extended(gateway->topics[topic], &ours);
}

static dds_return_t set_leader_filter(const tfa_dds *gateway)
{
    const struct dds_topic_filter ours = {.mode = DDS_TOPIC_FILTER_SAMPLE_SAMPLEINFO_ARG,
                                          .f.sample_sampleinfo_arg = tfa_dds_leader_is_ours,
                                          .arg = (void *)(uintptr_t)gateway};

    return dds_set_topic_filter_extended(gateway->topics[TFA_DDS_LEADER], &ours);
}

/* Everything but the readers of requests and torques, which open the gateway. */
static int make_entities(tfa_dds *gateway, uint32_t domain)
{
    gateway->participant = dds_create_participant(domain, NULL, NULL);
    if (failed(gateway->participant, "participant (a bad CYCLONEDDS_URI? no free index?)"))
        return TFA_E_SYSTEM;
    for (tfa_dds_topic i = TFA_DDS_ROBOT_INFO; i < TFA_DDS_TOPIC_COUNT; i++) {
        gateway->topics[i] = tfa_dds_create_topic(gateway->participant, i);
        if (failed(gateway->topics[i], "topic"))
            return TFA_E_SYSTEM;
    }
    gateway->info_writer = make_writer(gateway, TFA_DDS_ROBOT_INFO);
    gateway->reply_writer = make_writer(gateway, TFA_DDS_REPLY);
    gateway->leader_writer = tfa_dds_create_leader_writer(
        gateway->participant, gateway->topics[TFA_DDS_LEADER], gateway->lease_ns);
    if (failed(set_filter(gateway, TFA_DDS_REQUEST, tfa_dds_request_is_ours), "filter") ||
        failed(set_filter(gateway, TFA_DDS_TORQUES, tfa_dds_torques_are_ours), "filter") ||
        failed(set_leader_filter(gateway), "filter") ||
        failed(gateway->leader_writer, "leader writer") ||
        failed(gateway->info_writer, "robot_info writer") ||
        failed(gateway->reply_writer, "reply writer"))
        return TFA_E_SYSTEM;
    if (gateway->streaming) {
        gateway->accelerations_writer = make_writer(gateway, TFA_DDS_ACCELERATIONS);
        if (failed(gateway->accelerations_writer, "joint_accelerations writer"))
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
    tfa_dds *gateway = calloc(1, sizeof *gateway);
    if (gateway == NULL)
        return TFA_E_MEMORY;
    pthread_mutex_init(&gateway->mutex, NULL);
    pthread_cond_init(&gateway->handover, NULL);
    sem_init(&gateway->leader_stop, 0, 0);
    gateway->slots = options->slots > 0 ? options->slots : DEFAULT_SLOTS;
    gateway->direct_ns = options->direct_ns > 0 ? options->direct_ns : DEFAULT_DIRECT_NS;
    gateway->notice = options->notice;
    gateway->count = options->messages ? options->messages : &gateway->own;
    gateway->lease_ns =
        INT64_C(1000000) * (options->lease_ms > 0 ? options->lease_ms : DEFAULT_LEASE_MS);
    gateway->priority = options->priority;
    gateway->max_age_ns = INT64_C(1000) * options->max_age_us;
    gateway->streaming = !options->no_streaming;

    int status = make_robots(gateway, options);
    if (status == TFA_OK)
        status = make_domain(gateway, options);
    if (status == TFA_OK)
        status = make_entities(gateway, options->domain);
    if (status == TFA_OK)
        *result = gateway;
    else
        tfa_dds_stop(gateway);
    return status;
}

/* ---- start ---- */

static dds_entity_t make_listening_reader(tfa_dds *gateway, tfa_dds_topic topic,
                                          dds_on_data_available_fn on_data)
{
    dds_listener_t *listener = dds_create_listener(gateway);

    if (listener == NULL)
        return DDS_RETCODE_OUT_OF_RESOURCES;
    dds_lset_data_available(listener, on_data);
    const dds_entity_t reader =
        tfa_dds_create_reader(gateway->participant, gateway->topics[topic], topic, listener);
    dds_delete_listener(listener);
    return reader;
}

static int start_elections(tfa_dds *gateway)
{
    dds_guid_t guid;

    if (failed(dds_get_guid(gateway->participant, &guid), "participant"))
        return TFA_E_SYSTEM;
    const dds_entity_t reader = make_listening_reader(gateway, TFA_DDS_LEADER, tfa_dds_on_leader);
    pthread_mutex_lock(&gateway->mutex);
    gateway->leader_reader = reader;
    pthread_mutex_unlock(&gateway->mutex);
    if (failed(reader, "leader reader"))
        return TFA_E_SYSTEM;
    tfa_dds_begin_elections(gateway, guid.v);
    const int code = pthread_create(&gateway->leader_thread, NULL, tfa_dds_leader_thread, gateway);
    if (code != 0) {
        snprintf(last_error, sizeof last_error, "leader thread: %s", strerror(code));
        return TFA_E_SYSTEM;
    }
    gateway->leader_running = true;
    (void)pthread_setname_np(gateway->leader_thread, "tfa-leader");
    return TFA_OK;
}

/* The elections begin last: the leader announces the robots, and a client that sees one finds its
 * topics. */
static int open_gateway(tfa_dds *gateway)
{
    if (gateway->streaming) {
        gateway->torques_reader =
            make_listening_reader(gateway, TFA_DDS_TORQUES, tfa_dds_on_torques);
        if (failed(gateway->torques_reader, "joint_torques reader"))
            return TFA_E_SYSTEM;
    }
    gateway->request_reader = make_listening_reader(gateway, TFA_DDS_REQUEST, tfa_dds_on_request);
    if (failed(gateway->request_reader, "request reader"))
        return TFA_E_SYSTEM;
    return start_elections(gateway);
}

int tfa_dds_start(tfa_dds *gateway, struct tfa_worker *worker, const tfa_worker_robot *solvers)
{
    gateway->worker = worker;
    for (uint32_t i = 0; i < gateway->robot_count; i++) {
        dds_robot *robot = &gateway->robots[i];
        robot->solver = solvers[i];
        robot->memory = tfa_dds_reply_memory(robot);
        if (robot->memory == NULL)
            return TFA_E_MEMORY;
        const int status = tfa_dds_ring_open(worker, robot, gateway->slots, &robot->ring);
        if (status != TFA_OK)
            return status;
    }
    const int code = pthread_create(&gateway->thread, NULL, tfa_dds_thread, gateway);
    if (code != 0) {
        snprintf(last_error, sizeof last_error, "dds thread: %s", strerror(code));
        return TFA_E_SYSTEM;
    }
    gateway->running = true;
    (void)pthread_setname_np(gateway->thread, "tfa-dds");
    return open_gateway(gateway);
}

/* ---- stop ---- */

/* No new requests; those under way are answered: the worker still runs. */
static void close_gateway(tfa_dds *gateway)
{
    if (gateway->leader_reader > 0)
        (void)dds_delete(gateway->leader_reader);
    tfa_dds_resign_all(gateway);
    if (gateway->torques_reader > 0)
        (void)dds_delete(gateway->torques_reader); /* waits for a listener at work */
    if (gateway->request_reader > 0)
        (void)dds_delete(gateway->request_reader);
    pthread_mutex_lock(&gateway->mutex);
    gateway->stopping = true;
    pthread_cond_signal(&gateway->handover);
    pthread_mutex_unlock(&gateway->mutex);
    pthread_join(gateway->thread, NULL);
    (void)dds_wait_for_acks(gateway->reply_writer, DDS_MSECS(100));
}

void tfa_dds_stop(tfa_dds *gateway)
{
    if (gateway == NULL)
        return;
    if (gateway->running)
        close_gateway(gateway);
    if (gateway->participant > 0)
        (void)dds_delete(gateway->participant);
    if (gateway->domain > 0)
        (void)dds_delete(gateway->domain);
    for (uint32_t i = 0; gateway->robots != NULL && i < gateway->robot_count; i++) {
        tfa_dds_ring_close(gateway->robots[i].ring);
        free(gateway->robots[i].memory);
        pthread_mutex_destroy(&gateway->robots[i].mutex);
    }
    free(gateway->robots);
    tfa_dds_free_samples(gateway);
    sem_destroy(&gateway->leader_stop);
    pthread_cond_destroy(&gateway->handover);
    pthread_mutex_destroy(&gateway->mutex);
    free(gateway);
}

tfa_dds_statistics tfa_dds_count(const tfa_dds *gateway)
{
#define READ(counter) atomic_load_explicit(&gateway->count->counter, memory_order_relaxed)
    return (tfa_dds_statistics){READ(requests),
                                READ(torques),
                                READ(replies),
                                READ(rejected),
                                READ(late),
                                READ(unknown),
                                READ(dropped),
                                READ(handovers),
                                READ(standby),
                                READ(request_writers),
                                READ(reply_readers),
                                READ(torque_writers),
                                READ(acceleration_readers)};
#undef READ
}
