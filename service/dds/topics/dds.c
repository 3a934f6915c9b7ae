/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The DDS gateway of the daemon: joins the domain, opens and closes.
 */
#include "dds/topics/dds_internal.h"

#include "dds/common/ros_domain.h"

#include <stdlib.h>
#include <string.h>

#define DEFAULT_SLOTS 16
/* Samples of this size are taken whatever the robots: discovery of large domains is small. */
#define SAMPLE_BYTES_MIN 65536

/* ---- create ---- */

static int make_robots(tfa_dds *gateway, const gateway_context *c, uint32_t count)
{
    gateway->robots = calloc(count, sizeof *gateway->robots);
    if (gateway->robots == NULL)
        return TFA_E_MEMORY;
    gateway->robot_count = count;
    for (uint32_t i = 0; i < count; i++)
        pthread_mutex_init(&gateway->robots[i].mutex, NULL);
    for (uint32_t i = 0; i < count; i++) {
        const tfa_robot *from = &c->robots[i];
        dds_robot *robot = &gateway->robots[i];

        if (!tfa_dds_set_robot(robot->name, from->name)) {
            tfa_dds_set_error("robot %u: a name has 1 to %d bytes", i,
                              totalforce_dds_ROBOT_NAME_MAX);
            return TFA_E_ARGUMENT;
        }
        robot->index = i;
        robot->own.statistics = c->statistics ? &c->statistics[i] : NULL;
        robot->own.state = c->states ? &c->states[i] : NULL;
        robot->shape.max_batch = from->shape.max_batch > 0 ? from->shape.max_batch : 1;
        robot->shape.max_tips = from->shape.max_tips > 0 ? from->shape.max_tips : TFA_MAX_TIPS;
        tfa_dds_set_model(robot, from->model);
    }
    return TFA_OK;
}

static dds_entity_t make_writer(const tfa_dds *gateway, tfa_dds_topic topic)
{
    return tfa_dds_create_writer(gateway->member.participant, gateway->topics[topic], topic, NULL);
}

