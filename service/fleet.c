/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The robots of the daemon and the workers that solve for them.
 */
#include "daemon.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "log.h"
#include "realtime.h"

/* ---- robots ---- */

static int load_those(const config *settings, bool dds, fleet *f)
{
    for (size_t i = 0; i < settings->robots_count; i++) {
        const config_robot *from = &settings->robots[i];
        if (from->dds != dds)
            continue;
        int status = tfa_robot_load(settings, from, &f->robots[f->count]);
        if (status != TFA_OK)
            return status;
        f->count += (uint32_t)tfa_robot_count(from);
    }
    return TFA_OK;
}

int fleet_load(const config *settings, fleet *f)
{
    size_t count = 0;
    for (size_t i = 0; i < settings->robots_count; i++)
        count += tfa_robot_count(&settings->robots[i]);
    *f = (fleet){.robots = calloc(count, sizeof *f->robots)};
    int status = f->robots ? load_those(settings, true, f) : TFA_E_MEMORY;
    f->dds_count = f->count;
    if (status == TFA_OK)
        status = load_those(settings, false, f);
    if (status != TFA_OK)
        fleet_unload(f);
    return status;
}

void fleet_unload(fleet *f)
{
    for (uint32_t i = 0; i < f->count; i++)
        tfa_robot_unload(&f->robots[i]);
    free(f->robots);
    *f = (fleet){0};
}

/* ---- the pool ---- */

/* Threads as wanted, or as they can be had. */
static int start_team(const config_pool *wanted, const int *cpus, tfa_team **team)
{
    tfa_team_options options = {.threads = wanted->threads,
                                .spin_ns = wanted->spin_ns,
                                .cpus = wanted->affinity_count ? cpus : NULL,
                                .priority = wanted->priority};
    int status = tfa_team_create(&options, team);
    if (status != TFA_E_SYSTEM || (!options.cpus && !options.priority))
        return status;
    tfa_log(TFA_LOG_WARNING,
            "pool: its threads stay with the ordinary scheduler, on any processor: %s; for the "
            "priority raise LimitRTPRIO or give CAP_SYS_NICE",
            strerror(errno));
    options.cpus = NULL;
    options.priority = 0;
    return tfa_team_create(&options, team);
}

int daemon_start_pool(tfa_daemon *d)
{
    const config_pool *wanted = &d->settings->pool;
    int cpus[257] = {0}; /* the caller's, which is not changed, then those configured */
    if (!wanted->threads)
        return TFA_OK;
    for (uint32_t k = 1; k < wanted->threads; k++)
        cpus[k] = wanted->affinity_count
                      ? (int)wanted->affinity[(k - 1) % (uint32_t)wanted->affinity_count]
                      : 0;
    int status = start_team(wanted, cpus, &d->team);
    for (uint32_t i = 0; i < d->fleet.count && status == TFA_OK; i++)
        status = tfa_robot_open_pool(&d->fleet.robots[i], wanted, d->team);
    if (status == TFA_OK)
        tfa_log(TFA_LOG_INFO, "pool: %u threads with the worker's own, from %u bodies x states on",
                wanted->threads, wanted->from);
    return status;
}

/* ---- workers ---- */

/* The most eager wait mode that a robot is configured with. */
static tfa_wait worker_wait(const config *settings)
{
    tfa_wait wait = TFA_WAIT_BLOCK;
    for (size_t i = 0; i < settings->robots_count; i++)
        if (settings->robots[i].wait != TFA_WAIT_BLOCK)
            wait = TFA_WAIT_HYBRID; /* spins only while a client asks for it */
    return wait;
}

