/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Shared declarations of the DDS gateway, grouped by the file that defines them.
 *
 * Two kinds of threads work here: Cyclone's receiving threads, in listeners, and the dds thread.
 * Each robot has a mutex of its own, which guards everything of the robot that may change; a thread
 * holds one at a time, and may write to DDS meanwhile, because the gateway's writers never wait. So
 * robots do not wait for each other. The gateway's own mutex guards the handover to the dds thread
 * and is taken last.
 */
#ifndef TFA_SERVICE_DDS_INTERNAL_H
#define TFA_SERVICE_DDS_INTERNAL_H

#include "dds/topics/dds.h"

#include "dds/common/dds_domain.h"
#include "dds/common/gateway_solve.h"
#include "dds/standby/election.h"
#include "dds/topics/dds_convert.h"
#include "dds/topics/dds_topics.h"
#include "worker/cost.h"
#include "worker/worker.h"

#include <pthread.h>
#include <semaphore.h>
#include <stdatomic.h>

/* A sample that was taken, with the memory of its reply. The next one reuses its sequences and this
 * memory, which grow if it needs more. */
typedef struct dds_taken {
    struct dds_taken *next; /* of a list of free ones */
    totalforce_dds_Request request;
    totalforce_dds_JointTorques torques;
    void *reply;
    size_t reply_bytes;
} dds_taken;

/* Where the answer to a request goes. */
typedef struct dds_pending {
    bool is_stream;
    totalforce_dds_Guid client;
    uint64_t id;        /* or seq of the torques */
    uint64_t epoch;     /* of this daemon's leadership */
    int64_t stamp;      /* ROS time, echoed */
    int64_t t_received; /* ROS time */
    int64_t deadline;   /* ROS time; 0: none */
    tfa_wire_reply_shape reply_shape;
} dds_pending;

/* A request for the worker, and all that must live until it is answered. */
typedef struct dds_slot {
    dds_taken *taken; /* its arrays, and the buffers of the reply */
    dds_pending to;
    tfa_worker_call call;
} dds_slot;

struct tfa_dds_ring; /* dds_ring.c */

typedef struct dds_robot {
    char name[totalforce_dds_ROBOT_NAME_MAX + 1];
    uint32_t index; /* in the worker */

    pthread_mutex_t mutex; /* guards what follows */
    const tfa_model *model;
    tfa_wire_shape shape;
    gateway_robot own; /* for requests that are answered in the receiving thread */
    tfa_cost_table costs;
    totalforce_dds_Hash hash;  /* of the model that was announced */
    totalforce_dds_Hash other; /* of the one before or of the next: replies may come from it */
    struct tfa_dds_ring *ring; /* NULL after tfa_dds_detach */
    uint32_t stream_under_way; /* samples of torques at the worker: later ones follow them there */
    bool leaving;              /* no more requests */
    tfa_election election;
    int64_t next_tick;        /* tfa_election_next */
    uint64_t worker_beat;     /* the worker's heartbeat */
    int64_t worker_beat_time; /* when it changed */
    bool electing;            /* from begin to resignation; answers only then */
    bool stepped_down;        /* resigned until it has a ring again */
    bool announced;           /* RobotInfo is written, and no other daemon can have written since */
    bool rival;               /* another leader was live at the last look */
    uint32_t peers;           /* at the last look */
    uint8_t described[16];    /* the leader that `origin` describes; 0: none */
    char origin[TFA_DDS_ORIGIN_SIZE];
} dds_robot;

struct tfa_dds {
    dds_robot *robots;
    uint32_t robot_count;
    uint32_t slots;
    int64_t max_age_ns;

    dds_member member;
    dds_entity_t topics[TFA_DDS_TOPIC_COUNT];
    dds_entity_t info_writer, request_reader, reply_writer;
    dds_entity_t leader_writer;
    dds_entity_t torques_reader, accelerations_writer;

    pthread_mutex_t mutex; /* guards what follows */
    dds_entity_t leader_reader;
    dds_taken *free_samples; /* as many as listeners ran at once */
    pthread_cond_t handover; /* the dds thread has something to wait for, or must stop */
    uint32_t under_way;      /* requests at the worker */
    bool stopping;

    pthread_t thread;
    struct tfa_worker *worker;
    bool running;

    int64_t lease_ns;
    uint32_t priority;
    sem_t leader_stop; /* ends the leader thread */
    pthread_t leader_thread;
    bool leader_running;

    tfa_shared_dds *count; /* in the daemon's statistics */
};

