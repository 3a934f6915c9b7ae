/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * See estimates_tally.h.
 */
#include "estimates_tally.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>

#define FIRST_DECADE (-9) /* of the histogram */

const tally_rule tally_f64 = {TALLY_LEAST_F64, 1e-6, 1e-7}, tally_f32 = {5e-6, 1e-3, 1e-4};

static const char *const refines[TALLY_REFINES] = {"0", "1", "2", "default"};

static void count_reason(tally *t, unsigned flags)
{
    if (flags & TFA_ANSWER_FALLBACK)
        t->fallback[flags & TFA_ANSWER_INACCURATE   ? 0
                    : flags & TFA_ANSWER_STALLED    ? 1
                    : flags & TFA_ANSWER_NOT_FINITE ? 2
                                                    : 3]++;
}

int tally_add(tally *t, const tally_rule *rule, double truth, const tfa_answer *answer,
              const char *where)
{
    const double estimate = answer->error_estimate, ratio = truth / estimate;
    t->answered++;
    count_reason(t, answer->flags);
    t->log_truth += log10(fmax(truth, 1e-17));
    if (truth > t->worst_truth)
        t->worst_truth = truth;
    if (truth <= rule->least)
        return 0;
    const int decade = (int)ceil(log10(ratio)) - FIRST_DECADE; /* no estimate: as far as it goes */
    t->histogram[!(ratio < 1e9) || decade >= TALLY_DECADES ? TALLY_DECADES - 1
                 : decade < 0                              ? 0
                                                           : decade]++;
    if (!(ratio <= t->worst)) {
        t->worst = ratio;
        snprintf(t->where, sizeof t->where, "%s", where);
    }
    const int low = !(ratio <= TALLY_LOW);
    const int silent = truth > rule->wrong && !(estimate >= rule->silent);
    t->low += (uint64_t)low;
    t->silent += (uint64_t)silent;
    return low || silent;
}

static void print_histogram(const uint64_t *histogram, uint64_t all)
{
    printf("  truth / estimate, of %" PRIu64 " answers above rounding:\n", all);
    for (int k = 0; k < TALLY_DECADES; k++)
        printf("    %s 1e%-3d %8" PRIu64 "\n", k + 1 < TALLY_DECADES ? "up to" : "above",
               k + FIRST_DECADE - (k + 1 == TALLY_DECADES), histogram[k]);
}

void tally_print(const char *title, tally table[][TALLY_REFINES], uint32_t methods)
{
    uint64_t histogram[TALLY_DECADES] = {0}, all = 0;
    printf("%s\n  %-14s %-7s %8s %8s %6s | %7s %7s %7s %7s | %5s %6s %9s %9s %9s\n", title,
           "method", "refine", "answered", "refused", "none", "inacc.", "stalled", "not fin",
           "n.there", "low", "silent", "ratio", "mean", "truth");
    for (uint32_t m = 0; m < methods; m++)
        for (int k = 0; k < TALLY_REFINES; k++) {
            const tally *t = &table[m][k];
            if (t->answered + t->refused + t->not_computed == 0)
                continue;
            printf("  %-14s %-7s %8" PRIu64 " %8" PRIu64 " %6" PRIu64, tfa_method_name(m),
                   refines[k], t->answered, t->refused, t->not_computed);
            printf(" | %7" PRIu64 " %7" PRIu64 " %7" PRIu64 " %7" PRIu64, t->fallback[0],
                   t->fallback[1], t->fallback[2], t->fallback[3]);
            printf(" | %5" PRIu64 " %6" PRIu64 " %9.2g %9.2g %9.2g  %s\n", t->low, t->silent,
                   t->worst, pow(10, t->log_truth / (double)t->answered), t->worst_truth, t->where);
            for (int d = 0; d < TALLY_DECADES; d++) {
                histogram[d] += t->histogram[d];
                all += t->histogram[d];
            }
        }
    print_histogram(histogram, all);
    fflush(stdout);
}
