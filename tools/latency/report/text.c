/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The report for people: tables.
 */
#include "report.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

/* One line of the table, in us, under the head of `columns`: a quantile that has too few samples
 * of its own is left open. */
static void print_row(FILE *out, const char *name, const tfa_histogram *h,
                      const tfa_histogram *columns)
{
    if (h->count == 0)
        return;
    fprintf(out, "  %-12s %9.3f", name, (double)h->lowest / 1000.0);
    for (int i = 0; i < QUANTILE_COUNT; i++) {
        double quantile = latency_quantiles[i].quantile;
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
        if (tfa_histogram_supports(h, latency_quantiles[i].quantile))
            fprintf(out, "   p%-6s", latency_quantiles[i].name);
    fprintf(out, " %9s %9s\n", "max", "mean");
}

static void print_thread(FILE *out, const char *process, const thread_usage *t)
{
    fprintf(out,
            "  %-12s %-16s %s %d, context switches %" PRId64 " voluntary %" PRId64
            " involuntary, page faults %" PRId64 " minor %" PRId64 " major",
            process, t->name, environment_policy(t->policy), t->priority, t->voluntary,
            t->involuntary, t->minor_faults, t->major_faults);
    if (t->allocations >= 0)
        fprintf(out, ", allocations %" PRId64, t->allocations);
    if (t->cpu_ns >= 0)
        fprintf(out, ", processor time %.3f s", (double)t->cpu_ns / 1e9);
    fputc('\n', out);
}

static void print_breakdown_row(FILE *out, const char *name, uint64_t count,
                                const double parts[PART_COUNT])
{
    fprintf(out, "  %-12s", name);
    for (int i = 0; i < PART_COUNT; i++)
        fprintf(out, " %10.3f", parts[i] / 1000.0);
    fprintf(out, " %9" PRIu64 "\n", count);
}

/* Parts of the round trips about each percentile, and of the slowest itself. */
static void print_breakdown(FILE *out, const tally *t)
{
    const tfa_histogram *trip = &t->parts[PART_ROUND_TRIP].h;
    double means[PART_COUNT];
    char name[16];
    if (trip->count == 0)
        return;
    fputs("  parts of the round trips within 3 % of a percentile, means\n", out);
    fprintf(out, "  %-12s", "us");
    for (int i = 0; i < PART_COUNT; i++)
        fprintf(out, " %10s", latency_parts[i]);
    fprintf(out, " %9s\n", "of");
    for (int i = 0; i < QUANTILE_COUNT; i++) {
        if (!tfa_histogram_supports(trip, latency_quantiles[i].quantile))
            continue;
        const uint64_t value = tfa_histogram_quantile(trip, latency_quantiles[i].quantile);
        const uint64_t count = breakdown_at(t->breakdown, value, means);
        snprintf(name, sizeof name, "p%s", latency_quantiles[i].name);
        if (count)
            print_breakdown_row(out, name, count, means);
    }
    for (int i = 0; i < PART_COUNT; i++)
        means[i] = (double)t->slowest.parts[i];
    print_breakdown_row(out, "slowest", 1, means);
}

static void print_counters(FILE *out, const tally *t)
{
    fprintf(out,
            "  the slowest was number %" PRIu64 ", %.6f s after the start; the fastest number "
            "%" PRIu64 ", %.6f s\n",
            t->slowest.index, (double)t->slowest.at / 1e9, t->fastest.index,
            (double)t->fastest.at / 1e9);
    fprintf(out,
            "  misses %" PRIu64 ", late %" PRIu64 ", longest run of them %" PRIu64 "; lost %" PRIu64
            ", rejected %" PRIu64 ", duplicates %" PRIu64 ", reordered %" PRIu64
            ", after they were given up %" PRIu64 ", reconnects %" PRIu64 "\n",
            latency_misses(t), t->late, t->longest_run, t->lost, t->rejected, t->duplicates,
            t->reordered, t->stale, t->reconnects);
    for (int i = 0; i < TALLY_STATUSES && t->statuses[i].count; i++)
        fprintf(out, "  rejected with %s: %" PRIu64 "\n", tfa_status_text(t->statuses[i].status),
                t->statuses[i].count);
    if (t->full)
        fprintf(out, "  without room in the ring when due: %" PRIu64 " of %" PRIu64 "\n", t->full,
                t->sent);
}

static void print_subject(FILE *out, const latency_run *run)
{
    const tfa_client_info *info = &run->facts.info;
    const latency_options *o = &run->options;
    char load[256];
    fprintf(out,
            "\n%s: robot %s, %" PRIu32 " coordinates, %" PRIu32 " freedoms%s, batch %" PRIu32
            ", forward dynamics by %s, estimate %s, wait %s, model %.12s\n",
            latency_via_names[run->via], o->daemon.robot, info->q_count, info->v_count,
            info->base_freedoms ? " and a floating base" : "", o->batch,
            run->total->method ? tfa_method_name(run->total->method) : "nothing",
            tfa_word(TFA_WORDS_ESTIMATE, o->estimate), tfa_word(TFA_WORDS_WAIT, info->wait),
            run->facts.hash);
    latency_describe_load(o, load, sizeof load);
    fprintf(out,
            "  %s: %" PRIu64 " round trips after %" PRIu64 " of warm-up%s, %.3f s, a new state at "
            "every call\n",
            load, run->total->parts[PART_ROUND_TRIP].h.count, o->warmup,
            o->clients > 1 ? " each" : "", (double)run->total->elapsed_ns / 1e9);
    if (run->ended_early)
        fprintf(out, "  ended early: %s\n", run->ended_early);
}

static void print_clients(FILE *out, const latency_run *run)
{
    const tfa_histogram *columns = &run->clients[0].figures->parts[PART_ROUND_TRIP].h;
    char name[24];
    if (run->client_count < 2)
        return;
    print_head(out, "clients, us", columns);
    for (uint32_t k = 0; k < run->client_count; k++) {
        snprintf(name, sizeof name, "client %" PRIu32, k);
        print_row(out, name, &run->clients[k].figures->parts[PART_ROUND_TRIP].h, columns);
    }
}

static void print_processors(FILE *out, double busy)
{
    if (busy < 0)
        fputs("unknown", out);
    else
        fprintf(out, "%.2f", busy);
}

static void print_usage(FILE *out, const latency_run *run)
{
    for (uint32_t k = 0; k < run->client_count; k++)
        print_thread(out, "client", &run->clients[k].usage);
    for (int i = 0; i < run->thread_count; i++)
        print_thread(out, "daemon", &run->threads[i]);
    fputs("  processors kept busy: daemon ", out);
    print_processors(out, run->daemon_cpu);
    fprintf(out, ", this program %.2f; the host stole %.2f %%\n", run->tool_cpu,
            100 * run->busy.steal);
    if (run->busy.busy)
        fprintf(out, "  busy: %s\n", run->busy.text);
}

static void print_run(FILE *out, const latency_run *run, const latency_baseline *baseline)
{
    const tally *t = run->total;
    const tfa_histogram *trip = &t->parts[PART_ROUND_TRIP].h;
    print_subject(out, run);
    print_head(out, "us", trip);
    for (int i = 0; i < PART_COUNT; i++)
        if (i != PART_CLIENT || run->options.open)
            print_row(out, latency_parts[i], &t->parts[i].h, trip);
    print_breakdown(out, t);
    print_clients(out, run);
    print_counters(out, t);
    if (run->options.batch > 1)
        fprintf(out, "  p50 per state %.3f us\n",
                (double)tfa_histogram_quantile(trip, 0.5) / 1000.0 / run->options.batch);
    print_usage(out, run);
    if (baseline->have_pingpong)
        fprintf(out, "  p50 is %.2f x (ping-pong + solve %s)\n", latency_ratio(run, baseline),
                baseline->solve.h.count ? "in process" : "by the daemon's stamps");
    if (baseline->same_size.h.count)
        fprintf(out, "  p50 is %.2f x (ping-pong of the same %u + %u cache lines + solve)\n",
                latency_ratio_same_size(run, baseline), baseline->size.request_lines,
                baseline->size.reply_lines);
}

static void print_environment(FILE *out, const json_t *facts)
{
    json_t *value;
    const char *name;
    fprintf(out, "environment\n");
    json_object_foreach((json_t *)(uintptr_t)facts, name, value)
    {
        char *text = json_is_string(value) ? NULL : json_dumps(value, JSON_ENCODE_ANY);
        const char *shown = json_is_string(value) ? json_string_value(value) : text;
        fprintf(out, "  %-20s %s\n", name, json_is_null(value) ? "not told" : shown);
        free(text);
    }
}

static void print_machine(FILE *out, const latency_baseline *baseline)
{
    const machine_gaps *gaps = &baseline->gaps;
    if (gaps->elapsed_ns)
        fprintf(out,
                "  a spinning thread missed %.2f %% of %.2f s in %" PRIu64 " gaps above %d us, the "
                "longest %.0f us; load %.1f\n",
                100 * baseline->busy.gap_share, (double)gaps->elapsed_ns / 1e9, gaps->gaps.h.count,
                MACHINE_GAP_NS / 1000, (double)gaps->gaps.h.highest / 1e3, baseline->busy.load);
    if (baseline->busy.busy)
        fprintf(out, "  busy: %s\n", baseline->busy.text);
}

/* A line a run. */
static void print_sweep(FILE *out, const latency_session *session)
{
    const tfa_histogram *columns = &session->runs[0].total->parts[PART_ROUND_TRIP].h;
    char name[64], load[256];
    latency_describe_load(&session->runs[0].options, load, sizeof load);
    fprintf(out, "\nsweep of %s, %s loop; the first: %s\n", session->runs[0].options.sweep,
            latency_loop_name(&session->runs[0].options), load);
    print_head(out, "us", columns);
    for (int i = 0; i < session->count; i++) {
        const latency_run *run = &session->runs[i];
        snprintf(name, sizeof name, "%s %s", latency_via_names[run->via], run->swept);
        print_row(out, name, &run->total->parts[PART_ROUND_TRIP].h, columns);
    }
    for (int i = 0; i < session->count; i++) {
        const latency_run *run = &session->runs[i];
        const tally *t = run->total;
        fprintf(out,
                "  %s %s: %" PRIu64 " sent, misses %" PRIu64 ", late %" PRIu64
                ", longest run %" PRIu64 ", without room %" PRIu64 "; processors: daemon ",
                latency_via_names[run->via], run->swept, t->sent, latency_misses(t), t->late,
                t->longest_run, t->full);
        print_processors(out, run->daemon_cpu);
        fprintf(out, ", this program %.2f%s%s\n", run->tool_cpu, run->busy.busy ? "; busy: " : "",
                run->busy.text);
    }
}

void latency_print_text(FILE *out, const latency_session *session)
{
    const latency_baseline *baseline = session->baseline;
    print_environment(out, session->environment);
    fprintf(out, "\nbaseline of this run\n");
    const tfa_histogram *columns =
        baseline->pingpong.h.count ? &baseline->pingpong.h : &baseline->solve.h;
    print_head(out, "us", columns);
    print_row(out, "ping-pong", &baseline->pingpong.h, columns);
    if (baseline->same_size.h.count)
        print_row(out, "same size", &baseline->same_size.h, columns);
    print_row(out, "solve", &baseline->solve.h, columns);
    print_row(out, "timer", &baseline->timer.late.h, columns);
    print_machine(out, baseline);
    if (session->runs[0].swept) {
        print_sweep(out, session);
        return;
    }
    for (int i = 0; i < session->count; i++)
        print_run(out, &session->runs[i], baseline);
}

void latency_print_cyclictest(FILE *out, const latency_session *session)
{
    int number = 0;
    for (int i = 0; i < session->count; i++) {
        const latency_run *run = &session->runs[i];
        const double interval = run->options.rate > 0 ? 1e6 / run->options.rate : 0;
        fprintf(out, "# %s, ", latency_via_names[run->via]);
        if (run->swept)
            fprintf(out, "%s=%s, ", run->options.sweep, run->swept);
        fprintf(out, "%s loop, round trips in ns\n", latency_loop_name(&run->options));
        for (uint32_t k = 0; k < run->client_count; k++) {
            const tfa_histogram *h = &run->clients[k].figures->parts[PART_ROUND_TRIP].h;
            const thread_usage *usage = &run->clients[k].usage;
            fprintf(out,
                    "T:%2d (%5d) P:%2d I:%.0f C:%7" PRIu64 " Min:%7" PRIu64 " Act:%5" PRIu64
                    " Avg:%5.0f Max:%8" PRIu64 "\n",
                    number++, (int)usage->tid, usage->priority, interval, h->count, h->lowest,
                    run->clients[k].figures->last, tfa_histogram_mean(h), h->highest);
        }
    }
}
