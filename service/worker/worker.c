/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The worker's thread: takes requests, solves, answers, waits.
 */
#include "worker_internal.h"

#include <errno.h>
#include <limits.h>
#include <linux/futex.h>
#include <stdlib.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

#include "platform/sigbus.h"

/* Requests of one client in one turn: a client with a full ring delays another by at most so many
 * of its own; by one part of one if they are long. */
#define REQUESTS_PER_TURN 4
/* Idle cycles between two looks at the clock. */
#define CYCLES_PER_CLOCK_READ 64
/* A sleeping worker shows a sign of life so often. */
#define SLEEP_MS 1000
/* At the end, clients that never stop asking are not waited for. */
#define DRAIN_CYCLES 4096

static uint64_t clock_ns(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (uint64_t)t.tv_sec * 1000000000u + (uint64_t)t.tv_nsec;
}

/* ---- life ---- */

static int open_descriptors(tfa_worker *w)
{
    struct epoll_event event = {.events = EPOLLIN | EPOLLET};
    w->epoll = epoll_create1(EPOLL_CLOEXEC);
    w->wake_event = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    if (w->epoll < 0 || w->wake_event < 0)
        return TFA_E_SYSTEM;
    return epoll_ctl(w->epoll, EPOLL_CTL_ADD, w->wake_event, &event) == 0 ? TFA_OK : TFA_E_SYSTEM;
}

int tfa_worker_create(const tfa_worker_options *options, tfa_worker **worker)
{
    *worker = NULL;
    tfa_worker *w = aligned_alloc(TFA_WIRE_LINE, sizeof *w);
    if (!w)
        return TFA_E_MEMORY;
    memset(w, 0, sizeof *w);
    pthread_mutex_init(&w->mutex, NULL);
    w->epoll = w->wake_event = -1;
    w->robot_count = options->robot_count;
    w->spin_ns = options->spin_ns;
    w->wait = options->wait == TFA_WAIT_DEFAULT ? TFA_WAIT_HYBRID : options->wait;
    w->worker_status = options->worker_status ? options->worker_status : &w->private_status;
    for (int i = 0; i < 2; i++)
        w->solver_lists[i] = calloc(options->robot_count, sizeof *w->solver_lists[i]);
    int status = w->solver_lists[0] && w->solver_lists[1] ? open_descriptors(w) : TFA_E_MEMORY;
    if (status != TFA_OK) {
        tfa_worker_destroy(w);
        return status;
    }
    memcpy(w->solver_lists[0], options->robots, options->robot_count * sizeof *w->solver_lists[0]);
    w->robots = w->solver_lists[0];
    atomic_store_explicit(&w->offer, w->robots, memory_order_relaxed);
    atomic_store_explicit(&w->taken, w->robots, memory_order_relaxed);
    *worker = w;
    return TFA_OK;
}

void tfa_worker_destroy(tfa_worker *w)
{
    if (!w)
        return;
    if (w->epoll >= 0)
        close(w->epoll);
    if (w->wake_event >= 0)
        close(w->wake_event);
    pthread_mutex_destroy(&w->mutex);
    free(w->solver_lists[0]);
    free(w->solver_lists[1]);
    free(w);
}

/* ---- requests ---- */

static void wake_client(const void *reply_slot)
{
    (void)syscall(SYS_futex, tfa_ring_futex_word(reply_slot), FUTEX_WAKE, INT_MAX, NULL, NULL, 0);
}

/* Solves the private copy of a request into a reply slot. @return status of the reply */
static int solve_request(const tfa_worker *w, const tfa_worker_client *client, void *slot,
                         const tfa_yield *yield)
{
    const tfa_worker_robot *robot = &w->robots[client->robot];
    tfa_reply reply = {.status = TFA_OK};
    tfa_request request;
    tfa_wire_reply_shape reply_shape;
    int status = tfa_wire_decode_request(&client->shape, client->scratch, &request, &reply_shape,
                                         &reply.field);
    if (status == TFA_OK) {
        tfa_wire_reply_buffers(&client->shape, &reply_shape, slot, &reply);
        status = robot->solve(robot->self, &request, &reply, yield);
    }
    reply.status = status;
    tfa_wire_encode_reply(&reply, reply_shape.want, slot);
    return status;
}

static void count_request(tfa_worker_client *client, int status)
{
    /* one writer: no read-modify-write needed */
    uint64_t n = atomic_load_explicit(&client->count.requests, memory_order_relaxed);
    atomic_store_explicit(&client->count.requests, n + 1, memory_order_relaxed);
    if (tfa_wire_has_answers(status))
        return;
    n = atomic_load_explicit(&client->count.rejected, memory_order_relaxed);
    atomic_store_explicit(&client->count.rejected, n + 1, memory_order_relaxed);
}

