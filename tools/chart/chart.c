/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * `totalforce chart`: accuracy against speed.
 */
#include "chart.h"
#include "common/commands.h"
#include "common/html_page.h"
#include "common/progress.h"
#include "common/results.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

/* All rows of a run; pictures need them together. */
typedef struct rows {
    chart_row *all;
    size_t count, capacity;
    uint64_t cases; /* that are measured */
    int failed, unwritten;
    /* the fewest bodies at which a call was too long, by op, method and precision; 0: none was */
    uint32_t over[CHART_OP_COUNT][CHART_METHODS][CHART_PRECISION_COUNT];
} rows;

static chart_row *new_row(rows *r)
{
    if (r->count == r->capacity) {
        r->capacity = r->capacity ? 2 * r->capacity : 256;
        chart_row *more = realloc(r->all, r->capacity * sizeof *more);
        if (!more)
            return NULL;
        r->all = more;
    }
    r->all[r->count] = (chart_row){0};
    return &r->all[r->count++];
}

/* A residual of its own, or a peer, with steps only where there are such. */
static int combination_exists(const chart_choice *choice)
{
    if (!chart_op_answered(choice->op, choice->method, choice->precision))
        return 0;
    if (choice->method >= CHART_PEER)
        return choice->refine == 0 && choice->precision == CHART_F64 &&
               choice->strategy == CHART_SINGLE;
    if (chart_is_specialised(choice->strategy) &&
        (choice->refine > 0 || choice->method != TFA_METHOD_AUTO))
        return 0; /* a specialised kernel is its robot's choice, and leaves refinement alone */
    return choice->refine > 0 || chart_precisions[choice->precision].residual == TFA_RESIDUAL_SAME;
}

static int add_row(rows *r, const chart_options *o, chart_case *c, const chart_data *d,
                   const chart_choice *choice)
{
    chart_row *row = new_row(r);
    uint32_t *over = &r->over[choice->op][choice->method][choice->precision];
    if (!row)
        return TFA_E_MEMORY;
    row->choice = *choice;
    chart_row_begin(row, c, d);
    if (*over && c->bodies >= *over)
        row->skipped = CHART_SKIPPED_OVER_BUDGET;
    else
        chart_measure(row, c, d, o->budget, 1e-3 * o->budget / o->seeds);
    if (row->skipped && strcmp(row->skipped, CHART_SKIPPED_OVER_BUDGET) == 0 &&
        (!*over || c->bodies < *over))
        *over = c->bodies;
    return TFA_OK;
}

static int chart_methods(rows *r, const chart_options *o, chart_case *c, const chart_data *d)
{
    int status = TFA_OK;
    chart_choice choice = {.threads = c->threads, .strategy = c->strategy, .op = d->op};
    for (uint32_t p = 0; p < o->precision_count; p++)
        for (uint32_t m = 0; m < o->method_count; m++)
            for (choice.refine = 0; choice.refine < CHART_REFINE && status == TFA_OK;
                 choice.refine++) {
                choice.method = o->methods[m];
                choice.precision = o->precisions[p];
                if (o->refine >> choice.refine & 1u && combination_exists(&choice))
                    status = add_row(r, o, c, d, &choice);
            }
    return status;
}

/* All rows of one seed, op and right-hand side */
static int chart_states(rows *r, const chart_options *o, chart_case *c, chart_op op, chart_rhs rhs)
{
    chart_data d;
    c->op = op;
    int status = chart_data_make(&d, c, rhs, o->states);
    if (status != TFA_OK) {
        fprintf(stderr, "totalforce chart: %s, %" PRIu32 " bodies, %s: exact answer: %s\n", c->name,
                c->bodies, op == CHART_FORWARD ? chart_rhs_words[rhs] : chart_op_words[op],
                tfa_status_text(status));
        return status;
    }
    status = chart_methods(r, o, c, &d);
    chart_data_free(&d);
    return status;
}

/* All rows of one seed */
static int chart_seed(rows *r, const chart_options *o, const chart_target *target, uint32_t bodies,
                      const chart_choice *how)
{
    chart_case c;
    int status = chart_case_open(&c, o, target, bodies, how->threads, how->strategy);
    if (status != TFA_OK)
        return status;
    for (uint32_t rhs = 0; status == TFA_OK && rhs < CHART_RHS_COUNT; rhs++)
        if (o->ops >> CHART_FORWARD & 1u && o->rhs >> rhs & 1u)
            status = chart_states(r, o, &c, CHART_FORWARD, (chart_rhs)rhs);
    if (status == TFA_OK && o->ops >> CHART_LAMBDA & 1u)
        status = chart_states(r, o, &c, CHART_LAMBDA, CHART_QDD);
    chart_case_close(&c);
    return status;
}

