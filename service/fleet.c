/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The robots of the daemon and the workers that solve for them.
 */
#include "daemon.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "log.h"
#include "realtime.h"

/* ---- robots ---- */

static int load_those(tfa_daemon *d, bool dds)
{
    for (size_t i = 0; i < d->settings->robots_count; i++) {
        const config_robot *from = &d->settings->robots[i];
        if (from->dds != dds)
            continue;
        tfa_robot *robot = &d->robots[d->robot_count];
        int status = tfa_robot_load(d->settings, from, robot);
        if (status != TFA_OK)
            return status;
        d->robot_count++;
        tfa_log(TFA_LOG_INFO, "robot '%s': %u joints, %u freedoms%s, model %.12s", from->name,
                tfa_model_joint_count(robot->model), robot->shape.v_count,
                robot->shape.base_freedoms ? " and a floating base" : "",
                tfa_model_hash_text(robot->model));
    }
    return TFA_OK;
}

int daemon_load_robots(tfa_daemon *d)
{
    d->robots = calloc(d->settings->robots_count, sizeof *d->robots);
    if (!d->robots)
        return TFA_E_MEMORY;
    int status = load_those(d, true);
    d->dds_count = d->robot_count;
    return status == TFA_OK ? load_those(d, false) : status;
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
    tfa_worker_robot *robots = calloc(d->robot_count, sizeof *robots);
    w->solvers = calloc(d->robot_count, sizeof *w->solvers);
    int status = robots && w->solvers ? TFA_OK : TFA_E_MEMORY;
    for (uint32_t i = 0; i < d->robot_count && status == TFA_OK; i++) {
        robots[i] = (tfa_worker_robot){
            .shape = d->robots[i].shape, .solve = tfa_robot_solve, .self = &w->solvers[i]};
        status = tfa_robot_solver_init(&d->robots[i], &w->solvers[i]);
    }
    if (status == TFA_OK)
        status = tfa_segment_create((config_backend)d->settings->backend, sizeof(tfa_ring_pulse),
                                    &w->pulse);
    if (status == TFA_OK) {
        const tfa_worker_options options = {.robots = robots,
                                            .robot_count = d->robot_count,
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
    for (uint32_t i = 0; i < d->robot_count; i++)
        for (uint32_t k = 0; k < d->settings->workers; k++) {
            int status = tfa_robot_self_test(&d->robots[i], d->workers[k].worker, i);
            if (status != TFA_OK) {
                tfa_log(TFA_LOG_ERROR, "self-test: robot '%s', worker %u: %s",
                        d->robots[i].config->name, k, tfa_status_text(status));
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
    for (uint32_t i = 0; w->solvers && i < d->robot_count; i++)
        tfa_robot_solver_free(&w->solvers[i]);
    free(w->solvers);
}

void daemon_free_fleet(tfa_daemon *d)
{
    for (uint32_t i = 0; d->workers && i < d->settings->workers; i++)
        free_worker(d, &d->workers[i]);
    free(d->workers);
    for (uint32_t i = 0; i < d->robot_count; i++)
        tfa_robot_unload(&d->robots[i]);
    free(d->robots);
}
