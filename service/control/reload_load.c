/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The part of a reload in a thread of its own: configuration, models, checks, workspaces.
 *
 * Reading a large robot takes seconds, during which the control thread continues to greet clients,
 * to notice dead clients and to feed the watchdog.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>
#include <sys/resource.h>
#include <unistd.h>

#include "control/daemon.h"
#include "platform/log.h"

static int read_settings(const tfa_daemon *d, reload *r)
{
    char *errors = NULL, text[512];
    size_t size = 0;
    FILE *stream = open_memstream(&errors, &size);
    if (!stream)
        return TFA_E_MEMORY;
    int status = config_load(d->settings->file, stream, &r->settings);
    fclose(stream);
    for (char *rest = errors, *line; rest && (line = strsep(&rest, "\n"));)
        if (*line)
            tfa_log(TFA_LOG_ERROR, "%s", line);
    free(errors);
    if (status == TFA_OK && config_needs_restart(d->settings, r->settings, text, sizeof text)) {
        tfa_log(TFA_LOG_ERROR, "%s: that needs a restart", text);
        status = TFA_E_UNSUPPORTED;
    }
    return status;
}

static bool same_solver(const config_robot *a, const config_robot *b)
{
    return a->estimate == b->estimate && a->estimate_every == b->estimate_every &&
           a->precision == b->precision && a->residual == b->residual && a->methods == b->methods &&
           config_refusals(a) == config_refusals(b);
}

static bool same_model(const tfa_robot *a, const tfa_robot *b)
{
    return memcmp(tfa_model_hash(a->model), tfa_model_hash(b->model), 32) == 0;
}

static const config *settings_in_effect(const tfa_daemon *d)
{
    return d->reload.settings ? d->reload.settings : d->settings;
}

/* Names and their order are those of now: config_needs_restart. */
static int compare(const tfa_daemon *d, reload *r)
{
    const uint32_t count = d->robot_set.count;
    r->changed = calloc(count, sizeof *r->changed);
    r->shape_changed = calloc(count, sizeof *r->shape_changed);
    if (!r->changed || !r->shape_changed)
        return TFA_E_MEMORY;
    for (uint32_t i = 0; i < count; i++) {
        const tfa_robot *now = &d->robot_set.robots[i], *next = &r->robot_set.robots[i];
        if (!next->model)
            continue; /* another robot has a new description */
        r->changed[i] =
            !same_model(now, next) || now->max_state_us != settings_in_effect(d)->max_state_us ||
            !same_solver(now->config, next->config) || !tfa_robot_same_kernel(now, next);
        r->shape_changed[i] = r->changed[i] && !tfa_robot_same_shape(now, next);
    }
    return TFA_OK;
}

static int prepare(const tfa_daemon *d, reload *r)
{
    int status = TFA_OK;
    for (uint32_t i = 0; i < d->robot_set.count && status == TFA_OK; i++)
        if (r->changed[i])
            status =
                tfa_robot_prepare(&r->robot_set.robots[i], settings_in_effect(d), d->thread_pool);
    return status;
}

/* The k-th table of solvers in use, by robot, in the order of reload.solvers; NULL: none. */
static tfa_robot_solver *const *solvers_in_use(const tfa_daemon *d, uint32_t k)
{
    const uint32_t workers = d->settings->workers;
    if (k < workers)
        return d->workers[k].solvers;
    return d->gateways[k - workers].solvers;
}

static int make_solvers(const tfa_daemon *d, reload *r)
{
    const uint32_t rows = d->settings->workers + TFA_GATEWAY_SOURCES, count = d->robot_set.count;
    r->solvers = calloc(rows, sizeof *r->solvers);
    if (!r->solvers)
        return TFA_E_MEMORY;
    for (uint32_t k = 0; k < rows; k++) {
        r->solvers[k] = calloc(count, sizeof **r->solvers);
        if (!r->solvers[k])
            return TFA_E_MEMORY;
        tfa_robot_solver *const *now = solvers_in_use(d, k);
        for (uint32_t i = 0; i < count; i++) {
            int status =
                r->changed[i] && now && now[i]
                    ? tfa_robot_solver_create(&r->robot_set.robots[i], &settings_in_effect(d)->pool,
                                              k < d->settings->workers, &r->solvers[k][i])
                    : TFA_OK;
            if (status != TFA_OK)
                return status;
        }
    }
    return TFA_OK;
}

/* Configuration and robots of the files, and of descriptions that took their place. */
static int load_files(const tfa_daemon *d, reload *r)
{
    int status = read_settings(d, r);
    if (status == TFA_OK)
        status = tfa_admission_load(r->settings, &r->admission);
    return status == TFA_OK ? robot_set_load(r->settings, d->descriptions.loaded, &r->robot_set)
                            : status;
}

static int load_description(const tfa_daemon *d, reload *r)
{
    r->urdf.text = r->description;
    return robot_set_load_one(d->settings, &d->robot_set, r->robot, &r->urdf, &r->robot_set);
}

/* Where all cores spin, this thread gets a tenth of one, not a half: `test_reload 200 spin`
 * shows the difference. */
#define NICE 10

void *reload_thread(void *argument)
{
    tfa_daemon *d = argument;
    reload *r = &d->reload;
    const uint64_t one = 1;
    (void)setpriority(PRIO_PROCESS, 0, NICE); /* on Linux: of this thread */
    tfa_log_copy_errors(r->reason, sizeof r->reason);
    if (r->description)
        tfa_log_limit_thread(); /* whoever is in the domain may publish one, and another */
    int status = r->description ? load_description(d, r) : load_files(d, r);
    if (status == TFA_OK)
        status = compare(d, r);
    if (status == TFA_OK)
        status = prepare(d, r);
    if (status == TFA_OK)
        status = make_solvers(d, r);
    r->status = status;
    (void)!write(r->event, &one, sizeof one); /* an eventfd that holds 0 takes it */
    return NULL;
}