/* The front of each op and right-hand side */
static void mark_fronts(chart_row *all, size_t count)
{
    for (size_t i = 0, n; i < count; i += n) {
        for (n = 1; i + n < count && all[i + n].rhs == all[i].rhs &&
                    all[i + n].choice.op == all[i].choice.op;)
            n++;
        chart_mark_front(all + i, n);
    }
}

/* The seeds of one target and size, put together */
static int chart_target_at(rows *r, const chart_options *o, FILE *out, const chart_target *target,
                           uint32_t bodies, const chart_choice *how)
{
    const size_t first = r->count;
    chart_options one = *o;
    int status = TFA_OK;
    for (uint32_t k = 0; status == TFA_OK && k < o->seeds; k++) {
        one.seed = o->seed + k;
        status = chart_seed(r, &one, target, bodies, how);
    }
    const size_t count = status == TFA_OK ? (r->count - first) / o->seeds : 0;
    r->count = first + count;
    chart_combine_seeds(r->all + first, count, o->seeds);
    chart_find_same(r->all + first, count);
    mark_fronts(r->all + first, count);
    for (size_t i = first; i < r->count; i++)
        (o->json ? chart_print_row_json : chart_print_row)(out, &r->all[i]);
    r->unwritten = results_flush(out) != 0;
    return status;
}

/* One target and size, by each number of threads and strategy. Rows that cannot be charted are told
 * and left out; the rest is charted, while rows can be written. */
static void chart_size(rows *r, const chart_options *o, FILE *out, const chart_target *target,
                       uint32_t bodies)
{
    chart_choice how = {0};
    for (uint32_t t = 0; t < o->thread_count; t++)
        for (uint32_t k = 0; k < (o->strategy_count ? o->strategy_count : 1); k++) {
            if (r->unwritten)
                return;
            how.threads = o->threads[t];
            how.strategy = o->strategy_count ? o->strategies[k]
                           : how.threads > 1 ? CHART_BATCH
                                             : CHART_SINGLE;
            if (o->folder) /* otherwise the rows themselves tell */
                progress_step(target->label, r->cases, "cases");
            if (chart_target_at(r, o, out, target, bodies, &how) != TFA_OK)
                r->failed = 1;
        }
}

static void chart_all(rows *r, const chart_options *o, FILE *out)
{
    if (!o->json)
        chart_print_head(out, o);
    for (uint32_t i = 0; i < o->target_count; i++)
        r->cases += (uint64_t)(o->targets[i].file ? 1 : o->size_count) * o->thread_count *
                    (o->strategy_count ? o->strategy_count : 1);
    for (uint32_t i = 0; i < o->target_count; i++) {
        const chart_target *target = &o->targets[i];
        for (uint32_t k = 0; k < (target->file ? 1 : o->size_count); k++)
            chart_size(r, o, out, target, o->sizes[k]);
    }
    progress_show(NULL, 0, 0, "");
}

static int run(rows *r, const chart_options *o)
{
    FILE *page = NULL;
    if (o->html && !(page = html_open("chart", o->html)))
        return EXIT_FAILED;
    FILE *out = results_open("chart", o->folder, o->json);
    if (!out) {
        if (page)
            fclose(page);
        return EXIT_FAILED;
    }
    chart_all(r, o, out);
    int result = results_close("chart", out);
    if (result == EXIT_GOOD && o->folder)
        result = chart_draw(o, r->all, r->count);
    if (page && chart_page(page, o, r->all, r->count) != EXIT_GOOD)
        result = EXIT_FAILED;
    return result == EXIT_GOOD && r->failed ? EXIT_FAILED : result;
}

int command_chart(int argc, char **argv)
{
    chart_options options;
    rows r = {0};
    int error = chart_parse(argc, argv, &options);
    if (error) {
        fprintf(stderr, "totalforce chart: %s\n", strerror(error));
        free(options.command);
        return EXIT_USAGE;
    }
    const int result = run(&r, &options);
    free(r.all);
    free(options.command);
    return result;
}
