/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The tables of the page.
 */
#include "parts.h"

#include "common/html_page.h"

#include <inttypes.h>
#include <stdlib.h>

static void begin_table(FILE *out, const char *title, const char *const *heads, size_t count)
{
    fprintf(out, "<h2>%s</h2>\n<div class=\"scroll\"><table>\n<thead><tr>", title);
    for (size_t i = 0; i < count; i++)
        fprintf(out, "<th scope=\"col\"%s>%s</th>", i ? " class=\"n\"" : "", heads[i]);
    fputs("</tr></thead>\n<tbody>\n", out);
}

static void end_table(FILE *out)
{
    fputs("</tbody></table></div>\n", out);
}

static void begin_line(FILE *out, const char *name)
{
    fputs("<tr><th scope=\"row\">", out);
    html_text(out, name);
    fputs("</th>", out);
}

static void write_us(FILE *out, int supported, double ns)
{
    if (supported)
        fprintf(out, "<td class=\"n\">%.3f</td>", ns / 1e3);
    else
        fputs("<td class=\"n\">-</td>", out);
}

static void write_times(FILE *out, const char *name, const tfa_histogram *h)
{
    if (h->count == 0)
        return;
    begin_line(out, name);
    write_us(out, 1, (double)h->lowest);
    for (int i = 0; i < QUANTILE_COUNT; i++) {
        const double quantile = latency_quantiles[i].quantile;
        write_us(out, tfa_histogram_supports(h, quantile),
                 (double)tfa_histogram_quantile(h, quantile));
    }
    write_us(out, 1, (double)h->highest);
    write_us(out, 1, tfa_histogram_mean(h));
    fprintf(out, "<td class=\"n\">%" PRIu64 "</td></tr>\n", h->count);
}

static void begin_times(FILE *out, const char *title)
{
    fprintf(out,
            "<h2>%s</h2>\n<div class=\"scroll\"><table>\n<thead><tr><th scope=\"col\">µs</th>"
            "<th scope=\"col\" class=\"n\">min</th>",
            title);
    for (int i = 0; i < QUANTILE_COUNT; i++)
        fprintf(out, "<th scope=\"col\" class=\"n\">p%s</th>", latency_quantiles[i].name);
    fputs("<th scope=\"col\" class=\"n\">max</th><th scope=\"col\" class=\"n\">mean</th>"
          "<th scope=\"col\" class=\"n\">of</th></tr></thead>\n<tbody>\n",
          out);
}

static void write_runs(latency_page *p)
{
    char name[80], line[128];
    begin_times(p->out, "Percentiles");
    for (int i = 0; i < p->session->count; i++) {
        const latency_run *run = &p->session->runs[i];
        latency_run_name(name, sizeof name, run);
        for (int k = 0; k < PART_COUNT; k++) {
            snprintf(line, sizeof line, "%s %s", name, latency_parts[k]);
            if (k != PART_CLIENT || run->options.open)
                write_times(p->out, line, &run->total->parts[k].h);
        }
    }
    end_table(p->out);
}

static void write_baseline(latency_page *p)
{
    const latency_baseline *b = p->session->baseline;
    begin_times(p->out, "The machine, without the daemon");
    write_times(p->out, "ping-pong", &b->pingpong.h);
    write_times(p->out, "ping-pong of the same size", &b->same_size.h);
    write_times(p->out, "solve in process", &b->solve.h);
    write_times(p->out, "timer wake-up", &b->timer.late.h);
    write_times(p->out, "gaps of a spinning thread", &b->gaps.gaps.h);
    end_table(p->out);
    fputs("<p>", p->out);
    if (b->gaps.elapsed_ns)
        fprintf(p->out, "A spinning thread missed %.2f %% of %.2f s. ", 100.0 * b->busy.gap_share,
                (double)b->gaps.elapsed_ns / 1e9);
    html_text(p->out, b->busy.busy ? b->busy.text : "The machine was quiet.");
    fputs("</p>\n", p->out);
}

