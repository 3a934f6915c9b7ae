/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The overview: a small panel for each mechanism and size, and a summary in words.
 */
#include "chart.h"
#include "common/results.h"

#include <inttypes.h>
#include <math.h>
#include <string.h>

/* Both from CHART_CASES x CHART_SIZES: capacity of a picture */
typedef struct grid {
    char targets[CHART_CASES][64];
    uint32_t target_count;
    uint32_t sizes[CHART_SIZES];
    uint32_t size_count;
} grid;

static uint32_t column_of(grid *g, uint32_t bodies)
{
    uint32_t k = 0;
    while (k < g->size_count && g->sizes[k] != bodies)
        k++;
    if (k == g->size_count && k < CHART_SIZES)
        g->sizes[g->size_count++] = bodies;
    return k;
}

static uint32_t line_of(grid *g, const char *target)
{
    uint32_t k = 0;
    while (k < g->target_count && strcmp(g->targets[k], target) != 0)
        k++;
    if (k == g->target_count && k < CHART_CASES)
        snprintf(g->targets[g->target_count++], sizeof g->targets[0], "%s", target);
    return k;
}

/* Robots have the sizes they have: one column for all of them. */
static int has_one_column(const chart_options *o)
{
    for (uint32_t i = 0; i < o->target_count; i++)
        if (!o->targets[i].file)
            return 0;
    return 1;
}

static chart_rhs first_rhs(const chart_options *o)
{
    chart_rhs rhs = CHART_QDD;
    while (rhs < CHART_GRAVITY && !(o->rhs >> rhs & 1u))
        rhs++;
    return rhs;
}

/* In how many panels - mechanism, size, right-hand side - a method with so many steps is on the
 * front, is far above the floor, and gives no answer of its own. */
typedef struct tally {
    uint32_t front, far, silent, panels;
} tally;

#define FAR 100.0

static tally count_method(const chart_row *rows, size_t count, uint32_t method, uint32_t refine)
{
    tally t = {0};
    for (size_t i = 0; i < count; i++) {
        if (rows[i].choice.method != method || rows[i].choice.refine != refine)
            continue;
        const int good = chart_row_good(&rows[i]);
        t.panels++;
        t.silent += !good;
        t.front += good && rows[i].front;
        t.far += good && rows[i].error > FAR * fmax(rows[i].floor, 1e-15);
    }
    return t;
}

static void write_cells(FILE *out, const tally *t)
{
    if (t->panels > 0)
        fprintf(out, " |         %5" PRIu32 "%5" PRIu32 "%8" PRIu32, t->front, t->far, t->silent);
    else
        fprintf(out, " |         %5s%5s%8s", "-", "-", "-");
}

static void write_table(FILE *out, const chart_options *o, const chart_row *rows, size_t count)
{
    fprintf(out, "$words << EOD\n%-14s", "panels");
    for (uint32_t refine = 0; refine < CHART_REFINE; refine++)
        if (o->refine >> refine & 1u)
            fprintf(out, " | %" PRIu32 " steps: front  far  silent", refine);
    for (uint32_t m = 0; m < o->method_count; m++) {
        fprintf(out, "\n%-14s", chart_method_name(o->methods[m]));
        for (uint32_t refine = 0; refine < CHART_REFINE; refine++) {
            const tally t = count_method(rows, count, o->methods[m], refine);
            if (o->refine >> refine & 1u)
                write_cells(out, &t);
        }
    }
    fputs("\nEOD\n", out);
}

/* The methods for which the condition holds, or "none". */
static void list_methods(FILE *out, const chart_options *o, const chart_row *rows, size_t count,
                         uint32_t refine, int (*holds)(const tally *))
{
    const char *before = "";
    for (uint32_t m = 0; m < o->method_count; m++) {
        const tally t = count_method(rows, count, o->methods[m], refine);
        if (!holds(&t))
            continue;
        fprintf(out, "%s%s", before, chart_method_name(o->methods[m]));
        before = ", ";
    }
    fputs(*before ? ".\n" : "none.\n", out);
}

