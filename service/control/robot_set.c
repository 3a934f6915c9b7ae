/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The robots of the daemon and the workers that solve for them.
 */
#include "control/daemon.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "platform/log.h"
#include "platform/realtime.h"

/* ---- robots ---- */

/* A robot and its scenes, from the file or a text. @param robots  room for all of them */
static int load_robot(const config *settings, const config_robot *from, tfa_robot_urdf *urdf,
                      tfa_robot *robots)
{
    int status = tfa_robot_load(settings, from, urdf, robots);
    if (status != TFA_OK)
        return status;
    status =
        gateways_check_robot(settings, from, robots, urdf ? urdf->error : NULL, sizeof urdf->error);
    for (size_t i = tfa_robot_count(from); status != TFA_OK && i > 0; i--)
        tfa_robot_unload(&robots[i - 1]);
    return status;
}

static int load_robots_with_dds(const config *settings, char *const *descriptions, bool dds,
                                robot_set *f)
{
    for (size_t i = 0; i < settings->robots_count; i++) {
        const config_robot *from = &settings->robots[i];
        tfa_robot_urdf urdf = {.text = descriptions ? descriptions[i] : NULL};
        if (from->dds != dds)
            continue;
        int status = load_robot(settings, from, &urdf, &f->robots[f->count]);
        if (status != TFA_OK)
            return status;
        f->count += (uint32_t)tfa_robot_count(from);
    }
    return TFA_OK;
}

int robot_set_load(const config *settings, char *const *descriptions, robot_set *f)
{
    size_t count = 0;
    for (size_t i = 0; i < settings->robots_count; i++)
        count += tfa_robot_count(&settings->robots[i]);
    *f = (robot_set){.robots = calloc(count, sizeof *f->robots)};
    int status = f->robots ? load_robots_with_dds(settings, descriptions, true, f) : TFA_E_MEMORY;
    if (status == TFA_OK)
        status = load_robots_with_dds(settings, descriptions, false, f);
    if (status != TFA_OK)
        robot_set_unload(f);
    return status;
}

int robot_set_load_one(const config *settings, const robot_set *now, size_t robot,
                       tfa_robot_urdf *urdf, robot_set *f)
{
    const config_robot *from = &settings->robots[robot];
    uint32_t first = 0;
    *f = (robot_set){.robots = calloc(now->count, sizeof *f->robots)};
    if (!f->robots)
        return TFA_E_MEMORY;
    f->count = now->count;
    for (uint32_t i = 0; i < now->count; i++)
        f->robots[i].names = f->robots[i].description = TFA_SEGMENT_NONE;
    while (now->robots[first].config != from)
        first++;
    return load_robot(settings, from, urdf, &f->robots[first]);
}

void robot_set_unload(robot_set *f)
{
    for (uint32_t i = 0; i < f->count; i++)
        tfa_robot_unload(&f->robots[i]);
    free(f->robots);
    *f = (robot_set){0};
}

uint32_t robot_set_find(const robot_set *f, const char *name, char *text, size_t size)
{
    for (uint32_t i = 0; i < f->count; i++)
        if (strcmp(f->robots[i].name, name) == 0)
            return i;
    snprintf(text, size, "error: no robot '%s' is served here", name);
    return UINT32_MAX;
}

/* ---- the pool ---- */

/* Threads as wanted, or as they can be had. */
static int start_thread_pool(const config_pool *wanted, const int *cpus,
                             tfa_thread_pool **thread_pool)
{
    tfa_thread_pool_options options = {.threads = wanted->threads,
                                       .spin_ns = wanted->spin_ns,
                                       .cpus = wanted->affinity_count ? cpus : NULL,
                                       .priority = wanted->priority};
    int status = tfa_thread_pool_create(&options, thread_pool);
    if (status != TFA_E_SYSTEM || (!options.cpus && !options.priority))
        return status;
    tfa_log(TFA_LOG_WARNING,
            "pool: its threads stay with the ordinary scheduler, on any processor: %s; for the "
            "priority raise LimitRTPRIO or give CAP_SYS_NICE",
            strerror(errno));
    options.cpus = NULL;
    options.priority = 0;
    return tfa_thread_pool_create(&options, thread_pool);
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
    int status = start_thread_pool(wanted, cpus, &d->thread_pool);
    if (status == TFA_OK)
        tfa_log(TFA_LOG_INFO, "pool: %u threads with the worker's own, from %u bodies x states on",
                wanted->threads, wanted->from);
    return status;
}

