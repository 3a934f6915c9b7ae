/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Figures of a robot as JSON, for the page.
 */
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>
#include <totalforce/method.h>

#include "http/http_internal.h"

static const char *separator(uint32_t i)
{
    return i ? "," : "";
}

static void write_text(FILE *out, const char *key, const char *text)
{
    fprintf(out, ",\"%s\":", key);
    json_string(out, text);
}

static void write_number(FILE *out, const char *key, double number)
{
    fprintf(out, ",\"%s\":", key);
    json_number(out, number);
}

static void write_count(FILE *out, const char *key, uint64_t count)
{
    fprintf(out, ",\"%s\":%" PRIu64, key, count);
}

/* Age of a time, ms; null: there is none. */
static void write_age(FILE *out, const char *key, uint64_t now, uint64_t time)
{
    if (time)
        write_number(out, key, now > time ? (double)(now - time) * 1e-6 : 0);
    else
        fprintf(out, ",\"%s\":null", key);
}

/* ---- the model: frames, joints ---- */

void state_write_model(tfa_http *http, uint32_t robot, FILE *out)
{
    figure *f = &http->figures[robot];
    pthread_mutex_lock(&f->mutex);
    fputs("{\"robot\":", out);
    json_string(out, http->sampler.now->robots[robot].served.name);
    write_text(out, "model", tfa_model_hash_text(f->model));
    fputs(",\"frames\":[", out);
    for (uint32_t i = 0; i < f->frame_count; i++) {
        fputs(separator(i), out);
        json_string(out, tfa_model_frame(f->model, i).name);
    }
    fputs("],\"parents\":[", out);
    for (uint32_t i = 0; f->parents && i < f->frame_count; i++)
        fprintf(out, "%s%d", separator(i), f->parents[i]);
    fputs("],\"joints\":[", out);
    for (uint32_t i = 0; i < tfa_model_joint_count(f->model); i++) {
        fputs(separator(i), out);
        json_string(out, tfa_model_joint(f->model, i).name);
    }
    fputs("]}", out);
    pthread_mutex_unlock(&f->mutex);
}

/* ---- the motion: positions of frames, ellipsoids ---- */

static void write_tip(const figure *f, const figure_tip *tip, FILE *out)
{
    fprintf(out, "{\"frame\":%u", tip->frame);
    write_text(out, "name", tfa_model_frame(f->model, tip->frame).name);
    if (tip->status != TFA_OK) {
        write_text(out, "error", tfa_status_text(tip->status));
    } else {
        fputs(",\"lambda_inv\":", out);
        json_numbers(out, tip->block, 9);
        fputs(",\"values\":", out);
        json_numbers(out, tip->values, 3);
        fputs(",\"vectors\":", out);
        json_numbers(out, tip->vectors[0], 9);
    }
    fputc('}', out);
}

static void write_figure(const figure *f, FILE *out)
{
    if (f->status != TFA_OK) {
        write_text(out, "error", tfa_status_text(f->status));
        return;
    }
    fputs(",\"q\":", out);
    json_numbers(out, f->q, tfa_model_q_count(f->model));
    fputs(",\"positions\":[", out);
    for (uint32_t i = 0; i < f->frame_count; i++)
        for (int k = 0; k < 3; k++) {
            fputs(separator(i + (uint32_t)k), out);
            json_number(out, f->poses[i * 7 + (uint32_t)k]);
        }
    fputs("],\"tips\":[", out);
    for (uint32_t i = 0; i < f->tip_count; i++) {
        fputs(separator(i), out);
        write_tip(f, &f->tips[i], out);
    }
    fputc(']', out);
}

