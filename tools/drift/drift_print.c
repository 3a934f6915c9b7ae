/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Prints the lines of a drift: CSV under a head with their origin, and a sentence for each.
 */
#include "common/results.h"
#include "drift.h"

#include <inttypes.h>
#include <math.h>

void drift_print_head(FILE *out, const drift_options *o)
{
    results_print_head(out, o->command);
    fprintf(out,
            "# the robot swings from rest without torques and friction, %g s by %s in double; seed "
            "%" PRIu64 "\n"
            "# energy_error: kinetic and potential energy (in f128) less that of the start, over "
            "the kinetic energy of the start plus the weight of what moves times the distance of "
            "its centre of mass from the origin; largest_error: of all samples so far\n"
            "# floor 1: accelerations by aba in f128, rounded to double: the error of integrator "
            "and state alone\n"
            "mechanism,bodies,integrator,step_s,method,precision,refine,floor,time_s,energy_error,"
            "largest_error,status\n",
            o->seconds, drift_integrator_words[o->integrator], o->seed);
}

void drift_print(FILE *out, const drift_case *c, const drift_options *o, const drift_line *line)
{
    const int failed = line->status != TFA_OK;
    for (uint32_t k = 0; k < line->count + (uint32_t)failed; k++) {
        fprintf(out, "%s,%" PRIu32 ",%s,%g,%s,%s,%" PRIu32 ",%d,", c->chart.name, c->chart.bodies,
                drift_integrator_words[o->integrator], line->step,
                chart_method_name(line->choice.method),
                chart_precision_words[line->choice.precision], line->choice.refine, line->floor);
        if (k == line->count)
            fprintf(out, ",,,%s\n", tfa_status_name(line->status));
        else
            fprintf(out, "%.6g,%.3e,%.3e,ok\n", line->time[k], line->error[k],
                    drift_largest(line, k));
    }
}

/* Floor of the same step: the last one before the line */
static const drift_line *floor_of(const drift_line *line)
{
    while (!line->floor)
        line--;
    return line;
}

void drift_print_summary(FILE *out, const char *before, const drift_options *o,
                         const drift_line *lines, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        const drift_line *line = &lines[i];
        char name[64];
        const double end = line->count ? line->time[line->count - 1] : 0.0;
        if (line->floor) {
            fprintf(out, "%sstep %g s, %s: the integrator drifts by %.1e in %g s\n", before,
                    line->step, drift_integrator_words[o->integrator],
                    drift_largest(line, line->count), end);
            continue;
        }
        fprintf(out, "%s  %s: %.1e in %g s, %.2g times the integrator's", before,
                drift_line_name(line, name, sizeof name), drift_largest(line, line->count), end,
                drift_largest(line, line->count) /
                    drift_largest(floor_of(line), floor_of(line)->count));
        if (line->status != TFA_OK)
            fprintf(out, "; then %s", tfa_status_name(line->status));
        fputc('\n', out);
    }
}
