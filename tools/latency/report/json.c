/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The report as JSON, alone and with its histograms for `totalforce plot`.
 */
#include "report.h"

#include <jansson.h>

static json_t *json_histogram(const tfa_histogram *h)
{
    if (h->count == 0)
        return json_null();
    json_t *percentiles = json_object();
    for (int i = 0; i < QUANTILE_COUNT; i++)
        if (tfa_histogram_supports(h, latency_quantiles[i].quantile))
            json_object_set_new(
                percentiles, latency_quantiles[i].name,
                json_integer((json_int_t)tfa_histogram_quantile(h, latency_quantiles[i].quantile)));
    return json_pack("{sI sI sI sf so}", "count", (json_int_t)h->count, "min",
                     (json_int_t)h->lowest, "max", (json_int_t)h->highest, "mean",
                     tfa_histogram_mean(h), "percentiles", percentiles);
}

static json_t *json_thread(const char *process, const thread_usage *t)
{
    return json_pack("{ss ss si ss si sI sI sI sI sI sI}", "process", process, "name", t->name,
                     "tid", (int)t->tid, "policy", environment_policy(t->policy), "priority",
                     t->priority, "voluntary_switches", (json_int_t)t->voluntary,
                     "involuntary_switches", (json_int_t)t->involuntary, "minor_faults",
                     (json_int_t)t->minor_faults, "major_faults", (json_int_t)t->major_faults,
                     "cpu_ns", (json_int_t)t->cpu_ns, "allocations", (json_int_t)t->allocations);
}

static json_t *json_parts(uint64_t count, const double parts[PART_COUNT])
{
    json_t *json = json_pack("{sI}", "count", (json_int_t)count);
    for (int i = 0; i < PART_COUNT; i++)
        json_object_set_new(json, latency_parts[i], json_real(parts[i]));
    return json;
}

static json_t *json_breakdown(const tally *t)
{
    const tfa_histogram *trip = &t->parts[PART_ROUND_TRIP].h;
    json_t *json = json_object();
    double means[PART_COUNT];
    for (int i = 0; i < QUANTILE_COUNT && trip->count; i++) {
        if (!tfa_histogram_supports(trip, latency_quantiles[i].quantile))
            continue;
        const uint64_t value = tfa_histogram_quantile(trip, latency_quantiles[i].quantile);
        const uint64_t count = breakdown_at(t->breakdown, value, means);
        if (count)
            json_object_set_new(json, latency_quantiles[i].name, json_parts(count, means));
    }
    for (int i = 0; i < PART_COUNT; i++)
        means[i] = (double)t->slowest.parts[i];
    if (trip->count)
        json_object_set_new(json, "max", json_parts(1, means));
    return json;
}

static json_t *json_counters(const tally *t)
{
    json_t *statuses = json_object();
    for (int i = 0; i < TALLY_STATUSES && t->statuses[i].count; i++)
        json_object_set_new(statuses, tfa_status_text(t->statuses[i].status),
                            json_integer((json_int_t)t->statuses[i].count));
    return json_pack(
        "{sI sI sI sI sI so sI sI sI sI sI sI sI sI sI sI}", "sent", (json_int_t)t->sent, "misses",
        (json_int_t)latency_misses(t), "late", (json_int_t)t->late, "lost", (json_int_t)t->lost,
        "rejected", (json_int_t)t->rejected, "rejected_by", statuses, "longest_run",
        (json_int_t)t->longest_run, "full", (json_int_t)t->full, "duplicates",
        (json_int_t)t->duplicates, "reordered", (json_int_t)t->reordered, "stale",
        (json_int_t)t->stale, "reconnects", (json_int_t)t->reconnects, "max_index",
        (json_int_t)t->slowest.index, "max_at_ns", (json_int_t)t->slowest.at, "min_index",
        (json_int_t)t->fastest.index, "min_at_ns", (json_int_t)t->fastest.at);
}

static json_t *json_busy(const machine_busy *busy)
{
    return json_pack("{sb sf sf sf si ss}", "busy", busy->busy, "gap_share", busy->gap_share,
                     "steal", busy->steal, "load", busy->load, "processors", busy->processors,
                     "reason", busy->text);
}

static json_t *json_load(const latency_run *run)
{
    const latency_options *o = &run->options;
    return json_pack("{ss ss sf sf sf si si si si sI sf}", "via", latency_via_names[run->via],
                     "loop", latency_loop_name(o), "rate", o->rate, "think_us", o->think_us,
                     "jitter_us", o->jitter_us, "burst", (int)o->burst, "clients", (int)o->clients,
                     "compute_load", (int)o->compute_load, "memory_load", (int)o->memory_load,
                     "warmup", (json_int_t)o->warmup, "seconds",
                     (double)run->total->elapsed_ns / 1e9);
}

