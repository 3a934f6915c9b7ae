/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Shared declarations of a worker: worker.c (its thread), turn.c (requests), long_states.c
 * (requests of another thread), warm_up.c (requests solved again), tap.c (requests recorded),
 * worker_client.c (all other threads).
 */
#ifndef TFA_SERVICE_WORKER_WORKER_INTERNAL_H
#define TFA_SERVICE_WORKER_WORKER_INTERNAL_H

#include <semaphore.h>

#include "worker/cost.h"
#include "worker/robot_taps.h"
#include "worker/worker.h"

#define TFA_WAIT_MODES 4 /* numbers of tfa_wait */

enum worker_client_state {
    CLIENT_FREE,
    CLIENT_ATTACHED,
    CLIENT_BROKEN,
    CLIENT_DRAINING,
    CLIENT_DETACHING,
    CLIENT_DETACHED
};

enum worker_phase { WORKER_IDLE, WORKER_RUNNING, WORKER_ENDED };

/* Where a request under way is: long_states.c */
enum worker_place { REQUEST_HERE, REQUEST_WAITING, REQUEST_AWAY };

/* A request under way: between two parts of it the worker serves others. */
typedef struct worker_request {
    bool active;
    uint8_t place;                 /* enum worker_place */
    uint32_t first;                /* states answered so far */
    uint64_t want;                 /* blocks of the reply */
    uint64_t received, start;      /* CLOCK_MONOTONIC ns */
    uint64_t spent_ns;             /* on its parts so far */
    uint64_t kind;                 /* of tfa_cost_kind */
    const tfa_worker_robot *robot; /* its solver; in one of `solver_lists` */
    tfa_worker_call *call;         /* of a direct client */
    tfa_cost *cost;
    void *slot;          /* of the reply */
    tfa_request request; /* arrays lie in `scratch` */
    tfa_reply reply;     /* buffers lie in `slot` */
} worker_request;

/* Requests solved again between requests, so that code and tables stay in the caches. Belongs to
 * the worker's thread. */
typedef struct worker_warm_up {
    uint32_t period_ns; /* 0: off */
    uint32_t client;    /* the one looked at last */
    uint64_t due;       /* CLOCK_MONOTONIC ns: not before */
    void *reply;        /* TFA_WARM_UP_REPLY_BYTES for answers that are not read */
} worker_warm_up;

#define TFA_WARM_UP_REPLY_BYTES 16384

enum worker_long_phase { LONG_IDLE, LONG_GIVEN, LONG_DONE };

/* Requests that another thread answers. */
typedef struct worker_long_states {
    sem_t given;
    _Atomic uint32_t phase; /* enum worker_long_phase: A17, A18, R17, R18 */
    worker_request *at;     /* the thread's while GIVEN, and its time */
    uint64_t took_ns;
} worker_long_states;

/* Everything but state and statistics is written while FREE and constant while ATTACHED; the
 * members marked "worker" belong to the worker's thread then. */
struct tfa_worker_client {
    _Alignas(
        TFA_CACHE_LINE) _Atomic uint32_t state; /* enum worker_client_state: A6 to A8, R6 to R8 */
    uint32_t robot;
    _Atomic bool lost;    /* its memory: B3, B4 of sigbus.c */
    uint64_t virtual_ns;  /* worker: time served, as fair queueing counts it */
    tfa_ring_server ring; /* worker */
    tfa_wire_shape shape;
    void *scratch;       /* worker: the private copy of a request */
    tfa_wire_form form;  /* worker: of `at.request` */
    tfa_answer *answers; /* worker: max_batch, for replies without */
    int guards[2];       /* of sigbus.h: requests, replies */
    int doorbell;
    bool direct;
    bool self_test; /* publishes no state, and is forgotten when it leaves */
    tfa_wait wait;
    uint32_t drained;          /* worker: requests answered while DRAINING */
    uint64_t drain_ns;         /* worker: and the time they took */
    worker_request at;         /* worker */
    tfa_cost_debt debt;        /* worker */
    bool warm;                 /* worker: the request in `scratch` may be solved again */
    tfa_shared_client *shared; /* statistics; the tally: worker */
};

struct tfa_worker {
    tfa_worker_client clients[TFA_WORKER_CLIENTS_MAX];
    _Atomic uint32_t clients_used; /* entries beyond were never used. A9 release <-> R9 acquire */
    _Atomic uint32_t modes[TFA_WAIT_MODES]; /* clients by tfa_wait: relaxed, late costs a cycle */
    _Atomic uint32_t phase;                 /* enum worker_phase: A10 release <-> R10 acquire */
    _Atomic bool stop;                      /* A11 release <-> R11 acquire */
    tfa_worker_statistics statistics;       /* its heartbeat: relaxed, only changes matter */
    void *own_statistics;                   /* the memory of it, or NULL */
    size_t own_bytes;

    const tfa_worker_robot *robots;          /* one of `solver_lists`: the worker's own */
    _Atomic(const tfa_worker_robot *) offer; /* A12, R12 */
    _Atomic(const tfa_worker_robot *) taken; /* A13, R13 */
    tfa_worker_robot *solver_lists[2];       /* the one offered last, and the previous one */
    uint32_t latest;                         /* which; under the mutex */
    tfa_robot_taps taps;
    uint32_t robot_count;
    uint32_t spin_ns, turn_ns;
    tfa_wait wait;

