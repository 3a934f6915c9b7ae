/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * One scatter: a column of panels for each right-hand side, a line for each precision.
 */
#include "chart.h"
#include "common/results.h"

#include <inttypes.h>
#include <math.h>
#include <stdarg.h>
#include <string.h>

/* The line of panels a row belongs to. */
static int line_of(const chart_options *o, const chart_row *row)
{
    int line = 0;
    while (o->precisions[line] != row->choice.precision)
        line++;
    return line;
}

/* "tfa+1", and where there are several precisions "tfa+1 f32". */
static const char *name_row(const chart_options *o, const chart_row *row, char *text, size_t size)
{
    static const char *const steps[CHART_REFINE] = {"", "+1", "+2"};
    const int several = o->precision_count > 1;
    snprintf(text, size, "%s%s%s%s", chart_method_name(row->choice.method),
             steps[row->choice.refine], several ? " " : "",
             several ? chart_precision_words[row->choice.precision] : "");
    return text;
}

/* Block $data: rhs method refine time error front floor line, then least and largest error and time
 * of the seeds. */
static void write_rows(FILE *out, const chart_options *o, const chart_row *rows, size_t count)
{
    /* the first is of no panel: gnuplot warns of data without any */
    fputs("$data << EOD\n-1 0 0 1 1 0 1 -1 1 1 1 1\n", out);
    for (size_t i = 0; i < count; i++) {
        const chart_row *row = &rows[i];
        if (!chart_row_drawn(row))
            continue;
        fprintf(out, "%d %" PRIu32 " %" PRIu32 " %.6g %.6g %d %.6g %d", (int)row->rhs,
                chart_mark(row->choice.method), row->choice.refine, row->time,
                chart_draw_error(row->error), row->front, chart_draw_floor(row), line_of(o, row));
        fprintf(out, " %.6g %.6g %.6g %.6g\n", chart_draw_error(row->error_low),
                chart_draw_error(row->error_high), row->time_low, row->time_high);
    }
    fputs("EOD\n", out);
}

/* Whole decades around errors and floors. */
static void write_range(FILE *out, const chart_row *rows, size_t count)
{
    double low = 1.0, high = CHART_ERROR_MIN;
    for (size_t i = 0; i < count; i++) {
        if (!chart_row_drawn(&rows[i]))
            continue;
        const double floor = chart_draw_floor(&rows[i]);
        low = fmin(low, fmin(chart_draw_error(rows[i].error_low), floor));
        high = fmax(high, fmax(chart_draw_error(rows[i].error_high), floor));
    }
    fprintf(out, "low = 1e%d\nhigh = 1e%d\n", (int)floor(log10(low) - 0.2),
            (int)ceil(log10(high) + 0.2));
}

