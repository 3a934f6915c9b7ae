/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Title and tables of the page: conclusions, counted and not asserted.
 */
#include "chart_page.h"
#include "common/html_page.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* As docs/charts/tables.sh counts answers near the floor */
#define NEAR 10.0
#define LEAST_FLOOR 1e-15
/* Longer tables are folded. */
#define LONG_TABLE 120

int chart_is_exact(const chart_row *row)
{
    return row->error <= NEAR * fmax(row->floor, LEAST_FLOOR);
}

static int is_exact_call(const chart_row *row)
{
    return chart_is_exact(row) && row->choice.threads == 1 && !chart_is_batch(row->choice.strategy);
}

static int has_a_digit(const chart_row *row)
{
    return row->error < CHART_NO_DIGIT;
}

const chart_row *chart_fastest(const chart_panel *panel, int (*fits)(const chart_row *row))
{
    const chart_row *best = NULL;
    for (size_t i = 0; i < panel->count; i++) {
        const chart_row *row = &panel->rows[i];
        if (chart_row_drawn(row) && fits(row) && (!best || row->time < best->time))
            best = row;
    }
    return best;
}

/* The title is about the panels of the first op that are shown first. */
static int is_of_title(const chart_panels *p, const chart_panel *panel)
{
    return chart_panel_first(p, panel) && panel->rows->choice.op == p->rows->choice.op;
}

/* Panels of the title, and those of them that `winner` wins, with its times */
typedef struct tally {
    size_t panels, won;
    chart_range times;
} tally;

static tally count_wins(const chart_panels *p, const char *winner)
{
    tally t = {0};
    char name[96];
    for (size_t k = 0; k < p->count; k++) {
        const chart_row *best = chart_fastest(&p->all[k], chart_is_exact);
        if (!is_of_title(p, &p->all[k]))
            continue;
        t.panels++;
        if (!best)
            continue;
        chart_name_choice(name, sizeof name, &best->choice);
        if (strcmp(name, winner) == 0) {
            t.won++;
            chart_range_extend(&t.times, best->time);
        }
    }
    return t;
}

void chart_page_title(char *text, size_t size, const chart_panels *p)
{
    char name[96], winner[96] = "", low[32], high[32];
    tally most = {0};
    for (size_t k = 0; k < p->count; k++) {
        const chart_row *best = chart_fastest(&p->all[k], chart_is_exact);
        if (!best || !is_of_title(p, &p->all[k]))
            continue;
        chart_name_choice(name, sizeof name, &best->choice);
        const tally t = count_wins(p, name);
        if (t.won > most.won) {
            most = t;
            memcpy(winner, name, sizeof winner);
        }
    }
    svg_microseconds(low, sizeof low, most.times.low);
    svg_microseconds(high, sizeof high, most.times.high);
    if (most.won == 0)
        snprintf(text, size, "No answer is exact to rounding here");
    else if (most.panels == 1)
        snprintf(text, size, "%s: exact to rounding in %s by %s", p->rows->target, low, winner);
    else
        snprintf(text, size,
                 "%s: fastest answer exact to rounding on %zu of %zu charts, %s to %s a state",
                 winner, most.won, most.panels, low, high);
}

static void write_choice(FILE *out, const chart_row *row)
{
    char name[96], time[32];
    if (!row) {
        fputs("<td>none</td>", out);
        return;
    }
    chart_name_choice(name, sizeof name, &row->choice);
    svg_microseconds(time, sizeof time, row->time);
    fprintf(out, "<td>%s in %s<small>error %.1e</small></td>", name, time, row->error);
}

