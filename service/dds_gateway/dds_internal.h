/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Shared declarations of the DDS gateway, grouped by the file that defines them.
 *
 * Two threads work here: Cyclone's receiving thread, in listeners, and the dds thread. The mutex
 * of the gateway guards the rings' ends and the lists of pending requests; whoever holds it may
 * write to DDS, because the gateway's writers never wait.
 */
#ifndef TFA_SERVICE_DDS_GATEWAY_INTERNAL_H
#define TFA_SERVICE_DDS_GATEWAY_INTERNAL_H

#include "dds.h"

#include "dds_gateway/dds_convert.h"
#include "dds_gateway/dds_topics.h"

#include <pthread.h>
#include <stdatomic.h>

struct tfa_dds_ring; /* dds_ring.c */

/* Where the answer to a request goes. */
typedef struct dds_pending {
    bool is_stream;
    totalforce_dds_Guid client;
    uint64_t id;        /* or seq of the torques */
    int64_t stamp;      /* ROS time, echoed */
    int64_t t_received; /* ROS time */
    tfa_dds_reply_sizes sizes;
} dds_pending;

typedef struct dds_robot {
    char name[totalforce_dds_ROBOT_NAME_MAX + 1];
    const tfa_model *model;
    uint32_t index; /* in the worker */
    tfa_dds_shape shape;
    totalforce_dds_Hash hash;  /* of the model that was announced */
    totalforce_dds_Hash other; /* of the one before or of the next: replies may come from it */
    struct tfa_dds_ring *ring; /* NULL after tfa_dds_detach */
    bool leaving;              /* no more requests */
    dds_pending *pending;      /* a list of `slots`: entry i stands at i % slots, as in the ring */
    uint64_t first, last;      /* oldest under way, next to come */
    bool handed_over;          /* the dds thread takes its answers, until none is under way */
} dds_robot;

struct tfa_dds {
    dds_robot *robots;
    uint32_t robot_count;
    uint32_t slots;
    uint64_t spin_ns;
    bool streaming;

    dds_entity_t participant;
    dds_entity_t topics[TFA_DDS_ACCELERATIONS + 1];
    dds_entity_t info_writer, info_reader, request_reader, reply_writer;
    dds_entity_t torques_reader, accelerations_writer;

    pthread_mutex_t mutex;
    pthread_cond_t handover; /* the dds thread has something to wait for, or must stop */
    pthread_t thread;
    struct tfa_worker *worker;
    bool running, stopping;
    int64_t stop_deadline; /* CLOCK_MONOTONIC: then requests under way stay unanswered */

    struct {
        _Atomic uint64_t requests, torques, replies, rejected, dropped, handovers;
    } count;
};

/* ---- dds.c ---- */

/* CLOCK_MONOTONIC, ns. */
int64_t tfa_dds_monotonic(void);

/* ---- dds_swap.c: other models ---- */

/* Takes shape and hash from a model. */
void tfa_dds_set_model(dds_robot *robot, const tfa_model *model);

/* The hash with this tag among the possible ones of the robot's replies; the announced one if there
 * is none. The gateway is locked. */
const uint8_t *tfa_dds_hash_of(const dds_robot *robot, uint64_t tag);

/* ---- dds_calls.c: from samples to requests, from answers to samples ---- */

/* Listeners of the two input topics; `gateway` is a tfa_dds. */
void tfa_dds_on_request(dds_entity_t reader, void *gateway);
void tfa_dds_on_torques(dds_entity_t reader, void *gateway);

/* The dds thread: writes answers that took longer than the receiving thread waits. */
void *tfa_dds_thread(void *gateway);

/* ---- dds_info.c: announcement of the robots ---- */

/* Writes RobotInfo. @return a Cyclone code */
dds_return_t tfa_dds_write_info(tfa_dds *gateway, const dds_robot *robot);

/* Withdraws all robots: disposed, unregistered, and acknowledged if readers are quick. */
void tfa_dds_withdraw_all(tfa_dds *gateway);

/* Another daemon in the domain serves a robot of that name. */
bool tfa_dds_served_elsewhere(const tfa_dds *gateway, const char *name);

/* ---- dds_ring.c: the internal ring, one for each robot, between the gateway and the worker
 * ---- */

/* State of the oldest answer of a ring. Times are CLOCK_MONOTONIC ns. The buffers of the reply
 * lie in the ring until tfa_dds_ring_release. */
typedef struct dds_ring_answer {
    tfa_reply reply;
    int64_t t_start, t_done;
} dds_ring_answer;

/* Attaches to the worker as a client of `robot`. */
int tfa_dds_ring_open(struct tfa_worker *worker, const dds_robot *robot, uint32_t slots,
                      struct tfa_dds_ring **ring);
void tfa_dds_ring_close(struct tfa_dds_ring *ring);

/* Copies a request into the ring. @return TFA_OK, TFA_E_AGAIN, TFA_E_SIZE */
int tfa_dds_ring_submit(struct tfa_dds_ring *ring, const tfa_request *request);

/* The oldest answer if it is there; it stays until released. */
bool tfa_dds_ring_peek(struct tfa_dds_ring *ring, dds_ring_answer *answer);
void tfa_dds_ring_release(struct tfa_dds_ring *ring);

/* Sleeps until answer `index` (counted from 0, as dds_robot.first) is there or gone, at most
 * timeout_ns. Needs no lock. */
void tfa_dds_ring_wait(const struct tfa_dds_ring *ring, uint64_t index, uint64_t timeout_ns);

#endif
