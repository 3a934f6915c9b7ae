/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Seats of a worker: how clients come and go; and ports, the clients in this process.
 */
#include "worker_internal.h"

#include <errno.h>
#include <linux/futex.h>
#include <stdlib.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

#include "sigbus.h"

/* ---- attach and detach ---- */

static tfa_seat *free_seat(tfa_worker *w)
{
    for (uint32_t i = 0; i < TFA_WORKER_SEATS; i++)
        if (atomic_load_explicit(&w->seats[i].state, memory_order_relaxed) == SEAT_FREE)
            return &w->seats[i];
    return NULL;
}

static int fill_seat(const tfa_worker *w, const tfa_seat_options *o, tfa_seat *seat)
{
    seat->robot = o->robot;
    seat->shape = w->lists[w->latest][o->robot].shape;
    seat->drained = 0;
    seat->shape.max_batch = o->max_batch;
    seat->wait = o->wait;
    seat->doorbell = o->doorbell;
    seat->guard = -1;
    seat->ring = (tfa_ring_server){.layout = o->layout,
                                   .requests = o->requests,
                                   .replies = o->replies,
                                   .spin = o->wait == TFA_WAIT_SPIN};
    atomic_store_explicit(&seat->count.requests, 0, memory_order_relaxed);
    atomic_store_explicit(&seat->count.rejected, 0, memory_order_relaxed);
    seat->scratch = aligned_alloc(TFA_WIRE_LINE, o->layout.request_stride);
    if (!seat->scratch)
        return TFA_E_MEMORY;
    memset(seat->scratch, 0, o->layout.request_stride); /* no page fault later */
    if (o->internal)
        return TFA_OK;
    seat->guard = tfa_sigbus_guard(o->requests, o->layout.request_bytes);
    return seat->guard >= 0 ? TFA_OK : TFA_E_REFUSED;
}

static int watch_doorbell(const tfa_worker *w, const tfa_seat *seat)
{
    struct epoll_event event = {.events = EPOLLIN | EPOLLET};
    if (seat->doorbell < 0 || epoll_ctl(w->epoll, EPOLL_CTL_ADD, seat->doorbell, &event) == 0)
        return TFA_OK;
    return TFA_E_SYSTEM;
}

static void empty_seat(tfa_seat *seat)
{
    tfa_sigbus_release(seat->guard);
    free(seat->scratch);
    seat->scratch = NULL;
}

static int attach(tfa_worker *w, const tfa_seat_options *o, tfa_seat **out)
{
    tfa_seat *seat = free_seat(w);
    if (!seat)
        return TFA_E_REFUSED;
    int status = fill_seat(w, o, seat);
    if (status == TFA_OK)
        status = watch_doorbell(w, seat);
    if (status != TFA_OK) {
        empty_seat(seat);
        return status;
    }
    atomic_fetch_add_explicit(&w->modes[seat->wait], 1, memory_order_relaxed);
    atomic_store_explicit(&seat->state, SEAT_SITTING, memory_order_release); /* A6 */
    const uint32_t number = (uint32_t)(seat - w->seats);
    if (number >= atomic_load_explicit(&w->seats_used, memory_order_relaxed))
        atomic_store_explicit(&w->seats_used, number + 1, memory_order_release); /* A9 */
    *out = seat;
    return TFA_OK;
}

int tfa_worker_attach(tfa_worker *w, const tfa_seat_options *options, tfa_seat **seat)
{
    *seat = NULL;
    if (options->robot >= w->robot_count)
        return TFA_E_ROBOT;
    pthread_mutex_lock(&w->mutex);
    int status = attach(w, options, seat);
    pthread_mutex_unlock(&w->mutex);
    tfa_worker_kick(w);
    return status;
}

/* Asks the worker for the seat if it was not asked. @return the seat is free */
static bool leave(tfa_worker *w, tfa_seat *seat, uint32_t how)
{
    pthread_mutex_lock(&w->mutex);
    uint32_t state = atomic_load_explicit(&seat->state, memory_order_acquire); /* R8 */
    if (state != how && state != SEAT_LEAVING && state != SEAT_LEFT) {
        atomic_store_explicit(&seat->state, how, memory_order_release); /* A7 */
        state = how;
        tfa_worker_kick(w);
    }
    const bool gone = state == SEAT_LEFT || atomic_load_explicit(&w->phase, memory_order_acquire) !=
                                                WORKER_RUNNING; /* R10 */
    if (gone) {
        if (seat->doorbell >= 0)
            (void)epoll_ctl(w->epoll, EPOLL_CTL_DEL, seat->doorbell, NULL);
        atomic_fetch_sub_explicit(&w->modes[seat->wait], 1, memory_order_relaxed);
        empty_seat(seat);
        atomic_store_explicit(&seat->state, SEAT_FREE, memory_order_relaxed);
    }
    pthread_mutex_unlock(&w->mutex);
    return gone;
}

bool tfa_worker_detach(tfa_worker *w, tfa_seat *seat)
{
    return leave(w, seat, SEAT_LEAVING);
}

bool tfa_worker_drain(tfa_worker *w, tfa_seat *seat)
{
    return leave(w, seat, SEAT_DRAINING);
}

/* ---- other solvers ---- */

