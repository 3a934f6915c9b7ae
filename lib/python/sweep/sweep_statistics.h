/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Statistics of a block of states. Sums are exact, so that merging has no order: any split into
 * blocks, threads and ranks gives the same bits.
 */
#ifndef PYTHON_SWEEP_STATISTICS_H
#define PYTHON_SWEEP_STATISTICS_H

#include "exact_sum.h"

#include <stdint.h>

/* Values are added up in groups of this many states, aligned in the sweep; the sums of the groups
 * are added exactly. A whole exact sum for every value would cost as much as the dynamics. */
enum { STATISTICS_GROUP = 512 };

/* Bins of a factor of two: bin 0 is below 2^-64 (and zero), the last one from 2^64 on. */
enum { STATISTICS_BINS = 130, STATISTICS_LOWEST_EXPONENT = -64 };

enum { STATISTICS_STATUSES = 32, STATISTICS_METHODS = 32 };

/** Distribution of one number that is not negative. */
typedef struct series {
    uint64_t count;
    double min, max;         /**< 0 while count is 0 */
    uint64_t min_at, max_at; /**< states of the extremes: the first of equals */
    exact_sum sum;
    uint64_t bins[STATISTICS_BINS];
} series;

enum {
    SERIES_ANSWER,   /**< 2-norm of the answer */
    SERIES_ESTIMATE, /**< relative error as the reply estimates it */
    SERIES_ERROR,    /**< relative error against quadruple precision */
    SERIES_RATIO,    /**< error / estimate, of states that have both */
    SERIES
};

/** Zero-initialise. Members of eight bytes only: the resume file keeps them as words. Names,
 *  merging and printing: totalforce_tools/sweep_statistics.py. */
typedef struct statistics {
    uint64_t states, fallbacks, sentinels, wider, references, unreferenced;
    uint64_t status[STATISTICS_STATUSES]; /**< by -status */
    uint64_t method[STATISTICS_METHODS];  /**< that answered */
    series series[SERIES];
} statistics;

/** Adds the value of a state, and to the sum of its group. Not finite: not counted. States come in
 *  ascending order. */
void series_add(series *s, double *group, double value, uint64_t state);
/** Ends a group of each series. */
void statistics_end_groups(statistics *s, double groups[SERIES]);

#endif