static void write_clients(latency_page *p)
{
    char name[80], line[128];
    begin_times(p->out, "Clients");
    for (int i = 0; i < p->session->count; i++) {
        const latency_run *run = &p->session->runs[i];
        latency_run_name(name, sizeof name, run);
        for (uint32_t k = 0; k < run->client_count; k++) {
            snprintf(line, sizeof line, "%s, client %" PRIu32, name, k);
            write_times(p->out, line, &run->clients[k].figures->parts[PART_ROUND_TRIP].h);
        }
    }
    end_table(p->out);
}

static void write_counters(latency_page *p)
{
    static const char *const heads[] = {"run",
                                        "sent",
                                        "misses",
                                        "late",
                                        "lost",
                                        "rejected",
                                        "longest run",
                                        "no room",
                                        "twice",
                                        "reordered",
                                        "given up",
                                        "reconnects",
                                        "daemon, processors",
                                        "tool, processors"};
    char name[80];
    begin_table(p->out, "Requests", heads, sizeof heads / sizeof *heads);
    for (int i = 0; i < p->session->count; i++) {
        const latency_run *run = &p->session->runs[i];
        const tally *t = run->total;
        const uint64_t counts[] = {t->sent,      latency_misses(t), t->late,      t->lost,
                                   t->rejected,  t->longest_run,    t->full,      t->duplicates,
                                   t->reordered, t->stale,          t->reconnects};
        latency_run_name(name, sizeof name, run);
        begin_line(p->out, name);
        for (size_t k = 0; k < sizeof counts / sizeof *counts; k++)
            fprintf(p->out, "<td class=\"n\">%" PRIu64 "</td>", counts[k]);
        fprintf(p->out, "<td class=\"n\">%.2f</td><td class=\"n\">%.2f</td></tr>\n",
                run->daemon_cpu, run->tool_cpu);
    }
    end_table(p->out);
}

static void write_thread(FILE *out, const char *run, const char *process, const thread_usage *t)
{
    begin_line(out, run);
    fprintf(out, "<td>%s ", process);
    html_text(out, t->name);
    fprintf(out,
            "</td><td>%s %d</td><td class=\"n\">%" PRId64 "</td><td class=\"n\">%" PRId64
            "</td><td class=\"n\">%" PRId64 "</td><td class=\"n\">%" PRId64 "</td><td class=\"n\">",
            environment_policy(t->policy), t->priority, t->voluntary, t->involuntary,
            t->minor_faults, t->major_faults);
    if (t->allocations >= 0)
        fprintf(out, "%" PRId64, t->allocations);
    fputs("</td></tr>\n", out);
}

static void write_threads(latency_page *p)
{
    static const char *const heads[] = {"run",          "thread",      "policy",
                                        "voluntary",    "involuntary", "minor faults",
                                        "major faults", "allocations"};
    char name[80];
    begin_table(p->out, "Threads while measuring: context switches, page faults, allocations",
                heads, sizeof heads / sizeof *heads);
    for (int i = 0; i < p->session->count; i++) {
        const latency_run *run = &p->session->runs[i];
        latency_run_name(name, sizeof name, run);
        for (uint32_t k = 0; k < run->client_count; k++)
            write_thread(p->out, name, "client", &run->clients[k].usage);
        for (int k = 0; k < run->thread_count; k++)
            write_thread(p->out, name, "daemon", &run->threads[k]);
    }
    end_table(p->out);
}

static void write_environment(latency_page *p)
{
    json_t *value;
    const char *key;
    fputs("<h2>Environment</h2>\n<dl>\n", p->out);
    json_object_foreach(p->session->environment, key, value)
    {
        char *text = json_is_string(value) ? NULL : json_dumps(value, JSON_ENCODE_ANY);
        fputs("<dt>", p->out);
        html_text(p->out, key);
        fputs("</dt><dd>", p->out);
        html_text(p->out, json_is_null(value) ? "not told"
                          : text              ? text
                                              : json_string_value(value));
        fputs("</dd>\n", p->out);
        free(text);
    }
    fputs("</dl>\n", p->out);
}

void latency_page_tables(latency_page *p)
{
    write_runs(p);
    write_baseline(p);
    write_counters(p);
    write_clients(p);
    write_threads(p);
    write_environment(p);
}
