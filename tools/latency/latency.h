/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The parts of `totalforce latency`: options, measured runs, the machine beside them, reports.
 * Every report walks one latency_session.
 */
#ifndef TOOLS_LATENCY_LATENCY_H
#define TOOLS_LATENCY_LATENCY_H

#include "common/daemon.h"
#include "common/environment.h"
#include "hgrm.h"
#include "loop.h"
#include "machine.h"
#include "pingpong.h"
#include "tally.h"
#include "transport.h"

#include <jansson.h>
#include <stdio.h>
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
    int cpu; /**< of the clients, or -1 */
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

/** Random requests of one robot, the same for every transport and client. */
typedef struct latency_states {
    uint32_t sets; /**< requests that differ */
    tfa_request *requests;
    double *memory;
} latency_states;

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
    latency_states states;
} latency_run;

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

/** All that a report tells. */
typedef struct latency_session {
    const char *command; /**< line as it was typed */
    char date[32];       /**< of the start, UTC */
    json_t *environment;
    latency_baseline *baseline;
    latency_run *runs;
    int count;
} latency_session;

/** Makes an empty baseline. */
void latency_baseline_init(latency_baseline *baseline);

/* ---- latency_options.c ---- */

/** Reads the command line. @return 0, or errno of argp */
int latency_options_parse(latency_options *options, int argc, char **argv);

/** Runs of the options: of every transport and value of the sweep. @return their number, with
 *  *runs to be freed by latency_runs_free; 0: no memory */
int latency_plan(const latency_options *options, latency_run **runs);
void latency_runs_free(latency_run *runs, int count);

/* ---- latency_states.c ---- */

TFA_CHECKED int latency_states_init(latency_states *states, const latency_options *options,
                                    const tfa_client_info *info);
void latency_states_free(latency_states *states);

/** Buffers of a reply to a whole batch. @return TFA_OK, TFA_E_MEMORY; free it either way. */
TFA_CHECKED int latency_reply_init(tfa_reply *reply, const latency_options *options,
                                   const tfa_client_info *info);
void latency_reply_free(tfa_reply *reply);

/** Cache lines of a request (a line, q, v, tau) and of a reply (a line, what is known of each
 *  answer, qdd). */
pingpong_size latency_size(const latency_options *options, const tfa_client_info *info);

/* ---- transports: transport_*.c ----
 *
 * One is opened for each client. The first one draws the states that all send, which outlive it.
 * Errors are printed. */

TFA_CHECKED int transport_open(const latency_options *options, latency_via via,
                               latency_states *states, transport **t, transport_facts *facts);
TFA_CHECKED int transport_daemon_open(const latency_options *options, latency_via via,
                                      latency_states *states, transport **t,
                                      transport_facts *facts);
TFA_CHECKED int transport_process_open(const latency_options *options, latency_states *states,
                                       transport **t, transport_facts *facts);
TFA_CHECKED int transport_ros2_open(const latency_options *options, latency_states *states,
                                    transport **t, transport_facts *facts);
TFA_CHECKED int transport_socket_open(const latency_options *options, latency_states *states,
                                      transport **t, transport_facts *facts);

/** CLOCK_MONOTONIC, for transport_operations.now. */
uint64_t transport_clock(transport *t);
/** Waits until `until`: spins with TFA_WAIT_SPIN, otherwise sleeps. */
void transport_sleep(tfa_wait wait, uint64_t until);

/* ---- latency_run.c ---- */

/** Runs warm-up and measurement. Prints the error when there is one.
 *  @return TFA_OK, or the status that ended the run. */
TFA_CHECKED int latency_measure(latency_run *run);

/** Shape of the load of client `k`. */
load_shape latency_shape(const latency_options *options, uint32_t k);

/* ---- latency_baseline.c ---- */

/** Before the daemon has a client, so that its spinning worker does not take part: ping-pong, timer
 *  loop, gaps. Pins this thread with --cpu. @return 0, or -1 after a message */
int latency_measure_machine(const latency_options *options, latency_baseline *baseline);

/** After the runs, when the size of a request is known and the worker has no client again. */
void latency_measure_same_size(const latency_run *run, latency_baseline *baseline);

/** Solves the requests of `run` in process with the model in options->urdf. Prints errors.
 *  @return TFA_OK; TFA_E_MODEL; TFA_E_SIZE (another robot); as tfa_compute. */
TFA_CHECKED int latency_solve(const latency_run *run, tfa_histogram *h);

/* ---- reports ---- */

/** Requests without a good answer. */
uint64_t latency_misses(const tally *t);

/** p50 of the round trip / (p50 of the ping-pong + p50 of the solve); 0 without a baseline. */
double latency_ratio(const latency_run *run, const latency_baseline *baseline);
/** The same with the ping-pong of the same size: the overhead of software over moving the data. */
double latency_ratio_same_size(const latency_run *run, const latency_baseline *baseline);

/** True when every --fail option is satisfied. */
int latency_expected(const latency_run *run, const latency_baseline *baseline);

enum { QUANTILE_COUNT = 7 };
/** p50 .. p99.9999 */
extern const struct latency_quantile {
    double quantile;
    const char *name; /**< "99.9" */
} latency_quantiles[QUANTILE_COUNT];

/** "closed" or "open" */
const char *latency_loop_name(const latency_options *options);
/** "open loop at 1000/s", "closed loop" and so on. Always terminated. */
void latency_describe_load(const latency_options *options, char *text, size_t size);
const char *latency_wait_name(tfa_wait wait);
const char *latency_estimate_name(tfa_estimate estimate);

void latency_print_text(FILE *out, const latency_session *session);
/** Lines as of cyclictest -N: intervals in us, times in ns. */
void latency_print_cyclictest(FILE *out, const latency_session *session);
/** @return 0, or -1 when writing failed. */
int latency_print_json(FILE *out, const latency_session *session);
/** One line a round trip. @return 0, or -1 when the file cannot be written (errno). */
int latency_write_csv(const char *path, const latency_session *session);
/** One line a run. @return as latency_write_csv */
int latency_write_table(const char *path, const latency_session *session);
/** Percentile distributions in us, HdrHistogram's .hgrm. Files of runs after the first have the
 *  name of their transport and value of the sweep appended. @return as latency_write_csv */
int latency_write_histogram(const char *path, const latency_session *session);

/** A self-contained page. @return as latency_write_csv */
int latency_write_page(const char *path, const latency_session *session);

/** Writes the session with its histograms. @return as latency_write_csv */
int latency_save(const char *path, const latency_session *session);
/** Prints the ratios of the percentiles of two saved sessions, runs paired by their order. Prints
 *  errors. @return 0 or -1 */
int latency_compare(FILE *out, const char *before, const char *after);

#endif
