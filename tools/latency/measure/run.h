/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Measured runs: those of a session, and each with a thread for every client.
 */
#ifndef TOOLS_LATENCY_MEASURE_RUN_H
#define TOOLS_LATENCY_MEASURE_RUN_H

#include "common/environment.h"
#include "latency/loop/loop.h"
#include "latency/machine/machine.h"
#include "latency/workload/states.h"

/** One client of a run. */
typedef struct latency_client {
    tally *figures;
    thread_usage usage; /**< while measuring */
    int status;         /**< that ended it */
} latency_client;

/** One measured run. */
typedef struct latency_run {
    latency_options options;
    latency_via via;
    const char *swept; /**< value of the sweep; NULL: no sweep */
    transport_facts facts;
    tally *total; /**< of all clients */
    latency_client *clients;
    uint32_t client_count;
    thread_usage threads[THREADS_MAX]; /**< of the daemon, while measuring */
    int thread_count;
    double daemon_cpu, tool_cpu; /**< processors kept busy on average; -1: unknown */
    machine_busy busy;           /**< while measuring */
    const char *ended_early;     /**< why; NULL: it did not */
    latency_states states;
} latency_run;

/** Runs of the options: of every transport and value of the sweep. @return their number, with
 *  *runs to be freed by latency_runs_free; 0: no memory */
int latency_plan(const latency_options *options, latency_run **runs);
void latency_runs_free(latency_run *runs, int count);

/** Runs warm-up and measurement. SIGINT and SIGTERM end a measurement early, once. Prints the error
 *  when there is one. @return TFA_OK, or the status that ended the run; `total` has the figures
 *  until then. */
TFA_CHECKED int latency_measure(latency_run *run);

/** Shape of the load of client `k`. */
load_shape latency_shape(const latency_options *options, uint32_t k);

#endif