    /* the worker's thread */
    tfa_cost_table *costs;     /* by robot */
    uint64_t virtual_clock;    /* virtual time of the client that was served last */
    uint64_t now;              /* CLOCK_MONOTONIC ns, when the piece of work before ended */
    uint64_t beats, last_beat; /* cycles; `now` when clients were last shown a heartbeat */
    uint32_t idle;             /* cycles without work, since `idle_since` */
    uint64_t idle_since;
    uint32_t rest_ns;  /* of each REST_EVERY_NS; 0: none */
    uint64_t owed_ns;  /* of rest */
    uint64_t owed_for; /* time until which it is counted */
    worker_warm_up warm_up;
    worker_long_states long_states;
    tfa_worker_client *ready[TFA_WORKER_CLIENTS_MAX]; /* of a cycle */

    int epoll, wake_event; /* wake_event: in epoll */
    pthread_mutex_t mutex;
};

/* ---- clock.c ---- */

/* CLOCK_MONOTONIC, ns. */
uint64_t tfa_worker_clock(void);
/* Sleeps for so long, whatever comes meanwhile. */
void tfa_worker_nap(uint64_t ns);

/* The lines that counting a request writes. */
static inline void tfa_worker_prefetch_tally(const tfa_worker_client *client)
{
    __builtin_prefetch(&client->shared->tally.version, 1);
    __builtin_prefetch(&client->shared->tally.words[TFA_TALLY_METHODS], 1);
}

/* ---- admit.c ---- */

int tfa_worker_admit_slowly(const tfa_worker *worker, tfa_worker_client *client, bool in_time);

/* Whether a state of the client's request may take the worker's time: before it begins. A kind that
 * is neither measured nor bounded yet, takes too long, or is doubted goes to the thread beside the
 * worker (REQUEST_WAITING), or is refused. A self-test is answered at any cost. */
static inline int tfa_worker_admit(const tfa_worker *w, tfa_worker_client *client)
{
    const worker_request *at = &client->at;
    const uint32_t most = at->robot->max_state_ns;
    const bool in_time = at->cost->least_ns - 1 < most; /* 0 - 1 is above any limit */
    if (__builtin_expect(!most || (in_time && !client->debt.owed_ns), 1))
        return TFA_OK;
    return tfa_worker_admit_slowly(w, client, in_time);
}

/* Refuses the rest of a request whose first states took longer than their kind. */
bool tfa_worker_cut_short(const tfa_worker *worker, tfa_worker_client *client);

/* ---- turn.c ---- */

/* The client has a request that can go on, or one in its ring. */
bool tfa_worker_client_has_work(const tfa_worker *worker, const tfa_worker_client *client);

/* The reply goes to this slot. */
static inline void tfa_worker_move_reply(tfa_worker_client *client, void *slot)
{
    tfa_wire_move_buffers(client->form.reply_shape.want, client->at.slot, slot, &client->at.reply);
    client->at.slot = slot;
}

/* ---- tap.c ---- */

void tfa_worker_tap_put(tfa_tap *tap, const tfa_worker *worker, tfa_worker_client *client);

/* An answer is complete and not yet published: records it if a recorder is there. */
static inline void tfa_worker_tap_request(const tfa_worker *w, tfa_worker_client *client)
{
    tfa_tap *tap = tfa_robot_taps_get(&w->taps, client->robot); /* R14 */
    if (__builtin_expect(tap != NULL, 0))
        tfa_worker_tap_put(tap, w, client);
}

/* ---- worker.c ---- */

/* After a cycle without work: spins, solves a request again, naps or sleeps. */
void tfa_worker_wait(tfa_worker *worker);

/* ---- long_states.c ---- */

/* A request that waits for the thread, or is there, can go on. */
bool tfa_worker_long_may_go_on(const tfa_worker *worker, const tfa_worker_client *client);
/* The thread is idle and takes a waiting request. */
void tfa_worker_long_give(tfa_worker *worker, tfa_worker_client *client);
/* It has come back, with the reply. @return ns that it took */
uint64_t tfa_worker_long_take_back(tfa_worker *worker, tfa_worker_client *client);
/* After the worker's end: waits for the state that the thread is at. */
void tfa_worker_long_settle(tfa_worker *worker);

/* ---- warm_up.c ---- */

/* TFA_OK; TFA_E_MEMORY. */
TFA_CHECKED int tfa_worker_warm_up_init(worker_warm_up *warm_up, uint32_t period_ns);
/* A client's request was answered: it may be solved again, if it is an ordinary one. */
void tfa_worker_warm_up_keep(const tfa_worker *worker, tfa_worker_client *client);
/* No request that was answered so far is solved again. */
void tfa_worker_warm_up_forget(tfa_worker *worker);
/* Work has ended: the next warm-up is due in a period from now. */
void tfa_worker_warm_up_restart(tfa_worker *worker);
/* Solves a request again if one is due. Between two calls the worker looks at all clients. */
void tfa_worker_warm_up(tfa_worker *worker);

#endif