/* Other solvers may have been offered. */
static void accept_offer(tfa_worker *w)
{
    const tfa_worker_robot *offer = atomic_load_explicit(&w->offer, memory_order_acquire); /* R12 */
    if (offer == w->robots)
        return;
    w->robots = offer;
    atomic_store_explicit(&w->taken, offer, memory_order_release); /* A13 */
}

/* A long request under way. */
typedef struct nested_service {
    tfa_worker *worker;
    const tfa_worker_client *interrupted; /* whose it is */
} nested_service;

static void serve_short_requests(void *context);

/* A private copy of the next request, which is there. @return false: the client's memory is gone */
static bool copy_request(tfa_worker_client *client)
{
    tfa_ring_prefetch_for_write(tfa_ring_reply(&client->ring));
    tfa_wire_copy_request(&client->shape, tfa_ring_request(&client->ring), client->scratch);
    return !tfa_sigbus_hit(client->guard);
}

/* Is the private copy that of a long request? */
static bool is_long(const tfa_worker *w, const tfa_worker_client *client)
{
    const tfa_wire_request *request = client->scratch;
    const uint32_t cut = w->robots[client->robot].cut;
    return cut && request->count > cut;
}

/* Answers the request of which there is a private copy. `now`: in, when it was seen and when its
 * turn came; out, when it was done. */
static void serve(tfa_worker *w, tfa_worker_client *client, uint64_t received, uint64_t *now)
{
    nested_service nested = {w, client};
    const tfa_yield yield = {serve_short_requests, &nested};
    tfa_wire_reply *line = tfa_ring_reply(&client->ring);
    const tfa_wire_request *request = client->scratch;
    /* it came after the turn began: a client that answers a reply within it */
    if (request->t_sent > *now)
        *now = clock_ns();
    if (request->t_sent > received)
        received = *now;
    const uint64_t start = *now;
    const int status = solve_request(w, client, line, is_long(w, client) ? &yield : NULL);
    line->id = request->id;
    line->t_received = received;
    line->t_start = start;
    line->t_done = *now = clock_ns();
    count_request(client, status);
    if (tfa_ring_publish(&client->ring))
        wake_client(line);
}

/* No more requests of this client. It may be leaving at the same moment: then it stays so. */
static void mark_broken(tfa_worker_client *client)
{
    uint32_t attached = CLIENT_ATTACHED;
    atomic_compare_exchange_strong_explicit(&client->state, &attached, CLIENT_BROKEN,
                                            memory_order_relaxed, memory_order_relaxed);
}

/* A turn of one client, which a long request ends. Between the parts of another's long request
 * (`interlude`) solvers stay the ones that it began with, and long ones wait. */
static uint32_t serve_client(tfa_worker *w, tfa_worker_client *client, bool in_between)
{
    uint64_t received = 0, now = 0;
    uint32_t served = 0;
    bool may_continue = true;
    tfa_ring_state state;
    while ((state = tfa_ring_poll(&client->ring)) == TFA_RING_READY && may_continue &&
           served < REQUESTS_PER_TURN) {
        if (served == 0)
            received = now = clock_ns();
        if (!in_between)
            accept_offer(w);
        if (!copy_request(client)) {
            state = TFA_RING_BROKEN;
            break;
        }
        may_continue = !is_long(w, client);
        if (in_between && !may_continue)
            break;
        serve(w, client, received, &now);
        served++;
    }
    if (state == TFA_RING_BROKEN || tfa_sigbus_hit(client->guard))
        mark_broken(client);
    return served;
}

static void update_heartbeat(tfa_worker *w)
{
    atomic_store_explicit(&w->worker_status->heartbeat, ++w->heartbeat_count,
                          memory_order_relaxed); /* A5 */
}

/* A long request pauses: short requests of all others. A client that leaves waits for the
 * end of it. */
static void serve_short_requests(void *context)
{
    const nested_service *i = context;
    tfa_worker *w = i->worker;
    const uint32_t used = atomic_load_explicit(&w->clients_used, memory_order_acquire); /* R9 */
    for (uint32_t k = 0; k < used; k++) {
        tfa_worker_client *client = &w->clients[k];
        if (client != i->interrupted &&
            atomic_load_explicit(&client->state, memory_order_acquire) == CLIENT_ATTACHED) /* R6 */
            (void)serve_client(w, client, true);
    }
    update_heartbeat(w);
}

static void mark_detached(tfa_worker_client *client, uint32_t state)
{
    atomic_compare_exchange_strong_explicit(&client->state, &state, CLIENT_DETACHED,
                                            memory_order_release, memory_order_relaxed); /* A8 */
}

