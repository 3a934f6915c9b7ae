/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Prints an atlas: CSV under a head with origin and summary, or JSON lines.
 */
#include "atlas.h"
#include "common/results.h"

#include <inttypes.h>
#include <jansson.h>
#include <math.h>
#include <string.h>

void atlas_short(char *text, size_t size, double value)
{
    int exponent = 0;
    if (value == 0.0 || (value >= 0.01 && value < 99.5)) {
        snprintf(text, size, "%.2g", value);
        return;
    }
    snprintf(text, size, "%.1e", value);
    char *e = strchr(text, 'e');
    if (!e || sscanf(e + 1, "%d", &exponent) != 1)
        return;
    const int whole = e > text + 2 && strncmp(e - 2, ".0", 2) == 0;
    snprintf(whole ? e - 2 : e, 8, "e%d", exponent);
}

size_t atlas_same_map(const atlas_row *rows, size_t count)
{
    size_t n = 0;
    while (n < count && rows[n].map == rows->map)
        n++;
    return n;
}

static void print_modes(FILE *out)
{
#define ATLAS_MODE_LINE(name, word, what) fputs("# mode " word ": " what "\n", out);
    ATLAS_MODE_LIST(ATLAS_MODE_LINE)
#undef ATLAS_MODE_LINE
}

void atlas_print_head(FILE *out, const atlas_options *options, const atlas_row *rows, size_t count)
{
    char prefix[64];
    results_print_head(out, options->command);
    fprintf(
        out,
        "# states of each cell and seed: %" PRIu32 ", seeds: %" PRIu32 " from %" PRIu64 " on\n"
        "# error: relative 2-norm error of qdd to aba in f128, median over the seeds of the "
        "median over the states; error_low, error_high: of the least and the worst seed; worst: "
        "largest of all\n"
        "# own, fallback, refused: states answered by the method, by answered_by, by status\n"
        "# estimate: as replied, median; error_over_estimate: largest among errors above %g; "
        "silent: states with an error above 1e-6 estimated below 1e-7; unsaid: states wrong by "
        "more than %g without an estimate; same_as: an earlier method with the same answers, to "
        "the "
        "last bit\n"
        "# floor: change of the exact answer when every number of the robot and of the request "
        "changes in the last bit, and sines and cosines are rounded to double; at least 2^-53\n",
        options->states, options->seeds, options->seed, ATLAS_ROUNDING, ATLAS_FAILED);
    print_modes(out);
    for (size_t i = 0, n; i < count; i += n) {
        n = atlas_same_map(rows + i, count - i);
        snprintf(prefix, sizeof prefix, "# %s: ", atlas_map_words[rows[i].map]);
        fprintf(out, "%s%s; value: %s\n", prefix, atlas_map_text(rows[i].map),
                atlas_axis(rows[i].map));
        atlas_print_summary(out, prefix, rows + i, n);
    }
    const atlas_summary all = atlas_summarise(rows, count);
    atlas_print_estimates(out, "# all maps: ", &all);
    fputs("map,value,bodies,rhs,method,mode,own,fallback,refused,status,about,answered_by,reason,"
          "error,worst,estimate,error_over_estimate,silent,floor,error_low,error_high,unsaid,same_"
          "as\n",
          out);
}

static const char *status_word(const atlas_row *row)
{
    if (row->refused)
        return tfa_status_name(row->status);
    return row->fallback ? "fallback" : "ok";
}

static const char *answered_by(const atlas_row *row)
{
    return row->by_method + row->fallback ? tfa_method_name(row->answered_by) : "";
}

void atlas_print_row(FILE *out, const atlas_options *options, const atlas_row *row)
{
    const double numbers[] = {row->error, row->by_method + row->fallback ? row->worst : NAN,
                              row->estimate, row->over > 0.0 ? row->over : NAN};
    fprintf(out, "%s,%.6g,%" PRIu32 ",%s,%s,%s,%" PRIu32 ",%" PRIu32 ",%" PRIu32 ",%s,%s,%s,%s",
            atlas_map_words[row->map], row->value, row->bodies, chart_rhs_words[options->rhs],
            tfa_method_name(row->method), atlas_mode_words[row->mode], row->by_method,
            row->fallback, row->refused, status_word(row), row->field, answered_by(row),
            tfa_fallback_text(row->reason));
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++) {
        fputc(',', out);
        results_print_number(out, "%.2e", numbers[i]);
    }
    fprintf(out, ",%" PRIu32 ",%.2e,", row->silent, row->floor);
    results_print_number(out, "%.2e", row->error_low);
    fputc(',', out);
    results_print_number(out, "%.2e", row->error_high);
    fprintf(out, ",%" PRIu32 ",%s\n", row->unreported,
            row->same_as ? tfa_method_name(row->same_as) : "");
}

void atlas_print_row_json(FILE *out, const atlas_options *options, const atlas_row *row)
{
    json_t *o = json_object();
    json_object_set_new(o, "map", json_string(atlas_map_words[row->map]));
    results_set_number(o, "value", row->value);
    json_object_set_new(o, "bodies", json_integer(row->bodies));
    json_object_set_new(o, "rhs", json_string(chart_rhs_words[options->rhs]));
    json_object_set_new(o, "method", json_string(tfa_method_name(row->method)));
    json_object_set_new(o, "mode", json_string(atlas_mode_words[row->mode]));
    json_object_set_new(o, "own", json_integer(row->by_method));
    json_object_set_new(o, "fallback", json_integer(row->fallback));
    json_object_set_new(o, "refused", json_integer(row->refused));
    json_object_set_new(o, "status", json_string(status_word(row)));
    json_object_set_new(o, "about", json_string(row->field));
    json_object_set_new(o, "answered_by", json_string(answered_by(row)));
    json_object_set_new(o, "reason", json_string(tfa_fallback_text(row->reason)));
    results_set_number(o, "error", row->error);
    results_set_number(o, "worst", row->by_method + row->fallback ? row->worst : NAN);
    results_set_number(o, "estimate", row->estimate);
    results_set_number(o, "error_over_estimate", row->over > 0.0 ? row->over : NAN);
    json_object_set_new(o, "silent", json_integer(row->silent));
    results_set_number(o, "floor", row->floor);
    results_set_number(o, "error_low", row->error_low);
    results_set_number(o, "error_high", row->error_high);
    json_object_set_new(o, "unsaid", json_integer(row->unreported));
    json_object_set_new(o, "same_as",
                        row->same_as ? json_string(tfa_method_name(row->same_as)) : json_null());
    json_dumpf(o, out, JSON_COMPACT | JSON_REAL_PRECISION(4));
    fputc('\n', out);
    json_decref(o);
}
