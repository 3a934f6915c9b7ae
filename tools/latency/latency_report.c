/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Prints the measurements: a table for people, JSON, CSV and .hgrm for machines.
 */
#include "latency.h"

#include <errno.h>
#include <inttypes.h>
#include <jansson.h>
#include <stdlib.h>
#include <string.h>

static const struct {
    double quantile;
    const char *name;
} quantiles[] = {
    {0.5, "50"},       {0.9, "90"},         {0.99, "99"},          {0.999, "99.9"},
    {0.9999, "99.99"}, {0.99999, "99.999"}, {0.999999, "99.9999"},
};
enum { QUANTILE_COUNT = sizeof quantiles / sizeof quantiles[0] };

static const char *wait_name(tfa_wait wait)
{
    static const char *const names[] = {"default", "spin", "hybrid", "block"};
    return (unsigned)wait < 4 ? names[wait] : "unknown";
}

static const char *estimate_name(tfa_estimate estimate)
{
    static const char *const names[] = {"default", "never", "always"};
    return (unsigned)estimate < 3 ? names[estimate] : "unknown";
}

/* p50 of the compute part: in process when that was measured, else by the daemon's stamps. */
static double solve_p50(const latency_run *run, const latency_baseline *baseline)
{
    const tfa_histogram *h = baseline->solve.count ? &baseline->solve : &run->parts[PART_COMPUTE];
    return (double)tfa_histogram_quantile(h, 0.5);
}

static double ratio_to(const tfa_histogram *pingpong, const latency_run *run,
                       const latency_baseline *baseline)
{
    if (pingpong->count == 0)
        return 0.0;
    double floor = (double)tfa_histogram_quantile(pingpong, 0.5) + solve_p50(run, baseline);
    double p50 = (double)tfa_histogram_quantile(&run->parts[PART_ROUND_TRIP], 0.5);
    return floor > 0 ? p50 / floor : 0.0;
}

double latency_ratio(const latency_run *run, const latency_baseline *baseline)
{
    return baseline->have_pingpong ? ratio_to(&baseline->pingpong, run, baseline) : 0.0;
}

double latency_ratio_same_size(const latency_run *run, const latency_baseline *baseline)
{
    return ratio_to(&baseline->same_size, run, baseline);
}

int latency_expected(const latency_options *options, const latency_run *run,
                     const latency_baseline *baseline)
{
    double p99 = (double)tfa_histogram_quantile(&run->parts[PART_ROUND_TRIP], 0.99) / 1000.0;
    int threshold = options->fail_p99_us > 0 || options->fail_ratio > 0;
    if (threshold && run->misses)
        return 0;
    if (options->fail_p99_us > 0 && !(p99 <= options->fail_p99_us))
        return 0;
    double ratio = latency_ratio(run, baseline);
    return !(options->fail_ratio > 0) || (ratio > 0 && ratio <= options->fail_ratio);
}

/* One line of the table, in us, under the head of `columns`: a quantile that has too few samples
 * of its own is left open. */
static void print_row(FILE *out, const char *name, const tfa_histogram *h,
                      const tfa_histogram *columns)
{
    if (h->count == 0)
        return;
    fprintf(out, "  %-12s %9.3f", name, (double)h->lowest / 1000.0);
    for (int i = 0; i < QUANTILE_COUNT; i++) {
        double quantile = quantiles[i].quantile;
        if (!tfa_histogram_supports(columns, quantile))
            continue;
        if (tfa_histogram_supports(h, quantile))
            fprintf(out, " %9.3f", (double)tfa_histogram_quantile(h, quantile) / 1000.0);
        else
            fprintf(out, " %9s", "-");
    }
    fprintf(out, " %9.3f %9.3f\n", (double)h->highest / 1000.0, tfa_histogram_mean(h) / 1000.0);
}

static void print_head(FILE *out, const char *what, const tfa_histogram *h)
{
    fprintf(out, "  %-12s %9s", what, "min");
    for (int i = 0; i < QUANTILE_COUNT; i++)
        if (tfa_histogram_supports(h, quantiles[i].quantile))
            fprintf(out, "   p%-6s", quantiles[i].name);
    fprintf(out, " %9s %9s\n", "max", "mean");
}

static void print_thread(FILE *out, const char *who, const thread_usage *t)
{
    fprintf(out,
            "  %-12s %-16s %s %d, context switches %" PRId64 " voluntary %" PRId64
            " involuntary, page faults %" PRId64 " minor %" PRId64 " major\n",
            who, t->name, environment_policy(t->policy), t->priority, t->voluntary, t->involuntary,
            t->minor_faults, t->major_faults);
}

