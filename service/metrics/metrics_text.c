/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Statistics as text for Prometheus. All lines of one metric stand together, after its HELP and
 * TYPE.
 */
#include "metrics/metrics_text.h"

#include <inttypes.h>
#include <math.h>
#include <totalforce/method.h>

#define NS 1e-9
/* Bounds of the histograms' buckets: 2^k - 1 ns, which are tops of buckets of the statistics. */
#define BOUND_FIRST 7
#define BOUND_LAST TFA_STATISTICS_RANGE

/* ---- parts of a line ---- */

static void begin(FILE *out, const char *name, const char *type, const char *help)
{
    fprintf(out, "# HELP totalforce_%s %s\n# TYPE totalforce_%s %s\n", name, help, name, type);
}

static void write_text(FILE *out, const char *text)
{
    for (; *text; text++) {
        if (*text == '\n')
            fputs("\\n", out);
        else if (*text == '"' || *text == '\\')
            fprintf(out, "\\%c", *text);
        else
            fputc(*text, out);
    }
}

/* The format's words for what printf writes in lower case, a NaN perhaps with a sign. */
static void write_value(FILE *out, double value)
{
    if (isnan(value))
        fputs("NaN", out);
    else if (isinf(value))
        fputs(value > 0 ? "+Inf" : "-Inf", out);
    else
        fprintf(out, "%.9g", value);
}

/* name{robot="..." */
static void write_robot(FILE *out, const char *name, const tfa_robot_statistics *r)
{
    fprintf(out, "totalforce_%s{robot=\"", name);
    write_text(out, r->served.name);
    fputc('"', out);
}

static void write_label(FILE *out, const char *label, const char *value)
{
    fprintf(out, ",%s=\"", label);
    write_text(out, value);
    fputc('"', out);
}

/* ---- one figure of each robot ---- */

#define TALLY_COUNTERS(X)                                                                          \
    X("requests_total", requests, "Requests answered, with whatever status.")                      \
    X("deadline_misses_total", late, "Requests refused because their deadline had passed.")        \
    X("states_total", states, "States of requests with answers.")                                  \
    X("refined_states_total", refined, "States of requests that asked for refinement.")            \
    X("error_estimates_total", estimates, "States whose error was estimated.")                     \
    X("fallbacks_total", fallbacks, "States that another method answered than asked.")             \
    X("inaccurate_total", inaccurate, "States whose error estimate was above 1e-4.")               \
    X("stalled_refinements_total", stalled, "States whose refinement stalled.")                    \
    X("residual_precision_total", residual_precision, "States computed in higher precision.")      \
    X("sentinel_trips_total", sentinel, "States whose sentinel tripped.")

static void write_counters(const tfa_snapshot *s, FILE *out)
{
#define COUNTER(name, field, help)                                                                 \
    begin(out, name, "counter", help);                                                             \
    for (uint32_t i = 0; i < s->robot_count; i++) {                                                \
        write_robot(out, name, &s->robots[i]);                                                     \
        fprintf(out, "} %" PRIu64 "\n", s->robots[i].total.field);                                 \
    }
    TALLY_COUNTERS(COUNTER)
#undef COUNTER
    begin(out, "busy_seconds_total", "counter", "Time spent on requests.");
    for (uint32_t i = 0; i < s->robot_count; i++) {
        write_robot(out, "busy_seconds_total", &s->robots[i]);
        fprintf(out, "} %.9f\n", NS * (double)s->robots[i].total.busy_ns);
    }
}

static void write_gauges(const tfa_snapshot *s, FILE *out)
{
    begin(out, "clients", "gauge", "Connections of other processes, without gateways.");
    for (uint32_t i = 0; i < s->robot_count; i++) {
        write_robot(out, "clients", &s->robots[i]);
        fprintf(out, "} %u\n", s->robots[i].clients);
    }
    begin(out, "queued_requests", "gauge", "Requests that wait in rings.");
    for (uint32_t i = 0; i < s->robot_count; i++) {
        write_robot(out, "queued_requests", &s->robots[i]);
        fprintf(out, "} %u\n", s->robots[i].queued);
    }
    begin(out, "largest_error_estimate", "gauge", "Largest error estimate since the start.");
    for (uint32_t i = 0; i < s->robot_count; i++) {
        write_robot(out, "largest_error_estimate", &s->robots[i]);
        fputs("} ", out);
        write_value(out, s->robots[i].total.largest_estimate);
        fputc('\n', out);
    }
}

