/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Readings as lines of text: a block of lines for each robot, a line for each client.
 */
#include "watch.h"

#include <inttypes.h>
#include <totalforce/method.h>

static double rate(const watch *w, uint64_t count)
{
    return w->seconds > 0 ? (double)count / w->seconds : 0;
}

static double busy_percent(const watch *w, const tfa_tally *t)
{
    return 1e-7 * rate(w, t->busy_ns);
}

static void write_times(const char *name, const tfa_histogram *h, FILE *out)
{
    fprintf(out, "  %s", name);
    if (h->count)
        fprintf(out, " %.2f/%.2f/%.2f", 1e-3 * (double)tfa_histogram_quantile(h, 0.5),
                1e-3 * (double)tfa_histogram_quantile(h, 0.99), 1e-3 * (double)h->highest);
    else
        fputs(" -/-/-", out);
}

/* ---- the daemon ---- */

static void write_daemon(const watch *w, FILE *out)
{
    const tfa_snapshot *s = w->now;
    const uint64_t up = (s->time - s->start) / 1000000000u;
    fprintf(out,
            "totalforced %s, process %d, up %" PRIu64 ":%02u:%02u, %u workers\n"
            "connections %" PRIu64 ", refused %" PRIu64 "\n",
            s->version, s->process, up / 3600, (unsigned)(up / 60 % 60), (unsigned)(up % 60),
            s->worker_count, s->connections, s->refused);
    if (s->dds_on)
        fprintf(out,
                "dds: writers: requests %" PRIu64 ", torques %" PRIu64 "; readers: replies %" PRIu64
                ", accelerations %" PRIu64 "\ndds: dropped %" PRIu64 ", unknown robots %" PRIu64
                "\n",
                s->dds.request_writers, s->dds.torque_writers, s->dds.reply_readers,
                s->dds.acceleration_readers, s->dds.dropped, s->dds.unknown);
}

/* ---- robots ---- */

static void write_methods(const tfa_tally *t, FILE *out)
{
    const char *separator = "  methods:";
    for (uint32_t i = 0; i < TFA_STATISTICS_METHODS; i++) {
        if (!t->methods[i])
            continue;
        fprintf(out, "%s %s %.1f %%", separator, i ? tfa_method_name(i) : "unknown",
                100.0 * (double)t->methods[i] / (double)(t->requests - t->rejected));
        separator = ",";
    }
    if (*separator == ',')
        fputc('\n', out);
}

/* Since the start: a cause that was there once is looked for. */
static void write_causes(const tfa_tally *t, FILE *out)
{
    const char *separator = "  not ok since the start:";
    for (int i = 1; i < TFA_STATISTICS_STATUSES; i++) {
        if (!t->statuses[i])
            continue;
        fprintf(out, "%s %s %" PRIu64, separator, tfa_status_name(-i), t->statuses[i]);
        separator = ",";
    }
    if (*separator == ',')
        fputc('\n', out);
    if (t->fallbacks || t->estimates)
        fprintf(out,
                "  since the start: fallbacks %" PRIu64 ", error estimates %" PRIu64
                ", largest %.1e\n",
                t->fallbacks, t->estimates, t->largest_estimate);
}

static void write_age(const char *name, uint64_t now, uint64_t last, FILE *out)
{
    if (last)
        fprintf(out, "%s %.1f ms", name, 1e-6 * (double)(now > last ? now - last : 0));
    else
        fprintf(out, "%s never", name);
}

static void write_inputs(const tfa_robot_statistics *r, uint64_t now, FILE *out)
{
    if (r->served.dds) {
        write_age("  dds: last request", now, r->dds_request, out);
        write_age(", torques", now, r->dds_torques, out);
        fputc('\n', out);
    }
    for (uint32_t i = 0; i < r->ros2.input_count; i++) {
        const tfa_input_statistics *in = &r->ros2.inputs[i];
        fprintf(out, "  ros2 %s:", in->name);
        write_age("", now, in->last, out);
        fprintf(out, ", publishers %u, messages %" PRIu64 ", refused %" PRIu64 "\n", in->publishers,
                in->received, in->refused + in->oversized);
    }
    if (r->ros2.refused)
        fprintf(out, "  ros2: not answered %" PRIu64 ", last: %s\n", r->ros2.refused,
                r->ros2.refusal);
}

static void write_robot(const watch *w, uint32_t i, FILE *out)
{
    const tfa_robot_statistics *r = &w->now->robots[i];
    const tfa_tally *t = &w->since->robots[i].total;
    fprintf(out, "%-20.20s %7u %10.1f %10.1f %6.1f %6u %6" PRIu64 " %7" PRIu64 "\n", r->served.name,
            r->clients, rate(w, t->requests), rate(w, t->states), busy_percent(w, t), r->queued,
            t->late, t->rejected);
    if (t->requests) {
        write_times("us p50/p99/max: queue", &t->queue, out);
        write_times("compute", &t->compute, out);
        write_times("total", &t->total, out);
        fputc('\n', out);
    }
    write_methods(t, out);
    write_causes(&r->total, out);
    write_inputs(r, w->now->time, out);
}

/* ---- clients ---- */

static void write_client(const watch *w, uint32_t i, FILE *out)
{
    const tfa_client_statistics *c = &w->now->clients[i];
    const tfa_tally *t = w->clients[i];
    char process[16] = "gateway";
    if (c->served.kind == TFA_CLIENT_SELF)
        snprintf(process, sizeof process, "daemon");
    else if (c->served.kind == TFA_CLIENT_SHM)
        snprintf(process, sizeof process, "%d", c->served.process);
    fprintf(out, "%-8s %-5s %-16.16s %10.1f %6.1f %6u", process,
            tfa_client_kind_name(c->served.kind), w->now->robots[c->served.robot].served.name,
            rate(w, t->requests), busy_percent(w, t), c->queued);
    write_times("", &t->total, out);
    fputc('\n', out);
}

void watch_write_table(const watch *w, FILE *out)
{
    write_daemon(w, out);
    fprintf(out, "\n%-20s %7s %10s %10s %6s %6s %6s %7s\n", "ROBOT", "CLIENTS", "REQUESTS/S",
            "STATES/S", "BUSY %", "QUEUED", "LATE", "REFUSED");
    for (uint32_t i = 0; i < w->now->robot_count; i++)
        write_robot(w, i, out);
    if (!w->now->client_count)
        return;
    fprintf(out, "\n%-8s %-5s %-16s %10s %6s %6s   %s\n", "CLIENT", "BY", "ROBOT", "REQUESTS/S",
            "BUSY %", "QUEUED", "TOTAL us p50/p99/max");
    for (uint32_t i = 0; i < w->now->client_count; i++)
        write_client(w, i, out);
}