int daemon_prepare_robots(tfa_daemon *d)
{
    int status = TFA_OK;
    for (uint32_t i = 0; i < d->robot_set.count && status == TFA_OK; i++)
        status = tfa_robot_prepare(&d->robot_set.robots[i], d->settings, d->thread_pool);
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

int daemon_make_solver(const tfa_daemon *d, uint32_t i, bool of_worker, tfa_robot_solver ***solvers,
                       tfa_worker_robot *made)
{
    const tfa_robot *robot = &d->robot_set.robots[i];
    if (!*solvers)
        *solvers = calloc(d->robot_set.count, sizeof **solvers);
    if (!*solvers)
        return TFA_E_MEMORY;
    const int status =
        tfa_robot_solver_create(robot, &d->settings->pool, of_worker, &(*solvers)[i]);
    if (status == TFA_OK)
        *made = tfa_robot_for_worker(robot, (*solvers)[i]);
    return status;
}

static int make_worker(tfa_daemon *d, daemon_worker *w)
{
    const tfa_worker_statistics statistics = statistics_of_worker(d, (uint32_t)(w - d->workers));
    const robot_set *f = &d->robot_set;
    tfa_worker_robot *robots = calloc(f->count, sizeof *robots);
    int status = robots ? TFA_OK : TFA_E_MEMORY;
    for (uint32_t i = 0; i < f->count && status == TFA_OK; i++)
        status = daemon_make_solver(d, i, true, &w->solvers, &robots[i]);
    if (status == TFA_OK) {
        const tfa_worker_options options = {
            .robots = robots,
            .robot_count = f->count,
            .spin_ns = d->settings->spin_ns,
            .wait = worker_wait(d->settings),
            .turn_ns = d->settings->turn_us * 1000,
            .warm_ns = d->settings->warm_us * 1000,
            .rest_ns = tfa_realtime_rest_ns(&d->settings->realtime, "/proc/sys/kernel"),
            .statistics = &statistics};
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

static void *run_long(void *worker)
{
    tfa_stack_prepare();
    tfa_worker_long_run(worker);
    return NULL;
}

static void name_thread(pthread_t thread, const char *kind, uint32_t number)
{
    char name[24];
    snprintf(name, sizeof name, "%s%u", kind, number);
    name[15] = 0; /* the kernel takes no more */
    pthread_setname_np(thread, name);
}

/* Where there is a pool, states that take longer than max_state_us are answered beside the worker,
 * by the ordinary scheduler. */
static int start_long_thread(const tfa_daemon *d, daemon_worker *w, uint32_t number)
{
    if (!d->settings->pool.threads)
        return TFA_OK;
    if (pthread_create(&w->long_thread, NULL, run_long, w->worker) != 0)
        return TFA_E_SYSTEM;
    w->has_long_thread = true;
    name_thread(w->long_thread, "long", number);
    return TFA_OK;
}

static int start_worker(tfa_daemon *d, uint32_t number)
{
    daemon_worker *w = &d->workers[number];
    int status = make_worker(d, w);
    if (status != TFA_OK)
        return status;
    if (pthread_create(&w->thread, NULL, run_worker, w->worker) != 0)
        return TFA_E_SYSTEM;
    w->started = true;
    name_thread(w->thread, "worker", number);
    tfa_realtime_worker(&d->settings->realtime, number, w->thread);
    return start_long_thread(d, w, number);
}

int daemon_start_workers(tfa_daemon *d)
{
    d->workers = calloc(d->settings->workers, sizeof *d->workers);
    if (!d->workers)
        return TFA_E_MEMORY;
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
    for (uint32_t i = 0; i < d->robot_set.count; i++)
        for (uint32_t k = 0; k < d->settings->workers; k++) {
            int status = tfa_robot_self_test(&d->robot_set.robots[i], d->workers[k].worker, i);
            if (status != TFA_OK) {
                tfa_log(TFA_LOG_ERROR, "self-test: robot '%s', worker %u: %s",
                        d->robot_set.robots[i].name, k, tfa_status_text(status));
                return status;
            }
        }
    return TFA_OK;
}

/* After the worker's own. */
static void stop_long_thread(daemon_worker *w)
{
    if (!w->has_long_thread)
        return;
    tfa_worker_long_stop(w->worker);
    pthread_join(w->long_thread, NULL);
    w->has_long_thread = false;
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
        stop_long_thread(&d->workers[i]);
    }
}

/* Those of all robots. NULL is allowed. */
static void free_solvers(const tfa_daemon *d, tfa_robot_solver **solvers)
{
    for (uint32_t i = 0; solvers && i < d->robot_set.count; i++)
        tfa_robot_solver_free(solvers[i]);
    free(solvers);
}

static void free_worker(const tfa_daemon *d, daemon_worker *w)
{
    tfa_worker_destroy(w->worker);
    free_solvers(d, w->solvers);
}

void daemon_free_robot_set(tfa_daemon *d)
{
    for (uint32_t i = 0; d->workers && i < d->settings->workers; i++)
        free_worker(d, &d->workers[i]);
    free(d->workers);
    for (int k = 0; k < TFA_GATEWAY_SOURCES; k++)
        free_solvers(d, d->gateways[k].solvers);
    robot_set_unload(&d->robot_set);
    tfa_thread_pool_free(d->thread_pool);
}