/* Of each right-hand side: the panels below one another are compared. */
static void write_times(FILE *out, const chart_row *rows, size_t count)
{
    chart_range times[CHART_RHS_COUNT] = {0};
    for (size_t i = 0; i < count; i++)
        if (chart_row_drawn(&rows[i])) {
            chart_range_extend(&times[rows[i].rhs], rows[i].time_low);
            chart_range_extend(&times[rows[i].rhs], rows[i].time_high);
        }
    chart_set_times(out, times, CHART_RHS_COUNT);
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

/* Breaks a list behind the last blank before `width` characters, again and again; what is beyond
 * the last line is left out. Names are shorter than a line. */
static void wrap(char *text, size_t width, int lines)
{
    char *line = text;
    for (int k = 1; strlen(line) > width; k++) {
        char *at = line + width;
        while (at > line && *at != ' ')
            at--;
        if (k == lines) {
            memcpy(at > line + 3 ? at - 3 : line, "...", sizeof "...");
            return;
        }
        *at = '\n';
        line = at + 1;
    }
}

/* The names of the front of one right-hand side, fastest first. */
static void name_front(FILE *out, const chart_options *o, const chart_row *rows, size_t count,
                       chart_rhs rhs)
{
    char text[512] = "front: ", name[64];
    const char *comma = "";
    double after = -1.0;
    for (;;) {
        const chart_row *next = NULL;
        for (size_t i = 0; i < count; i++)
            if (rows[i].front && rows[i].rhs == rhs && rows[i].time > after &&
                (!next || rows[i].time < next->time))
                next = &rows[i];
        if (!next)
            break;
        append(text, sizeof text, "%s%s", comma, name_row(o, next, name, sizeof name));
        comma = ", ";
        after = next->time;
    }
    wrap(text, 46, 3);
    snprintf(name, sizeof name, "front_%d", (int)rhs);
    gnuplot_string(out, name, text);
}

/* Why a row is not in the picture; NULL if it is. */
static const char *reason_not_drawn(const chart_row *row)
{
    if (chart_row_good(row))
        return NULL;
    if (row->skipped)
        return row->skipped;
    return row->status == TFA_OK ? "fell back to another method" : tfa_status_text(row->status);
}

/* A precision that is not built is silent as a whole. */
static const char *name_silent_row(const chart_options *o, const chart_row *row, char *text,
                                   size_t size)
{
    return strcmp(row->field, CHART_FIELD_PRECISION) == 0
               ? chart_precision_words[row->choice.precision]
               : name_row(o, row, text, size);
}

/* A row of the same reason, and where asked for of the same name, that came earlier. */
static int appeared_before(const chart_options *o, const chart_row *rows, size_t i,
                           int compare_name)
{
    char a[64], b[64];
    const char *name = name_silent_row(o, &rows[i], a, sizeof a);
    for (size_t k = 0; k < i; k++) {
        const char *why = reason_not_drawn(&rows[k]);
        if (why && strcmp(why, reason_not_drawn(&rows[i])) == 0 &&
            (!compare_name || strcmp(name, name_silent_row(o, &rows[k], b, sizeof b)) == 0))
            return 1;
    }
    return 0;
}

/* Methods without an answer, and with another method's answer, by reason */
static void name_silent(FILE *out, const chart_options *o, const chart_row *rows, size_t count)
{
    char text[1024] = "not shown: ", name[64];
    const char *semicolon = "";
    for (size_t i = 0; i < count; i++) {
        if (!reason_not_drawn(&rows[i]) || appeared_before(o, rows, i, 0))
            continue;
        append(text, sizeof text, "%s%s: ", semicolon, reason_not_drawn(&rows[i]));
        semicolon = "; ";
        for (size_t k = i; k < count; k++)
            if (reason_not_drawn(&rows[k]) &&
                strcmp(reason_not_drawn(&rows[k]), reason_not_drawn(&rows[i])) == 0 &&
                !appeared_before(o, rows, k, 1))
                append(text, sizeof text, "%s%s", k == i ? "" : ", ",
                       name_silent_row(o, &rows[k], name, sizeof name));
    }
    append(text, sizeof text, "%s", *semicolon ? "" : "none");
    wrap(text, 180, 2);
    gnuplot_string(out, "silent", text);
}

/* "tfa-cr = cfa-cr" for each mark that stands for several methods, by number of steps */
static void name_same(FILE *out, const chart_options *o, const chart_row *rows, size_t count)
{
    char text[1024] = "One mark, the same answers to the last bit: ", name[64], last[64] = "";
    const char *semicolon = "";
    for (size_t i = 0; i < count; i++) {
        int listed = 0;
        for (size_t k = 0; k < i && !listed; k++) /* of another right-hand side */
            listed = rows[k].same_as && rows[k].same_as == rows[i].same_as &&
                     rows[k].choice.method == rows[i].choice.method &&
                     rows[k].choice.refine == rows[i].choice.refine &&
                     rows[k].choice.precision == rows[i].choice.precision;
        if (!rows[i].same_as || listed)
            continue;
        chart_row first = rows[i];
        first.choice.method = rows[i].same_as;
        append(text, sizeof text, "%s%s = ", semicolon, name_row(o, &first, name, sizeof name));
        append(text, sizeof text, "%s", name_row(o, &rows[i], last, sizeof last));
        semicolon = "; ";
    }
    append(text, sizeof text, "%s", *semicolon ? "" : "none");
    wrap(text, 180, 1);
    gnuplot_string(out, "same", text);
}

/* Title of the picture, and the name of its file */
static void write_names(FILE *out, const chart_row *row)
{
    char name[256], how[96];
    snprintf(name, sizeof name, "%s, %" PRIu32 " bodies%s", row->target, row->bodies,
             chart_name_how(&row->choice, 0, how, sizeof how));
    gnuplot_string(out, "subject", name);
    snprintf(name, sizeof name, "%s-%" PRIu32 "%s", row->target, row->bodies,
             chart_name_how(&row->choice, 1, how, sizeof how));
    for (char *c = name; *c; c++)
        if (*c == ':')
            *c = '-';
    gnuplot_string(out, "file", name);
    chart_set_time_name(out, &row->choice);
}

void chart_draw_scatter(FILE *gnuplot, const chart_options *o, const chart_row *rows, size_t count)
{
    write_names(gnuplot, rows);
    write_rows(gnuplot, o, rows, count);
    write_range(gnuplot, rows, count);
    write_times(gnuplot, rows, count);
    const uint32_t lambda = rows->choice.op == CHART_LAMBDA;
    fprintf(gnuplot, "lambda = %" PRIu32 "\n", lambda);
    for (int rhs = 0; rhs < CHART_RHS_COUNT; rhs++) {
        name_front(gnuplot, o, rows, count, (chart_rhs)rhs);
        fprintf(gnuplot, "has_%d = %d\n", rhs,
                ((lambda ? 1u << CHART_QDD : o->rhs) >> rhs & 1u) != 0);
    }
    fprintf(gnuplot, "lines = %" PRIu32 "\narray line_name[%" PRIu32 "]\n", o->precision_count,
            o->precision_count);
    for (uint32_t k = 0; k < o->precision_count; k++)
        fprintf(gnuplot, "line_name[%" PRIu32 "] = '%s'\n", k + 1,
                chart_precision_words[o->precisions[k]]);
    name_silent(gnuplot, o, rows, count);
    name_same(gnuplot, o, rows, count);
    fputs("load scripts.'/scatter.gp'\n", gnuplot);
}