static int is_always_near(const tally *t)
{
    return t->panels > 0 && t->far == 0 && t->silent == 0;
}

static int is_on_a_front(const tally *t)
{
    return t->front > 0;
}

/* Summary of the rows, counted and not asserted */
static void write_sentences(FILE *out, const chart_options *o, const chart_row *rows, size_t count)
{
    const tally any = count_method(rows, count, o->methods[0], o->refine & 1u ? 0 : 1);
    fprintf(out,
            "$sentences << EOD\nCounted over all %" PRIu32 " panels, all right-hand sides. Far: "
            "error more than %g times the floor (or 1e-15).\n"
            "Silent: refused, skipped, or fell back to another method.\n",
            any.panels, FAR);
    for (uint32_t refine = 0; refine < CHART_REFINE; refine++) {
        if (!(o->refine >> refine & 1u))
            continue;
        fprintf(out, "With %" PRIu32 " refinement steps, never far and never silent: ", refine);
        list_methods(out, o, rows, count, refine, is_always_near);
        fprintf(out, "With %" PRIu32 " refinement steps, on the front somewhere: ", refine);
        list_methods(out, o, rows, count, refine, is_on_a_front);
    }
    fputs("EOD\n", out);
}

void chart_draw_overview(FILE *gnuplot, const chart_options *o, const chart_row *rows, size_t count)
{
    grid g = {0};
    const int lambda = rows->choice.op == CHART_LAMBDA;
    const chart_rhs rhs = lambda ? CHART_QDD : first_rhs(o);
    const int one_column = has_one_column(o);
    chart_range times[CHART_SIZES + 1] = {0};
    char how[96];
    /* the first is of no panel: gnuplot warns of data without any */
    fputs("$data << EOD\n-1 -1 0 0 1 1 1 0 1 1\n", gnuplot);
    for (size_t i = 0; i < count; i++) {
        const uint32_t line = line_of(&g, rows[i].target);
        const uint32_t column = column_of(&g, one_column ? 0 : rows[i].bodies);
        if (rows[i].rhs != rhs || !chart_row_drawn(&rows[i]))
            continue;
        chart_range_extend(&times[column], rows[i].time);
        fprintf(gnuplot,
                "%" PRIu32 " %" PRIu32 " %" PRIu32 " %" PRIu32 " %.6g %.6g %.6g %d %.6g %.6g\n",
                line, column, chart_mark(rows[i].choice.method), rows[i].choice.refine,
                rows[i].time, chart_draw_error(rows[i].error), chart_draw_floor(&rows[i]),
                rows[i].front, chart_draw_error(rows[i].error_low),
                chart_draw_error(rows[i].error_high));
    }
    fputs("EOD\n", gnuplot);
    chart_set_times(gnuplot, times, g.size_count);
    chart_set_time_name(gnuplot, &rows->choice);
    gnuplot_string(gnuplot, "how", chart_name_how(&rows->choice, 0, how, sizeof how));
    gnuplot_string(gnuplot, "suffix", chart_name_how(&rows->choice, 1, how, sizeof how));
    fprintf(gnuplot, "lambda = %d\nrhs_name = rhs_%d\nlines = %" PRIu32 "\ncolumns = %" PRIu32 "\n",
            lambda, (int)rhs, g.target_count, g.size_count);
    fprintf(gnuplot, "array line_name[%" PRIu32 "]\narray column_name[%" PRIu32 "]\n",
            g.target_count, g.size_count);
    for (uint32_t k = 0; k < g.target_count; k++)
        fprintf(gnuplot, "line_name[%" PRIu32 "] = '%s'\n", k + 1, g.targets[k]);
    for (uint32_t k = 0; k < g.size_count && !one_column; k++)
        fprintf(gnuplot, "column_name[%" PRIu32 "] = '%" PRIu32 " bodies'\n", k + 1, g.sizes[k]);
    if (one_column)
        fputs("column_name[1] = 'robots'\n", gnuplot);
    write_table(gnuplot, o, rows, count);
    write_sentences(gnuplot, o, rows, count);
    fputs("load scripts.'/overview.gp'\n", gnuplot);
}
