/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The pictures of the page.
 */
#include "parts.h"

#include "common/html_page.h"
#include "common/results.h"
#include "common/svg.h"

#include <inttypes.h>
#include <math.h>
#include <string.h>

/* User units */
#define WIDE 400.0
#define HIGH 260.0
#define LEFT 46.0
#define RIGHT (WIDE - 14.0)
#define TOP 16.0
#define BOTTOM (HIGH - 34.0)

static double us(uint64_t ns)
{
    return (double)ns / 1e3;
}

static void begin_panel(latency_page *p, const char *title, const char *label, double high)
{
    fputs("<figure class=\"panel\"><figcaption><b>", p->out);
    html_text(p->out, title);
    fputs("</b></figcaption>\n", p->out);
    svg_begin(p->out, WIDE, high, "curves", label);
}

static void end_panel(latency_page *p)
{
    fputs("</svg></figure>\n", p->out);
}

/* Begins a row of the numbers: run,figure */
static size_t begin_row(latency_page *p, const char *run, const char *figure)
{
    results_print_text(p->rows, run);
    fprintf(p->rows, ",%s,", figure);
    return p->count++;
}

/* A point with its numbers under the pointer */
static void write_point(latency_page *p, double x, double y, unsigned colour, size_t row,
                        const char *label)
{
    fprintf(p->out,
            "<g class=\"m k%u\" transform=\"translate(%.1f %.1f)\" data-r=\"%zu\" data-l=\"",
            colour, x, y, row);
    html_text(p->out, label);
    fputs("\"><path class=\"f\" d=\"M-1.6 0A1.6 1.6 0 1 1 1.6 0A1.6 1.6 0 1 1-1.6 0Z\"/></g>\n",
          p->out);
}

/* "90", "99.99": of 1 / (1 - percentile) */
static void format_percentile(char *text, size_t size, double value)
{
    const int nines = (int)lround(log10(value));
    snprintf(text, size, "%.*f%%", nines > 2 ? nines - 2 : 0, 100.0 * (1.0 - 1.0 / value));
}

enum { STEPS = 10 }; /* points of a decade of 1 / (1 - percentile) */

/* Percentiles up to the one that ten round trips exceed, then the slowest */
static double percentile_at(const tfa_histogram *h, int step, double *value)
{
    const double at = pow(10.0, (double)step / STEPS);
    if (step > 0 && at > (double)h->count)
        return 0.0;
    *value = us(tfa_histogram_quantile(h, 1.0 - 1.0 / at));
    return at;
}

static void write_percentiles(latency_page *p, const svg_axis *x, const svg_axis *y,
                              const tfa_histogram *h, const char *name, unsigned colour)
{
    double value, at;
    char text[32];
    fprintf(p->out, "<path class=\"curve k%u\" data-f=\"%zu\" d=\"", colour, p->count);
    for (int k = 0; (at = percentile_at(h, k, &value)) > 0.0; k++)
        fprintf(p->out, "%c%.1f %.1f", k ? 'L' : 'M', svg_at(x, at), svg_at(y, value));
    fputs("\"/>\n", p->out);
    for (int k = 0; (at = percentile_at(h, k, &value)) > 0.0; k++) {
        const size_t row = begin_row(p, name, "percentiles");
        snprintf(text, sizeof text, "%.8g", 100.0 * (1.0 - 1.0 / at));
        fprintf(p->rows, "%s,,,,,%.4g,\n", text, value);
        write_point(p, svg_at(x, at), svg_at(y, value), colour, row, name);
    }
    if (h->count)
        svg_text(p->out, LEFT + 6.0, svg_at(y, us(h->lowest)) - 7.0, "label", name);
}

static void extend(double *low, double *high, uint64_t *count, const tfa_histogram *h)
{
    if (h->count == 0)
        return;
    *low = fmin(*low, us(h->lowest));
    *high = fmax(*high, us(h->highest));
    *count = h->count > *count ? h->count : *count;
}