/* Answers earlier requests of a client that is detached: no more than the ring holds. */
static uint32_t drain_client(tfa_worker *w, tfa_worker_client *client)
{
    const uint32_t served = serve_client(w, client, false);
    client->drained += served;
    if (served == 0 || client->drained >= client->ring.layout.slots ||
        tfa_sigbus_hit(client->guard))
        mark_detached(client, CLIENT_DRAINING);
    return served;
}

uint32_t tfa_worker_cycle(tfa_worker *w)
{
    const uint32_t used = atomic_load_explicit(&w->clients_used, memory_order_acquire); /* R9 */
    uint32_t served = 0;
    accept_offer(w);
    for (uint32_t i = 0; i < used; i++) {
        tfa_worker_client *client = &w->clients[i];
        switch (atomic_load_explicit(&client->state, memory_order_acquire)) { /* R6, R7 */
        case CLIENT_ATTACHED:
            served += serve_client(w, client, false);
            break;
        case CLIENT_DETACHING:
            mark_detached(client, CLIENT_DETACHING);
            break;
        case CLIENT_DRAINING:
            served += drain_client(w, client);
            break;
        default:
            break;
        }
    }
    update_heartbeat(w);
    return served;
}

/* ---- waiting ---- */

/* After A3: whether there is work after all. Events that are no request come with a wake-up, which
 * epoll remembers. */
static bool has_work(const tfa_worker *w)
{
    const uint32_t used = atomic_load_explicit(&w->clients_used, memory_order_acquire); /* R9 */
    for (uint32_t i = 0; i < used; i++) {
        const tfa_worker_client *client = &w->clients[i];
        if (atomic_load_explicit(&client->state, memory_order_acquire) ==
                CLIENT_ATTACHED && /* R6 */
            tfa_ring_poll_last(&client->ring) != TFA_RING_EMPTY)
            return true;
    }
    return false;
}

void tfa_worker_sleep(tfa_worker *w, int timeout_ms)
{
    struct epoll_event events[8];
    atomic_store_explicit(&w->worker_status->asleep, 1, memory_order_seq_cst); /* A3 */
    /* edge triggered: doorbells are never read, so a client cannot make reading them block */
    if (!has_work(w))
        (void)epoll_wait(w->epoll, events, 8, timeout_ms);
    atomic_store_explicit(&w->worker_status->asleep, 0, memory_order_relaxed); /* A3 */
}

/* The most eager wish among the clients; without clients there is nothing to spin for. */
static tfa_wait mode_of(const tfa_worker *w)
{
    uint32_t clients[4];
    for (int i = 0; i < 4; i++)
        clients[i] = atomic_load_explicit(&w->modes[i], memory_order_relaxed);
    if (w->wait == TFA_WAIT_SPIN || clients[TFA_WAIT_SPIN])
        return TFA_WAIT_SPIN;
    if (clients[TFA_WAIT_HYBRID])
        return TFA_WAIT_HYBRID;
    return TFA_WAIT_BLOCK;
}

/* Has the worker been idle long enough to sleep? `idle` counts cycles, `since` is the first look
 * at the clock in this idle time. */
static bool should_sleep(const tfa_worker *w, uint32_t idle, uint64_t *since)
{
    switch (mode_of(w)) {
    case TFA_WAIT_SPIN:
        return false;
    case TFA_WAIT_HYBRID:
        break;
    default:
        return true;
    }
    if (idle % CYCLES_PER_CLOCK_READ != 0)
        return false;
    const uint64_t now = clock_ns();
    if (idle == CYCLES_PER_CLOCK_READ)
        *since = now;
    return now - *since > w->spin_ns;
}

void tfa_worker_run(tfa_worker *w)
{
    uint32_t idle = 0;
    uint64_t since = 0;
    atomic_store_explicit(&w->phase, WORKER_RUNNING, memory_order_release); /* A10 */
    while (!atomic_load_explicit(&w->stop, memory_order_acquire)) {         /* R11 */
        if (tfa_worker_cycle(w)) {
            idle = 0;
            continue;
        }
        tfa_ring_cpu_relax();
        idle = idle == UINT32_MAX ? 2 * CYCLES_PER_CLOCK_READ : idle + 1;
        if (should_sleep(w, idle, &since)) {
            tfa_worker_sleep(w, SLEEP_MS);
            idle = 0;
        }
    }
    for (uint32_t i = 0; i < DRAIN_CYCLES && tfa_worker_cycle(w); i++)
        ;
    atomic_store_explicit(&w->phase, WORKER_ENDED, memory_order_release); /* A10 */
}