/* Methods without an answer of their own, or without a correct digit, each once */
static void write_failures(FILE *out, const chart_panel *panel)
{
    uint64_t seen = 0;
    const char *before = "";
    fputs("<td>", out);
    for (size_t i = 0; i < panel->count; i++) {
        const chart_row *row = &panel->rows[i];
        const uint64_t bit = UINT64_C(1) << row->choice.method % 64;
        if ((chart_row_good(row) && has_a_digit(row)) || row->choice.refine > 0 || seen & bit)
            continue;
        seen |= bit;
        fprintf(out, "%s%s <small>%s</small>", before, chart_method_name(row->choice.method),
                chart_row_good(row) ? "no digit" : chart_row_status(row));
        before = " ";
    }
    fprintf(out, "%s</td>", *before ? "" : "none");
}

void chart_page_choices(FILE *out, const chart_panels *p)
{
    char name[128];
    fputs(
        "<h2>Which answer to use</h2>\n<div class=\"scroll\"><table "
        "class=\"words\">\n<caption>Exact: error at "
        "most ten times the floor of the data.</caption>\n<thead><tr><th scope=\"col\">robot</th>"
        "<th scope=\"col\">exact, one call</th><th scope=\"col\">exact, least time</th>"
        "<th scope=\"col\">least time of all</th><th scope=\"col\">fails alone</th></tr></thead>\n"
        "<tbody>\n",
        out);
    for (size_t k = 0; k < p->count; k++) {
        const chart_panel *panel = &p->all[k];
        chart_panel_name(name, sizeof name, panel);
        fprintf(out, "<tr data-p=\"p%zu\"><th scope=\"row\">", k);
        html_text(out, name);
        fputs("</th>", out);
        write_choice(out, chart_fastest(panel, is_exact_call));
        write_choice(out, chart_fastest(panel, chart_is_exact));
        write_choice(out, chart_fastest(panel, has_a_digit));
        write_failures(out, panel);
        fputs("</tr>\n", out);
    }
    fputs("</tbody></table></div>\n", out);
}

static void write_number(FILE *out, const char *format, double value)
{
    fputs("<td class=\"n\">", out);
    if (isfinite(value))
        fprintf(out, format, value);
    fputs("</td>", out);
}

static void write_numbers(FILE *out, const chart_row *row, size_t index)
{
    char name[96];
    chart_name_choice(name, sizeof name, &row->choice);
    fprintf(out, "<tr data-r=\"%zu\"><th scope=\"row\">", index);
    html_text(out, row->target);
    fprintf(out, "</th><td class=\"n\">%" PRIu32 "</td><td>%s</td><td>%s</td>", row->bodies,
            chart_row_rhs(row), name);
    write_number(out, "%.3e", row->error);
    write_number(out, "%.3e", row->error_high);
    write_number(out, "%.3e", row->floor);
    write_number(out, "%.4g", row->time);
    write_number(out, "%.4g", row->time_high);
    fputs("<td>", out);
    html_text(out, chart_row_status(row));
    if (row->field[0] && row->status != TFA_OK) {
        fputs(" ", out);
        html_text(out, row->field);
    }
    fputs("</td></tr>\n", out);
}

void chart_page_numbers(FILE *out, const chart_row *rows, size_t count)
{
    fprintf(out,
            "<details%s><summary>Table of the numbers</summary>\n<div class=\"scroll\"><table>\n"
            "<thead><tr><th scope=\"col\">robot</th><th scope=\"col\" class=\"n\">bodies</th>"
            "<th scope=\"col\">rhs</th><th scope=\"col\">answer</th>"
            "<th scope=\"col\" class=\"n\">error</th><th scope=\"col\" class=\"n\">worst seed</th>"
            "<th scope=\"col\" class=\"n\">floor</th><th scope=\"col\" class=\"n\">time (µs)</th>"
            "<th scope=\"col\" class=\"n\">slowest seed</th><th scope=\"col\">status</th></tr>"
            "</thead>\n<tbody>\n",
            count <= LONG_TABLE ? " open" : "");
    for (size_t i = 0; i < count; i++)
        write_numbers(out, &rows[i], i);
    fputs("</tbody></table></div></details>\n", out);
}
