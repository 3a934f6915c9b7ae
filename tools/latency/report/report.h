/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Reports of `totalforce latency`. Each walks one latency_session.
 */
#ifndef TOOLS_LATENCY_REPORT_REPORT_H
#define TOOLS_LATENCY_REPORT_REPORT_H

#include "latency/measure/baseline.h"

#include <jansson.h>
#include <stdio.h>
#include <totalforce/text.h>

/** All that a report tells. */
typedef struct latency_session {
    const char *command; /**< line as it was typed */
    char date[32];       /**< of the start, UTC */
    json_t *environment;
    latency_baseline *baseline;
    latency_run *runs;
    int count;
} latency_session;

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

/** Writes the session with its histograms. @return as latency_write_csv */
int latency_save(const char *path, const latency_session *session);

/* `totalforce plot`, which prints its own errors. @return an exit status */

/** Prints the ratios of two saved sessions. */
int latency_compare(const char *before, const char *after);
/** Before a run: it is there and can read the session to compare with */
int latency_check_plot(const latency_options *options);
/** The page and the comparison that were asked for */
int latency_plot(const latency_options *options, const latency_session *session);

#endif
