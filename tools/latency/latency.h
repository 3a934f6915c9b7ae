/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The parts of `totalforce latency`: options, one measured run, the report.
 */
#ifndef TOOLS_LATENCY_LATENCY_H
#define TOOLS_LATENCY_LATENCY_H

#include "common/daemon.h"
#include "common/environment.h"
#include "hgrm.h"
#include "pingpong.h"

#include <stdio.h>
#include <totalforce/dynamics.h>

/** Resolution of its histograms, 0.8 %, and their buckets. */
#define LATENCY_BITS 8
#define LATENCY_BUCKETS TFA_HISTOGRAM_BUCKETS(LATENCY_BITS, 64)

/** The command line. */
typedef struct latency_options {
    daemon_options daemon;
    int shm, dds; /**< transports to measure */
    uint64_t count, warmup;
    double rate; /**< calls a second; 0: each as soon as the reply to the one before is there */
    uint32_t batch;
    tfa_method method;
    tfa_estimate estimate;
    int cpu; /**< of the client, or -1 */
    const char *urdf;
    double deadline_us; /**< a later reply counts as late; 0: none */
    double fail_p99_us; /**< 0: no such expectation */
    double fail_ratio;  /**< 0: no such expectation */
    int json;
    const char *csv, *histogram;
} latency_options;

/** Parts of a round trip; they add up to the whole. */
enum { PART_ROUND_TRIP, PART_REQUEST, PART_QUEUE, PART_COMPUTE, PART_REPLY, PART_COUNT };

/** "round_trip", "request", "queue", "compute", "reply". */
extern const char *const latency_parts[PART_COUNT];

/** Random requests of one robot, the same for every transport. */
typedef struct latency_states {
    uint32_t sets; /**< requests that differ */
    tfa_request *requests;
    double *memory;
} latency_states;

/** One exchange, for --csv: when it was sent after the start, and its parts, in ns. */
typedef struct latency_sample {
    uint64_t index, at;
    uint64_t parts[PART_COUNT];
} latency_sample;

/** One measured run. */
typedef struct latency_run {
    daemon_via via;
    tfa_client_info info; /**< numbers only: the strings are gone with the connection */
    char hash[65];
    tfa_histogram parts[PART_COUNT]; /**< ns */
    uint64_t highest_at;             /**< ns after the start when the slowest was sent */
    uint64_t misses, late, longest_run, reconnects;
    uint64_t elapsed_ns, steal_ticks;
    uint16_t method; /**< that answered last */
    latency_states states;
    thread_usage client;
    thread_usage threads[THREADS_MAX]; /**< of the daemon */
    int thread_count;
    latency_sample *samples; /**< with --csv: count of them */
    uint64_t sample_count;
    uint64_t buckets[PART_COUNT][LATENCY_BUCKETS]; /**< of parts */
} latency_run;

/** Baseline of the round trip, from the same run. ns. */
typedef struct latency_baseline {
    tfa_histogram pingpong;
    int have_pingpong;
    cpu_set_t others;        /**< with --cpu: where the other side of a ping-pong runs */
    int pinned;              /**< others holds a processor */
    tfa_histogram same_size; /**< a ping-pong of as many lines as a request and its reply have */
    pingpong_size size;      /**< of same_size */
    tfa_histogram solve;     /**< the same requests in process; empty without --urdf */
    uint64_t buckets[3][LATENCY_BUCKETS];
} latency_baseline;

/** Empties the histograms of a run or a baseline; before anything else. */
void latency_run_init(latency_run *run);
void latency_baseline_init(latency_baseline *baseline);

/** Buffers of a reply to a whole batch. @return TFA_OK, TFA_E_MEMORY; free it either way. */
TFA_CHECKED int latency_reply_init(tfa_reply *reply, const latency_options *options,
                                   const tfa_client_info *info);
void latency_reply_free(tfa_reply *reply);

/** Runs warm-up and measurement over one transport. Prints the error when there is one.
 *  @return TFA_OK, or the status that ended the run. */
TFA_CHECKED int latency_measure(const latency_options *options, daemon_via via, latency_run *run);
void latency_run_free(latency_run *run);

/** Where standard error is a terminal: "what: done of count" in its last line, at most twice a
 *  second; count 0: "what" alone, at once; what NULL: clears the line. */
void latency_progress(const char *what, uint64_t done, uint64_t count);

/** Solves the requests of `run` in process with the model in options->urdf. Prints errors.
 *  @return TFA_OK; TFA_E_MODEL; TFA_E_SIZE (another robot); as tfa_compute. */
TFA_CHECKED int latency_solve(const latency_options *options, const latency_run *run,
                              tfa_histogram *h);

/** p50 of the round trip / (p50 of the ping-pong + p50 of the solve); 0 without a baseline. */
double latency_ratio(const latency_run *run, const latency_baseline *baseline);
/** The same with the ping-pong of the same size: the overhead of software over moving the data. */
double latency_ratio_same_size(const latency_run *run, const latency_baseline *baseline);

/** True when every --fail option is satisfied. */
int latency_expected(const latency_options *options, const latency_run *run,
                     const latency_baseline *baseline);

void latency_print_text(FILE *out, const latency_options *options, const latency_run *runs,
                        int count, const latency_baseline *baseline);
/** @return 0, or -1 when writing failed. */
int latency_print_json(FILE *out, const latency_options *options, const latency_run *runs,
                       int count, const latency_baseline *baseline);
/** One line a round trip. @return 0, or -1 when the file cannot be written (errno). */
int latency_write_csv(const latency_options *options, const latency_run *runs, int count);
/** Percentile distributions in us, HdrHistogram's .hgrm. With two runs the second file has the name
 *  of its transport appended. @return as latency_write_csv. */
int latency_write_histogram(const latency_options *options, const latency_run *runs, int count);

#endif