static void print_loop(FILE *out, const latency_options *options, const latency_run *run)
{
    if (options->rate > 0)
        fprintf(out, "  %g a second", options->rate);
    else
        fputs("  closed loop", out);
    fprintf(out,
            ": %" PRIu64 " round trips after %" PRIu64
            " of warm-up, %.3f s, a new state at every call\n",
            run->parts[PART_ROUND_TRIP].count, options->warmup, (double)run->elapsed_ns / 1e9);
}

static void print_run(FILE *out, const latency_options *options, const latency_run *run,
                      const latency_baseline *baseline)
{
    const tfa_client_info *info = &run->info;
    const tfa_histogram *trip = &run->parts[PART_ROUND_TRIP];
    fprintf(out,
            "\n%s: robot %s, %" PRIu32 " coordinates, %" PRIu32 " freedoms%s, batch %" PRIu32
            ", forward dynamics by %s, estimate %s, wait %s, model %.12s\n",
            daemon_via_name(run->via), options->daemon.robot, info->q_count, info->v_count,
            info->base_freedoms ? " and a floating base" : "", options->batch,
            tfa_method_name(run->method), estimate_name(options->estimate), wait_name(info->wait),
            run->hash);
    print_loop(out, options, run);
    print_head(out, "us", trip);
    for (int i = 0; i < PART_COUNT; i++)
        print_row(out, latency_parts[i], &run->parts[i], trip);
    fprintf(out, "  the slowest was number %" PRIu64 ", %.6f s after the start\n",
            trip->highest_index, (double)run->highest_at / 1e9);
    fprintf(out,
            "  misses %" PRIu64 ", late %" PRIu64 ", longest run of them %" PRIu64
            ", reconnects %" PRIu64 ", stolen by the host %" PRIu64 " ticks\n",
            run->misses, run->late, run->longest_run, run->reconnects, run->steal_ticks);
    if (options->batch > 1)
        fprintf(out, "  p50 per state %.3f us\n",
                (double)tfa_histogram_quantile(trip, 0.5) / 1000.0 / options->batch);
    print_thread(out, "client", &run->client);
    for (int i = 0; i < run->thread_count; i++)
        print_thread(out, "daemon", &run->threads[i]);
    if (baseline->have_pingpong)
        fprintf(out, "  p50 is %.2f x (ping-pong + solve %s)\n", latency_ratio(run, baseline),
                baseline->solve.count ? "in process" : "by the daemon's stamps");
    if (baseline->same_size.count)
        fprintf(out, "  p50 is %.2f x (ping-pong of the same %u + %u cache lines + solve)\n",
                latency_ratio_same_size(run, baseline), baseline->size.request_lines,
                baseline->size.reply_lines);
}

static void print_environment(FILE *out)
{
    json_t *facts = environment_read(), *value;
    const char *name;
    fprintf(out, "environment\n");
    json_object_foreach(facts, name, value)
    {
        char *text = json_is_string(value) ? NULL : json_dumps(value, JSON_ENCODE_ANY);
        const char *shown = json_is_string(value) ? json_string_value(value) : text;
        fprintf(out, "  %-20s %s\n", name, json_is_null(value) ? "not told" : shown);
        free(text);
    }
    json_decref(facts);
}

void latency_print_text(FILE *out, const latency_options *options, const latency_run *runs,
                        int count, const latency_baseline *baseline)
{
    print_environment(out);
    fprintf(out, "\nbaseline of this run\n");
    const tfa_histogram *columns =
        baseline->pingpong.count ? &baseline->pingpong : &baseline->solve;
    print_head(out, "us", columns);
    print_row(out, baseline->have_pingpong ? "ping-pong" : "busy", &baseline->pingpong, columns);
    if (baseline->same_size.count)
        print_row(out, "same size", &baseline->same_size, columns);
    print_row(out, "solve", &baseline->solve, columns);
    for (int i = 0; i < count; i++)
        print_run(out, options, &runs[i], baseline);
}

static json_t *json_histogram(const tfa_histogram *h)
{
    if (h->count == 0)
        return json_null();
    json_t *percentiles = json_object();
    for (int i = 0; i < QUANTILE_COUNT; i++)
        if (tfa_histogram_supports(h, quantiles[i].quantile))
            json_object_set_new(
                percentiles, quantiles[i].name,
                json_integer((json_int_t)tfa_histogram_quantile(h, quantiles[i].quantile)));
    return json_pack("{sI sI sI sf so}", "count", (json_int_t)h->count, "min",
                     (json_int_t)h->lowest, "max", (json_int_t)h->highest, "mean",
                     tfa_histogram_mean(h), "percentiles", percentiles);
}

