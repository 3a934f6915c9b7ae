/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Waiting for a reply: spins, sleeps on the reply's futex word, and checks now and then that the
 * daemon lives.
 */
#include <errno.h>
#include <limits.h>
#include <linux/futex.h>
#include <poll.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

#include "client/client.h"

/* Spins between two reads of the clock (31 ns): about 1 us */
#define SPINS_PER_CLOCK_READ 64
/* Interval of liveness checks while spinning. The worker's heartbeat does not suffice: it continues
 * when the daemon hung up on this client only, for instance after a reload changed the robot's
 * shape. A check is a system call, so it is rare. */
#define LIVENESS_CHECK_NS 100000000u
/* A worker that shows no progress for this time does not run: it does so a hundred times a second,
 * or once a second while it sleeps. */
#define STALL_NS 3000000000u
/* Longest sleep without a liveness check */
#define WAIT_SLICE_NS 20000000u

uint64_t tfa_clock_ns(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (uint64_t)t.tv_sec * 1000000000u + (uint64_t)t.tv_nsec;
}

bool tfa_connection_hung_up(const client_connection *connection)
{
    struct pollfd fd = {.fd = connection->socket, .events = POLLRDHUP};
    return poll(&fd, 1, 0) > 0 && (fd.revents & (POLLHUP | POLLRDHUP | POLLERR | POLLNVAL)) != 0;
}

/* @return true: a check is due; *last_check: 0 at first */
static bool liveness_check_is_due(uint64_t *last_check, uint64_t now)
{
    if (*last_check == 0)
        *last_check = now;
    if (now - *last_check < LIVENESS_CHECK_NS)
        return false;
    *last_check = now;
    return true;
}

/* The worker's heartbeat does not advance. */
static bool is_stalled(client_connection *c, uint64_t now)
{
    const uint64_t beat =
        atomic_load_explicit(&c->ring.worker_status->heartbeat, memory_order_relaxed); /* R5 */
    if (beat != c->heartbeat || c->beat_seen == 0) {
        c->heartbeat = beat;
        c->beat_seen = now;
    }
    return now - c->beat_seen > STALL_NS;
}

/* Spins until the reply is there or until `end`. @return TFA_OK, TFA_E_TIMEOUT (end reached) or
 * TFA_E_DISCONNECTED */
static int spin_until(client_connection *c, uint64_t end)
{
    uint64_t last_check = 0;
    for (;;) {
        for (int i = 0; i < SPINS_PER_CLOCK_READ; i++) {
            if (tfa_ring_reply_ready(&c->ring))
                return TFA_OK;
            tfa_ring_cpu_relax();
        }
        const uint64_t now = tfa_clock_ns();
        if (now >= end)
            return tfa_ring_reply_ready(&c->ring) ? TFA_OK : TFA_E_TIMEOUT;
        if (!liveness_check_is_due(&last_check, now))
            continue;
        if (tfa_connection_hung_up(c))
            return tfa_ring_reply_ready(&c->ring) ? TFA_OK : TFA_E_DISCONNECTED;
        if (end == UINT64_MAX && is_stalled(c, now))
            return TFA_E_TIMEOUT;
    }
}

static void futex_wait(const uint32_t *word, uint32_t value, uint64_t ns)
{
    const struct timespec time = {.tv_sec = (time_t)(ns / 1000000000u),
                                  .tv_nsec = (long)(ns % 1000000000u)};
    /* woken, timed out, interrupted or changed: the caller checks again */
    (void)syscall(SYS_futex, word, FUTEX_WAIT, value, &time, NULL, 0);
}

static int wait_until(client_connection *c, uint64_t deadline)
{
    const tfa_ring_client *ring = &c->ring;
    int status;
    for (;;) {
        const uint64_t seq = tfa_ring_client_prepare_wait(ring, ring->received);
        status = TFA_OK;
        if (seq == ring->received + 1)
            break;
        const uint64_t now = tfa_clock_ns();
        status = TFA_E_TIMEOUT;
        if (now >= deadline || (deadline == UINT64_MAX && is_stalled(c, now)))
            break;
        const uint64_t left = deadline - now;
        futex_wait(tfa_ring_futex_word(tfa_ring_oldest_reply(ring)), (uint32_t)seq,
                   left < WAIT_SLICE_NS ? left : WAIT_SLICE_NS);
        status = TFA_OK;
        if (tfa_ring_reply_ready(ring))
            break;
        status = TFA_E_DISCONNECTED;
        if (tfa_connection_hung_up(c) && !tfa_ring_reply_ready(ring))
            break;
    }
    tfa_ring_client_end_wait(ring);
    return status;
}

int tfa_connection_wait(tfa_client *client, uint64_t deadline)
{
    if (tfa_ring_reply_ready(&client->connection.ring))
        return TFA_OK;
    uint64_t spin_end = UINT64_MAX;
    client->connection.beat_seen = 0;
    if (client->info.wait == TFA_WAIT_HYBRID)
        spin_end = tfa_clock_ns() + client->spin_ns;
    else if (client->info.wait == TFA_WAIT_BLOCK)
        spin_end = 0;
    if (spin_end != 0) {
        int status = spin_until(&client->connection, spin_end < deadline ? spin_end : deadline);
        if (status != TFA_E_TIMEOUT || spin_end >= deadline)
            return status;
    }
    return wait_until(&client->connection, deadline);
}
