/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The command line of `totalforce latency`: what is sent which way, and where reports go.
 */
#ifndef TOOLS_LATENCY_WORKLOAD_OPTIONS_H
#define TOOLS_LATENCY_WORKLOAD_OPTIONS_H

#include "common/daemon.h"

#include <totalforce/client.h>
#include <totalforce/dynamics.h>

/** Ways to an answer, in the order of the report. */
typedef enum latency_via {
    VIA_SHM,
    VIA_DDS,
    VIA_ROS2,
    VIA_PROCESS, /**< the library, in this process */
    VIA_SOCKET,  /**< echo of as many bytes over a Unix socket, without a solve */
    VIA_COUNT
} latency_via;

/** "shm", "dds", "ros2", "process", "socket" */
extern const char *const latency_via_names[VIA_COUNT];

enum { CLIENTS_MAX = 256, COMPARED_MAX = 2 };

/** The command line; of a run of a sweep with the values of its row. */
typedef struct latency_options {
    daemon_options daemon;
    unsigned vias;   /**< bit mask of latency_via */
    int open;        /**< loop */
    uint64_t count;  /**< of each client; 0: by seconds */
    double seconds;  /**< 0: by count */
    uint64_t warmup; /**< round trips of each client before */
    double rate;     /**< requests a second of each client; 0: as fast as replies come */
    double think_us, jitter_us;
    uint32_t burst, clients;
    uint32_t compute_load, memory_load; /**< threads of background load */
    uint32_t batch;
    tfa_method method;
    tfa_estimate estimate;
    int cpu;      /**< of the clients, or -1 */
    int priority; /**< SCHED_FIFO; 0: none */
    int mlock;
    const char *urdf;
    uint64_t baseline_ms; /**< duration of timer loop and gap detector */
    double deadline_us;   /**< a later reply counts as late; 0: none */
    double fail_p99_us;   /**< 0: no such expectation */
    double fail_ratio;    /**< 0: no such expectation */
    char *sweep;          /**< "KEY=VALUE,..."; NULL: none */
    int json, cyclictest;
    const char *csv, *table, *histogram, *html, *save;
    const char *compare[COMPARED_MAX];
    int compare_count;
    tfa_client_info known; /**< robot as an earlier run found it; q_count 0: not yet */
} latency_options;

/** Reads the command line. @return 0, or errno of argp */
int latency_options_parse(latency_options *options, int argc, char **argv);

#endif