void latency_page_percentiles(latency_page *p)
{
    const latency_session *s = p->session;
    const tfa_histogram *pingpong = &s->baseline->pingpong.h;
    double low = INFINITY, high = 1e-3;
    uint64_t count = 10;
    char name[80];
    for (int i = 0; i < s->count; i++)
        extend(&low, &high, &count, &s->runs[i].total->parts[PART_ROUND_TRIP].h);
    extend(&low, &high, &count, pingpong);
    const svg_axis x = {
        .low = 1.0, .high = (double)count, .from = LEFT, .to = RIGHT, .logarithmic = 1};
    const svg_axis y = {.low = fmin(low, high) / 1.5,
                        .high = high * 1.5,
                        .from = BOTTOM,
                        .to = TOP,
                        .logarithmic = 1};
    begin_panel(p, "Round trip by percentile",
                "Round trip over 1 / (1 - percentile); the numbers are in the table below", HIGH);
    svg_axis_x(p->out, &x, TOP, BOTTOM, format_percentile);
    svg_axis_y(p->out, &y, LEFT, RIGHT, svg_microseconds);
    svg_text(p->out, RIGHT, HIGH - 6.0, "end", "share of round trips that were faster");
    if (pingpong->count)
        write_percentiles(p, &x, &y, pingpong, "ping-pong", 2);
    for (int i = 0; i < s->count; i++) {
        latency_run_name(name, sizeof name, &s->runs[i]);
        write_percentiles(p, &x, &y, &s->runs[i].total->parts[PART_ROUND_TRIP].h, name,
                          latency_run_colour(i));
    }
    end_panel(p);
}

enum { BINS = 60 };

#define SHOWN 0.999 /* slower ones would leave the others no room */

typedef struct bins {
    uint64_t counts[BINS], most, beyond;
    double low, width; /* logarithms of ns */
    int count;
} bins;

/* Bins of equal width in the logarithm, at least 2 % wide: a bucket of the histogram has 0.8 %. */
static bins fill_bins(const tfa_histogram *h)
{
    const double high = (double)tfa_histogram_quantile(h, SHOWN) + 1.0;
    bins b = {.low = log(fmax((double)h->lowest, 1.0)), .most = 1};
    b.count = (int)fmin(BINS, fmax(1.0, ceil((log(high) - b.low) / log(1.02))));
    b.width = (log(high) - b.low) / b.count;
    for (uint32_t k = 0; k < h->bucket_count; k++) {
        if (h->buckets[k] == 0)
            continue;
        const double top = fmin((double)tfa_histogram_top(h, k), (double)h->highest);
        const int bin = (int)((log(fmax(top, 1.0)) - b.low) / b.width);
        if (bin < b.count)
            b.counts[bin < 0 ? 0 : bin] += h->buckets[k];
        else
            b.beyond += h->buckets[k];
    }
    for (int k = 0; k < b.count; k++)
        b.most = b.counts[k] > b.most ? b.counts[k] : b.most;
    return b;
}

static void write_bins(latency_page *p, const bins *b, const svg_axis *x, const svg_axis *y,
                       const char *name, int run)
{
    for (int k = 0; k < b->count; k++) {
        const double from = exp(b->low + k * b->width) / 1e3,
                     to = exp(b->low + (k + 1) * b->width) / 1e3;
        if (b->counts[k] == 0)
            continue;
        const size_t row = begin_row(p, name, "histogram");
        fprintf(p->rows, ",,,%.4g,%.4g,,%" PRIu64 "\n", from, to, b->counts[k]);
        fprintf(p->out,
                "<rect class=\"area k%u\" x=\"%.1f\" y=\"%.1f\" width=\"%.2f\" height=\"%.1f\" "
                "data-r=\"%zu\"/>\n",
                latency_run_colour(run), svg_at(x, from), svg_at(y, (double)b->counts[k]),
                fmax(1.0, svg_at(x, to) - svg_at(x, from) - 0.6),
                BOTTOM - svg_at(y, (double)b->counts[k]), row);
    }
}

