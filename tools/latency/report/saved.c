/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Saved sessions and their comparison.
 */
#include "report.h"

#include <inttypes.h>
#include <jansson.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const char format_name[] = "totalforce latency 1";
/* Tenths of a run that must support a percentile for their range to tell its noise */
enum { SLICES_WANTED = 5 };
/* Standard deviations of a rank that its interval extends to each side: 95 % */
static const double rank_deviations = 1.96;

/* ---- saving ---- */

/* Full buckets as pairs of number and count. */
static json_t *buckets_of(const tfa_histogram *h)
{
    json_t *list = json_array();
    for (uint32_t i = 0; i < h->bucket_count; i++)
        if (h->buckets[i])
            json_array_append_new(list,
                                  json_pack("[II]", (json_int_t)i, (json_int_t)h->buckets[i]));
    return json_pack("{sI sI sI sf so}", "count", (json_int_t)h->count, "lowest",
                     (json_int_t)h->lowest, "highest", (json_int_t)h->highest, "sum", h->sum,
                     "buckets", list);
}

static json_t *run_of(const latency_run *run)
{
    const latency_options *o = &run->options;
    char load[256];
    json_t *slices = json_array();
    for (int i = 0; i < TALLY_SLICES; i++)
        json_array_append_new(slices, buckets_of(&run->total->slices[i].h));
    latency_describe_load(o, load, sizeof load);
    return json_pack("{ss* ss ss ss ss ss si ss so so}", "ended_early", run->ended_early, "via",
                     latency_via_names[run->via], "loop", latency_loop_name(o), "load", load,
                     "robot", o->daemon.robot, "wait",
                     tfa_word(TFA_WORDS_WAIT, run->facts.info.wait), "batch", (int)o->batch,
                     "model", run->facts.hash, "round_trip",
                     buckets_of(&run->total->parts[PART_ROUND_TRIP].h), "slices", slices);
}

int latency_save(const char *path, const latency_session *session)
{
    json_t *runs = json_array();
    for (int i = 0; i < session->count; i++)
        json_array_append_new(runs, run_of(&session->runs[i]));
    json_t *root =
        json_pack("{ss ss ss si sb sO so}", "format", format_name, "date", session->date, "command",
                  session->command, "bits", LATENCY_BITS, "busy", session->baseline->busy.busy,
                  "environment", session->environment, "runs", runs);
    const int result = json_dump_file(root, path, JSON_COMPACT);
    json_decref(root);
    return result;
}

/* ---- reading ---- */

/* @return 0, or -1: not what latency_save writes */
static int read_histogram(latency_times *times, const json_t *json)
{
    size_t i;
    json_t *pair;
    latency_times_init(times);
    tfa_histogram *h = &times->h;
    json_array_foreach(json_object_get(json, "buckets"), i, pair)
    {
        const json_int_t bucket = json_integer_value(json_array_get(pair, 0));
        const json_int_t count = json_integer_value(json_array_get(pair, 1));
        if (bucket < 0 || bucket >= (json_int_t)h->bucket_count || count < 0)
            return -1;
        h->buckets[bucket] = (uint64_t)count;
        h->count += (uint64_t)count;
    }
    h->lowest = (uint64_t)json_integer_value(json_object_get(json, "lowest"));
    h->highest = (uint64_t)json_integer_value(json_object_get(json, "highest"));
    h->sum = json_number_value(json_object_get(json, "sum"));
    return (json_int_t)h->count == json_integer_value(json_object_get(json, "count")) ? 0 : -1;
}

/* Round trips of one saved run */
typedef struct saved_run {
    latency_times whole, slices[TALLY_SLICES];
} saved_run;

static int read_run(saved_run *run, const json_t *json)
{
    const json_t *slices = json_object_get(json, "slices");
    if (read_histogram(&run->whole, json_object_get(json, "round_trip")) != 0)
        return -1;
    for (int i = 0; i < TALLY_SLICES; i++)
        if (read_histogram(&run->slices[i], json_array_get(slices, (size_t)i)) != 0)
            return -1;
    return 0;
}

static json_t *read_session(const char *path)
{
    json_error_t error;
    json_t *root = json_load_file(path, JSON_REJECT_DUPLICATES, &error);
    const char *format = json_string_value(json_object_get(root, "format"));
    if (root && format && strcmp(format, format_name) == 0 &&
        json_integer_value(json_object_get(root, "bits")) == LATENCY_BITS)
        return root;
    fprintf(stderr, "totalforce latency: %s: %s\n", path,
            root ? "not a session that --save of this version wrote" : error.text);
    json_decref(root);
    return NULL;
}

/* ---- comparing ---- */

/* Values between which a percentile lies */
typedef struct range {
    double low, high;
    int by_rank; /* 0: the range over the tenths of the run */
} range;

