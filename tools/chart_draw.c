/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Draws the chart: feeds rows and captions to gnuplot, whose scripts in chart.d say how it looks.
 */
#include "chart.h"
#include "commands.h"
#include "results.h"

#include <inttypes.h>
#include <math.h>
#include <stdarg.h>
#include <string.h>

/* Block $data: rhs method refine time error front floor. Numbers only. */
static void give_rows(FILE *out, const chart_row *rows, size_t count)
{
    fputs("$data << EOD\n", out);
    for (size_t i = 0; i < count; i++)
        if (chart_row_good(&rows[i]))
            fprintf(out, "%d %" PRIu32 " %" PRIu32 " %.6g %.6g %d %.6g\n", (int)rows[i].rhs,
                    rows[i].method, rows[i].refine, rows[i].time, fmax(rows[i].error, 1e-17),
                    rows[i].front, fmax(rows[i].floor, 1e-17));
    fputs("EOD\n", out);
}

/* Whole decades around errors and floors. */
static void give_range(FILE *out, const chart_row *rows, size_t count)
{
    double low = 1.0, high = 1e-17;
    for (size_t i = 0; i < count; i++) {
        if (!chart_row_good(&rows[i]))
            continue;
        low = fmin(low, fmax(fmin(rows[i].error, rows[i].floor), 1e-17));
        high = fmax(high, fmax(rows[i].error, rows[i].floor));
    }
    fprintf(out, "low = 1e%d\nhigh = 1e%d\n", (int)floor(log10(low) - 0.2),
            (int)ceil(log10(high) + 0.2));
}

static const char *steps_word(uint32_t refine)
{
    static const char *const words[CHART_REFINE] = {"", "+1", "+2"};
    return refine < CHART_REFINE ? words[refine] : "+?";
}

__attribute__((format(printf, 3, 4))) static void append(char *text, size_t size,
                                                         const char *format, ...)
{
    const size_t used = strlen(text);
    va_list list;
    va_start(list, format);
    vsnprintf(text + used, size - used, format, list);
    va_end(list);
}

/* The names of the front of one right-hand side, fastest first. */
static void name_front(FILE *out, const chart_row *rows, size_t count, chart_rhs rhs)
{
    char text[256] = "", name[32];
    double after = -1.0;
    for (;;) {
        const chart_row *next = NULL;
        for (size_t i = 0; i < count; i++)
            if (rows[i].front && rows[i].rhs == rhs && rows[i].time > after &&
                (!next || rows[i].time < next->time))
                next = &rows[i];
        if (!next)
            break;
        append(text, sizeof text, "%s%s%s", text[0] ? ", " : "", tfa_method_name(next->method),
               steps_word(next->refine));
        after = next->time;
    }
    snprintf(name, sizeof name, "front_%d", (int)rhs);
    gnuplot_string(out, name, text);
}

/* Why a row is not in the picture; NULL if it is. */
static const char *silence(const chart_row *row)
{
    if (chart_row_good(row))
        return NULL;
    return row->status == TFA_OK ? "fell back to another method" : tfa_status_text(row->status);
}

/* A row of the same method and steps, or of the same reason, that came earlier. */
static int came_before(const chart_row *rows, size_t i, int compare_method)
{
    for (size_t k = 0; k < i; k++) {
        const char *why = silence(&rows[k]);
        const int same = rows[k].method == rows[i].method && rows[k].refine == rows[i].refine;
        if (why && strcmp(why, silence(&rows[i])) == 0 && (same || !compare_method))
            return 1;
    }
    return 0;
}

/* Who did not answer, and who had another method's answer, by reason. */
static void name_silent(FILE *out, const chart_row *rows, size_t count)
{
    char text[1024] = "";
    for (size_t i = 0; i < count; i++) {
        if (!silence(&rows[i]) || came_before(rows, i, 0))
            continue;
        append(text, sizeof text, "%s%s: ", text[0] ? "; " : "", silence(&rows[i]));
        for (size_t k = i; k < count; k++)
            if (silence(&rows[k]) && strcmp(silence(&rows[k]), silence(&rows[i])) == 0 &&
                !came_before(rows, k, 1))
                append(text, sizeof text, "%s%s%s", k == i ? "" : ", ",
                       tfa_method_name(rows[k].method), steps_word(rows[k].refine));
    }
    gnuplot_string(out, "silent", text[0] ? text : "none");
}

static void draw_scatter(FILE *out, const chart_options *options, const chart_row *rows,
                         size_t count)
{
    char name[256];
    snprintf(name, sizeof name, "%s, %" PRIu32 " bodies", rows->subject, rows->bodies);
    gnuplot_string(out, "subject", name);
    snprintf(name, sizeof name, "%s-%" PRIu32, rows->subject, rows->bodies);
    for (char *c = name; *c; c++)
        if (*c == ':')
            *c = '-';
    gnuplot_string(out, "file", name);
    give_rows(out, rows, count);
    give_range(out, rows, count);
    for (int rhs = 0; rhs < CHART_RHS_COUNT; rhs++) {
        name_front(out, rows, count, (chart_rhs)rhs);
        fprintf(out, "has_%d = %d\n", rhs, (options->rhs >> rhs & 1u) != 0);
    }
    name_silent(out, rows, count);
    fputs("load scripts.'/scatter.gp'\n", out);
}

/* Rows of the subject and size that `rows` begins with. */
static size_t same_case(const chart_row *rows, size_t count)
{
    size_t n = 1;
    while (n < count && rows[n].bodies == rows->bodies &&
           strcmp(rows[n].subject, rows->subject) == 0)
        n++;
    return n;
}

int chart_draw(const chart_options *options, const chart_row *rows, size_t count)
{
    gnuplot_pipe g;
    if (count == 0)
        return EXIT_GOOD;
    if (gnuplot_start(&g, "chart", options->scripts, options->folder) == 0) {
        fputs("load scripts.'/style.gp'\n", g.in);
        for (size_t i = 0, n; i < count; i += n) {
            n = same_case(rows + i, count - i);
            draw_scatter(g.in, options, rows + i, n);
        }
        chart_draw_overview(g.in, options, rows, count);
    }
    return gnuplot_finish(&g);
}