void latency_page_histogram(latency_page *p, int run)
{
    const tfa_histogram *h = &p->session->runs[run].total->parts[PART_ROUND_TRIP].h;
    char name[80], label[160], beyond[96], slowest[32];
    const bins b = fill_bins(h);
    latency_run_name(name, sizeof name, &p->session->runs[run]);
    const svg_axis x = {.low = exp(b.low) / 1e3,
                        .high = exp(b.low + b.count * b.width) / 1e3,
                        .from = LEFT,
                        .to = RIGHT,
                        .logarithmic = 1};
    const svg_axis y = {.low = 0.0, .high = 1.05 * (double)b.most, .from = BOTTOM, .to = TOP};
    snprintf(label, sizeof label, "%s: round trips by duration", name);
    svg_microseconds(slowest, sizeof slowest, us(h->highest));
    snprintf(beyond, sizeof beyond, "%" PRIu64 " slower ones, up to %s", b.beyond, slowest);
    begin_panel(p, label, label, HIGH);
    svg_axis_x(p->out, &x, TOP, BOTTOM, svg_microseconds);
    svg_axis_y(p->out, &y, LEFT, RIGHT, svg_number);
    write_bins(p, &b, &x, &y, name, run);
    svg_text(p->out, RIGHT, HIGH - 6.0, "end", "round trip");
    svg_text(p->out, RIGHT, TOP + 12.0, "end", beyond);
    svg_text(p->out, 0.0, 10.0, "tick", "round trips");
    end_panel(p);
}

#define BAR 16.0
#define BAR_GAP 9.0

/* Parts of one percentile as shares of their sum, from zero */
static void write_bar(latency_page *p, const char *run, int line, const char *percentile,
                      uint64_t count, const double parts[PART_COUNT])
{
    const double y = TOP + 8.0 + line * (BAR + BAR_GAP), whole = fmax(parts[PART_ROUND_TRIP], 1.0);
    double from = LEFT;
    char text[40];
    svg_text(p->out, LEFT - 5.0, y + 12.0, "end", percentile);
    for (int i = PART_CLIENT; i < PART_COUNT; i++) {
        const double wide = (RIGHT - 60.0 - LEFT) * parts[i] / whole;
        if (parts[i] <= 0.0)
            continue;
        const size_t row = begin_row(p, run, "parts");
        fprintf(p->rows, "%s,%s,,,,%.4g,%" PRIu64 "\n", percentile, latency_parts[i],
                parts[i] / 1e3, count);
        fprintf(p->out,
                "<rect class=\"area k%u\" x=\"%.1f\" y=\"%.1f\" width=\"%.1f\" height=\"%g\" "
                "data-r=\"%zu\" data-l=\"%s\"/>",
                latency_part_colour(i), from, y, wide, BAR, row, latency_parts[i]);
        from += wide;
    }
    svg_microseconds(text, sizeof text, parts[PART_ROUND_TRIP] / 1e3);
    svg_text(p->out, from + 5.0, y + 12.0, "tick", text);
    fputc('\n', p->out);
}

static void write_part_key(latency_page *p)
{
    fputs("<ul class=\"legend\">\n", p->out);
    for (int i = PART_CLIENT; i < PART_COUNT; i++)
        fprintf(
            p->out,
            "<li data-k=\"part\" data-v=\"%s\"><svg viewBox=\"-7 -7 14 14\" aria-hidden=\"true\">"
            "<rect class=\"area k%u\" x=\"-6\" y=\"-6\" width=\"12\" "
            "height=\"12\"/></svg>%s</li>\n",
            latency_parts[i], latency_part_colour(i), latency_parts[i]);
    fputs("</ul>\n", p->out);
}

