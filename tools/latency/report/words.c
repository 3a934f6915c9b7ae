/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Names and figures that all reports share.
 */
#include "report.h"

#include <inttypes.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

const struct latency_quantile latency_quantiles[QUANTILE_COUNT] = {
    {0.5, "50"},       {0.9, "90"},         {0.99, "99"},          {0.999, "99.9"},
    {0.9999, "99.99"}, {0.99999, "99.999"}, {0.999999, "99.9999"},
};

const char *latency_loop_name(const latency_options *options)
{
    return options->open ? "open" : "closed";
}

/* Appends to a text that has `used` of `size` bytes. */
__attribute__((format(printf, 3, 4))) static void append(char *text, size_t size,
                                                         const char *format, ...)
{
    const size_t used = strlen(text);
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text + used, size - used, format, arguments);
    va_end(arguments);
}

void latency_describe_load(const latency_options *o, char *text, size_t size)
{
    snprintf(text, size, "%s loop", latency_loop_name(o));
    if (o->rate > 0)
        append(text, size, ", %g a second%s", o->rate,
               o->open ? ", from the intended times" : ", from the time of sending");
    if (o->think_us > 0)
        append(text, size, ", pauses of %g us", o->think_us);
    if (o->jitter_us > 0)
        append(text, size, ", jitter 0 to %g us", o->jitter_us);
    if (o->burst > 1)
        append(text, size, ", bursts of %" PRIu32, o->burst);
    if (o->clients > 1)
        append(text, size, ", %" PRIu32 " clients%s", o->clients,
               o->open ? " spread over the period" : "");
    if (o->compute_load)
        append(text, size, ", %" PRIu32 " threads that compute", o->compute_load);
    if (o->memory_load)
        append(text, size, ", %" PRIu32 " threads that write memory", o->memory_load);
}

uint64_t latency_misses(const tally *t)
{
    return t->lost + t->rejected;
}

/* p50 of the compute part: in process when that was measured, else by the daemon's stamps. */
static double solve_p50(const latency_run *run, const latency_baseline *baseline)
{
    const tfa_histogram *h =
        baseline->solve.h.count ? &baseline->solve.h : &run->total->parts[PART_COMPUTE].h;
    return (double)tfa_histogram_quantile(h, 0.5);
}

static double ratio_to(const tfa_histogram *pingpong, const latency_run *run,
                       const latency_baseline *baseline)
{
    if (pingpong->count == 0)
        return 0.0;
    double floor = (double)tfa_histogram_quantile(pingpong, 0.5) + solve_p50(run, baseline);
    double p50 = (double)tfa_histogram_quantile(&run->total->parts[PART_ROUND_TRIP].h, 0.5);
    return floor > 0 ? p50 / floor : 0.0;
}

double latency_ratio(const latency_run *run, const latency_baseline *baseline)
{
    return baseline->have_pingpong ? ratio_to(&baseline->pingpong.h, run, baseline) : 0.0;
}

double latency_ratio_same_size(const latency_run *run, const latency_baseline *baseline)
{
    return ratio_to(&baseline->same_size.h, run, baseline);
}

int latency_expected(const latency_run *run, const latency_baseline *baseline)
{
    const latency_options *options = &run->options;
    const tfa_histogram *trip = &run->total->parts[PART_ROUND_TRIP].h;
    const double p99 = (double)tfa_histogram_quantile(trip, 0.99) / 1000.0;
    const int threshold = options->fail_p99_us > 0 || options->fail_ratio > 0;
    if (threshold && latency_misses(run->total))
        return 0;
    if (options->fail_p99_us > 0 && !(p99 <= options->fail_p99_us))
        return 0;
    const double ratio = latency_ratio(run, baseline);
    return !(options->fail_ratio > 0) || (ratio > 0 && ratio <= options->fail_ratio);
}
