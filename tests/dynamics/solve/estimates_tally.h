/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * How estimates compare with the truth, counted by method, refinement and op.
 */
#ifndef TESTS_DYNAMICS_SOLVE_ESTIMATES_TALLY_H
#define TESTS_DYNAMICS_SOLVE_ESTIMATES_TALLY_H

#include <stdint.h>
#include <totalforce/dynamics.h>

/** The rule: truth <= `least`, or estimate >= truth / TALLY_LOW; and never truth > `wrong` with
 * estimate < `silent`. `least` is what rounding alone does. */
typedef struct tally_rule {
    double least, wrong, silent;
} tally_rule;
extern const tally_rule tally_f64, tally_f32;
#define TALLY_LOW 30.0
#define TALLY_LEAST_F64 1e-14

enum { TALLY_REFINES = 4, TALLY_DECADES = 12, TALLY_REASONS = 4 };

typedef struct tally {
    uint64_t answered, refused, not_computed;
    uint64_t fallback[TALLY_REASONS];  /* inaccurate, stalled, not finite, not there */
    uint64_t low, silent;              /* the rule broken */
    double worst;                      /* truth / estimate where truth > least */
    double log_truth;                  /* sum of log10 of the errors, 1e-17 at least */
    double worst_truth;                /* largest error of an answer that was given */
    char where[200];                   /* the worst */
    uint64_t histogram[TALLY_DECADES]; /* log10(truth / estimate), from below 1e-8 to above 100 */
} tally;

/** 0, or 1 when the answer breaks the rule. `where` says what was asked. */
int tally_add(tally *t, const tally_rule *rule, double truth, const tfa_answer *answer,
              const char *where);
/** One line for each method and refinement that was asked, then the histogram of all. */
void tally_print(const char *title, tally table[][TALLY_REFINES], uint32_t methods);

#endif
