/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Draws the drift: a panel for each step, a line for each method and precision, its name at its
 * end.
 */
#include "common/commands.h"
#include "common/results.h"
#include "drift.h"

#include <math.h>
#include <stdlib.h>

/* Labels stand at least so far apart, as a part of the axis. */
#define LABEL_STEP 0.052

#define ERROR_MIN 1e-17
#define ERROR_MAX 1e3

static double drawn(const drift_line *line, uint32_t sample)
{
    return fmin(fmax(drift_largest(line, sample), ERROR_MIN), ERROR_MAX);
}

static double last_of(const drift_line *line)
{
    return line->count ? drawn(line, line->count - 1) : ERROR_MIN;
}

static void write_lines(FILE *out, const drift_line *lines, size_t count)
{
    fputs("$data << EOD\n", out);
    for (size_t i = 0; i < count; i++) {
        if (lines[i].count == 0)
            fputs("0 NaN\n", out);
        for (uint32_t k = 0; k < lines[i].count; k++)
            fprintf(out, "%.6g %.4g\n", lines[i].time[k], drawn(&lines[i], k));
        fputs("\n\n", out);
    }
    fputs("EOD\n", out);
}

/* Whole decades around all lines */
static void find_range(const drift_line *lines, size_t count, double *low, double *high)
{
    *low = ERROR_MAX;
    *high = ERROR_MIN;
    for (size_t i = 0; i < count; i++)
        for (uint32_t k = 0; k < lines[i].count; k++) {
            *low = fmin(*low, drawn(&lines[i], k));
            *high = fmax(*high, drawn(&lines[i], k));
        }
    *low = pow(10.0, floor(log10(*low)));
    *high = pow(10.0, ceil(log10(*high) + 0.1));
}

/* Places of the labels of one panel, 0 to 1, from the lowest line up: each at the end of its line
 * or above the one below it; those above the top go down again. */
static void place_labels(const drift_line *lines, size_t count, double low, double high, double *at)
{
    size_t order[1 + CHART_METHODS * CHART_PRECISION_COUNT];
    for (size_t i = 0; i < count; i++) {
        size_t k = i;
        for (; k > 0 && last_of(&lines[order[k - 1]]) > last_of(&lines[i]); k--)
            order[k] = order[k - 1];
        order[k] = i;
    }
    for (size_t k = 0; k < count; k++) {
        const double end = log(last_of(&lines[order[k]]) / low) / log(high / low);
        at[order[k]] = k > 0 ? fmax(end, at[order[k - 1]] + LABEL_STEP) : end;
    }
    for (size_t k = count; k-- > 0;) {
        const double most = k + 1 < count ? at[order[k + 1]] - LABEL_STEP : 0.98;
        at[order[k]] = fmin(at[order[k]], most);
    }
}

static void write_line(FILE *out, size_t number, const drift_line *line, size_t panel, double at)
{
    char name[64];
    fprintf(out, "panel_of[%zu] = %zu\nmark[%zu] = %u\nprecision[%zu] = %u\nplace[%zu] = %g\n",
            number, panel, number, chart_mark(line->choice.method), number,
            line->floor ? (unsigned)CHART_F128 : line->choice.precision, number, at);
    fprintf(out, "name[%zu] = \"%s%s\"\n", number,
            line->floor ? "integrator alone" : drift_line_name(line, name, sizeof name),
            line->status != TFA_OK ? ": fails" : "");
}

int drift_draw(const drift_options *o, const drift_case *c, const drift_line *lines, size_t count)
{
    gnuplot_pipe g;
    const size_t panel = count / o->step_count;
    double low, high, *at = calloc(count, sizeof *at);
    if (!at)
        return EXIT_FAILED;
    find_range(lines, count, &low, &high);
    if (gnuplot_start(&g, "drift", o->scripts, o->folder) == 0) {
        char title[256];
        snprintf(title, sizeof title, "%s, %u bodies: energy error of free swinging by %s",
                 c->chart.name, c->chart.bodies, drift_integrator_words[o->integrator]);
        gnuplot_string(g.in, "subject", title);
        write_lines(g.in, lines, count);
        fprintf(g.in, "count = %zu\npanels = %u\nlow = %g\nhigh = %g\nseconds = %g\n", count,
                o->step_count, low, high, o->seconds);
        fprintf(g.in,
                "array step[%u]\narray panel_of[%zu]\narray mark[%zu]\narray "
                "precision[%zu]\narray place[%zu]\narray name[%zu]\n",
                o->step_count, count, count, count, count, count);
        for (uint32_t s = 0; s < o->step_count; s++) {
            fprintf(g.in, "step[%u] = %g\n", s + 1, o->steps[s]);
            place_labels(lines + s * panel, panel, low, high, at + s * panel);
        }
        for (size_t i = 0; i < count; i++)
            write_line(g.in, i + 1, &lines[i], 1 + i / panel, at[i]);
        fputs("load scripts.'/drift.gp'\n", g.in);
    }
    free(at);
    return gnuplot_finish(&g);
}