static range range_of(const saved_run *run, double quantile)
{
    range r = {.low = INFINITY};
    int slices = 0;
    for (int i = 0; i < TALLY_SLICES; i++) {
        const tfa_histogram *h = &run->slices[i].h;
        if (!tfa_histogram_supports(h, quantile))
            continue;
        const double value = (double)tfa_histogram_quantile(h, quantile);
        r.low = value < r.low ? value : r.low;
        r.high = value > r.high ? value : r.high;
        slices++;
    }
    if (slices >= SLICES_WANTED)
        return r;
    const tfa_histogram *h = &run->whole.h;
    const double off = rank_deviations * sqrt(quantile * (1 - quantile) / (double)h->count);
    const double above = quantile + off < 1 ? quantile + off : 1;
    return (range){.low = (double)tfa_histogram_quantile(h, quantile > off ? quantile - off : 0),
                   .high = (double)tfa_histogram_quantile(h, above),
                   .by_rank = 1};
}

static void compare_quantile(FILE *out, const saved_run *before, const saved_run *after, int i)
{
    const double quantile = latency_quantiles[i].quantile;
    if (!tfa_histogram_supports(&before->whole.h, quantile) ||
        !tfa_histogram_supports(&after->whole.h, quantile))
        return;
    const double old = (double)tfa_histogram_quantile(&before->whole.h, quantile);
    const double new = (double)tfa_histogram_quantile(&after->whole.h, quantile);
    const range a = range_of(before, quantile), b = range_of(after, quantile);
    const double low = b.low / a.high, high = b.high / a.low;
    fprintf(out, "  p%-10s %10.3f %10.3f %7.3f  %.3f to %.3f %s%s\n", latency_quantiles[i].name,
            old / 1000, new / 1000, new / old, low, high,
            low > 1    ? "slower"
            : high < 1 ? "faster"
                       : "within noise",
            a.by_rank || b.by_rank ? " (by ranks)" : "");
}

static void print_differences(FILE *out, const json_t *before, const json_t *after)
{
    static const char *const keys[] = {"via",   "load",    "robot",  "wait",      "batch",
                                       "model", "version", "kernel", "processor", "ended_early"};
    for (size_t i = 0; i < sizeof keys / sizeof keys[0]; i++) {
        const json_t *a = json_object_get(before, keys[i]), *b = json_object_get(after, keys[i]);
        if (json_equal(a, b) || (!a && !b))
            continue;
        char *old = json_dumps(a, JSON_ENCODE_ANY), *new = json_dumps(b, JSON_ENCODE_ANY);
        fprintf(out, "  not the same %s: %s, %s\n", keys[i], old ? old : "none",
                new ? new : "none");
        free(old);
        free(new);
    }
}

static int compare_run(FILE *out, const json_t *before, const json_t *after)
{
    saved_run *runs = calloc(2, sizeof *runs);
    int result = -1;
    if (runs && read_run(&runs[0], before) == 0 && read_run(&runs[1], after) == 0) {
        fprintf(out, "\n%s, robot %s, batch %" JSON_INTEGER_FORMAT ", wait %s, %s\n",
                json_string_value(json_object_get(after, "via")),
                json_string_value(json_object_get(after, "robot")),
                json_integer_value(json_object_get(after, "batch")),
                json_string_value(json_object_get(after, "wait")),
                json_string_value(json_object_get(after, "load")));
        print_differences(out, before, after);
        fprintf(out, "  %-11s %10s %10s %7s  %s\n", "us", "before", "after", "ratio",
                "ratios of the tenths of the runs");
        for (int i = 0; i < QUANTILE_COUNT; i++)
            compare_quantile(out, &runs[0], &runs[1], i);
        fprintf(out, "  %-11s %10.3f %10.3f\n", "max", (double)runs[0].whole.h.highest / 1000,
                (double)runs[1].whole.h.highest / 1000);
        result = 0;
    } else
        fprintf(stderr, "totalforce latency: --compare: damaged\n");
    free(runs);
    return result;
}

static void print_session(FILE *out, const char *name, const char *path, const json_t *session)
{
    fprintf(out, "%s: %s, %s%s: %s\n", name, path,
            json_string_value(json_object_get(session, "date")),
            json_is_true(json_object_get(session, "busy")) ? ", busy machine" : "",
            json_string_value(json_object_get(session, "command")));
}

int latency_compare(FILE *out, const char *before, const char *after)
{
    json_t *a = read_session(before), *b = read_session(after);
    int result = a && b ? 0 : -1;
    if (result == 0) {
        const json_t *old = json_object_get(a, "runs"), *new = json_object_get(b, "runs");
        print_session(out, "before", before, a);
        print_session(out, "after", after, b);
        print_differences(out, json_object_get(a, "environment"),
                          json_object_get(b, "environment"));
        for (size_t i = 0; i < json_array_size(old) && i < json_array_size(new); i++)
            if (compare_run(out, json_array_get(old, i), json_array_get(new, i)) != 0)
                result = -1;
        if (json_array_size(old) != json_array_size(new))
            fprintf(out, "\nnot as many runs: %zu, %zu\n", json_array_size(old),
                    json_array_size(new));
    }
    json_decref(a);
    json_decref(b);
    return result;
}

int latency_check_saved(const char *path)
{
    json_t *session = read_session(path);
    const int result = session ? 0 : -1;
    json_decref(session);
    return result;
}
