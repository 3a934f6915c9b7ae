/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The worker's thread: its life, and how it waits.
 */
#include "worker_internal.h"

#include <stdlib.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <sys/mman.h>
#include <time.h>
#include <unistd.h>

/* Idle cycles between two looks at the clock. */
#define CYCLES_PER_CLOCK_READ 64
/* A sleeping worker shows a sign of life so often. */
#define SLEEP_MS 1000
/* At the end the requests in the rings are answered for at most this time. */
#define DRAIN_NS 100000000u
/* Clients in spin mode that have sent nothing for this time are polled at intervals: one that was
 * stopped would keep a processor busy. */
#define SPIN_IDLE_NS 1000000000u
#define NAP_NS 50000u
#define REST_EVERY_NS 1000000u

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

/* Blocks that only this worker sees. */
static int make_statistics(tfa_worker *w)
{
    const tfa_statistics_layout l =
        tfa_statistics_layout_of(1, w->robot_count, TFA_WORKER_CLIENTS_MAX);
    void *memory = mmap(NULL, l.bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (memory == MAP_FAILED)
        return TFA_E_MEMORY;
    const tfa_statistics_view view = tfa_statistics_view_of(memory, &l);
    w->own_statistics = memory;
    w->own_bytes = l.bytes;
    w->statistics =
        (tfa_worker_statistics){0, view.workers, view.clients, view.departed, view.states};
    return TFA_OK;
}

int tfa_worker_create(const tfa_worker_options *options, tfa_worker **worker)
{
    *worker = NULL;
    tfa_worker *w = aligned_alloc(TFA_CACHE_LINE, sizeof *w);
    if (!w)
        return TFA_E_MEMORY;
    memset(w, 0, sizeof *w);
    pthread_mutex_init(&w->mutex, NULL);
    sem_init(&w->long_states.given, 0, 0);
    w->epoll = w->wake_event = -1;
    w->robot_count = options->robot_count;
    w->spin_ns = options->spin_ns;
    w->wait = options->wait == TFA_WAIT_DEFAULT ? TFA_WAIT_HYBRID : options->wait;
    w->rest_ns = options->rest_ns;
    w->now = w->owed_for = tfa_worker_clock();
    w->turn_ns = options->turn_ns ? options->turn_ns : TFA_WORKER_TURN_US * 1000;
    int status = tfa_worker_warm_up_init(&w->warm_up, options->warm_ns);
    w->costs = calloc(options->robot_count, sizeof *w->costs);
    w->taps.taps = calloc(options->robot_count, sizeof *w->taps.taps);
    for (int i = 0; i < 2; i++)
        w->solver_lists[i] = calloc(options->robot_count, sizeof *w->solver_lists[i]);
    if (!w->costs || !w->taps.taps || !w->solver_lists[0] || !w->solver_lists[1])
        status = TFA_E_MEMORY;
    if (options->statistics)
        w->statistics = *options->statistics;
    else if (status == TFA_OK)
        status = make_statistics(w);
    if (status == TFA_OK)
        status = open_descriptors(w);
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
    sem_destroy(&w->long_states.given);
    if (w->own_statistics)
        munmap(w->own_statistics, w->own_bytes);
    free(w->warm_up.reply);
    free(w->costs);
    free((void *)w->taps.taps);
    free(w->solver_lists[0]);
    free(w->solver_lists[1]);
    free(w);
}

/* ---- rest ---- */

/* What it runs makes it owe a part of that, what it sleeps pays; nothing is saved up. */
static void count_time(tfa_worker *w, bool slept)
{
    const uint64_t time = w->now - w->owed_for;
    w->owed_for = w->now;
    if (!slept)
        w->owed_ns += time * w->rest_ns / REST_EVERY_NS;
    else
        w->owed_ns -= time < w->owed_ns ? time : w->owed_ns;
}

/* The kernel stops a real-time thread that takes more than its share of a second, for 50 ms by its
 * default. Short rests in time keep it below. */
void tfa_worker_rest(tfa_worker *w)
{
    if (w->rest_ns == 0)
        return;
    count_time(w, false);
    if (w->owed_ns < w->rest_ns)
        return;
    tfa_worker_nap(w->owed_ns);
    w->now = w->owed_for = tfa_worker_clock();
    w->owed_ns = 0;
}

/* ---- waiting ---- */

static bool is_attached(const tfa_worker_client *client)
{
    return atomic_load_explicit(&client->state, memory_order_acquire) == CLIENT_ATTACHED; /* R6 */
}

/* A3, for each client. One that is attached meanwhile wakes the worker by its attachment. Asleep,
 * nothing is queued. */
static void show_asleep(const tfa_worker *w, uint32_t used, uint32_t asleep)
{
    for (uint32_t i = 0; i < used; i++) {
        const tfa_worker_client *client = &w->clients[i];
        if (!is_attached(client))
            continue;
        atomic_store_explicit(&tfa_ring_worker_status_of(&client->ring)->asleep, asleep,
                              memory_order_seq_cst); /* A3 */
        atomic_store_explicit(&client->shared->queued, 0, memory_order_relaxed);
    }
}

/* After A3: whether there is work after all. Events that are no request come with a wake-up, which
 * epoll remembers. */
static bool has_work(const tfa_worker *w, uint32_t used)
{
    for (uint32_t i = 0; i < used; i++)
        if (is_attached(&w->clients[i]) && tfa_worker_client_has_work(w, &w->clients[i]))
            return true;
    return false;
}

void tfa_worker_sleep(tfa_worker *w, int timeout_ms)
{
    const uint32_t used = atomic_load_explicit(&w->clients_used, memory_order_acquire); /* R9 */
    struct epoll_event events[8];
    show_asleep(w, used, 1);
    /* edge triggered: doorbells are never read, so a client cannot make reading them block */
    if (!has_work(w, used))
        (void)epoll_wait(w->epoll, events, 8, timeout_ms);
    show_asleep(w, used, 0);
    w->now = tfa_worker_clock();
    count_time(w, true);
}

/* The most eager wish among the clients; without clients there is nothing to spin for. */
static tfa_wait mode_of(const tfa_worker *w)
{
    uint32_t clients[TFA_WAIT_MODES];
    for (int i = 0; i < TFA_WAIT_MODES; i++)
        clients[i] = atomic_load_explicit(&w->modes[i], memory_order_relaxed);
    if (w->wait == TFA_WAIT_SPIN || clients[TFA_WAIT_SPIN])
        return TFA_WAIT_SPIN;
    return clients[TFA_WAIT_HYBRID] ? TFA_WAIT_HYBRID : TFA_WAIT_BLOCK;
}

/* Looks at the clock now and then. @return the worker has spun for as long as its mode lets it */
static bool spin(tfa_worker *w, tfa_wait mode)
{
    if (++w->idle % CYCLES_PER_CLOCK_READ != 0)
        return false;
    w->now = tfa_worker_clock();
    if (w->idle == CYCLES_PER_CLOCK_READ) {
        w->idle_since = w->now;
        tfa_worker_warm_up_restart(w);
    }
    if (w->now - w->idle_since > (mode == TFA_WAIT_SPIN ? SPIN_IDLE_NS : w->spin_ns))
        return true;
    tfa_worker_warm_up(w);
    return false;
}

void tfa_worker_wait(tfa_worker *w)
{
    const tfa_wait mode = mode_of(w);
    tfa_ring_cpu_relax();
    if (mode != TFA_WAIT_BLOCK && !spin(w, mode))
        return;
    if (mode == TFA_WAIT_SPIN) {
        tfa_worker_nap(NAP_NS);
        w->idle = 2 * CYCLES_PER_CLOCK_READ - 1; /* looks at the clock in the next cycle, too */
        return;
    }
    tfa_worker_sleep(w, SLEEP_MS);
    w->idle = 0;
}

void tfa_worker_run(tfa_worker *w)
{
    w->now = w->owed_for = tfa_worker_clock();
    atomic_store_explicit(&w->phase, WORKER_RUNNING, memory_order_release); /* A10 */
    while (!atomic_load_explicit(&w->stop, memory_order_acquire)) {         /* R11 */
        if (tfa_worker_cycle(w))
            w->idle = 0;
        else
            tfa_worker_wait(w);
        tfa_worker_rest(w);
    }
    const uint64_t end = tfa_worker_clock() + DRAIN_NS;
    while (tfa_worker_cycle(w) && w->now < end)
        ;
    tfa_worker_long_settle(w);
    atomic_store_explicit(&w->phase, WORKER_ENDED, memory_order_release); /* A10 */
}
