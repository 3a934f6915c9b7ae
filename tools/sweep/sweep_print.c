/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Prints results: statistics on standard output, which are the same for any split; rate and missing
 * blocks on standard error.
 */
#include "common/commands.h"
#include "common/results.h"
#include "sweep.h"

#include <errno.h>
#include <inttypes.h>
#include <jansson.h>
#include <math.h>
#include <string.h>

static const char *status_name(unsigned k)
{
    return tfa_status_name(-(int)k);
}

static void print_series(const char *name, const char *what, const series *s)
{
    if (s->count == 0)
        return;
    printf("\n%s: %s\n  states %" PRIu64 "\n  min    %-24.17g state %" PRIu64
           "\n  mean   %-24.17g\n  max    %-24.17g state %" PRIu64 "\n",
           name, what, s->count, s->min, s->min_at, series_mean(s), s->max, s->max_at);
    printf("  50 %% below %.3g, 99 %% below %.3g, 99.99 %% below %.3g\n", series_quantile(s, 0.5),
           series_quantile(s, 0.99), series_quantile(s, 0.9999));
    for (unsigned bin = 0; bin < STATISTICS_BINS; bin++)
        if (s->bins[bin])
            printf("  %10.4g .. %-10.4g %" PRIu64 "\n", series_bin_bound(bin),
                   series_bin_bound(bin + 1), s->bins[bin]);
}

static void print_table(const sweep_plan *plan, const statistics *s)
{
    printf("# %s\n", plan->identity);
#define PRINT_COUNT(member, name) printf("%-20s %" PRIu64 "\n", name, s->member);
    STATISTICS_COUNTS(PRINT_COUNT)
#undef PRINT_COUNT
    for (unsigned k = 0; k < STATISTICS_STATUSES; k++)
        if (s->status[k])
            printf("status %-13s %" PRIu64 "\n", status_name(k), s->status[k]);
    for (unsigned k = 0; k < STATISTICS_METHODS; k++)
        if (s->method[k])
            printf("method %-13s %" PRIu64 "\n", tfa_method_name(k), s->method[k]);
#define PRINT_SERIES(member, name, what) print_series(name, what, &s->member);
    STATISTICS_SERIES(PRINT_SERIES)
#undef PRINT_SERIES
}

static void set_count(json_t *object, const char *key, uint64_t value)
{
    json_object_set_new(object, key, json_integer((json_int_t)value));
}

static json_t *series_json(const series *s)
{
    json_t *object = json_object(), *bins = json_array();
    set_count(object, "count", s->count);
    results_set_number(object, "min", s->min);
    set_count(object, "min_state", s->min_at);
    results_set_number(object, "mean", series_mean(s));
    results_set_number(object, "max", s->max);
    set_count(object, "max_state", s->max_at);
    for (unsigned bin = 0; bin < STATISTICS_BINS; bin++) {
        if (!s->bins[bin])
            continue;
        json_t *row = json_object();
        results_set_number(row, "from", series_bin_bound(bin));
        results_set_number(row, "below", series_bin_bound(bin + 1));
        set_count(row, "count", s->bins[bin]);
        json_array_append_new(bins, row);
    }
    json_object_set_new(object, "histogram", bins);
    return object;
}

static json_t *statistics_json(const statistics *s)
{
    json_t *object = json_object(), *statuses = json_object(), *methods = json_object();
#define SET_COUNT(member, name) set_count(object, name, s->member);
    STATISTICS_COUNTS(SET_COUNT)
#undef SET_COUNT
    for (unsigned k = 0; k < STATISTICS_STATUSES; k++)
        if (s->status[k])
            set_count(statuses, status_name(k), s->status[k]);
    for (unsigned k = 0; k < STATISTICS_METHODS; k++)
        if (s->method[k])
            set_count(methods, tfa_method_name(k), s->method[k]);
    json_object_set_new(object, "status", statuses);
    json_object_set_new(object, "method", methods);
#define SET_SERIES(member, name, what)                                                             \
    if (s->member.count)                                                                           \
        json_object_set_new(object, name, series_json(&s->member));
    STATISTICS_SERIES(SET_SERIES)
#undef SET_SERIES
    return object;
}