static int make_worker(tfa_daemon *d, daemon_worker *w)
{
    const fleet *f = &d->fleet;
    tfa_worker_robot *robots = calloc(f->count, sizeof *robots);
    w->solvers = calloc(f->count, sizeof *w->solvers);
    int status = robots && w->solvers ? TFA_OK : TFA_E_MEMORY;
    for (uint32_t i = 0; i < f->count && status == TFA_OK; i++) {
        status = tfa_robot_solver_create(&f->robots[i], &d->settings->pool, &w->solvers[i]);
        if (status == TFA_OK)
            robots[i] = tfa_robot_for_worker(&f->robots[i], w->solvers[i]);
    }
    if (status == TFA_OK)
        status = tfa_segment_create((config_backend)d->settings->backend, sizeof(tfa_ring_pulse),
                                    &w->pulse);
    if (status == TFA_OK) {
        const tfa_worker_options options = {.robots = robots,
                                            .robot_count = f->count,
                                            .spin_ns = d->settings->spin_ns,
                                            .wait = worker_wait(d->settings),
                                            .pulse = w->pulse.memory};
        status = tfa_worker_create(&options, &w->worker);
    }
    free(robots);
    return status;
}

static void *run_worker(void *worker)
{
    tfa_stack_prepare(); /* a rare question goes deeper than those before it */
    tfa_worker_run(worker);
    return NULL;
}

static int start_worker(tfa_daemon *d, uint32_t number)
{
    daemon_worker *w = &d->workers[number];
    char name[24];
    int status = make_worker(d, w);
    if (status != TFA_OK)
        return status;
    if (pthread_create(&w->thread, NULL, run_worker, w->worker) != 0)
        return TFA_E_SYSTEM;
    w->started = true;
    snprintf(name, sizeof name, "worker%u", number);
    name[15] = 0; /* the kernel takes no more */
    pthread_setname_np(w->thread, name);
    tfa_realtime_worker(&d->settings->realtime, number, w->thread);
    return TFA_OK;
}

int daemon_start_workers(tfa_daemon *d)
{
    d->workers = calloc(d->settings->workers, sizeof *d->workers);
    if (!d->workers)
        return TFA_E_MEMORY;
    for (uint32_t i = 0; i < d->settings->workers; i++)
        d->workers[i].pulse = TFA_SEGMENT_NONE;
    for (uint32_t i = 0; i < d->settings->workers; i++) {
        int status = start_worker(d, i);
        if (status != TFA_OK) {
            tfa_log(TFA_LOG_ERROR, "worker %u cannot start: %s", i, tfa_status_text(status));
            return status;
        }
    }
    return TFA_OK;
}

int daemon_self_test(tfa_daemon *d)
{
    for (uint32_t i = 0; i < d->fleet.count; i++)
        for (uint32_t k = 0; k < d->settings->workers; k++) {
            int status = tfa_robot_self_test(&d->fleet.robots[i], d->workers[k].worker, i);
            if (status != TFA_OK) {
                tfa_log(TFA_LOG_ERROR, "self-test: robot '%s', worker %u: %s",
                        d->fleet.robots[i].name, k, tfa_status_text(status));
                return status;
            }
        }
    return TFA_OK;
}

void daemon_stop_workers(tfa_daemon *d)
{
    for (uint32_t i = 0; d->workers && i < d->settings->workers; i++)
        if (d->workers[i].started)
            tfa_worker_stop(d->workers[i].worker);
    for (uint32_t i = 0; d->workers && i < d->settings->workers; i++) {
        if (d->workers[i].started)
            pthread_join(d->workers[i].thread, NULL);
        d->workers[i].started = false;
    }
}

static void free_worker(const tfa_daemon *d, daemon_worker *w)
{
    tfa_worker_destroy(w->worker);
    tfa_segment_destroy(&w->pulse);
    for (uint32_t i = 0; w->solvers && i < d->fleet.count; i++)
        tfa_robot_solver_free(w->solvers[i]);
    free(w->solvers);
}

void daemon_free_fleet(tfa_daemon *d)
{
    for (uint32_t i = 0; d->workers && i < d->settings->workers; i++)
        free_worker(d, &d->workers[i]);
    free(d->workers);
    fleet_unload(&d->fleet);
    tfa_team_free(d->team);
}
