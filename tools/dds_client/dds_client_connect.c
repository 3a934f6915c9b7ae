/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A small synchronous client of totalforced over DDS: joining the domain and finding the robot.
 */
#include "dds_client_internal.h"

#include <stdlib.h>
#include <string.h>

#define NS_PER_MS UINT64_C(1000000)

/* ---- announcement of the robot ---- */

/* The robot's info if the leader announces it now: a copy, for RobotInfo_free; or NULL. */
static totalforce_dds_RobotInfo *read_robot(tfa_dds_client *client)
{
    totalforce_dds_RobotInfo *info = totalforce_dds_RobotInfo__alloc();
    void *sample[1] = {info};
    dds_sample_info_t state;

    if (info == NULL)
        return NULL;
    memset(info, 0, sizeof *info);
    memcpy(info->robot, client->robot, sizeof info->robot);
    tfa_dds_client_follow(client);
    const dds_instance_handle_t robot = dds_lookup_instance(client->info_reader, info);
    if (robot != DDS_HANDLE_NIL &&
        dds_read_instance_mask(client->info_reader, sample, &state, 1, 1, robot,
                               DDS_ANY_SAMPLE_STATE | DDS_ANY_VIEW_STATE |
                                   DDS_ALIVE_INSTANCE_STATE) == 1 &&
        state.valid_data &&
        tfa_dds_client_is_leaders(client, client->info_reader, state.publication_handle))
        return info;
    totalforce_dds_RobotInfo_free(info, DDS_FREE_ALL);
    return NULL;
}

static bool any_robot_is_announced(const tfa_dds_client *client)
{
    void *samples[1] = {NULL};
    dds_sample_info_t states[1];
    const dds_return_t count =
        dds_read_mask(client->info_reader, samples, states, 1, 1,
                      DDS_ANY_SAMPLE_STATE | DDS_ANY_VIEW_STATE | DDS_ALIVE_INSTANCE_STATE);

    if (count > 0)
        (void)dds_return_loan(client->info_reader, samples, count);
    return count > 0;
}

/* Fills client->info from the daemon's RobotInfo, which the client then owns. */
static int adopt_robot(tfa_dds_client *client, totalforce_dds_RobotInfo *robot)
{
    const size_t links = robot->joints._length, constraints = links + robot->frames._length;
    const char **names = calloc(constraints + robot->constraints._length + 1, sizeof *names);
    uint32_t *types = calloc((size_t)robot->joints._length + 1, sizeof *types);

    client->robot_info = robot;
    client->info.joint_names = names;
    client->info.joint_types = types;
    if (names == NULL || types == NULL)
        return TFA_E_MEMORY;
    for (uint32_t i = 0; i < robot->joints._length; i++) {
        names[i] = robot->joints._buffer[i].name;
        types[i] = robot->joints._buffer[i].type;
    }
    for (uint32_t i = 0; i < robot->frames._length; i++)
        names[links + i] = robot->frames._buffer[i];
    for (uint32_t i = 0; i < robot->constraints._length; i++)
        names[constraints + i] = robot->constraints._buffer[i];
    for (uint32_t i = 0; i < 32; i++) {
        client->hash_text[2 * i] = "0123456789abcdef"[robot->model_hash[i] >> 4];
        client->hash_text[2 * i + 1] = "0123456789abcdef"[robot->model_hash[i] & 15];
    }
    const uint32_t max_tips = robot->max_tips < TFA_MAX_TIPS ? robot->max_tips : TFA_MAX_TIPS;
    client->shape = (tfa_wire_shape){.q_count = robot->q_count,
                                     .v_count = robot->v_count,
                                     .base_freedoms = robot->base_freedoms,
                                     .frames = robot->frames._length,
                                     .modes = robot->modes._length,
                                     .max_batch = robot->max_batch,
                                     .max_tips = max_tips};
    client->info = (tfa_client_info){
        .q_count = robot->q_count,
        .v_count = robot->v_count,
        .base_freedoms = robot->base_freedoms,
        .max_batch = robot->max_batch,
        .max_tips = max_tips,
        .joint_count = robot->joints._length,
        .frame_count = robot->frames._length,
        .joint_names = names,
        .joint_types = types,
        .frame_names = names + links,
        .mode_count = robot->modes._length,
        .mode_frames = robot->modes._buffer,
        .constraint_count = robot->constraints._length,
        .constraint_names = names + constraints,
        .model_hash = client->hash_text,
    };
    return TFA_OK;
}

/* Waits until the robot's leader announces it: a daemon that starts or takes over is silent for a
 * lease, while others of the domain announce other robots. */
static int await_robot(tfa_dds_client *client, uint64_t deadline)
{
    for (;;) {
        totalforce_dds_RobotInfo *robot = read_robot(client);
        if (robot != NULL)
            return adopt_robot(client, robot);
        if (!tfa_dds_event_wait(&client->event, TFA_WAIT_BLOCK, 0, deadline))
            return any_robot_is_announced(client) ? TFA_E_ROBOT : TFA_E_TIMEOUT;
    }
}

/* ---- joining ---- */

/* Runs in Cyclone's threads, which have left it for good when dds_delete of the reader returns. */
static bool reply_is_mine(const void *sample, void *guid)
{
    const totalforce_dds_Reply *reply = sample;

    return memcmp(reply->client, guid, sizeof reply->client) == 0;
}

/* Sends hellos until one is answered: the daemon has matched our writer and its writer our reader,
 * and what comes from now on is not lost. */
