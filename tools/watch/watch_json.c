/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Readings as JSON.
 */
#include "watch.h"

#include <totalforce/method.h>

static json_int_t whole(uint64_t value)
{
    return (json_int_t)value;
}

static double rate(const watch *w, uint64_t count)
{
    return w->seconds > 0 ? (double)count / w->seconds : 0;
}

static json_t *json_times(const tfa_histogram *h)
{
    return json_pack("{s:I, s:f, s:f, s:f}", "count", whole(h->count), "p50",
                     1e-3 * (double)tfa_histogram_quantile(h, 0.5), "p99",
                     1e-3 * (double)tfa_histogram_quantile(h, 0.99), "max",
                     1e-3 * (double)h->highest);
}

/* The statuses that are not ok. */
static json_t *json_statuses(const tfa_tally *t)
{
    json_t *object = json_object();
    for (int i = 1; i < TFA_STATISTICS_STATUSES; i++)
        if (t->statuses[i])
            json_object_set_new(object, tfa_status_name(-i), json_integer(whole(t->statuses[i])));
    return object;
}

static json_t *json_methods(const tfa_tally *t)
{
    json_t *object = json_object();
    for (uint32_t i = 0; i < TFA_STATISTICS_METHODS; i++)
        if (t->methods[i])
            json_object_set_new(object, i ? tfa_method_name(i) : "unknown",
                                json_integer(whole(t->methods[i])));
    return object;
}

static json_t *json_interval(const watch *w, const tfa_tally *t)
{
    return json_pack("{s:f, s:f, s:f, s:I, s:I, s:I, s:o, s:o, s:o, s:o}", "requests_per_s",
                     rate(w, t->requests), "states_per_s", rate(w, t->states), "busy",
                     1e-9 * rate(w, t->busy_ns), "rejected", whole(t->rejected), "late",
                     whole(t->late), "fallbacks", whole(t->fallbacks), "methods", json_methods(t),
                     "queue_us", json_times(&t->queue), "compute_us", json_times(&t->compute),
                     "total_us", json_times(&t->total));
}

static json_t *json_totals(const tfa_tally *t)
{
    return json_pack("{s:I, s:I, s:I, s:I, s:I, s:I, s:f, s:o, s:o}", "requests",
                     whole(t->requests), "rejected", whole(t->rejected), "late", whole(t->late),
                     "states", whole(t->states), "fallbacks", whole(t->fallbacks), "estimates",
                     whole(t->estimates), "largest_estimate", t->largest_estimate, "methods",
                     json_methods(t), "not_ok", json_statuses(t));
}

static json_t *json_age(uint64_t now, uint64_t last)
{
    return last ? json_real(1e-6 * (double)(now > last ? now - last : 0)) : json_null();
}

static json_t *json_inputs(const tfa_robot_statistics *r, uint64_t now)
{
    json_t *list = json_array();
    for (uint32_t i = 0; i < r->ros2.input_count; i++) {
        const tfa_input_statistics *in = &r->ros2.inputs[i];
        json_array_append_new(list, json_pack("{s:s, s:o, s:i, s:I, s:I}", "topic", in->name,
                                              "age_ms", json_age(now, in->last), "publishers",
                                              (int)in->publishers, "messages", whole(in->received),
                                              "refused", whole(in->refused + in->oversized)));
    }
    return list;
}

static json_t *json_robot(const watch *w, uint32_t i)
{
    const tfa_robot_statistics *r = &w->now->robots[i];
    return json_pack("{s:s, s:s, s:i, s:i, s:o, s:o, s:o, s:o, s:o}", "name", r->served.name,
                     "model", r->served.model_hash, "clients", (int)r->clients, "queued",
                     (int)r->queued, "interval", json_interval(w, &w->since->robots[i].total),
                     "totals", json_totals(&r->total), "inputs", json_inputs(r, w->now->time),
                     "dds_request_age_ms", json_age(w->now->time, r->dds_request),
                     "dds_torques_age_ms", json_age(w->now->time, r->dds_torques));
}

static json_t *json_client(const watch *w, uint32_t i)
{
    const tfa_client_statistics *c = &w->now->clients[i];
    return json_pack("{s:s, s:s, s:i, s:i, s:i, s:i, s:o, s:o}", "robot",
                     w->now->robots[c->served.robot].served.name, "by",
                     tfa_client_kind_name(c->served.kind), "process", (int)c->served.process,
                     "user", (int)c->served.user, "worker", (int)c->served.worker, "queued",
                     (int)c->queued, "interval", json_interval(w, w->clients[i]), "totals",
                     json_totals(&c->tally));
}

static json_t *json_dds(const tfa_dds_statistics *d)
{
    return json_pack("{s:I, s:I, s:I, s:I, s:I, s:I, s:I, s:I}", "request_writers",
                     whole(d->request_writers), "reply_readers", whole(d->reply_readers),
                     "torque_writers", whole(d->torque_writers), "acceleration_readers",
                     whole(d->acceleration_readers), "requests", whole(d->requests), "torques",
                     whole(d->torques), "replies", whole(d->replies), "dropped", whole(d->dropped));
}

json_t *watch_json(const watch *w)
{
    const tfa_snapshot *s = w->now;
    json_t *robots = json_array(), *clients = json_array();
    for (uint32_t i = 0; i < s->robot_count; i++)
        json_array_append_new(robots, json_robot(w, i));
    for (uint32_t i = 0; i < s->client_count; i++)
        json_array_append_new(clients, json_client(w, i));
    return json_pack("{s:s, s:i, s:f, s:f, s:i, s:I, s:I, s:o, s:o, s:o}", "version", s->version,
                     "process", (int)s->process, "seconds", 1e-9 * (double)(s->time - s->start),
                     "interval_s", w->seconds, "workers", (int)s->worker_count, "connections",
                     whole(s->connections), "refused", whole(s->refused), "dds",
                     s->dds_on ? json_dds(&s->dds) : json_null(), "robots", robots, "clients",
                     clients);
}