/* ---- robots: what they are, methods, refusals ---- */

static void write_robots(const tfa_snapshot *s, FILE *out)
{
    begin(out, "robot_info", "gauge", "Model and kernel of each robot; always 1.");
    for (uint32_t i = 0; i < s->robot_count; i++) {
        const tfa_served_robot *r = &s->robots[i].served;
        write_robot(out, "robot_info", &s->robots[i]);
        write_label(out, "model", r->model_hash);
        write_label(out, "isa", r->kernel_isa);
        write_label(out, "kernel", r->kernel_file[0] ? "specialised" : "generic");
        write_label(out, "precision", r->precision);
        fprintf(out, ",joints=\"%u\"} 1\n", r->joints);
    }
}

static void write_methods(const tfa_snapshot *s, FILE *out)
{
    begin(out, "answers_total", "counter", "Requests with answers, by method of the first state.");
    for (uint32_t i = 0; i < s->robot_count; i++)
        for (uint32_t k = 0; k < TFA_STATISTICS_METHODS; k++) {
            if (!s->robots[i].total.methods[k])
                continue;
            write_robot(out, "answers_total", &s->robots[i]);
            write_label(out, "method", k ? tfa_method_name(k) : "unknown");
            fprintf(out, "} %" PRIu64 "\n", s->robots[i].total.methods[k]);
        }
    begin(out, "failures_total", "counter", "Requests with a status other than ok, by status.");
    for (uint32_t i = 0; i < s->robot_count; i++)
        for (int k = 1; k < TFA_STATISTICS_STATUSES; k++) {
            if (!s->robots[i].total.statuses[k])
                continue;
            write_robot(out, "failures_total", &s->robots[i]);
            write_label(out, "status", tfa_status_name(-k));
            fprintf(out, "} %" PRIu64 "\n", s->robots[i].total.statuses[k]);
        }
}

/* ---- histograms ---- */

static void write_histogram(const tfa_robot_statistics *r, const char *name, const tfa_histogram *h,
                            FILE *out)
{
    uint64_t below = 0;
    uint32_t bucket = 0;
    for (uint32_t k = BOUND_FIRST; k < BOUND_LAST; k++) {
        const uint64_t bound = (UINT64_C(1) << k) - 1;
        for (; bucket + 1 < h->bucket_count && tfa_histogram_top(h, bucket) <= bound; bucket++)
            below += h->buckets[bucket];
        fprintf(out, "totalforce_%s_bucket{robot=\"", name);
        write_text(out, r->served.name);
        fprintf(out, "\",le=\"%.12g\"} %" PRIu64 "\n", NS * (double)bound, below);
    }
    fprintf(out, "totalforce_%s_bucket{robot=\"", name);
    write_text(out, r->served.name);
    fprintf(out, "\",le=\"+Inf\"} %" PRIu64 "\ntotalforce_%s_sum{robot=\"", h->count, name);
    write_text(out, r->served.name);
    fprintf(out, "\"} %.9f\ntotalforce_%s_count{robot=\"", NS * h->sum, name);
    write_text(out, r->served.name);
    fprintf(out, "\"} %" PRIu64 "\n", h->count);
}

static void write_histograms(const tfa_snapshot *s, FILE *out)
{
    begin(out, "queue_seconds", "histogram", "Time from receipt of a request to its start.");
    for (uint32_t i = 0; i < s->robot_count; i++)
        write_histogram(&s->robots[i], "queue_seconds", &s->robots[i].total.queue, out);
    begin(out, "compute_seconds", "histogram", "Time from the start of a request to its answer.");
    for (uint32_t i = 0; i < s->robot_count; i++)
        write_histogram(&s->robots[i], "compute_seconds", &s->robots[i].total.compute, out);
    begin(out, "latency_seconds", "histogram",
          "Time from the client's sending to the answer, where the client says when.");
    for (uint32_t i = 0; i < s->robot_count; i++)
        write_histogram(&s->robots[i], "latency_seconds", &s->robots[i].total.total, out);
}

