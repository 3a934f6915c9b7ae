/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Prints what was charted: CSV under a head that says how it came about, or JSON lines.
 */
#include "chart.h"
#include "results.h"

#include <inttypes.h>
#include <jansson.h>
#include <math.h>

void chart_print_head(FILE *out, const chart_options *options)
{
    results_print_head(out, options->command);
    fprintf(out,
            "# states of each row: %" PRIu32 ", seed %" PRIu64 "\n"
            "# error: relative 2-norm error of qdd to aba in f128, median over the states;"
            " worst_component: largest relative error of one component in any state\n"
            "# floor: change of the exact answer when q, v and tau change in the last bit, at "
            "least 2^-53; the robot's own constants do not change\n"
            "# time_us: median CPU time of a call; aba_us: aba's, in turns; time_ratio: median of "
            "neighbours' ratios\n"
            "# front: 1 on the Pareto front of its mechanism, size and right-hand side, errors "
            "within a factor of two, or below the floor, being equal\n",
            options->states, options->seed);
    fputs("mechanism,bodies,rhs,method,refine,status,about,answered_by,error,worst_component,floor,"
          "estimate,time_us,aba_us,time_ratio,samples,front\n",
          out);
}

static const char *status_word(const chart_row *row)
{
    if (row->status == TFA_OK)
        return row->answered_by == row->method ? "ok" : "fallback";
    return tfa_status_name(row->status);
}

void chart_print_row(FILE *out, const chart_row *row)
{
    const double numbers[] = {row->error, row->worst,    row->floor, row->estimate,
                              row->time,  row->aba_time, row->ratio};
    fprintf(out, "%s,%" PRIu32 ",%s,%s,%" PRIu32 ",%s,%s,%s", row->subject, row->bodies,
            chart_rhs_words[row->rhs], tfa_method_name(row->method), row->refine, status_word(row),
            row->field, row->status == TFA_OK ? tfa_method_name(row->answered_by) : "");
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++) {
        fputc(',', out);
        results_print_number(out, i < 4 ? "%.3e" : "%.4g", numbers[i]);
    }
    fprintf(out, ",%" PRIu32 ",%d\n", row->samples, row->front);
}

void chart_print_row_json(FILE *out, const chart_row *row)
{
    json_t *o = json_object();
    json_object_set_new(o, "mechanism", json_string(row->subject));
    json_object_set_new(o, "bodies", json_integer(row->bodies));
    json_object_set_new(o, "rhs", json_string(chart_rhs_words[row->rhs]));
    json_object_set_new(o, "method", json_string(tfa_method_name(row->method)));
    json_object_set_new(o, "refine", json_integer(row->refine));
    json_object_set_new(o, "status", json_string(status_word(row)));
    json_object_set_new(o, "about", json_string(row->field));
    json_object_set_new(o, "answered_by",
                        row->status == TFA_OK ? json_string(tfa_method_name(row->answered_by))
                                              : json_null());
    results_set_number(o, "error", row->error);
    results_set_number(o, "worst_component", row->worst);
    results_set_number(o, "floor", row->floor);
    results_set_number(o, "estimate", row->estimate);
    results_set_number(o, "time_us", row->time);
    results_set_number(o, "aba_us", row->aba_time);
    results_set_number(o, "time_ratio", row->ratio);
    json_object_set_new(o, "samples", json_integer(row->samples));
    json_object_set_new(o, "front", json_boolean(row->front));
    json_dumpf(o, out, JSON_COMPACT | JSON_REAL_PRECISION(4));
    fputc('\n', out);
    json_decref(o);
}
