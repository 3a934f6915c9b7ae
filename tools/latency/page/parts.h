/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Parts of the page of latencies.
 */
#ifndef TOOLS_LATENCY_PAGE_PARTS_H
#define TOOLS_LATENCY_PAGE_PARTS_H

#include "latency/report/report.h"

/** A page under way: its pictures, and the rows of their numbers */
typedef struct latency_page {
    FILE *out, *rows;
    size_t count; /**< of rows */
    const latency_session *session;
} latency_page;

/** "shm", or of a sweep "shm 1000" */
void latency_run_name(char *text, size_t size, const latency_run *run);
/** Class of page.css with the colour of a run, or of a part of a round trip */
unsigned latency_run_colour(int run);
unsigned latency_part_colour(int part);

/** Percentiles of all runs over 1 / (1 - percentile), beside the ping-pong */
void latency_page_percentiles(latency_page *page);
/** For each run: how many round trips took how long, */
void latency_page_histogram(latency_page *page, int run);
/** the parts of round trips at the percentiles, */
void latency_page_breakdown(latency_page *page, int run);
/** and percentiles of each tenth of the run. */
void latency_page_slices(latency_page *page, int run);

/** Percentiles, counters, clients, threads, machine */
void latency_page_tables(latency_page *page);

#endif