static inline void tfa_dds_increment(_Atomic uint64_t *counter)
{
    atomic_fetch_add_explicit(counter, 1, memory_order_relaxed);
}

/* ---- dds_swap.c: other models ---- */

/* Takes shape and hash from a model. */
void tfa_dds_set_model(dds_robot *robot, const tfa_model *model);

/* The hash with this tag among the possible ones of the robot's replies; the announced one if there
 * is none. The robot is locked. */
const uint8_t *tfa_dds_hash_of(const dds_robot *robot, uint64_t tag);

/* ---- dds_calls.c: from samples to requests ---- */

/* Listeners of the two input topics; `gateway` is a tfa_dds. */
void tfa_dds_on_request(dds_entity_t reader, void *gateway);
void tfa_dds_on_torques(dds_entity_t reader, void *gateway);

/* Filters of the input topics: samples about the gateway's robots. Others leave nothing behind, and
 * are counted. */
bool tfa_dds_request_is_ours(const void *sample, void *gateway);
bool tfa_dds_torques_are_ours(const void *sample, void *gateway);

/* NULL is allowed. */
void tfa_dds_free_sample(dds_taken *taken);
void tfa_dds_free_samples(tfa_dds *gateway);

/* NULL: it is not served here. */
dds_robot *tfa_dds_find_robot(const tfa_dds *gateway, const char *name);

/* ---- dds_answers.c: from answers to samples ---- */

/* Writes the answer of the worker, or of the receiving thread. The robot is locked. */
void tfa_dds_answer(tfa_dds *gateway, const dds_robot *robot, const dds_pending *to,
                    const tfa_worker_call *call);

/* The dds thread: writes the answers of the worker. */
void *tfa_dds_thread(void *gateway);

/* ---- dds_info.c: announcement of the robots ---- */

/* Writes RobotInfo. @return a Cyclone code */
dds_return_t tfa_dds_write_info(tfa_dds *gateway, const dds_robot *robot);

/* Unregisters it. Not disposed: the next leader may have written it already. */
void tfa_dds_withdraw_info(tfa_dds *gateway, const dds_robot *robot);

/* ---- dds_leader.c: hot standby ---- */

/* Each robot begins to listen for others; `daemon` is this participant's GUID. */
void tfa_dds_begin_elections(tfa_dds *gateway, const uint8_t daemon[16]);

/* Advertises this daemon until the gateway stops. */
void *tfa_dds_leader_thread(void *gateway);

/* Looks at the clock: advertises this daemon, takes over, gives up. The robot is locked. */
void tfa_dds_tick_election(tfa_dds *gateway, dds_robot *robot, int64_t now);

/* Filter of the topic LEADER: daemons that speak for themselves, about the gateway's robots. */
bool tfa_dds_leader_is_ours(const void *sample, const dds_sample_info_t *info, void *gateway);

/* Listener of the topic LEADER. */
void tfa_dds_on_leader(dds_entity_t reader, void *gateway);

/* Another model, already in `robot`, which is locked and can answer. */
void tfa_dds_set_leader_model(tfa_dds *gateway, dds_robot *robot);

/* The robot, which is locked, cannot answer: another daemon shall lead, until
 * tfa_dds_set_leader_model. */
void tfa_dds_step_down(tfa_dds *gateway, dds_robot *robot);

/* Ends the thread. Another daemon may lead now: nothing is answered any more. */
void tfa_dds_resign_all(tfa_dds *gateway);

/* ---- dds_ring.c: requests at the worker, a ring of slots for each robot ---- */

/* Attaches to the worker as a client of `robot`. */
int tfa_dds_ring_open(struct tfa_worker *worker, const dds_robot *robot, uint32_t slots,
                      struct tfa_dds_ring **ring);
/* No request may be under way, or the worker has ended. NULL is allowed. */
void tfa_dds_ring_close(struct tfa_dds_ring *ring);

/* The slot of the next request; NULL: all are taken. */
dds_slot *tfa_dds_ring_next(struct tfa_dds_ring *ring);
/* Sends the request in it. */
void tfa_dds_ring_send(struct tfa_dds_ring *ring);

/* The slot of the oldest request, if it is answered. */
dds_slot *tfa_dds_ring_oldest(struct tfa_dds_ring *ring);
void tfa_dds_ring_release(struct tfa_dds_ring *ring);
bool tfa_dds_ring_is_empty(const struct tfa_dds_ring *ring);

/* Sleeps until the oldest request is answered, at most timeout_ns. Only the thread that releases
 * may call it; needs no lock. */
void tfa_dds_ring_wait(const struct tfa_dds_ring *ring, uint64_t timeout_ns);

#endif