void state_write_motion(tfa_http *http, uint32_t robot, FILE *out)
{
    const tfa_robot_statistics *r = &http->sampler.now->robots[robot];
    const uint64_t now = http_clock();
    figure *f = &http->figures[robot];
    pthread_mutex_lock(&f->mutex);
    figure_update(f, &r->state, now);
    fputs("{\"robot\":", out);
    json_string(out, r->served.name);
    write_text(out, "model", tfa_model_hash_text(f->model));
    write_age(out, "age_ms", now, r->state.time);
    write_figure(f, out);
    fputc('}', out);
    pthread_mutex_unlock(&f->mutex);
}

/* ---- counters ---- */

static void write_methods(const tfa_tally *t, FILE *out)
{
    bool any = false;
    fputs(",\"methods\":{", out);
    for (uint32_t i = 0; i < TFA_STATISTICS_METHODS; i++) {
        if (!t->methods[i])
            continue;
        fputs(any ? "," : "", out);
        json_string(out, i ? tfa_method_name(i) : "other");
        fprintf(out, ":%" PRIu64, t->methods[i]);
        any = true;
    }
    fputc('}', out);
}

static void write_statuses(const tfa_tally *t, FILE *out)
{
    bool any = false;
    fputs(",\"refusals\":[", out);
    for (int i = 1; i < TFA_STATISTICS_STATUSES; i++) {
        if (!t->statuses[i])
            continue;
        fprintf(out, "%s{\"count\":%" PRIu64, any ? "," : "", t->statuses[i]);
        write_text(out, "name", tfa_status_name(-i));
        write_text(out, "text", tfa_status_text(-i));
        write_text(out, "cause", tfa_status_cause(-i));
        fputc('}', out);
        any = true;
    }
    fputc(']', out);
}

static void write_tally(const tfa_tally *t, FILE *out)
{
    write_count(out, "requests", t->requests);
    write_count(out, "rejected", t->rejected);
    write_count(out, "late", t->late);
    write_count(out, "states", t->states);
    write_count(out, "fallbacks", t->fallbacks);
    write_count(out, "estimates", t->estimates);
    write_count(out, "refined", t->refined);
    write_count(out, "inaccurate", t->inaccurate);
    write_count(out, "not_finite", t->not_finite);
    write_count(out, "sentinel", t->sentinel);
    write_number(out, "largest_estimate", t->largest_estimate);
    write_methods(t, out);
    write_statuses(t, out);
}

/* One row a second, the oldest first: requests, states, rejected, fallbacks in it; times, us. */
static void write_history(const sampler *s, uint32_t robot, FILE *out)
{
    bool any = false;
    fprintf(out, ",\"second\":%" PRIu64 ",\"history\":[", s->seconds);
    for (uint32_t ago = HTTP_SECONDS; ago-- > 0;) {
        const http_second *h = sampler_second(s, robot, ago);
        if (!h)
            continue;
        fprintf(out, "%s[%.6g,%.6g,%.6g,%.6g", any ? "," : "", (double)h->requests,
                (double)h->states, (double)h->rejected, (double)h->fallbacks);
        for (int t = 0; t < TIME_COUNT; t++)
            for (int k = 0; k < QUANTILE_COUNT; k++)
                if (h->times[t][k] < 0)
                    fputs(",null", out);
                else
                    fprintf(out, ",%.6g", (double)h->times[t][k]);
        fputc(']', out);
        any = true;
    }
    fputc(']', out);
}

static void write_inputs(const tfa_robot_statistics *r, uint64_t now, FILE *out)
{
    const tfa_ros2_statistics *ros2 = &r->ros2;
    fputs(",\"inputs\":[", out);
    for (uint32_t i = 0; i < ros2->input_count; i++) {
        const tfa_input_statistics *input = &ros2->inputs[i];
        fprintf(out, "%s{\"publishers\":%u", separator(i), input->publishers);
        write_text(out, "topic", input->name);
        write_count(out, "received", input->received);
        write_count(out, "refused", input->refused + input->oversized);
        write_age(out, "age_ms", now, input->last);
        fputc('}', out);
    }
    fputc(']', out);
    write_count(out, "ros2_refused", ros2->refused);
    write_text(out, "ros2_refusal", ros2->refusal);
    write_count(out, "ros2_subscribers", ros2->subscribers);
    write_age(out, "dds_request_age_ms", now, r->dds_request);
    write_age(out, "dds_torques_age_ms", now, r->dds_torques);
}