/* The largest sample that means anything to the robots, with room for names and lists. */
static size_t largest_sample(const tfa_dds *gateway, bool ros2)
{
    size_t most = ros2 ? TFA_ROS2_SAMPLE_MAX : SAMPLE_BYTES_MIN;

    for (uint32_t i = 0; i < gateway->robot_count; i++) {
        const tfa_wire_shape *shape = &gateway->robots[i].shape;
        const size_t request = 2 * tfa_wire_request_capacity(shape);
        const size_t reply = 2 * tfa_wire_reply_capacity(shape);
        most = request > most ? request : most;
        most = reply > most ? reply : most;
    }
    return most;
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
static int make_entities(tfa_dds *gateway)
{
    for (tfa_dds_topic i = TFA_DDS_ROBOT_INFO; i < TFA_DDS_TOPIC_COUNT; i++) {
        gateway->topics[i] = tfa_dds_create_topic(gateway->member.participant, i);
        if (tfa_dds_failed(gateway->topics[i], "topic"))
            return TFA_E_SYSTEM;
    }
    gateway->info_writer = make_writer(gateway, TFA_DDS_ROBOT_INFO);
    gateway->reply_writer = make_writer(gateway, TFA_DDS_REPLY);
    gateway->leader_writer = tfa_dds_create_leader_writer(
        gateway->member.participant, gateway->topics[TFA_DDS_LEADER], gateway->lease_ns);
    if (tfa_dds_failed(set_filter(gateway, TFA_DDS_REQUEST, tfa_dds_request_is_ours), "filter") ||
        tfa_dds_failed(set_filter(gateway, TFA_DDS_TORQUES, tfa_dds_torques_are_ours), "filter") ||
        tfa_dds_failed(set_leader_filter(gateway), "filter") ||
        tfa_dds_failed(gateway->leader_writer, "leader writer") ||
        tfa_dds_failed(gateway->info_writer, "robot_info writer") ||
        tfa_dds_failed(gateway->reply_writer, "reply writer"))
        return TFA_E_SYSTEM;
    gateway->accelerations_writer = make_writer(gateway, TFA_DDS_ACCELERATIONS);
    return tfa_dds_failed(gateway->accelerations_writer, "joint_accelerations writer")
               ? TFA_E_SYSTEM
               : TFA_OK;
}

/* A writer that keeps all waits for a reader that died until its participant is missed, after 10 s
 * by Cyclone's default; ten leases of the election are longer than any pause that it forgives. */
static int join_domain(tfa_dds *gateway, const config_dds *settings, const char *xml)
{
    const uint32_t leases = 10 * settings->lease_ms;
    const uint32_t ms = leases < 1000 ? 1000 : leases > 10000 ? 10000 : leases;
    char *all;

    if (asprintf(&all,
                 "<CycloneDDS><Domain Id=\"any\"><Discovery><LeaseDuration>%u ms</LeaseDuration>"
                 "</Discovery></Domain></CycloneDDS>%s%s",
                 ms, xml != NULL ? "," : "", xml != NULL ? xml : "") < 0)
        return TFA_E_MEMORY;
    const int status = tfa_dds_join(settings->domain, all, largest_sample(gateway, xml != NULL),
                                    NULL, &gateway->member);
    free(all);
    return status;
}

int tfa_dds_create(const gateway_context *context, uint32_t robot_count, const char *xml,
                   uint32_t slots, tfa_dds **result)
{
    const config_dds *settings = &context->settings->dds;

    *result = NULL;
    if (robot_count == 0)
        return TFA_E_ARGUMENT;
    tfa_dds *gateway = calloc(1, sizeof *gateway);
    if (gateway == NULL)
        return TFA_E_MEMORY;
    pthread_mutex_init(&gateway->mutex, NULL);
    pthread_cond_init(&gateway->handover, NULL);
    sem_init(&gateway->leader_stop, 0, 0);
    gateway->slots = slots > 0 ? slots : DEFAULT_SLOTS;
    gateway->count = context->messages;
    gateway->lease_ns = INT64_C(1000000) * settings->lease_ms;
    gateway->priority = settings->priority;
    gateway->max_age_ns = INT64_C(1000000) * settings->max_age_ms;

    int status = make_robots(gateway, context, robot_count);
    if (status == TFA_OK)
        status = join_domain(gateway, settings, xml);
    if (status == TFA_OK)
        status = make_entities(gateway);
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
        tfa_dds_create_reader(gateway->member.participant, gateway->topics[topic], topic, listener);
    dds_delete_listener(listener);
    return reader;
}

static int start_elections(tfa_dds *gateway)
{
    dds_guid_t guid;

    if (tfa_dds_failed(dds_get_guid(gateway->member.participant, &guid), "participant"))
        return TFA_E_SYSTEM;
    const dds_entity_t reader = make_listening_reader(gateway, TFA_DDS_LEADER, tfa_dds_on_leader);
    pthread_mutex_lock(&gateway->mutex);
    gateway->leader_reader = reader;
    pthread_mutex_unlock(&gateway->mutex);
    if (tfa_dds_failed(reader, "leader reader"))
        return TFA_E_SYSTEM;
    tfa_dds_begin_elections(gateway, guid.v);
    const int code = pthread_create(&gateway->leader_thread, NULL, tfa_dds_leader_thread, gateway);
    if (code != 0) {
        tfa_dds_set_error("leader thread: %s", strerror(code));
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
    gateway->torques_reader = make_listening_reader(gateway, TFA_DDS_TORQUES, tfa_dds_on_torques);
    if (tfa_dds_failed(gateway->torques_reader, "joint_torques reader"))
        return TFA_E_SYSTEM;
    gateway->request_reader = make_listening_reader(gateway, TFA_DDS_REQUEST, tfa_dds_on_request);
    if (tfa_dds_failed(gateway->request_reader, "request reader"))
        return TFA_E_SYSTEM;
    return start_elections(gateway);
}

int tfa_dds_start(tfa_dds *gateway, struct tfa_worker *worker, const tfa_worker_robot *solvers)
{
    gateway->worker = worker;
    for (uint32_t i = 0; i < gateway->robot_count; i++) {
        dds_robot *robot = &gateway->robots[i];
        robot->own.solver = solvers[i];
        const int status = tfa_dds_ring_open(worker, robot, gateway->slots, &robot->ring);
        if (status != TFA_OK)
            return status;
    }
    const int code = pthread_create(&gateway->thread, NULL, tfa_dds_thread, gateway);
    if (code != 0) {
        tfa_dds_set_error("dds thread: %s", strerror(code));
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
    tfa_dds_leave(&gateway->member);
    for (uint32_t i = 0; gateway->robots != NULL && i < gateway->robot_count; i++) {
        tfa_dds_ring_close(gateway->robots[i].ring);
        pthread_mutex_destroy(&gateway->robots[i].mutex);
    }
    free(gateway->robots);
    tfa_dds_free_samples(gateway);
    sem_destroy(&gateway->leader_stop);
    pthread_cond_destroy(&gateway->handover);
    pthread_mutex_destroy(&gateway->mutex);
    free(gateway);
}