/* ---- inputs and messages ---- */

static void write_topic(FILE *out, const char *metric, const tfa_robot_statistics *r,
                        const tfa_input_statistics *in)
{
    write_robot(out, metric, r);
    write_label(out, "topic", in->name);
    fputs("} ", out);
}

static void write_inputs(const tfa_snapshot *s, FILE *out)
{
#define INPUTS(metric, kind, help, write)                                                          \
    begin(out, metric, kind, help);                                                                \
    for (uint32_t i = 0; i < s->robot_count; i++)                                                  \
        for (uint32_t k = 0; k < s->robots[i].ros2.input_count; k++) {                             \
            const tfa_input_statistics *in = &s->robots[i].ros2.inputs[k];                         \
            write_topic(out, metric, &s->robots[i], in);                                           \
            write;                                                                                 \
            fputc('\n', out);                                                                      \
        }
    INPUTS("input_age_seconds", "gauge", "Time since the last message; NaN: none.",
           write_value(out, in->last ? NS * (double)(s->time - in->last) : (double)NAN))
    INPUTS("input_messages_total", "counter", "Messages of ROS 2.",
           fprintf(out, "%" PRIu64, in->received))
    INPUTS("input_refusals_total", "counter", "Messages of ROS 2 that could not be used.",
           fprintf(out, "%" PRIu64, in->refused + in->oversized))
    INPUTS("input_publishers", "gauge", "Matched publishers.", fprintf(out, "%u", in->publishers))
#undef INPUTS
}

static void write_dds(const tfa_snapshot *s, FILE *out)
{
    const tfa_dds_statistics *d = &s->dds;
    const struct {
        const char *what;
        uint64_t count;
    } messages[] = {{"requests", d->requests},  {"torques", d->torques},
                    {"replies", d->replies},    {"rejected", d->rejected},
                    {"late", d->late},          {"unknown", d->unknown},
                    {"dropped", d->dropped},    {"standby", d->standby},
                    {"handovers", d->handovers}},
      endpoints[] = {{"request_writers", d->request_writers},
                     {"reply_readers", d->reply_readers},
                     {"torque_writers", d->torque_writers},
                     {"acceleration_readers", d->acceleration_readers}};
    if (!s->dds_on)
        return;
    begin(out, "dds_messages_total", "counter", "Messages of the DDS gateway, by outcome.");
    for (size_t i = 0; i < sizeof messages / sizeof *messages; i++)
        fprintf(out, "totalforce_dds_messages_total{kind=\"%s\"} %" PRIu64 "\n", messages[i].what,
                messages[i].count);
    begin(out, "dds_endpoints", "gauge", "Matched endpoints of others on DDS.");
    for (size_t i = 0; i < sizeof endpoints / sizeof *endpoints; i++)
        fprintf(out, "totalforce_dds_endpoints{kind=\"%s\"} %" PRIu64 "\n", endpoints[i].what,
                endpoints[i].count);
}

/* ---- the daemon ---- */

static void write_daemon(const tfa_snapshot *s, FILE *out)
{
    begin(out, "build_info", "gauge", "Version of the daemon; always 1.");
    fputs("totalforce_build_info{version=\"", out);
    write_text(out, s->version);
    fputs("\"} 1\n", out);
    begin(out, "uptime_seconds", "gauge", "Time since the start of the daemon.");
    fprintf(out, "totalforce_uptime_seconds %.3f\n", NS * (double)(s->time - s->start));
    begin(out, "connections_total", "counter", "Connections of clients to sockets.");
    fprintf(out, "totalforce_connections_total %" PRIu64 "\n", s->connections);
    begin(out, "refused_connections_total", "counter", "Connections that were refused.");
    fprintf(out, "totalforce_refused_connections_total %" PRIu64 "\n", s->refused);
    begin(out, "reloads_total", "counter", "Reloads that exchanged a model.");
    fprintf(out, "totalforce_reloads_total %" PRIu64 "\n", s->reloads);
}

void metrics_write(const tfa_snapshot *s, FILE *out)
{
    write_daemon(s, out);
    write_robots(s, out);
    write_counters(s, out);
    write_gauges(s, out);
    write_methods(s, out);
    write_histograms(s, out);
    write_inputs(s, out);
    write_dds(s, out);
}
