/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The floor under every shared-memory round trip: cache lines each way between two processes.
 */
#ifndef TOOLS_LATENCY_MACHINE_PINGPONG_H
#define TOOLS_LATENCY_MACHINE_PINGPONG_H

#include <sched.h>
#include <stdint.h>
#include <totalforce/histogram.h>
#include <totalforce/status.h>

#include "common/environment.h"

/** Cache lines of 64 bytes each way, 1..PINGPONG_LINES_MAX; the first holds the number. */
typedef struct pingpong_size {
    uint32_t request_lines, reply_lines;
} pingpong_size;

#define PINGPONG_LINES_MAX 4096

/** Longest run: on an idle machine the round trips take a tenth of a second. */
#define PINGPONG_LIMIT_NS UINT64_C(2000000000)

/**
 * Bounces a number, and lines of payload with it, between this process and a child, both spinning,
 * and times every round trip.
 * @param count   round trips measured, after `warmup` that are not
 * @param limit   longest duration, ns: where it ends the run, h holds what was measured until then
 * @param others  processors for the child; NULL: wherever this process may run
 * @param[out] h  round-trip times in ns, the cost of reading the clock (twice) included as it is in
 *                every other figure of `totalforce latency`
 * @return TFA_OK; TFA_E_SYSTEM (no memory, no process; errno); TFA_E_TIMEOUT (the limit: the two
 *         processes do not have a processor each).
 */
TFA_CHECKED int pingpong_run(pingpong_size size, uint64_t count, uint64_t warmup, uint64_t limit,
                             const cpu_set_t *others, tfa_histogram *h);

#endif
