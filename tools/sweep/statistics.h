/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Statistics of a sweep. Merging is exact, associative and commutative, so that any split into
 * blocks, threads and ranks gives the same bits.
 */
#ifndef TOOLS_SWEEP_STATISTICS_H
#define TOOLS_SWEEP_STATISTICS_H

#include "exact_sum.h"

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

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

/* X(member, name in tables and JSON, what) */
#define STATISTICS_SERIES(X)                                                                       \
    X(answer, "answer", "2-norm of the answer")                                                    \
    X(estimate, "error_estimate", "relative error as the reply estimates it")                      \
    X(error, "error", "relative error against quadruple precision")                                \
    X(ratio, "error_over_estimate", "error / estimate, of states that have both")

/* X(member, name in tables and JSON): numbers of states */
#define STATISTICS_COUNTS(X)                                                                       \
    X(states, "states")                                                                            \
    X(fallbacks, "fallbacks")                                                                      \
    X(sentinels, "sentinels")                                                                      \
    X(wider, "residual_precision")                                                                 \
    X(references, "references")                                                                    \
    X(unreferenced, "references_failed")

/** Zero-initialise. Members of eight bytes only: the resume file keeps them as words. */
typedef struct statistics {
#define STATISTICS_COUNT(member, name) uint64_t member;
    STATISTICS_COUNTS(STATISTICS_COUNT)
#undef STATISTICS_COUNT
    uint64_t status[STATISTICS_STATUSES]; /**< by -status */
    uint64_t method[STATISTICS_METHODS];  /**< that answered */
#define STATISTICS_MEMBER(member, name, what) series member;
    STATISTICS_SERIES(STATISTICS_MEMBER)
#undef STATISTICS_MEMBER
} statistics;

/** Adds the value of a state, and to the sum of its group. Not finite: not counted. States come in
 *  ascending order. */
void series_add(series *s, double *group, double value, uint64_t state);
/** Ends a group. */
void series_end_group(series *s, double *group);

double series_mean(const series *s);
/** Upper bound of the bin that has the value which a share `quantile` (0 to 1) does not exceed, or
 *  the maximum if that is less. 0 of an empty series. */
double series_quantile(const series *s, double quantile);
/** Lower bound of a bin; bin STATISTICS_BINS: infinite. */
double series_bin_bound(unsigned bin);

void statistics_merge(statistics *into, const statistics *from);

/** Writes the words that are not zero, "INDEX:VALUE" in hexadecimal, each after a blank. */
void statistics_write(const statistics *s, FILE *out);
/** Reads such a text. @return 0, or -1 if it is none */
int statistics_read(statistics *s, const char *text);

#endif
