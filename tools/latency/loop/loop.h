/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The load of one client, measured: a closed loop, where a request leaves when the reply to the one
 * before is there, or an open loop, where requests leave at their times whatever the replies do.
 */
#ifndef TOOLS_LATENCY_LOOP_LOOP_H
#define TOOLS_LATENCY_LOOP_LOOP_H

#include "tally.h"
#include "transport.h"

#include <totalforce/status.h>

/** Shape of a load. Zero-initialise; count, duration_ns or both end it, whichever is first. */
typedef struct load_shape {
    int open;             /**< times count from when a request was due, not from when it left */
    double rate;          /**< requests a second; 0 (closed loop only): as fast as replies come */
    uint64_t think_ns;    /**< closed loop: pause after each reply */
    uint64_t jitter_ns;   /**< with a rate: each time is late by 0 to this, uniformly */
    uint32_t burst;       /**< with a rate: so many requests are due at once; 0: 1 */
    uint64_t offset_ns;   /**< open loop: of the first time after the start */
    uint64_t count;       /**< of requests; 0: no limit */
    uint64_t duration_ns; /**< 0: no limit */
    uint64_t timeout_ns;  /**< without a reply for this time a request is lost */
    uint64_t deadline_ns; /**< a later reply counts as late; 0: none */
    uint64_t seed;        /**< of the jitter */
    const _Atomic int *stop; /**< set: no more requests leave, replies are awaited; NULL: never */
} load_shape;

/** One client's loop. Made by loop_create; the ids of requests continue from run to run. */
typedef struct loop loop;

/** @param window  requests that are remembered while one before them has no outcome, a power of
 *                 two; beyond it requests count as without room
 *  @return NULL: no memory */
loop *loop_create(transport *t, uint64_t window);
void loop_free(loop *l);

/** A window for a load over a ring of `slots`: no lost reply holds up the requests after it. */
uint64_t loop_window(const load_shape *shape, uint32_t slots);

/** Time of request `index` after the start, with a rate; ns. */
uint64_t load_time(const load_shape *shape, uint64_t index);

/** Requests until the end; 0: as many as the duration allows. */
uint64_t load_count(const load_shape *shape);

/**
 * Runs a load from `start` on. The figures go to `t`; NULL (warm-up): a request without a good
 * reply ends the run.
 * @return TFA_OK; the status of a miss that was the last of 100 in a row, or of a reconnection that
 *         failed
 */
TFA_CHECKED int loop_run(loop *l, const load_shape *shape, uint64_t start, tally *t);

#endif
