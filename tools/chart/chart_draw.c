/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Draws the chart: feeds rows and captions to gnuplot, whose scripts in chart/ say how it looks.
 */
#include "chart.h"
#include "common/commands.h"
#include "common/results.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

void chart_set_time_name(FILE *out, const chart_choice *choice)
{
    char name[64];
    snprintf(name, sizeof name, "%s time of a %s (µs)", choice->threads > 1 ? "wall" : "CPU",
             chart_is_batch(choice->strategy) ? "state in a batch" : "call");
    gnuplot_string(out, "time_name", name);
}

uint32_t chart_mark(uint32_t method)
{
    return method == TFA_METHOD_AUTO ? CHART_METHODS - 1 : method;
}

double chart_draw_error(double error)
{
    return fmin(fmax(error, CHART_ERROR_MIN), CHART_ERROR_MAX);
}

double chart_draw_floor(const chart_row *row)
{
    return fmax(row->floor, CHART_ERROR_MIN);
}

void chart_range_extend(chart_range *range, double value)
{
    range->low = range->high > 0.0 ? fmin(range->low, value) : value;
    range->high = fmax(range->high, value);
}

/* Steps of a decade, coarser where an axis is longer; at least two are on every axis. */
static const double *find_steps(double ratio)
{
    static const double fine[] = {1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 0.0},
                        middle[] = {1.0, 1.5, 2.0, 3.0, 5.0, 7.0, 0.0},
                        coarse[] = {1.0, 2.0, 5.0, 0.0};
    return ratio <= 4.0 ? fine : ratio <= 12.0 ? middle : coarse;
}

/* Tics at parts of a decade where an axis may hold fewer than three decades. */
static void set_tics(FILE *out, uint32_t k, double low, double high)
{
    const char *before = "";
    if (high / low > 1000.0) {
        fprintf(out, "time_tics[%" PRIu32 "] = '10'\ntime_format[%" PRIu32 "] = '10^{%%L}'\n", k,
                k);
        return;
    }
    fprintf(out, "time_tics[%" PRIu32 "] = '(", k);
    for (int decade = (int)floor(log10(low)); pow(10.0, decade) <= high; decade++)
        for (const double *step = find_steps(high / low); *step > 0.0; step++) {
            const double at = pow(10.0, decade) * *step;
            if (at < low || at > high)
                continue;
            fprintf(out, "%s%g", before, at);
            before = ",";
        }
    fprintf(out, ")'\ntime_format[%" PRIu32 "] = '%%g'\n", k);
}

void chart_set_times(FILE *out, const chart_range *times, uint32_t count)
{
    static const char *const arrays[] = {"low_time", "high_time", "time_tics", "time_format"};
    for (int i = 0; i < 4; i++)
        fprintf(out, "array %s[%" PRIu32 "]\n", arrays[i], count);
    for (uint32_t k = 1; k <= count; k++) {
        const int empty = times[k - 1].high <= 0.0;
        const double low = empty ? 1.0 : times[k - 1].low / 1.5;
        const double high = empty ? 10.0 : times[k - 1].high * 1.5;
        fprintf(out, "low_time[%" PRIu32 "] = %g\nhigh_time[%" PRIu32 "] = %g\n", k, low, k, high);
        set_tics(out, k, low, high);
    }
}

const char *chart_name_how(const chart_choice *choice, int file, char *text, size_t size)
{
    const char *comma = file ? "-" : ", ", *blank = file ? "-" : " ";
    char threads[48] = "", strategy[48] = "";
    if (choice->threads > 1)
        snprintf(threads, sizeof threads, "%s%" PRIu32 "%sthreads", comma, choice->threads, blank);
    if (choice->strategy != CHART_SINGLE)
        snprintf(strategy, sizeof strategy, "%s%s", comma, chart_strategy_words[choice->strategy]);
    snprintf(text, size, "%s%s%s", choice->op == CHART_LAMBDA ? comma : "",
             choice->op == CHART_LAMBDA ? file ? "lambda" : "Λ⁻¹" : "", threads);
    const size_t used = strlen(text);
    snprintf(text + used, size - used, "%s", strategy);
    return text;
}

/* Rows of the target, size, threads and strategy that `rows` begins with. */
static size_t same_case(const chart_row *rows, size_t count)
{
    size_t n = 1;
    while (n < count && rows[n].bodies == rows->bodies &&
           rows[n].choice.threads == rows->choice.threads &&
           rows[n].choice.strategy == rows->choice.strategy &&
           rows[n].choice.op == rows->choice.op && strcmp(rows[n].target, rows->target) == 0)
        n++;
    return n;
}

static int same_how(const chart_row *a, const chart_row *b)
{
    return a->choice.threads == b->choice.threads && a->choice.strategy == b->choice.strategy &&
           a->choice.op == b->choice.op;
}

/* One overview for each number of threads and strategy, of the first precision. */
static int draw_overviews(FILE *gnuplot, const chart_options *o, const chart_row *rows,
                          size_t count)
{
    chart_row *some = malloc(count * sizeof *some);
    if (!some)
        return -1;
    for (size_t i = 0; i < count; i++) {
        size_t n = 0, before = 0;
        while (before < i && !same_how(&rows[before], &rows[i]))
            before++;
        for (size_t k = i; before == i && k < count; k++)
            if (rows[k].choice.precision == o->precisions[0] && same_how(&rows[k], &rows[i]))
                some[n++] = rows[k];
        if (n > 0)
            chart_draw_overview(gnuplot, o, some, n);
    }
    free(some);
    return 0;
}

/* Which methods there are, and the names of what the marks of peers stand for. */
static void write_style(FILE *out, const chart_options *o)
{
    fputs("charted = ' ", out);
    for (uint32_t m = 0; m < o->method_count; m++)
        fprintf(out, "%" PRIu32 " ", chart_mark(o->methods[m]));
    fputs("'\nload scripts.'/style.gp'\n", out);
    for (uint32_t m = 0; m < o->method_count; m++)
        if (o->methods[m] >= CHART_PEER)
            fprintf(out, "label[%" PRIu32 "] = '%s'\n", o->methods[m],
                    chart_method_name(o->methods[m]));
}

int chart_draw(const chart_options *options, const chart_row *rows, size_t count)
{
    gnuplot_pipe g;
    int drawn = 0;
    if (count == 0)
        return EXIT_GOOD;
    if (gnuplot_start(&g, "chart", options->scripts, options->folder) == 0) {
        write_style(g.in, options);
        for (size_t i = 0, n; i < count; i += n) {
            n = same_case(rows + i, count - i);
            chart_draw_scatter(g.in, options, rows + i, n);
        }
        drawn = draw_overviews(g.in, options, rows, count);
    }
    const int finished = gnuplot_finish(&g);
    return drawn == 0 ? finished : EXIT_FAILED;
}
