/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A responder with a scripted pattern of delays, losses, duplicates and refusals, and a clock that
 * moves only when the measuring loop waits.
 */
#ifndef TFA_TESTS_TOOLS_LATENCY_SCRIPT_H
#define TFA_TESTS_TOOLS_LATENCY_SCRIPT_H

#include "latency/loop/loop.h"

#define US UINT64_C(1000) /* ns */
#define MS UINT64_C(1000000)
#define SECOND UINT64_C(1000000000)

/** What happens to one request. */
typedef struct script_line {
    uint64_t delay;  /**< ns from the send to the reply; of a queue: of the service */
    int lost;        /**< no reply */
    uint64_t repeat; /**< ns after the reply it comes again; 0: it does not */
    int status;      /**< of the reply */
} script_line;

/** A stretch of time in which a queue serves nothing. */
typedef struct script_stall {
    uint64_t begin, end;
} script_stall;

typedef struct script {
    transport base;
    const script_line *lines;
    uint64_t count;
    int queue; /**< one request at a time, in order; otherwise all at once */
    script_stall stall;
    uint32_t slots;    /**< of the ring */
    uint64_t hang_ups; /**< the connection ends when that many requests were sent; 0: never */

    uint64_t now, busy_until, sent, reconnections;
    uint32_t outstanding;
    struct script_reply {
        uint64_t at;
        transport_answer answer;
        int frees;
    } * replies; /**< not delivered, by time */
    uint64_t reply_count, reply_room;
} script;

/** Parts of a round trip of the script: request a tenth, queue two, compute three, the reply the
 *  rest. */
void script_init(script *s, const script_line *lines, uint64_t count, uint32_t slots);
void script_free(script *s);

/** Numbers of a fixed sequence, 0 .. below - 1. */
uint64_t script_draw(uint64_t *seed, uint64_t below);
/** Lines of 1 to 21 us, now and then far more; the caller frees them. */
script_line *script_delays(uint64_t count);
/** Index of the line with the longest delay. */
uint64_t script_slowest(const script_line *lines, uint64_t count);

#endif