void latency_page_breakdown(latency_page *p, int run)
{
    const tally *t = p->session->runs[run].total;
    const tfa_histogram *trip = &t->parts[PART_ROUND_TRIP].h;
    double means[PART_COUNT];
    char name[80], label[160], percentile[16];
    int line = 0, lines = 1;
    for (int i = 0; i < QUANTILE_COUNT; i++)
        lines += tfa_histogram_supports(trip, latency_quantiles[i].quantile);
    latency_run_name(name, sizeof name, &p->session->runs[run]);
    snprintf(label, sizeof label, "%s: parts of a round trip", name);
    begin_panel(p, label, label, TOP + lines * (BAR + BAR_GAP));
    for (int i = 0; i < QUANTILE_COUNT; i++) {
        if (!tfa_histogram_supports(trip, latency_quantiles[i].quantile))
            continue;
        const uint64_t value = tfa_histogram_quantile(trip, latency_quantiles[i].quantile);
        const uint64_t count = breakdown_at(t->breakdown, value, means);
        snprintf(percentile, sizeof percentile, "p%s", latency_quantiles[i].name);
        if (count)
            write_bar(p, name, line++, percentile, count, means);
    }
    for (int i = 0; i < PART_COUNT; i++)
        means[i] = (double)t->slowest.parts[i];
    if (trip->count)
        write_bar(p, name, line, "slowest", 1, means);
    fputs("</svg>\n", p->out);
    write_part_key(p);
    fputs("</figure>\n", p->out);
}

/* One line of the tenths: a percentile, or 1: the slowest */
static void write_slices(latency_page *p, const svg_axis *x, const svg_axis *y, int run,
                         double quantile, const char *label, unsigned colour)
{
    const tally *t = p->session->runs[run].total;
    const double tenth = (double)t->elapsed_ns / 1e9 / TALLY_SLICES;
    char name[80];
    const char *before = "M";
    latency_run_name(name, sizeof name, &p->session->runs[run]);
    fprintf(p->out, "<path class=\"curve k%u\" d=\"", colour);
    for (int k = 0; k < TALLY_SLICES; k++) {
        const tfa_histogram *h = &t->slices[k].h;
        if (h->count == 0)
            continue;
        fprintf(p->out, "%s%.1f %.1f", before, svg_at(x, (k + 0.5) * tenth),
                svg_at(y, us(tfa_histogram_quantile(h, quantile))));
        before = "L";
    }
    fputs("\"/>\n", p->out);
    for (int k = 0; k < TALLY_SLICES; k++) {
        const tfa_histogram *h = &t->slices[k].h;
        if (h->count == 0)
            continue;
        const double value = us(tfa_histogram_quantile(h, quantile));
        const size_t row = begin_row(p, name, "time");
        fprintf(p->rows, "%s,,%.4g,,,%.4g,%" PRIu64 "\n", label, (k + 0.5) * tenth, value,
                h->count);
        write_point(p, svg_at(x, (k + 0.5) * tenth), svg_at(y, value), colour, row, label);
        if (k == 0)
            svg_text(p->out, svg_at(x, 0.5 * tenth), svg_at(y, value) - 7.0, "label", label);
    }
}

void latency_page_slices(latency_page *p, int run)
{
    const tally *t = p->session->runs[run].total;
    const tfa_histogram *trip = &t->parts[PART_ROUND_TRIP].h;
    char name[80], label[160];
    latency_run_name(name, sizeof name, &p->session->runs[run]);
    snprintf(label, sizeof label, "%s: over the run", name);
    const svg_axis x = {.high = (double)t->elapsed_ns / 1e9, .from = LEFT, .to = RIGHT};
    const svg_axis y = {.low = us(trip->lowest) / 1.5,
                        .high = us(trip->highest) * 1.5,
                        .from = BOTTOM,
                        .to = TOP,
                        .logarithmic = 1};
    begin_panel(p, label, label, HIGH);
    svg_axis_x(p->out, &x, TOP, BOTTOM, svg_number);
    svg_axis_y(p->out, &y, LEFT, RIGHT, svg_microseconds);
    write_slices(p, &x, &y, run, 0.5, "p50", 3);
    write_slices(p, &x, &y, run, 0.99, "p99", 5);
    write_slices(p, &x, &y, run, 1.0, "slowest", 11);
    svg_text(p->out, RIGHT, HIGH - 6.0, "end", "seconds after the start");
    end_panel(p);
}