static json_t *json_subject(const latency_run *run)
{
    const tfa_client_info *info = &run->facts.info;
    const latency_options *o = &run->options;
    return json_pack(
        "{ss si si si ss ss ss ss si si}", "robot", o->daemon.robot, "q_count", (int)info->q_count,
        "v_count", (int)info->v_count, "base_freedoms", (int)info->base_freedoms, "model_hash",
        run->facts.hash, "method", run->total->method ? tfa_method_name(run->total->method) : "",
        "estimate", tfa_word(TFA_WORDS_ESTIMATE, o->estimate), "wait",
        tfa_word(TFA_WORDS_WAIT, info->wait), "batch", (int)o->batch, "slots", (int)info->slots);
}

static json_t *json_clients(const latency_run *run)
{
    json_t *list = json_array();
    for (uint32_t k = 0; k < run->client_count; k++) {
        const latency_client *client = &run->clients[k];
        json_t *json = json_counters(client->figures);
        json_object_set_new(json, "round_trip_ns",
                            json_histogram(&client->figures->parts[PART_ROUND_TRIP].h));
        json_array_append_new(list, json);
    }
    return list;
}

static json_t *json_text_or_null(const char *text)
{
    return text ? json_string(text) : json_null();
}

static json_t *json_run(const latency_run *run, const latency_baseline *baseline)
{
    json_t *threads = json_array(), *parts = json_object();
    for (uint32_t k = 0; k < run->client_count; k++)
        json_array_append_new(threads, json_thread("client", &run->clients[k].usage));
    for (int i = 0; i < run->thread_count; i++)
        json_array_append_new(threads, json_thread("daemon", &run->threads[i]));
    for (int i = 0; i < PART_COUNT; i++)
        json_object_set_new(parts, latency_parts[i], json_histogram(&run->total->parts[i].h));
    json_t *json = json_load(run);
    json_object_update_new(json, json_subject(run));
    json_object_update_new(json, json_counters(run->total));
    if (run->swept)
        json_object_set_new(json, "swept", json_string(run->swept));
    json_object_set_new(json, "ended_early", json_text_or_null(run->ended_early));
    json_object_update_new(
        json, json_pack("{so so so so sf sf so sf sf sb}", "ns", parts, "breakdown_ns",
                        json_breakdown(run->total), "per_client", json_clients(run), "threads",
                        threads, "daemon_cpu", run->daemon_cpu, "tool_cpu", run->tool_cpu, "busy",
                        json_busy(&run->busy), "ratio", latency_ratio(run, baseline),
                        "ratio_same_size", latency_ratio_same_size(run, baseline), "expected",
                        latency_expected(run, baseline)));
    return json;
}

static json_t *json_baseline(const latency_baseline *baseline)
{
    return json_pack("{so so so so so}", "pingpong", json_histogram(&baseline->pingpong.h),
                     "same_size", json_histogram(&baseline->same_size.h), "solve",
                     json_histogram(&baseline->solve.h), "timer",
                     json_histogram(&baseline->timer.late.h), "gaps",
                     json_histogram(&baseline->gaps.gaps.h));
}

static json_t *json_session(const latency_session *session)
{
    json_t *list = json_array();
    for (int i = 0; i < session->count; i++)
        json_array_append_new(list, json_run(&session->runs[i], session->baseline));
    return json_pack("{sO ss ss so so so}", "environment", session->environment, "date",
                     session->date, "command", session->command, "busy",
                     json_busy(&session->baseline->busy), "baseline_ns",
                     json_baseline(session->baseline), "runs", list);
}

int latency_print_json(FILE *out, const latency_session *session)
{
    json_t *root = json_session(session);
    int result = json_dumpf(root, out, JSON_INDENT(2) | JSON_REAL_PRECISION(17));
    fputc('\n', out);
    json_decref(root);
    return result;
}

/* Full buckets as pairs of number and count. */
static json_t *json_buckets(const tfa_histogram *h)
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

static json_t *json_histograms(const latency_run *run)
{
    char load[256];
    json_t *slices = json_array();
    for (int i = 0; i < TALLY_SLICES; i++)
        json_array_append_new(slices, json_buckets(&run->total->slices[i].h));
    latency_describe_load(&run->options, load, sizeof load);
    return json_pack("{ss ss so so}", "load", load, "model", run->facts.hash, "round_trip",
                     json_buckets(&run->total->parts[PART_ROUND_TRIP].h), "slices", slices);
}

int latency_save(const char *path, const latency_session *session)
{
    json_t *root = json_session(session), *runs = json_object_get(root, "runs");
    json_object_update_new(root, json_pack("{ss si so}", "format", "totalforce latency 2", "bits",
                                           LATENCY_BITS, "pingpong",
                                           json_buckets(&session->baseline->pingpong.h)));
    for (int i = 0; i < session->count; i++)
        json_object_update_new(json_array_get(runs, (size_t)i), json_histograms(&session->runs[i]));
    const int result = json_dump_file(root, path, JSON_COMPACT);
    json_decref(root);
    return result;
}
