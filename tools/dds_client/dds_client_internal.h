/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Shared declarations of the two halves of the DDS client, calls and streams.
 */
#ifndef TOOLS_DDS_CLIENT_DDS_CLIENT_INTERNAL_H
#define TOOLS_DDS_CLIENT_DDS_CLIENT_INTERNAL_H

#include "dds_client.h"

#include "dds/topics/dds_convert.h"
#include "dds/topics/dds_topics.h"

#include <semaphore.h>
#include <stdatomic.h>
#include <stdbool.h>

#define TFA_DDS_OUTSTANDING 64 /* as many replies as the reader keeps */

/* A event that Cyclone's threads ring and the caller waits for. Rings may be too many, never too
 * few: a waiting caller looks for its own event, and waits again when it is not there. */
typedef struct tfa_dds_event {
    sem_t signals;
    _Atomic int32_t peers; /* endpoints of daemons that ours is matched with */
} tfa_dds_event;

/* A request sent and not yet received. */
typedef struct tfa_dds_pending {
    uint64_t id;
    uint64_t t_sent;
    tfa_wire_reply_shape reply_shape;
} tfa_dds_pending;

/* The daemon that answers for the robot. Replies of others are dropped. */
typedef struct tfa_dds_leader {
    bool known;
    totalforce_dds_Guid daemon; /* of its participant */
    uint64_t epoch;
    uint64_t expires;     /* it is silent: another one may be believed. CLOCK_MONOTONIC ns */
    uint64_t any_expires; /* no daemon of the robot is discovered any more, standbys included */
    uint64_t changes;     /* other leaders, or other epochs */
} tfa_dds_leader;

struct tfa_dds_client {
    char robot[totalforce_dds_ROBOT_NAME_MAX + 1];
    tfa_wait wait;
    uint64_t spin_ns;
    tfa_client_info info;
    tfa_wire_shape shape;
    totalforce_dds_RobotInfo *robot_info; /* owns the strings of info */
    char hash_text[65];

    tfa_dds_leader leader;
    dds_instance_handle_t replier;  /* its writer of replies, once one came */
    dds_instance_handle_t streamer; /* the same of accelerations */

    dds_entity_t participant;
    dds_entity_t request_topic, info_topic, leader_topic;
    dds_entity_t info_reader, leader_reader;

    /* Calls. */
    dds_entity_t reply_topic, reply_reader, request_writer;
    totalforce_dds_Guid guid; /* of request_writer */
    tfa_dds_event event;
    uint64_t next_id;
    tfa_dds_pending pending[TFA_DDS_OUTSTANDING]; /* a ring: oldest at first % OUTSTANDING */
    uint64_t first, last;
    const tfa_request *again;      /* under way in a call: sent again to the next leader */
    uint64_t changes;              /* of the leader, when the requests under way were sent */
    totalforce_dds_Reply *scratch; /* the reply last taken; its memory serves the next */
    totalforce_dds_Reply *early[TFA_DDS_OUTSTANDING]; /* by id, replies that overtook the oldest */

    /* Streams. */
    dds_entity_t torques_topic, torques_writer, accelerations_topic, accelerations_reader;
    tfa_dds_event stream_event;
};

/* CLOCK_MONOTONIC, ns. */
uint64_t tfa_dds_now(void);

/* Waits for a ring until `deadline` (CLOCK_MONOTONIC ns): spins as the client was told to, then
 * sleeps. false: the deadline passed. */
bool tfa_dds_event_wait(tfa_dds_event *event, tfa_wait wait, uint64_t spin_ns, uint64_t deadline);

/* A listener that rings `event` for data, and for peers that come and go. The caller deletes it. */
dds_listener_t *tfa_dds_event_listener(tfa_dds_event *event);

/* Rings `event`, for a listener of Cyclone's. */
void tfa_dds_event_signal(dds_entity_t reader, void *event);

/* Waits for a ring and looks now and then whether the daemon is still there.
 * TFA_OK: look at the readers again; TFA_E_TIMEOUT; TFA_E_DISCONNECTED. */
int tfa_dds_client_wait(tfa_dds_client *client, tfa_dds_event *event, uint64_t deadline);

/* Forgets old rings, so that the next wait sleeps unless something new comes. Look at the readers
 * after this, not before. */
void tfa_dds_event_clear(tfa_dds_event *event);

/* now + timeout_ns; 0 means never. */
uint64_t tfa_dds_deadline(uint64_t timeout_ns);

/* ---- dds_client_leader.c ---- */

/* Joins the topic on which the daemons of the robot say which one leads. */
int tfa_dds_client_join_leader(tfa_dds_client *client);

/* Reads what came. */
void tfa_dds_client_follow(tfa_dds_client *client);

/* No daemon of the robot is there, not even a standby. */
bool tfa_dds_client_daemon_is_gone(tfa_dds_client *client);

/* Is this the leader's writer? `reader` is matched with it. */
bool tfa_dds_client_is_leaders(const tfa_dds_client *client, dds_entity_t reader,
                               dds_instance_handle_t writer);

/* Did the leader write this reply, or these accelerations? `known` is its writer, if known. */
bool tfa_dds_client_is_from_leader(tfa_dds_client *client, dds_entity_t reader,
                                   dds_instance_handle_t writer, uint64_t epoch,
                                   dds_instance_handle_t *known);

/* ---- the other files ---- */

/* Writes one request, or a hello when `request` is NULL. */
int tfa_dds_client_publish(tfa_dds_client *client, const tfa_request *request, uint64_t id);

/* Takes the next reply that has come into client->scratch and returns it, or NULL. */
totalforce_dds_Reply *tfa_dds_client_take(tfa_dds_client *client);

/* Makes the request writer and the reply reader anew and proves both ways with a hello; whatever
 * endpoints were made before are then known to the daemon, too. */
int tfa_dds_client_open_calls(tfa_dds_client *client, uint64_t deadline);

#endif
