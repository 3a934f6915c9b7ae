/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The page of a chart: panels, choices, numbers.
 */
#include "chart_page.h"
#include "common/commands.h"
#include "common/html_page.h"
#include "common/results.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

static int same_panel(const chart_row *a, const chart_row *b)
{
    return a->bodies == b->bodies && a->rhs == b->rhs && a->choice.op == b->choice.op &&
           strcmp(a->target, b->target) == 0;
}

/* The rows of the panel that row `first` belongs to; 0 if an earlier row does, too. */
static size_t gather(chart_panel *panel, const chart_row *rows, size_t count, size_t first)
{
    size_t n = 0;
    for (size_t i = 0; i < first; i++)
        if (same_panel(&rows[i], &rows[first]))
            return 0;
    for (size_t i = first; i < count; i++)
        if (same_panel(&rows[i], &rows[first])) {
            panel->rows[n] = rows[i];
            panel->index[n++] = i;
        }
    return panel->count = n;
}

int chart_panels_make(chart_panels *p, const chart_row *rows, size_t count)
{
    *p = (chart_panels){.all = calloc(count + 1, sizeof *p->all),
                        .rows = calloc(count + 1, sizeof *p->rows),
                        .index = calloc(count + 1, sizeof *p->index)};
    if (!p->all || !p->rows || !p->index) {
        chart_panels_free(p);
        return -1;
    }
    size_t used = 0;
    for (size_t i = 0; i < count; i++) {
        chart_panel *panel = &p->all[p->count];
        *panel = (chart_panel){.rows = p->rows + used, .index = p->index + used};
        if (gather(panel, rows, count, i) == 0)
            continue;
        chart_mark_front(panel->rows, panel->count);
        used += panel->count;
        p->count++;
    }
    return 0;
}

void chart_panels_free(chart_panels *p)
{
    free(p->all);
    free(p->rows);
    free(p->index);
    *p = (chart_panels){0};
}

int chart_panel_first(const chart_panels *p, const chart_panel *panel)
{
    return panel->rows->choice.op != CHART_FORWARD || panel->rows->rhs == p->rows->rhs;
}

void chart_panel_name(char *text, size_t size, const chart_panel *panel)
{
    const chart_row *row = panel->rows;
    snprintf(text, size, "%s, %" PRIu32 " %s, %s", row->target, row->bodies,
             row->bodies == 1 ? "body" : "bodies",
             row->choice.op == CHART_FORWARD ? chart_row_rhs(row) : "Λ⁻¹");
}

static void write_panel(FILE *out, const chart_panels *p, size_t k, const chart_page_axes *axes)
{
    const chart_panel *panel = &p->all[k];
    char name[128];
    chart_panel_name(name, sizeof name, panel);
    fprintf(out, "<figure class=\"panel\" id=\"p%zu\"%s><figcaption><b>", k,
            chart_panel_first(p, panel) ? "" : " hidden");
    html_text(out, name);
    fputs("</b></figcaption>\n", out);
    chart_page_scatter(out, axes, panel);
    fputs("</figure>\n", out);
}

static const char *subject_of(const chart_options *o)
{
    if (o->ops == 1u << CHART_FORWARD)
        return "Forward dynamics";
    return o->ops == 1u << CHART_LAMBDA ? "Λ⁻¹ of one link"
                                        : "Forward dynamics, and Λ⁻¹ of one link";
}

static void write_lead(char *text, size_t size, const chart_options *o)
{
    snprintf(
        text, size,
        "%s: relative error against quadruple precision, and time of one state; "
        "left is fast, low is exact. Grey: no other answer is both faster and as exact. Filled: "
        "refined. Bars: %" PRIu32 " seed%s. Dashed: floor of the data. Times are CPU times, "
        "with several threads wall times.",
        subject_of(o), o->seeds, o->seeds == 1 ? "" : "s");
}

/* The rows as in the file, for the script and the notes */
static char *print_rows(const chart_options *o, const chart_row *rows, size_t count)
{
    char *text = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    if (!out)
        return NULL;
    chart_print_head(out, o);
    for (size_t i = 0; i < count; i++)
        chart_print_row(out, &rows[i]);
    return fclose(out) == 0 ? text : NULL;
}

static void write_page(FILE *out, const chart_options *o, const chart_panels *p, const char *csv,
                       const chart_row *rows, size_t count)
{
    char title[512], lead[640], filters[160];
    const chart_page_axes axes = chart_page_axes_of(p);
    chart_page_title(title, sizeof title, p);
    write_lead(lead, sizeof lead, o);
    snprintf(filters, sizeof filters,
             "mechanism bodies op rhs=%s| method refine precision threads strategy",
             p->count ? chart_row_rhs(p->rows) : "");
    html_begin(out, &(html_page){.title = title,
                                 .lead = lead,
                                 .filters = filters,
                                 .tip = "error error_low error_high worst_component floor estimate "
                                        "time_us time_low_us time_high_us time_ratio samples "
                                        "same_as"});
    fputs("<noscript><p>Without scripts: the first right-hand side; the tables have all "
          "rows.</p></noscript>\n<div id=\"filters\"></div>\n",
          out);
    chart_page_legend(out, o);
    fputs("<div class=\"panels\">\n", out);
    for (size_t k = 0; k < p->count; k++)
        write_panel(out, p, k, &axes);
    fputs("</div>\n", out);
    chart_page_choices(out, p);
    chart_page_numbers(out, rows, count);
    html_end(out, csv);
}

int chart_page(FILE *out, const chart_options *options, const chart_row *rows, size_t count)
{
    chart_panels p;
    char *csv = print_rows(options, rows, count);
    const int made = csv ? chart_panels_make(&p, rows, count) : -1;
    if (made == 0) {
        write_page(out, options, &p, csv, rows, count);
        chart_panels_free(&p);
    } else {
        fprintf(stderr, "totalforce chart: %s\n", tfa_status_text(TFA_E_MEMORY));
    }
    free(csv);
    const int closed = results_close("chart", out);
    return made == 0 ? closed : EXIT_FAILED;
}
