/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Status of the daemon as JSON: robots, workers, clients, counters. Names of robots need no
 * escapes: letters, digits, '-', '_', '.'.
 */
#include "control/daemon.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <totalforce/version.h>
#include <unistd.h>

static const char *separator(uint32_t i)
{
    return i ? ",\n    " : "\n    ";
}

/* Other daemons may serve the robot, too. */
static void write_leadership(const gateway_slot *g, uint32_t robot, FILE *out)
{
    gateway_leadership l;
    if (!g || !g->kind->leadership(g->self, robot, &l))
        return;
    fprintf(out,
            ", \"leadership\": {\"role\": \"%s\", \"epoch\": %" PRIu64 ", \"peers\": %u, "
            "\"pause_ms\": %.1f, \"silence_ms\": %.1f",
            l.role, l.epoch, l.peers, l.pause_ms, l.silence_ms);
    if (*l.leader)
        fprintf(out, ", \"leader\": {\"participant\": \"%s\", \"origin\": \"%s\", \"ms\": %.1f}",
                l.leader, l.origin, l.follows_ms);
    fputc('}', out);
}

static void write_robots(const tfa_daemon *d, FILE *out)
{
    fputs("  \"robots\": [", out);
    for (uint32_t i = 0; i < d->robot_set.count; i++) {
        const tfa_robot *r = &d->robot_set.robots[i];
        const gateway_slot *dds = gateways_of_robot(d, TFA_SOURCE_DDS, i);
        fprintf(out,
                "%s{\"name\": \"%s\", \"model\": \"%s\", \"joints\": %u, \"freedoms\": %u, "
                "\"floating\": %s, \"dds\": %s, \"specialised\": %s",
                separator(i), r->name, tfa_model_hash_text(r->model),
                tfa_model_joint_count(r->model), r->shape.v_count + r->shape.base_freedoms,
                r->shape.base_freedoms ? "true" : "false", dds ? "true" : "false",
                r->specialised ? "true" : "false");
        write_leadership(dds, i, out);
        fputc('}', out);
    }
    fputs("\n  ],\n", out);
}

static void write_workers(const tfa_daemon *d, FILE *out)
{
    fputs("  \"workers\": [", out);
    for (uint32_t i = 0; i < d->settings->workers; i++)
        fprintf(out, "%s{\"clients\": %u, \"heartbeat\": %" PRIu64 "}", separator(i),
                d->workers[i].clients, tfa_worker_heartbeat(d->workers[i].worker));
    fputs("\n  ],\n", out);
}

static void write_clients(const tfa_daemon *d, FILE *out)
{
    uint32_t count = 0;
    fputs("  \"clients\": [", out);
    for (const session *s = d->sessions; s; s = s->next) {
        if (s->state != SESSION_ATTACHED)
            continue;
        const tfa_tally_sums n = tfa_worker_client_sums(s->client);
        fprintf(out,
                "%s{\"robot\": \"%s\", \"process\": %d, \"user\": %u, \"requests\": %" PRIu64
                ", \"rejected\": %" PRIu64 ", \"late\": %" PRIu64 ", \"busy_us\": %" PRIu64 "}",
                separator(count++), d->robot_set.robots[s->robot].name, (int)s->process,
                (unsigned)s->user, n.requests, n.rejected, n.late, n.busy_ns / 1000);
    }
    fputs("\n  ],\n", out);
}

static uint64_t value_of(const tfa_counter *word)
{
    return atomic_load_explicit(word, memory_order_relaxed);
}

static void write_dds(const tfa_daemon *d, FILE *out)
{
    if (!d->gateways[TFA_SOURCE_DDS].self)
        return;
    const tfa_shared_dds *c = &d->statistics.header->dds_messages;
    fprintf(out,
            "  \"dds\": {\"requests\": %" PRIu64 ", \"torques\": %" PRIu64 ", \"replies\": %" PRIu64
            ", \"rejected\": %" PRIu64 ", \"late\": %" PRIu64 ", \"unknown_robots\": %" PRIu64
            ", \"dropped\": %" PRIu64 ", \"handovers\": %" PRIu64 ", \"standby\": %" PRIu64 "},\n",
            value_of(&c->requests), value_of(&c->torques), value_of(&c->replies),
            value_of(&c->rejected), value_of(&c->late), value_of(&c->unknown),
            value_of(&c->dropped), value_of(&c->handovers), value_of(&c->standby));
}

int status_write(const tfa_daemon *d, char **text, size_t *size)
{
    const tfa_tally_sums departed = statistics_departed(d);
    FILE *out = open_memstream(text, size);
    if (!out)
        return TFA_E_MEMORY;
    fprintf(out, "{\n  \"version\": \"" TFA_VERSION "\",\n  \"process\": %d,\n", (int)getpid());
    fprintf(out, "  \"seconds\": %.1f,\n", (double)(control_clock() - d->start) * 1e-9);
    write_robots(d, out);
    write_workers(d, out);
    write_clients(d, out);
    write_dds(d, out);
    fprintf(out,
            "  \"totals\": {\"connections\": %" PRIu64 ", \"refused\": %" PRIu64
            ", \"requests\": %" PRIu64 ", \"rejected\": %" PRIu64 ", \"late\": %" PRIu64 "}\n}\n",
            value_of(&d->statistics.header->connections), value_of(&d->statistics.header->refused),
            departed.requests, departed.rejected, departed.late);
    const int failed = ferror(out);
    return fclose(out) == 0 && !failed ? TFA_OK : TFA_E_MEMORY;
}
