/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The page of latencies.
 */
#include "page.h"

#include "common/html_page.h"
#include "common/svg.h"
#include "parts.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

void latency_run_name(char *text, size_t size, const latency_run *run)
{
    snprintf(text, size, "%s%s%s", latency_via_names[run->via], run->swept ? " " : "",
             run->swept ? run->swept : "");
}

unsigned latency_run_colour(int run)
{
    static const unsigned colours[] = {3, 6, 9, 8, 5, 11, 4, 7};
    return colours[(size_t)run % (sizeof colours / sizeof *colours)];
}

unsigned latency_part_colour(int part)
{
    static const unsigned colours[PART_COUNT] = {[PART_CLIENT] = 11,
                                                 [PART_REQUEST] = 4,
                                                 [PART_QUEUE] = 5,
                                                 [PART_COMPUTE] = 9,
                                                 [PART_REPLY] = 8};
    return colours[part];
}

/* "arm over shm: p50 0.9 µs, p99.9 2.1 µs, slowest 40 µs of 100000 round trips" */
static void write_title(char *text, size_t size, const latency_session *s)
{
    const latency_run *run = &s->runs[0];
    const tfa_histogram *h = &run->total->parts[PART_ROUND_TRIP].h;
    const double tail = tfa_histogram_supports(h, 0.999)  ? 0.999
                        : tfa_histogram_supports(h, 0.99) ? 0.99
                                                          : 0.9;
    char name[80], half[32], high[32], slowest[32];
    latency_run_name(name, sizeof name, run);
    svg_microseconds(half, sizeof half, (double)tfa_histogram_quantile(h, 0.5) / 1e3);
    svg_microseconds(high, sizeof high, (double)tfa_histogram_quantile(h, tail) / 1e3);
    svg_microseconds(slowest, sizeof slowest, (double)h->highest / 1e3);
    snprintf(text, size,
             "%s over %s: half of %" PRIu64 " round trips within %s, %g %% within %s, all within "
             "%s%s%s%s",
             run->options.daemon.robot, name, h->count, half, 100.0 * tail, high, slowest,
             run->busy.busy || s->baseline->busy.busy ? "; the machine was busy" : "",
             run->ended_early ? "; ended early: " : "", run->ended_early ? run->ended_early : "");
}

static void write_lead(char *text, size_t size, const latency_session *s)
{
    char load[256];
    const latency_run *run = &s->runs[0];
    const char *why = run->busy.busy ? run->busy.text : s->baseline->busy.text;
    latency_describe_load(&run->options, load, sizeof load);
    snprintf(
        text, size,
        "Forward dynamics of %" PRIu32 " freedoms by %s, batch %" PRIu32 ", %s. Ping-pong: the "
        "same exchange between two processes without a solve. %s%s",
        run->facts.info.v_count,
        run->total->method ? tfa_method_name(run->total->method) : "nothing", run->options.batch,
        load, why[0] ? "Busy: " : "No sign that other work took time from the run.", why);
}

/* Origin, for the footer, before the rows of the pictures */
static void write_origin(FILE *rows, const latency_session *s)
{
    static const char *const facts[] = {"processor", "client_kernels", "version"};
    fprintf(rows, "# command: %s\n# date: %s\n", s->command, s->date);
    for (size_t i = 0; i < sizeof facts / sizeof *facts; i++) {
        const char *text = json_string_value(json_object_get(s->environment, facts[i]));
        if (text)
            fprintf(rows, "# %s: %s\n", facts[i], text);
    }
    fputs("# percentiles: share of round trips that were not slower; the last are single round "
          "trips\n"
          "# parts: means of the round trips within 3 % of a percentile; they add up to the round "
          "trip\n"
          "# time: each tenth of the run by itself\n"
          "run,figure,percentile,part,seconds,from_us,to_us,us,count\n",
          rows);
}

static void write_pictures(latency_page *p)
{
    fputs("<div class=\"panels\">\n", p->out);
    latency_page_percentiles(p);
    for (int i = 0; i < p->session->count; i++) {
        if (p->session->runs[i].total->parts[PART_ROUND_TRIP].h.count == 0)
            continue;
        latency_page_breakdown(p, i);
        latency_page_histogram(p, i);
        latency_page_slices(p, i);
    }
    fputs("</div>\n", p->out);
    latency_page_tables(p);
}

/* Pictures and rows are written side by side: the page begins with the one and ends with the
 * other. */
static int write_page(FILE *out, const latency_session *session)
{
    char title[512], lead[768], *rows = NULL;
    size_t size = 0;
    latency_page page = {.out = out, .session = session, .rows = open_memstream(&rows, &size)};
    if (!page.rows)
        return -1;
    write_title(title, sizeof title, session);
    write_lead(lead, sizeof lead, session);
    html_begin(out, &(html_page){.title = title,
                                 .lead = lead,
                                 .filters = "run",
                                 .tip = "percentile part seconds from_us to_us us count"});
    fputs("<div id=\"filters\"></div>\n", out);
    write_origin(page.rows, session);
    write_pictures(&page);
    const int closed = fclose(page.rows);
    if (closed == 0)
        html_end(out, rows);
    free(rows);
    return closed;
}

int latency_write_page(const char *path, const latency_session *session)
{
    FILE *out = fopen(path, "we");
    if (!out)
        return -1;
    const int bad = write_page(out, session) != 0 || ferror(out);
    return fclose(out) != 0 || bad ? -1 : 0;
}
