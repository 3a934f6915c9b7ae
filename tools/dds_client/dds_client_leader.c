/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A small synchronous client of totalforced over DDS: which daemon leads.
 *
 * A client follows the leader of the highest epoch; another of a lower epoch is believed when that
 * one was silent for its lease or has said that it leads no more.
 */
#include "dds_client_internal.h"

#include <string.h>

#define NS_PER_MS UINT64_C(1000000)
#define LEASE_MS_MAX 3600000u
/* A daemon may hang for a while without a standby; its calls time out meanwhile. */
#define GONE_LEASES 5

/* ---- the topic ---- */

static bool is_about_robot(const void *sample, void *client)
{
    return strcmp(((const totalforce_dds_Leader *)sample)->robot,
                  ((const tfa_dds_client *)client)->robot) == 0;
}

/* Calls and streams wait for events of their own. */
static void signal_both(dds_entity_t reader, void *arg)
{
    tfa_dds_client *client = arg;

    tfa_dds_event_signal(reader, &client->event);
    tfa_dds_event_signal(reader, &client->stream_event);
}

int tfa_dds_client_join_leader(tfa_dds_client *client)
{
    const struct dds_topic_filter mine = {
        .mode = DDS_TOPIC_FILTER_SAMPLE_ARG, .f.sample_arg = is_about_robot, .arg = client};

    client->leader_topic = tfa_dds_create_topic(client->participant, TFA_DDS_LEADER);
    if (client->leader_topic < 0 || dds_set_topic_filter_extended(client->leader_topic, &mine) < 0)
        return TFA_E_SYSTEM;
    dds_listener_t *listener = dds_create_listener(client);
    if (listener == NULL)
        return TFA_E_MEMORY;
    dds_lset_data_available(listener, signal_both);
    client->leader_reader =
        tfa_dds_create_reader(client->participant, client->leader_topic, TFA_DDS_LEADER, listener);
    dds_delete_listener(listener);
    return client->leader_reader < 0 ? TFA_E_SYSTEM : TFA_OK;
}

/* ---- its samples ---- */

static bool is_participants(dds_entity_t reader, dds_instance_handle_t writer,
                            const totalforce_dds_Guid participant)
{
    dds_builtintopic_endpoint_t *endpoint = dds_get_matched_publication_data(reader, writer);

    if (endpoint == NULL)
        return false;
    const bool same = memcmp(endpoint->participant_key.v, participant, 16) == 0;
    dds_builtintopic_free_endpoint(endpoint);
    return same;
}

static bool is_leader(const tfa_dds_leader *leader, const totalforce_dds_Leader *sample)
{
    return memcmp(leader->daemon, sample->daemon, sizeof leader->daemon) == 0;
}

static void take_leader(tfa_dds_client *client, const totalforce_dds_Leader *sample, uint64_t now)
{
    tfa_dds_leader *leader = &client->leader;
    const bool same = leader->known && is_leader(leader, sample);

    if (leader->known && !same && sample->epoch <= leader->epoch && now < leader->expires)
        return;
    if (!same || sample->epoch != leader->epoch) {
        leader->changes++;
        client->replier = client->streamer = DDS_HANDLE_NIL;
    }
    leader->known = true;
    memcpy(leader->daemon, sample->daemon, sizeof leader->daemon);
    leader->epoch = sample->epoch;
    leader->expires = now + NS_PER_MS * sample->lease_ms;
}

static void hear(tfa_dds_client *client, const totalforce_dds_Leader *sample,
                 const dds_sample_info_t *info, uint64_t now)
{
    tfa_dds_leader *leader = &client->leader;
    const bool leads = info->valid_data && sample->role == totalforce_dds_LEADER_LEADING;

    if (!leads && leader->known && is_leader(leader, sample) &&
        (info->valid_data || info->instance_state == DDS_NOT_ALIVE_DISPOSED_INSTANCE_STATE))
        leader->known = false;
    if (!info->valid_data || sample->lease_ms > LEASE_MS_MAX)
        return;
    const uint64_t end = now + GONE_LEASES * NS_PER_MS * sample->lease_ms;
    leader->any_expires = end > leader->any_expires ? end : leader->any_expires;
    if (leads)
        take_leader(client, sample, now);
}

void tfa_dds_client_follow(tfa_dds_client *client)
{
    totalforce_dds_Leader sample = {0};
    dds_sample_info_t info;

    while (dds_take(client->leader_reader, (void *[]){&sample}, &info, 1, 1) == 1)
        if (is_participants(client->leader_reader, info.publication_handle, sample.daemon))
            hear(client, &sample, &info, tfa_dds_now());
}

/* ---- decisions ---- */

bool tfa_dds_client_daemon_is_gone(tfa_dds_client *client)
{
    tfa_dds_client_follow(client);
    return atomic_load_explicit(&client->event.peers, memory_order_acquire) == 0 ||
           tfa_dds_now() > client->leader.any_expires;
}

bool tfa_dds_client_is_leaders(const tfa_dds_client *client, dds_entity_t reader,
                               dds_instance_handle_t writer)
{
    return client->leader.known && is_participants(reader, writer, client->leader.daemon);
}

bool tfa_dds_client_is_from_leader(tfa_dds_client *client, dds_entity_t reader,
                                   dds_instance_handle_t writer, uint64_t epoch,
                                   dds_instance_handle_t *known)
{
    if (epoch < client->leader.epoch)
        return false;
    if (writer == *known)
        return true;
    tfa_dds_client_follow(client); /* a new leader's word comes before its replies */
    if (epoch < client->leader.epoch || !tfa_dds_client_is_leaders(client, reader, writer))
        return false;
    *known = writer;
    return true;
}