static json_t *json_thread(const char *process, const thread_usage *t)
{
    return json_pack("{ss ss ss si sI sI sI sI}", "process", process, "name", t->name, "policy",
                     environment_policy(t->policy), "priority", t->priority, "voluntary_switches",
                     (json_int_t)t->voluntary, "involuntary_switches", (json_int_t)t->involuntary,
                     "minor_faults", (json_int_t)t->minor_faults, "major_faults",
                     (json_int_t)t->major_faults);
}

static json_t *json_run(const latency_options *options, const latency_run *run,
                        const latency_baseline *baseline)
{
    json_t *threads = json_array(), *parts = json_object();
    json_array_append_new(threads, json_thread("client", &run->client));
    for (int i = 0; i < run->thread_count; i++)
        json_array_append_new(threads, json_thread("daemon", &run->threads[i]));
    for (int i = 0; i < PART_COUNT; i++)
        json_object_set_new(parts, latency_parts[i], json_histogram(&run->parts[i]));
    json_t *json =
        json_pack("{ss ss sf ss si si si ss ss}", "via", daemon_via_name(run->via), "loop",
                  options->rate > 0 ? "rate" : "closed", "rate", options->rate, "robot",
                  options->daemon.robot, "q_count", (int)run->info.q_count, "v_count",
                  (int)run->info.v_count, "base_freedoms", (int)run->info.base_freedoms,
                  "model_hash", run->hash, "method", tfa_method_name(run->method));
    json_t *rest = json_pack(
        "{ss ss si sI so sI sI sI sI sI sI sI sf sf so sb}", "estimate",
        estimate_name(options->estimate), "wait", wait_name(run->info.wait), "batch",
        (int)options->batch, "warmup", (json_int_t)options->warmup, "ns", parts, "max_index",
        (json_int_t)run->parts[0].highest_index, "max_at_ns", (json_int_t)run->highest_at, "misses",
        (json_int_t)run->misses, "late", (json_int_t)run->late, "longest_run",
        (json_int_t)run->longest_run, "reconnects", (json_int_t)run->reconnects, "steal_ticks",
        (json_int_t)run->steal_ticks, "ratio", latency_ratio(run, baseline), "ratio_same_size",
        latency_ratio_same_size(run, baseline), "threads", threads, "expected",
        latency_expected(options, run, baseline));
    json_object_update_new(json, rest);
    return json;
}

int latency_print_json(FILE *out, const latency_options *options, const latency_run *runs,
                       int count, const latency_baseline *baseline)
{
    json_t *list = json_array();
    for (int i = 0; i < count; i++)
        json_array_append_new(list, json_run(options, &runs[i], baseline));
    json_t *root = json_pack("{so s{so so so} so}", "environment", environment_read(),
                             "baseline_ns", "pingpong", json_histogram(&baseline->pingpong),
                             "same_size", json_histogram(&baseline->same_size), "solve",
                             json_histogram(&baseline->solve), "runs", list);
    int result = json_dumpf(root, out, JSON_INDENT(2) | JSON_REAL_PRECISION(17));
    fputc('\n', out);
    json_decref(root);
    return result;
}

/* Closes a file and says whether all of it was written. */
static int finish(FILE *file)
{
    int bad = ferror(file);
    return fclose(file) != 0 || bad ? -1 : 0;
}

int latency_write_csv(const latency_options *options, const latency_run *runs, int count)
{
    FILE *file = fopen(options->csv, "we");
    if (!file)
        return -1;
    fprintf(file, "via,index,at_ns");
    for (int k = 0; k < PART_COUNT; k++)
        fprintf(file, ",%s_ns", latency_parts[k]);
    fputc('\n', file);
    for (int i = 0; i < count; i++)
        for (uint64_t j = 0; j < runs[i].sample_count; j++) {
            const latency_sample *sample = &runs[i].samples[j];
            fprintf(file, "%s,%" PRIu64 ",%" PRIu64, daemon_via_name(runs[i].via), sample->index,
                    sample->at);
            for (int k = 0; k < PART_COUNT; k++)
                fprintf(file, ",%" PRIu64, sample->parts[k]);
            fputc('\n', file);
        }
    return finish(file);
}

int latency_write_histogram(const latency_options *options, const latency_run *runs, int count)
{
    for (int i = 0; i < count; i++) {
        char path[4096];
        snprintf(path, sizeof path, "%s%s%s", options->histogram, i ? "." : "",
                 i ? daemon_via_name(runs[i].via) : "");
        FILE *file = fopen(path, "we");
        if (!file)
            return -1;
        hgrm_write(&runs[i].parts[PART_ROUND_TRIP], file, 1000.0);
        if (finish(file) != 0)
            return -1;
    }
    return 0;
}