void tfa_worker_offer(tfa_worker *w, const tfa_worker_robot *robots)
{
    pthread_mutex_lock(&w->mutex);
    w->latest = 1 - w->latest;
    tfa_worker_robot *list = w->lists[w->latest];
    memcpy(list, robots, w->robot_count * sizeof *list);
    atomic_store_explicit(&w->offer, list, memory_order_release); /* A12 */
    pthread_mutex_unlock(&w->mutex);
    tfa_worker_kick(w);
}

bool tfa_worker_took(const tfa_worker *w)
{
    return atomic_load_explicit(&w->taken, memory_order_acquire) == /* R13 */
               atomic_load_explicit(&w->offer, memory_order_relaxed) ||
           atomic_load_explicit(&w->phase, memory_order_acquire) != WORKER_RUNNING; /* R10 */
}

bool tfa_seat_broken(const tfa_seat *seat)
{
    return atomic_load_explicit(&seat->state, memory_order_relaxed) == SEAT_BROKEN;
}

const tfa_seat_counters *tfa_seat_count(const tfa_seat *seat)
{
    return &seat->count;
}

void tfa_worker_kick(tfa_worker *w)
{
    const uint64_t one = 1;
    ssize_t n;
    do
        n = write(w->kick, &one, sizeof one);
    while (n < 0 && errno == EINTR);
}

void tfa_worker_stop(tfa_worker *w)
{
    atomic_store_explicit(&w->stop, true, memory_order_release); /* A11 */
    tfa_worker_kick(w);
}

const tfa_ring_pulse *tfa_worker_pulse(const tfa_worker *w)
{
    return w->pulse;
}

/* ---- ports ---- */

/* A request through a port comes from threads of this process and of others (with DDS there are
 * three). Where they would queue for the cores that spinning leaves, the worker sleeps instead: on
 * two cores a DDS round trip had a median of 17 or of 107 us with a worker that spins, by where the
 * host put the threads, and 35 us every time with one that sleeps (totalforce latency arm --via dds
 * --wait hybrid, 20000 calls, four runs each, 2026-11-21). */
#define CORES_TO_SPIN 4

static tfa_wait port_wait(const tfa_worker *w)
{
    if (w->wait == TFA_WAIT_BLOCK || sysconf(_SC_NPROCESSORS_ONLN) < CORES_TO_SPIN)
        return TFA_WAIT_BLOCK;
    return TFA_WAIT_HYBRID;
}

static int attach_port(tfa_port *port, uint32_t robot, const tfa_ring_layout *layout)
{
    unsigned char *memory = port->memory;
    const tfa_seat_options options = {.robot = robot,
                                      .max_batch = port->shape.max_batch,
                                      .layout = *layout,
                                      .requests = memory,
                                      .replies = memory + layout->request_bytes,
                                      .wait = port_wait(port->worker),
                                      .doorbell = -1,
                                      .internal = true};
    port->ring = (tfa_ring_client){.layout = *layout,
                                   .requests = memory,
                                   .replies = memory + layout->request_bytes,
                                   .pulse = port->worker->pulse};
    return tfa_worker_attach(port->worker, &options, &port->seat);
}

int tfa_port_open(tfa_worker *w, uint32_t robot, uint32_t slots, uint32_t max_batch, tfa_port *port)
{
    *port = (tfa_port){.worker = w};
    if (robot >= w->robot_count)
        return TFA_E_ROBOT;
    pthread_mutex_lock(&w->mutex);
    port->shape = w->lists[w->latest][robot].shape;
    pthread_mutex_unlock(&w->mutex);
    if (!tfa_ring_slots_valid(slots) || max_batch == 0 || max_batch > port->shape.max_batch)
        return TFA_E_SIZE;
    port->shape.max_batch = max_batch;
    const tfa_ring_layout layout = tfa_ring_layout_of(&port->shape, slots);
    const size_t size = layout.request_bytes + layout.reply_bytes;
    port->memory = aligned_alloc(TFA_WIRE_LINE, size);
    if (!port->memory)
        return TFA_E_MEMORY;
    memset(port->memory, 0, size);
    int status = attach_port(port, robot, &layout);
    if (status != TFA_OK) {
        free(port->memory);
        port->memory = NULL;
    }
    return status;
}

void tfa_port_close(tfa_port *port)
{
    const struct timespec a_while = {.tv_nsec = 100000};
    if (!port->seat)
        return;
    while (!tfa_worker_detach(port->worker, port->seat))
        nanosleep(&a_while, NULL);
    free(port->memory);
    *port = (tfa_port){0};
}

void tfa_port_send(tfa_port *port)
{
    if (tfa_ring_send(&port->ring))
        tfa_worker_kick(port->worker);
}

bool tfa_port_wait(const tfa_port *port, uint64_t index, uint64_t timeout_ns)
{
    const tfa_ring_client *ring = &port->ring;
    const void *slot = ring->replies + tfa_ring_reply_offset(&ring->layout, index);
    const struct timespec time = {.tv_sec = (time_t)(timeout_ns / 1000000000u),
                                  .tv_nsec = (long)(timeout_ns % 1000000000u)};
    uint64_t seq = tfa_ring_client_lie_down(ring, index);
    if (seq <= index) {
        (void)syscall(SYS_futex, tfa_ring_futex_word(slot), FUTEX_WAIT, (uint32_t)seq, &time, NULL,
                      0);
        const tfa_wire_reply *line = slot;
        seq = atomic_load_explicit(&line->seq, memory_order_acquire); /* R2 */
    }
    tfa_ring_client_get_up(ring);
    return seq > index;
}
