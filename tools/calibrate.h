/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * `totalforce chart --calibrate`: from which size on which way is the faster one on this machine.
 */
#ifndef TFA_TOOLS_CALIBRATE_H
#define TFA_TOOLS_CALIBRATE_H

#include <totalforce/totalforce.h>

enum { CALIBRATE_SIZES = 16 };

/** What grows from size to size. */
typedef enum calibrate_axis {
    CALIBRATE_STATES, /**< states of a batch of a 7-body chain: one by one, or in lanes */
    CALIBRATE_WORK,   /**< the same, counted in bodies: one thread, or the threads of a pool */
    CALIBRATE_CHAIN,  /**< bodies of a chain */
    CALIBRATE_TIPS,   /**< tips on a tree of 40 bodies */
} calibrate_axis;

/** One crossover: two ways to the same answer, and where to look for it. */
typedef struct calibrate_contest {
    const char *name;
    size_t at; /**< of its number in tfa_crossovers */
    calibrate_axis axis;
    tfa_op op;
    tfa_method old, next;            /**< `next` is the way that pays from some size on */
    uint32_t threads;                /**< of `next`; that of `old` is always one */
    uint32_t sizes[CALIBRATE_SIZES]; /**< rising; 0 ends them */
} calibrate_contest;

/**
 * Time of the next way over that of the old, at one size: lower quartiles of turns one after the
 * other, over `budget_ms`.
 * @return a tfa_status
 */
TFA_CHECKED int calibrate_measure(const calibrate_contest *contest, uint32_t size,
                                  uint32_t budget_ms, double *ratio);

/**
 * The crossover from the ratios of `count` rising sizes: from where on every ratio is below 1,
 * between two sizes where the line through both (over the logarithm of the size) meets 1.
 * @return TFA_NEVER when the last ratio is not below 1
 */
uint32_t calibrate_crossing(const uint32_t *sizes, const double *ratios, uint32_t count);

/** Measures all, tells of each on standard error, and writes the table to FOLDER/crossovers.conf, or
 * to standard output without a folder. @return an exit status */
int calibrate(const char *command, const char *folder, uint32_t budget_ms);

#endif
