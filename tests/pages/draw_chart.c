/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The page of a chart whose rows stand in a file.
 *
 *   draw_chart ROWS.csv PAGE.html
 */
#include "chart/chart.h"
#include "common/html_page.h"
#include "rows.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { ROWS_MAX = 1024 };

static void read_choice(const rows *r, chart_row *row)
{
    row->choice = (chart_choice){
        .method = (uint32_t)chart_method_find(rows_text(r, "method")),
        .refine = rows_whole(r, "refine"),
        .precision = rows_word(r, "precision", chart_precision_words, CHART_PRECISION_COUNT),
        .threads = rows_whole(r, "threads"),
        .strategy = rows_word(r, "strategy", chart_strategy_words, CHART_STRATEGY_COUNT),
        .op = rows_word(r, "op", chart_op_words, CHART_OP_COUNT)};
    if (row->choice.op == CHART_FORWARD)
        row->rhs = (chart_rhs)rows_word(r, "rhs", chart_rhs_words, CHART_RHS_COUNT);
}

static void read_answer(const rows *r, chart_row *row)
{
    const char *status = rows_text(r, "status"), *by = rows_text(r, "answered_by"),
               *same = rows_text(r, "same_as");
    const int answered = strcmp(status, "ok") == 0 || strcmp(status, "fallback") == 0;
    snprintf(row->field, sizeof row->field, "%s", rows_text(r, "about"));
    row->status = answered ? TFA_OK : rows_status(r, "status");
    if (row->status == 1)
        row->skipped = strdup(status); /* as long as the program lives */
    row->answered_by = *by ? (uint32_t)chart_method_find(by) : 0;
    row->same_as = *same ? (uint32_t)chart_method_find(same) : 0;
    row->front = (int)rows_whole(r, "front");
}

static void read_numbers(const rows *r, chart_row *row)
{
    row->error = rows_number(r, "error", NAN);
    row->worst = rows_number(r, "worst_component", NAN);
    row->floor = rows_number(r, "floor", NAN);
    row->estimate = rows_number(r, "estimate", NAN);
    row->time = rows_number(r, "time_us", NAN);
    row->aba_time = rows_number(r, "aba_us", NAN);
    row->ratio = rows_number(r, "time_ratio", NAN);
    row->samples = rows_whole(r, "samples");
    row->error_low = rows_number(r, "error_low", NAN);
    row->error_high = rows_number(r, "error_high", NAN);
    row->time_low = rows_number(r, "time_low_us", NAN);
    row->time_high = rows_number(r, "time_high_us", NAN);
}

/* What the page says of a row in its legend and lead */
static void add_to_options(chart_options *o, const chart_row *row)
{
    uint32_t k = 0;
    o->ops |= 1u << row->choice.op;
    while (k < o->method_count && o->methods[k] != row->choice.method)
        k++;
    if (k == o->method_count)
        o->methods[o->method_count++] = row->choice.method;
}

int main(int argc, char **argv)
{
    static chart_row all[ROWS_MAX];
    static rows r;
    size_t count = 0;
    if (argc != 3)
        return 3;
    rows_open(&r, argv[1]);
    chart_options o = {.states = 2, .seeds = 2, .budget = 1, .command = r.command};
    for (; count < ROWS_MAX && rows_next(&r); count++) {
        chart_row *row = &all[count];
        snprintf(row->target, sizeof row->target, "%s", rows_text(&r, "mechanism"));
        row->bodies = rows_whole(&r, "bodies");
        read_choice(&r, row);
        read_answer(&r, row);
        read_numbers(&r, row);
        add_to_options(&o, row);
    }
    FILE *page = html_open("chart", argv[2]);
    return page ? chart_page(page, &o, all, count) : 2;
}