static const char *const time_words[SWEEP_TIMES] = {"states", "dynamics", "statistics", "reference",
                                                    "output"};

static json_t *run_json(const sweep_results *r, int ranks)
{
    json_t *object = json_object(), *shares = json_object();
    double sum = 0;
    for (int part = 0; part < SWEEP_TIMES; part++)
        sum += r->seconds[part];
    set_count(object, "ranks", (uint64_t)ranks);
    set_count(object, "threads", r->threads);
    set_count(object, "computed", r->states);
    set_count(object, "blocks_found", r->found);
    results_set_number(object, "seconds", r->elapsed);
    results_set_number(object, "states_per_second",
                       r->elapsed > 0 ? (double)r->states / r->elapsed : 0.0);
    for (int part = 0; part < SWEEP_TIMES && sum > 0; part++)
        results_set_number(shares, time_words[part], r->seconds[part] / sum);
    json_object_set_new(object, "shares", shares);
    return object;
}

static int print_json(const sweep_plan *plan, const sweep_results *r, int ranks)
{
    json_t *object = json_object();
    json_object_set_new(object, "sweep", json_string(plan->identity));
    json_object_set_new(object, "statistics", statistics_json(&r->statistics));
    json_object_set_new(object, "run", run_json(r, ranks));
    const int bad = json_dumpf(object, stdout, JSON_COMPACT | JSON_REAL_PRECISION(17));
    json_decref(object);
    putchar('\n');
    return bad;
}

int sweep_print(const sweep_plan *plan, const sweep_results *results, int ranks)
{
    int bad = 0;
    if (plan->options->json)
        bad = print_json(plan, results, ranks);
    else
        print_table(plan, &results->statistics);
    if (bad == 0 && fflush(stdout) == 0 && !ferror(stdout))
        return EXIT_GOOD;
    fprintf(stderr, "totalforce sweep: output: %s\n", strerror(errno));
    return EXIT_FAILED;
}

void sweep_print_rate(const sweep_results *r, int ranks)
{
    double sum = 0;
    for (int part = 0; part < SWEEP_TIMES; part++)
        sum += r->seconds[part];
    if (r->states == 0 || sum <= 0)
        return;
    fprintf(stderr,
            "totalforce sweep: %" PRIu64
            " states in %.3g s: %.3g states/s, %u thread%s, %d rank%s;",
            r->states, r->elapsed, (double)r->states / r->elapsed, r->threads,
            r->threads == 1 ? "" : "s", ranks, ranks == 1 ? "" : "s");
    const char *before = " ";
    for (int part = 0; part < SWEEP_TIMES; part++)
        if (r->seconds[part] >= 0.001 * sum) {
            fprintf(stderr, "%s%s %.1f %%", before, time_words[part], 100 * r->seconds[part] / sum);
            before = ", ";
        }
    fputc('\n', stderr);
}

/* At most `most` ranges of blocks that are not done: "0..3, 7" */
static void print_ranges(const sweep_plan *plan, const uint8_t *done, int most)
{
    uint64_t block = 0;
    for (int shown = 0; block < plan->blocks;) {
        if (sweep_is_done(done, block)) {
            block++;
            continue;
        }
        const uint64_t first = block;
        while (block < plan->blocks && !sweep_is_done(done, block))
            block++;
        if (shown++ == most) {
            fputs(", ...", stderr);
            return;
        }
        fprintf(stderr, "%s%" PRIu64, shown > 1 ? ", " : "", first);
        if (block - first > 1)
            fprintf(stderr, "..%" PRIu64, block - 1);
    }
}

void sweep_print_missing(const sweep_plan *plan, const sweep_results *r)
{
    const char *resume = plan->options->resume;
    fprintf(stderr, "totalforce sweep: %s%" PRIu64 " of %" PRIu64 " blocks are missing (",
            r->interrupted ? "interrupted: " : "", plan->blocks - r->found - r->finished,
            plan->blocks);
    print_ranges(plan, r->done, 8);
    if (resume)
        fprintf(stderr, "): run again with --resume %s\n", resume);
    else
        fputs("), and nothing was kept: run again with --resume FILE\n", stderr);
}
