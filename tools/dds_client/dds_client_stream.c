/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A small synchronous client of totalforced over DDS: streams of torques and accelerations.
 */
#include "dds_client_internal.h"

#include <string.h>

static bool accelerations_are_mine(const void *sample, void *arg)
{
    return strcmp(((const totalforce_dds_JointAccelerations *)sample)->robot, arg) == 0;
}

static int make_topics(tfa_dds_client *client)
{
    const struct dds_topic_filter mine = {.mode = DDS_TOPIC_FILTER_SAMPLE_ARG,
                                          .f.sample_arg = accelerations_are_mine,
                                          .arg = client->robot};

    client->torques_topic = tfa_dds_create_topic(client->participant, TFA_DDS_TORQUES);
    client->accelerations_topic = tfa_dds_create_topic(client->participant, TFA_DDS_ACCELERATIONS);
    if (client->torques_topic < 0 || client->accelerations_topic < 0 ||
        dds_set_topic_filter_extended(client->accelerations_topic, &mine) < 0)
        return TFA_E_SYSTEM;
    return TFA_OK;
}

static int make_endpoints(tfa_dds_client *client)
{
    dds_listener_t *listener = tfa_dds_event_listener(&client->stream_event);

    if (listener == NULL)
        return TFA_E_MEMORY;
    client->torques_writer =
        tfa_dds_create_writer(client->participant, client->torques_topic, TFA_DDS_TORQUES, NULL);
    client->accelerations_reader = tfa_dds_create_reader(
        client->participant, client->accelerations_topic, TFA_DDS_ACCELERATIONS, listener);
    dds_delete_listener(listener);
    return client->torques_writer < 0 || client->accelerations_reader < 0 ? TFA_E_SYSTEM : TFA_OK;
}

/* The daemon's streaming endpoints are known to us. */
static bool is_matched(const tfa_dds_client *client)
{
    dds_publication_matched_status_t status = {0};

    return dds_get_publication_matched_status(client->torques_writer, &status) == DDS_RETCODE_OK &&
           status.current_count > 0 &&
           atomic_load_explicit(&client->stream_event.peers, memory_order_acquire) > 0;
}

int tfa_dds_stream_open(tfa_dds_client *client, int32_t timeout_ms)
{
    const uint64_t deadline =
        tfa_dds_now() + (uint64_t)(timeout_ms > 0 ? timeout_ms : 5000) * 1000000u;

    if (client->first != client->last)
        return TFA_E_AGAIN;
    int status = make_topics(client);
    if (status == TFA_OK)
        status = make_endpoints(client);
    /* Discovery tells of endpoints in the order in which they were made: once the daemon answers
     * calls through endpoints that are younger than the streams', it knows those, too. */
    if (status == TFA_OK)
        status = tfa_dds_client_open_calls(client, deadline);
    while (status == TFA_OK && !is_matched(client)) {
        const uint64_t again = tfa_dds_now() + 10000000u;
        if (again > deadline)
            return TFA_E_TIMEOUT;
        (void)tfa_dds_event_wait(&client->stream_event, TFA_WAIT_BLOCK, 0, again);
    }
    return status;
}

/* A sequence that borrows an array, which dds_write only reads. */
static dds_sequence_double alias_array(const double *array, uint32_t length)
{
    length = array != NULL ? length : 0;
    return (dds_sequence_double){length, length, (double *)(uintptr_t)(length > 0 ? array : NULL),
                                 false};
}

int tfa_dds_stream_publish(tfa_dds_client *client, const tfa_dds_torques *torques)
{
    const uint32_t base = client->shape.base_freedoms > 0 ? 1 : 0;
    totalforce_dds_JointTorques sample = {
        .seq = torques->seq,
        .stamp = torques->stamp != 0 ? torques->stamp : tfa_dds_ros_time(),
        .q = alias_array(torques->q, client->shape.q_count),
        .v = alias_array(torques->v, client->shape.v_count),
        .tau = alias_array(torques->tau, client->shape.v_count),
        .base_pose = alias_array(torques->base_pose, 7 * base),
        .base_twist = alias_array(torques->base_twist, 6 * base),
        .base_wrench = alias_array(torques->base_wrench, 6 * base),
        .modes = alias_array(torques->modes, client->shape.modes),
        .mode_velocities = alias_array(torques->mode_velocities, client->shape.modes),
    };

    if (client->torques_writer <= 0)
        return TFA_E_ARGUMENT;
    memcpy(sample.robot, client->robot, sizeof sample.robot);
    return dds_write(client->torques_writer, &sample) == DDS_RETCODE_OK ? TFA_OK : TFA_E_SYSTEM;
}

static bool copy(double *to, const dds_sequence_double *from, uint32_t expected)
{
    if (from->_length != expected)
        return false;
    if (to != NULL && expected > 0)
        memcpy(to, from->_buffer, expected * sizeof *to);
    return true;
}

static int read_accelerations(const tfa_dds_client *client,
                              const totalforce_dds_JointAccelerations *sample,
                              tfa_dds_accelerations *out)
{
    const bool answered = tfa_wire_has_answers(sample->status);

    out->seq = sample->seq;
    out->stamp = sample->stamp;
    out->status = sample->status;
    out->field = (tfa_field)sample->field;
    out->index = sample->index;
    out->answer =
        (tfa_answer){sample->status, sample->method, sample->flags, sample->error_estimate};
    if (!copy(out->qdd, &sample->qdd, answered ? client->shape.v_count : 0) ||
        !copy(out->base_acceleration, &sample->base_acceleration,
              answered ? client->shape.base_freedoms : 0) ||
        !copy(out->modes, &sample->modes, answered ? client->shape.modes : 0))
        return TFA_E_PROTOCOL;
    return TFA_OK;
}

int tfa_dds_stream_take(tfa_dds_client *client, tfa_dds_accelerations *accelerations,
                        uint64_t timeout_ns)
{
    const uint64_t deadline = tfa_dds_deadline(timeout_ns);
    void *sample[1] = {NULL};
    dds_sample_info_t state;

    if (client->accelerations_reader <= 0)
        return TFA_E_ARGUMENT;
    tfa_dds_event_clear(&client->stream_event);
    for (;;) {
        const dds_return_t count = dds_take(client->accelerations_reader, sample, &state, 1, 1);
        int status = TFA_E_SYSTEM;
        if (count > 0) {
            const totalforce_dds_JointAccelerations *a = sample[0];
            const bool valid = state.valid_data &&
                               tfa_dds_client_is_from_leader(client, client->accelerations_reader,
                                                             state.publication_handle, a->epoch,
                                                             &client->streamer);
            if (valid)
                status = read_accelerations(client, a, accelerations);
            (void)dds_return_loan(client->accelerations_reader, sample, count);
            if (valid)
                return status;
            continue;
        }
        if (count < 0)
            return TFA_E_SYSTEM;
        status = tfa_dds_client_wait(client, &client->stream_event, deadline);
        if (status != TFA_OK)
            return status;
    }
}