static int send_dds_hello(tfa_dds_client *client, uint64_t deadline)
{
    while (tfa_dds_now() < deadline) {
        const uint64_t id = client->next_id++;
        uint64_t again = tfa_dds_now() + 20 * NS_PER_MS;

        again = again < deadline ? again : deadline;
        tfa_dds_event_clear(&client->event);
        const int status = tfa_dds_client_publish(client, NULL, id);
        if (status != TFA_OK)
            return status;
        do {
            const totalforce_dds_Reply *reply = tfa_dds_client_take(client);
            if (reply != NULL)
                return reply->status;
        } while (tfa_dds_event_wait(&client->event, TFA_WAIT_BLOCK, 0, again));
    }
    return TFA_E_TIMEOUT;
}

int tfa_dds_client_open_calls(tfa_dds_client *client, uint64_t deadline)
{
    dds_guid_t guid;

    if (client->reply_reader > 0)
        (void)dds_delete(client->reply_reader);
    if (client->request_writer > 0)
        (void)dds_delete(client->request_writer);
    client->reply_reader = 0;
    client->request_writer =
        tfa_dds_create_writer(client->participant, client->request_topic, TFA_DDS_REQUEST, NULL);
    if (client->request_writer < 0 || dds_get_guid(client->request_writer, &guid) < 0)
        return TFA_E_SYSTEM;
    /* The filter of the topic points at client->guid: it may change only without a reader. */
    memcpy(client->guid, guid.v, sizeof client->guid);
    dds_listener_t *listener = tfa_dds_event_listener(&client->event);
    if (listener == NULL)
        return TFA_E_MEMORY;
    client->reply_reader =
        tfa_dds_create_reader(client->participant, client->reply_topic, TFA_DDS_REPLY, listener);
    dds_delete_listener(listener);
    return client->reply_reader < 0 ? TFA_E_SYSTEM : send_dds_hello(client, deadline);
}

/* The participant, the topics of calls and the reader of RobotInfo. */
static int join_domain(tfa_dds_client *client, uint32_t domain)
{
    const struct dds_topic_filter mine = {
        .mode = DDS_TOPIC_FILTER_SAMPLE_ARG, .f.sample_arg = reply_is_mine, .arg = client->guid};

    client->participant = dds_create_participant(domain, NULL, NULL);
    if (client->participant < 0)
        return TFA_E_SYSTEM;
    client->info_topic = tfa_dds_create_topic(client->participant, TFA_DDS_ROBOT_INFO);
    client->request_topic = tfa_dds_create_topic(client->participant, TFA_DDS_REQUEST);
    client->reply_topic = tfa_dds_create_topic(client->participant, TFA_DDS_REPLY);
    if (client->info_topic < 0 || client->request_topic < 0 || client->reply_topic < 0 ||
        dds_set_topic_filter_extended(client->reply_topic, &mine) < 0)
        return TFA_E_SYSTEM;

    dds_listener_t *listener = dds_create_listener(&client->event);
    if (listener == NULL)
        return TFA_E_MEMORY;
    dds_lset_data_available(listener, tfa_dds_event_signal);
    client->info_reader = tfa_dds_create_reader(client->participant, client->info_topic,
                                                TFA_DDS_ROBOT_INFO, listener);
    dds_delete_listener(listener);
    return client->info_reader < 0 ? TFA_E_SYSTEM : tfa_dds_client_join_leader(client);
}

int tfa_dds_client_connect(const tfa_dds_client_options *options, tfa_dds_client **result)
{
    *result = NULL;
    tfa_dds_client *client = calloc(1, sizeof *client);
    if (client == NULL)
        return TFA_E_MEMORY;
    sem_init(&client->event.signals, 0, 0);
    sem_init(&client->stream_event.signals, 0, 0);
    client->wait = options->wait == TFA_WAIT_DEFAULT ? TFA_WAIT_HYBRID : options->wait;
    client->spin_ns = options->spin_ns > 0 ? options->spin_ns : 50000;
    client->next_id = 1;
    const int64_t timeout_ms = options->connect_timeout_ms > 0 ? options->connect_timeout_ms : 5000;
    const uint64_t deadline = tfa_dds_now() + (uint64_t)timeout_ms * NS_PER_MS;

    int status = TFA_E_ARGUMENT;
    if (options->robot != NULL && tfa_dds_set_robot(client->robot, options->robot))
        status = join_domain(client, options->domain);
    if (status == TFA_OK)
        status = await_robot(client, deadline);
    if (status == TFA_OK)
        status = tfa_dds_client_open_calls(client, deadline);
    if (status == TFA_OK)
        *result = client;
    else
        tfa_dds_client_close(client);
    return status;
}

void tfa_dds_client_close(tfa_dds_client *client)
{
    if (client == NULL)
        return;
    if (client->participant > 0)
        (void)dds_delete(client->participant); /* waits for the listeners under way */
    for (uint32_t i = 0; i < TFA_DDS_OUTSTANDING; i++)
        totalforce_dds_Reply_free(client->early[i], DDS_FREE_ALL);
    totalforce_dds_Reply_free(client->scratch, DDS_FREE_ALL);
    free((void *)(uintptr_t)client->info.joint_names);
    free((void *)(uintptr_t)client->info.joint_types);
    totalforce_dds_RobotInfo_free(client->robot_info, DDS_FREE_ALL);
    sem_destroy(&client->event.signals);
    sem_destroy(&client->stream_event.signals);
    free(client);
}

const tfa_client_info *tfa_dds_client_get_info(const tfa_dds_client *client)
{
    return &client->info;
}
