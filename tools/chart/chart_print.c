/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Prints the rows of a chart: CSV under a head with their origin, or JSON lines.
 */
#include "chart.h"
#include "common/results.h"

#include <inttypes.h>
#include <math.h>

void chart_print_head(FILE *out, const chart_options *options)
{
    results_print_head(out, options->command);
    fprintf(
        out,
        "# states of each row and seed: %" PRIu32 ", seeds: %" PRIu32 " from %" PRIu64 " on\n"
        "# error: relative 2-norm error of qdd to aba in f128, or relative Frobenius-norm error of "
        "Lambda^-1 (6 x 6, linear rows first, m and rad, axes of the world) to the dense J M^-1 "
        "J^T in "
        "f128 (above 128 bodies: to propagation in f128), median over the seeds of the median over "
        "the states; error_low, error_high: of the least and the worst seed; worst_component: "
        "largest relative error of one component in any state\n"
        "# floor: change of the exact answer when every number of the robot and of the request "
        "changes in the last bit, and sines and cosines are rounded to double; at least 2^-53\n"
        "# precision: of the factors, and behind + of the residual of refinement steps\n"
        "# strategy: single: one state a request; batch: 512 (64 above 128 bodies); specialised: "
        "by "
        "a specialised kernel\n"
        "# time_us: median time for one state: CPU time with one thread, with more wall time; "
        "aba_us: that of aba in f64 and generic code, in turns; time_ratio: median of neighbours' "
        "ratios\n"
        "# time_low_us, time_high_us: of the fastest and the slowest seed\n"
        "# status over_budget: a call, here or with fewer bodies, took more than %g ms; "
        "too_large, refused: of peers\n"
        "# front: 1 on the Pareto front of its mechanism, size, threads and right-hand side, "
        "errors within a factor of two, or below the floor, being equal, and 0.1 no answer; "
        "same_as: an earlier method whose answers are the same to the last bit, with as many "
        "steps: "
        "such a row has no mark and no place on the front\n",
        options->states, options->seeds, options->seed, CHART_OVER_BUDGET * options->budget);
    fputs("mechanism,bodies,rhs,method,refine,precision,threads,status,about,answered_by,"
          "error,"
          "worst_component,floor,"
          "estimate,time_us,aba_us,time_ratio,samples,front,error_low,error_high,time_low_us,"
          "time_high_us,same_as,strategy,op\n",
          out);
}

/* NULL: none */
static const char *answered_by(const chart_row *row)
{
    return row->status == TFA_OK && !row->skipped ? chart_method_name(row->answered_by) : NULL;
}

void chart_print_row(FILE *out, const chart_row *row)
{
    const double numbers[] = {row->error, row->worst,    row->floor, row->estimate,
                              row->time,  row->aba_time, row->ratio};
    const chart_choice *choice = &row->choice;
    fprintf(out, "%s,%" PRIu32 ",%s,%s,%" PRIu32 ",%s,%" PRIu32 ",%s,", row->target, row->bodies,
            chart_row_rhs(row), chart_method_name(choice->method), choice->refine,
            chart_precision_words[choice->precision], choice->threads, chart_row_status(row));
    results_print_text(out, row->field);
    fprintf(out, ",%s", answered_by(row) ? answered_by(row) : "");
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++) {
        fputc(',', out);
        results_print_number(out, i < 4 ? "%.3e" : "%.4g", numbers[i]);
    }
    fprintf(out, ",%" PRIu32 ",%d", row->samples, row->front);
    const double spread[] = {row->error_low, row->error_high, row->time_low, row->time_high};
    for (size_t i = 0; i < sizeof spread / sizeof *spread; i++) {
        fputc(',', out);
        results_print_number(out, i < 2 ? "%.3e" : "%.4g", spread[i]);
    }
    fprintf(out, ",%s,%s,%s\n", row->same_as ? chart_method_name(row->same_as) : "",
            chart_strategy_words[choice->strategy], chart_op_words[choice->op]);
}

void chart_print_row_json(FILE *out, const chart_row *row)
{
    json_t *o = json_object();
    const chart_choice *choice = &row->choice;
    json_object_set_new(o, "mechanism", json_string(row->target));
    json_object_set_new(o, "bodies", json_integer(row->bodies));
    json_object_set_new(o, "rhs", json_string(chart_row_rhs(row)));
    json_object_set_new(o, "method", json_string(chart_method_name(choice->method)));
    json_object_set_new(o, "refine", json_integer(choice->refine));
    json_object_set_new(o, "precision", json_string(chart_precision_words[choice->precision]));
    json_object_set_new(o, "threads", json_integer(choice->threads));
    json_object_set_new(o, "strategy", json_string(chart_strategy_words[choice->strategy]));
    json_object_set_new(o, "status", json_string(chart_row_status(row)));
    json_object_set_new(o, "about", json_string(row->field));
    json_object_set_new(o, "answered_by",
                        answered_by(row) ? json_string(answered_by(row)) : json_null());
    results_set_number(o, "error", row->error);
    results_set_number(o, "worst_component", row->worst);
    results_set_number(o, "floor", row->floor);
    results_set_number(o, "estimate", row->estimate);
    results_set_number(o, "time_us", row->time);
    results_set_number(o, "aba_us", row->aba_time);
    results_set_number(o, "time_ratio", row->ratio);
    json_object_set_new(o, "samples", json_integer(row->samples));
    json_object_set_new(o, "front", json_boolean(row->front));
    results_set_number(o, "error_low", row->error_low);
    results_set_number(o, "error_high", row->error_high);
    results_set_number(o, "time_low_us", row->time_low);
    results_set_number(o, "time_high_us", row->time_high);
    json_object_set_new(o, "same_as",
                        row->same_as ? json_string(chart_method_name(row->same_as)) : json_null());
    json_object_set_new(o, "op", json_string(chart_op_words[choice->op]));
    json_dumpf(o, out, JSON_COMPACT | JSON_REAL_PRECISION(4));
    fputc('\n', out);
    json_decref(o);
}