static void write_clients(const sampler *s, uint32_t robot, FILE *out)
{
    bool any = false;
    fputs(",\"clients\":[", out);
    for (uint32_t i = 0; i < s->now->client_count; i++) {
        const tfa_client_statistics *c = &s->now->clients[i];
        const double rate = sampler_rate(s, c);
        if (c->served.robot != robot || c->served.kind == TFA_CLIENT_SELF)
            continue;
        fprintf(out, "%s{\"process\":%d,\"user\":%u,\"worker\":%d", any ? "," : "",
                c->served.process, c->served.user, c->served.worker);
        write_text(out, "kind", tfa_client_kind_name(c->served.kind));
        write_number(out, "seconds", (double)(s->now->time - c->served.since) * 1e-9);
        write_count(out, "queued", c->queued);
        write_count(out, "requests", c->tally.requests);
        write_count(out, "rejected", c->tally.rejected);
        if (rate >= 0)
            write_number(out, "rate", rate);
        write_number(out, "p50_us", (double)tfa_histogram_quantile(&c->tally.compute, 0.5) * 1e-3);
        write_number(out, "p99_us", (double)tfa_histogram_quantile(&c->tally.compute, 0.99) * 1e-3);
        fputc('}', out);
        any = true;
    }
    fputc(']', out);
}

static void write_robot(const tfa_served_robot *r, FILE *out)
{
    write_text(out, "robot", r->name);
    write_text(out, "model", r->model_hash);
    write_text(out, "isa", r->kernel_isa);
    write_text(out, "kernel", r->kernel_file);
    write_text(out, "precision", r->precision);
    write_count(out, "joints", r->joints);
    write_count(out, "freedoms", r->freedoms + r->base_freedoms);
    write_count(out, "dds", r->dds);
    write_text(out, "ros2", r->ros2_node[0] ? r->ros2_namespace : "");
    write_text(out, "ros2_node", r->ros2_node);
}

static void write_daemon(const tfa_snapshot *s, FILE *out)
{
    fprintf(out, "{\"process\":%d,\"robots\":[", s->process);
    for (uint32_t i = 0; i < s->robot_count; i++) {
        fputs(separator(i), out);
        json_string(out, s->robots[i].served.name);
    }
    fputc(']', out);
    write_text(out, "version", s->version);
    write_number(out, "uptime_s", (double)(s->time - s->start) * 1e-9);
    write_count(out, "workers", s->worker_count);
    write_count(out, "reloads", s->reloads);
    write_count(out, "connections", s->connections);
    write_count(out, "connections_refused", s->refused);
    if (!s->dds_on)
        return;
    write_count(out, "dds_request_writers", s->dds.request_writers);
    write_count(out, "dds_reply_readers", s->dds.reply_readers);
    write_count(out, "dds_torque_writers", s->dds.torque_writers);
    write_count(out, "dds_acceleration_readers", s->dds.acceleration_readers);
    write_count(out, "dds_rejected", s->dds.rejected);
}

void state_write(tfa_http *http, uint32_t robot, FILE *out)
{
    const sampler *s = &http->sampler;
    const tfa_robot_statistics *r = &s->now->robots[robot];
    write_daemon(s->now, out);
    write_robot(&r->served, out);
    write_count(out, "queued", r->queued);
    write_tally(&r->total, out);
    write_history(s, robot, out);
    write_inputs(r, s->now->time, out);
    write_clients(s, robot, out);
    fputs(",\"motion\":", out);
    state_write_motion(http, robot, out);
    fputc('}', out);
}
