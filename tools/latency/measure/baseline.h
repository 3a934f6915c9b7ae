/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The floor under round trips, from the same session.
 */
#ifndef TOOLS_LATENCY_MEASURE_BASELINE_H
#define TOOLS_LATENCY_MEASURE_BASELINE_H

#include "latency/machine/pingpong.h"
#include "run.h"

/** Baseline of the round trip, from the same session. ns. */
typedef struct latency_baseline {
    latency_times pingpong;
    int have_pingpong;
    cpu_set_t others;        /**< with --cpu: where the other side of a ping-pong runs */
    int pinned;              /**< others holds a processor */
    latency_times same_size; /**< a ping-pong of as many lines as a request and its reply have */
    pingpong_size size;      /**< of same_size */
    latency_times solve;     /**< the same requests in process; empty without --urdf */
    machine_timer timer;
    machine_gaps gaps;
    machine_busy busy; /**< before the first run */
} latency_baseline;

/** Makes an empty baseline. */
void latency_baseline_init(latency_baseline *baseline);

/** Before the daemon has a client, so that its spinning worker does not take part: ping-pong, timer
 *  loop, gaps. Pins this thread with --cpu. @return 0, or -1 after a message */
int latency_measure_machine(const latency_options *options, latency_baseline *baseline);

/** After the runs, when the size of a request is known and the worker has no client again. */
void latency_measure_same_size(const latency_run *run, latency_baseline *baseline);

/** Solves the requests of `run` in process with the model in options->urdf. Prints errors.
 *  @return TFA_OK; TFA_E_MODEL; TFA_E_SIZE (another robot); as tfa_compute. */
TFA_CHECKED int latency_solve(const latency_run *run, tfa_histogram *h);

#endif
