/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The daemon's statistics in shared memory: one segment, made before everything that counts.
 */
#include "control/daemon.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <totalforce/version.h>
#include <unistd.h>

#include "platform/log.h"

/* ---- the segment ---- */

static void set_header(const tfa_daemon *d, tfa_shared_header *h)
{
    h->magic = TFA_STATISTICS_MAGIC;
    h->abi = TFA_STATISTICS_ABI;
    h->process = (int32_t)getpid();
    h->bytes = d->statistics_segment.size;
    h->start = d->start;
    h->workers = d->settings->workers;
    h->robots = d->robot_set.count;
    h->clients = TFA_WORKER_CLIENTS_MAX;
    h->dds = d->settings->dds.enabled && d->robot_set.robots[0].config->dds;
    snprintf(h->version, sizeof h->version, "%s", TFA_VERSION);
    snprintf(h->runtime_dir, sizeof h->runtime_dir, "%s", d->settings->runtime_dir);
}

int statistics_open(tfa_daemon *d)
{
    const tfa_statistics_layout l =
        tfa_statistics_layout_of(d->settings->workers, d->robot_set.count, TFA_WORKER_CLIENTS_MAX);
    const int status = tfa_segment_create(CONFIG_BACKEND_MEMFD, TFA_SEGMENT_PEER_READS, l.bytes,
                                          &d->statistics_segment);
    if (status != TFA_OK) {
        tfa_log(TFA_LOG_ERROR, "statistics: shared memory of %zu KiB: %s", l.bytes / 1024,
                tfa_status_text(status));
        return status;
    }
    d->statistics = tfa_statistics_view_of(d->statistics_segment.memory, &l);
    set_header(d, d->statistics.header);
    statistics_update(d);
    return TFA_OK;
}

void statistics_close(tfa_daemon *d)
{
    if (d->statistics.header)
        tfa_counter_set(&d->statistics.header->stopped, 1);
    tfa_segment_destroy(&d->statistics_segment);
    d->statistics = (tfa_statistics_view){0};
}

tfa_worker_statistics statistics_of_worker(const tfa_daemon *d, uint32_t worker)
{
    const tfa_statistics_view *v = &d->statistics;
    const size_t robots = d->robot_set.count;
    return (tfa_worker_statistics){worker, &v->workers[worker],
                                   &v->clients[(size_t)worker * TFA_WORKER_CLIENTS_MAX],
                                   &v->departed[worker * robots], &v->states[worker * robots]};
}

tfa_shared_state *statistics_gateway_states(const tfa_daemon *d, uint32_t source)
{
    return &d->statistics.states[(size_t)(d->settings->workers + source) * d->robot_set.count];
}

/* ---- robots ---- */

static void describe_kernel(const tfa_robot *robot, tfa_served_robot *r)
{
    if (!robot->specialised) {
        snprintf(r->kernel_isa, sizeof r->kernel_isa, "%s", tfa_isa_name());
        return;
    }
    const tfa_specialised_info info = tfa_specialised_describe(robot->specialised);
    snprintf(r->kernel_isa, sizeof r->kernel_isa, "%s", info.isa);
    snprintf(r->kernel_file, sizeof r->kernel_file, "%s", info.path);
}

static tfa_served_robot describe(const tfa_daemon *d, uint32_t i)
{
    const tfa_robot *robot = &d->robot_set.robots[i];
    tfa_served_robot r = {.joints = tfa_model_joint_count(robot->model),
                          .freedoms = robot->shape.v_count,
                          .q_count = robot->shape.q_count,
                          .base_freedoms = robot->shape.base_freedoms,
                          .dds_domain = d->settings->dds.domain};
    snprintf(r.name, sizeof r.name, "%s", robot->name);
    snprintf(r.model_hash, sizeof r.model_hash, "%s", tfa_model_hash_text(robot->model));
    snprintf(r.precision, sizeof r.precision, "%s",
             robot->config->precision == CONFIG_PRECISION_F32 ? "f32" : "f64");
    describe_kernel(robot, &r);
    for (const gateway_slot *g = NULL; (g = gateways_next(d, i, g));)
        g->kind->describe(g->self, i, &r);
    return r;
}

void statistics_update(tfa_daemon *d)
{
    for (uint32_t i = 0; i < d->robot_set.count; i++) {
        const tfa_served_robot served = describe(d, i);
        tfa_shared_robot *block = &d->statistics.robots[i];
        tfa_record_write(&block->served.version, block->served.words, &served, sizeof served);
    }
}

/* ---- sums ---- */

tfa_tally_sums statistics_departed(const tfa_daemon *d)
{
    const uint32_t blocks = d->settings->workers * d->robot_set.count;
    tfa_tally_sums sums = {0};
    for (uint32_t i = 0; i < blocks; i++)
        tfa_tally_sum(&d->statistics.departed[i], &sums);
    return sums;
}

tfa_tally_sums statistics_all(const tfa_daemon *d)
{
    tfa_tally_sums sums = statistics_departed(d);
    for (uint32_t i = 0; i < d->robot_set.count; i++)
        for (int k = 0; k < TFA_GATEWAY_SOURCES; k++)
            tfa_tally_sum(&d->statistics.robots[i].gateway[k], &sums);
    for (uint32_t i = 0; i < d->settings->workers * TFA_WORKER_CLIENTS_MAX; i++) {
        const tfa_shared_client *c = &d->statistics.clients[i];
        const uint32_t kind = (uint32_t)atomic_load_explicit(&c->served[0], memory_order_relaxed);
        if (kind != TFA_CLIENT_NONE && kind != TFA_CLIENT_SELF)
            tfa_tally_sum(&c->tally, &sums);
    }
    return sums;
}
