/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A reload: other models while the daemon answers. Nothing here waits; the tick comes back.
 *
 *   SIGHUP, or a robot_description, which is about one robot
 *          -> LOADING   a thread makes everything that is new aside (reload_load.c)
 *          -> DRAINING  robots whose arrays or names change lose their clients, when their requests
 *                       is answered; new ones wait. All other robots skip this
 *          -> commit    new and old objects change places: one assignment each
 *          -> OFFERED   each worker takes the new solvers between two requests
 *          -> NONE      the old objects are released; the new ones, if something failed on the way
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "control/daemon.h"
#include "platform/log.h"

/* The end of the daemon waits this long for the thread of a reload. */
#define ABANDON_NS 100000000

/* A reload that a topic asks for is logged as what a client can cause. */
typedef void (*log_function)(tfa_log_level level, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

static log_function log_of(const tfa_daemon *d)
{
    return d->reload.of_topic ? tfa_log_client : tfa_log;
}

static void release_reload(const tfa_daemon *d, reload *r)
{
    for (uint32_t k = 0; r->solvers && k < d->settings->workers + TFA_GATEWAY_SOURCES; k++) {
        for (uint32_t i = 0; r->solvers[k] && i < d->robot_set.count; i++)
            tfa_robot_solver_free(r->solvers[k][i]);
        free(r->solvers[k]);
    }
    free(r->solvers);
    free(r->changed);
    free(r->shape_changed);
    robot_set_unload(&r->robot_set);
    tfa_admission_free(&r->admission);
    config_free(r->settings);
    free(r->description);
    *r = (reload){.event = r->event, .requested_again = r->requested_again};
}

/* The outcome of a robot_description. @param error  NULL: it is the model */
static void describe(const tfa_daemon *d, const char *error)
{
    const config_robot *robot = &d->settings->robots[d->reload.robot];
    for (uint32_t i = 0; i < d->robot_set.count; i++)
        for (const gateway_slot *g = NULL; (g = gateways_next(d, i, g));)
            if (d->robot_set.robots[i].config == robot && g->kind->report)
                g->kind->report(g->self, i, error);
}

static void begin_reload(tfa_daemon *d)
{
    reload *r = &d->reload;
    r->start = control_clock();
    r->phase = RELOAD_LOADING;
    if (r->of_topic)
        log_of(d)(TFA_LOG_INFO, "reload: robot '%s': a robot_description of %zu bytes",
                  d->settings->robots[r->robot].name, strlen(r->description));
    else
        tfa_log(TFA_LOG_INFO, "reload: reading '%s'", d->settings->file);
    notify_reloading();
    if (pthread_create(&r->thread, NULL, reload_thread, d) == 0)
        return;
    log_of(d)(TFA_LOG_ERROR, "reload: no thread could be started; everything stays as it was");
    if (r->of_topic)
        describe(d, "no thread could be started");
    free(r->description);
    r->description = NULL;
    r->phase = RELOAD_NONE;
    commands_reloaded(d, "error: no thread could be started; everything stays as it was");
    notify_ready();
}

/* All of it if that was asked for, else the next robot_description, if there is one. */
static void begin_next(tfa_daemon *d)
{
    reload *r = &d->reload;
    const bool all = r->requested_again;
    r->requested_again = false;
    r->description = all ? NULL : descriptions_take(d, &r->robot);
    r->of_topic = r->description != NULL;
    if (all || r->description)
        begin_reload(d);
}

/* @param text  for operators that wait */
static void finish_reload(tfa_daemon *d, const char *text)
{
    release_reload(d, &d->reload);
    if (!d->reload.requested_again)
        commands_reloaded(d, text);
    notify_ready();
    begin_next(d);
}

void reload_request(tfa_daemon *d)
{
    d->reload.requested_again = true;
    if (d->reload.phase == RELOAD_NONE)
        begin_next(d);
}

void reload_described(tfa_daemon *d)
{
    uint64_t count;
    (void)!read(d->descriptions.event, &count, sizeof count);
    if (d->reload.phase == RELOAD_NONE)
        begin_next(d);
}

bool reload_is_urgent(const tfa_daemon *d)
{
    return d->reload.phase == RELOAD_DRAINING || d->reload.phase == RELOAD_OFFERED;
}

/* ---- draining ---- */

static void start_draining(tfa_daemon *d)
{
    const reload *r = &d->reload;
    for (uint32_t i = 0; i < d->robot_set.count; i++) {
        if (!r->shape_changed[i])
            continue;
        if (r->of_topic)
            descriptions_rest(d, r->robot);
        log_of(d)(
            TFA_LOG_WARNING,
            "reload: robot '%s' has other joints, links or a base now: its clients are hung up "
            "on when their requests are answered%s",
            d->robot_set.robots[i].name,
            r->of_topic ? "; its next robot_description is taken after 5 s" : "");
        d->robot_set.robots[i].reshaping = true;
        session_drain(d, i);
    }
}

static bool all_detached(tfa_daemon *d)
{
    bool left = true;
    for (uint32_t i = 0; i < d->robot_set.count; i++) {
        if (!d->reload.shape_changed[i])
            continue;
        left = !session_any_attached(d, i) && left;
        for (const gateway_slot *g = NULL; (g = gateways_next(d, i, g));)
            left = (!g->kind->detach || g->kind->detach(g->self, i)) && left;
    }
    return left;
}

/* ---- the exchange ---- */

/* New and old change places; unchanged robots get their place in the new configuration. */
static void commit_robot(tfa_daemon *d, uint32_t i)
{
    tfa_robot *now = &d->robot_set.robots[i], *next = &d->reload.robot_set.robots[i];
    if (!d->reload.changed[i] && !d->reload.of_topic) {
        now->config = next->config;
        now->scene = next->scene;
        tfa_segment_destroy(&now->description); /* of the previous file */
    }
    if (!d->reload.changed[i])
        return;
    log_of(d)(TFA_LOG_INFO, "reload: robot '%s': model %.16s in place of %.16s", now->name,
              tfa_model_hash_text(next->model), tfa_model_hash_text(now->model));
    const tfa_robot old = *now;
    *now = *next;
    *next = old;
}

static void exchange(tfa_robot_solver **now, tfa_robot_solver **next)
{
    tfa_robot_solver *old = *now;
    *now = *next;
    *next = old;
}

/* The gateway answers by the new solvers when this returns. */
static void exchange_gateway_solvers(const tfa_daemon *d, uint32_t source)
{
    tfa_robot_solver **next = d->reload.solvers[d->settings->workers + source];
    for (uint32_t i = 0; i < d->robot_set.count; i++) {
        const gateway_slot *g = gateways_of_robot(d, source, i);
        if (!d->reload.changed[i] || !g)
            continue;
        const tfa_robot *robot = &d->robot_set.robots[i];
        const tfa_worker_robot solver = tfa_robot_for_worker(robot, next[i]);
        g->kind->exchange(g->self, i, robot->model, &solver);
        exchange(&g->solvers[i], &next[i]);
    }
}

static void offer_solvers(const tfa_daemon *d, uint32_t worker, tfa_worker_robot *robots)
{
    daemon_worker *w = &d->workers[worker];
    tfa_robot_solver **next = d->reload.solvers[worker];
    for (uint32_t i = 0; i < d->robot_set.count; i++) {
        if (d->reload.changed[i])
            exchange(&w->solvers[i], &next[i]);
        robots[i] = tfa_robot_for_worker(&d->robot_set.robots[i], w->solvers[i]);
    }
    tfa_worker_offer(w->worker, robots);
}

/* Those of the file, or the description of one robot. */
static void exchange_settings(tfa_daemon *d)
{
    reload *r = &d->reload;
    config *settings = d->settings;
    const tfa_admission admission = d->admission;
    if (r->of_topic) {
        char *before = d->descriptions.loaded[r->robot];
        d->descriptions.loaded[r->robot] = r->description;
        r->description = before;
        return;
    }
    d->settings = r->settings;
    d->admission = r->admission;
    r->settings = settings;
    r->admission = admission;
}

static void commit(tfa_daemon *d)
{
    reload *r = &d->reload;
    tfa_worker_robot *robots = calloc(d->robot_set.count, sizeof *robots);
    if (!robots)
        return; /* the next tick tries again */
    for (uint32_t i = 0; i < d->robot_set.count; i++)
        if (r->changed[i]) /* before the offer: no answer of the new solvers is recorded */
            recordings_end(d, i, "a reload gave the robot another model or other settings");
    for (uint32_t i = 0; i < d->robot_set.count; i++)
        commit_robot(d, i);
    exchange_settings(d);
    for (uint32_t k = 0; k < TFA_GATEWAY_SOURCES; k++)
        exchange_gateway_solvers(d, k);
    for (uint32_t k = 0; k < d->settings->workers; k++)
        offer_solvers(d, k, robots);
    free(robots);
    statistics_update(d);
    r->phase = RELOAD_OFFERED;
    session_resume_deferred(d);
}

static bool all_taken(const tfa_daemon *d)
{
    for (uint32_t k = 0; k < d->settings->workers; k++)
        if (!tfa_worker_offer_is_taken(d->workers[k].worker))
            return false;
    return true;
}

static void complete_reload(tfa_daemon *d)
{
    uint32_t changed = 0;
    for (uint32_t i = 0; i < d->robot_set.count; i++) {
        if (!d->reload.changed[i])
            continue;
        changed++;
        for (const gateway_slot *g = NULL; (g = gateways_next(d, i, g));)
            if (g->kind->announce)
                g->kind->announce(g->self, i, d->robot_set.robots[i].model);
    }
    char text[96];
    if (d->reload.of_topic)
        describe(d, NULL);
    if (changed)
        tfa_counter_add(&d->statistics.header->reloads, 1);
    snprintf(text, sizeof text, "ok: %u of %u models exchanged, %.1f ms", changed,
             d->robot_set.count, (double)(control_clock() - d->reload.start) * 1e-6);
    log_of(d)(TFA_LOG_INFO, "reload: done, %s", text + 4);
    finish_reload(d, text);
}

/* ---- events and time ---- */

/* Nothing more here: sessions may end, and this batch of events may hold some of theirs. */
void reload_event(tfa_daemon *d)
{
    uint64_t count;
    if (read(d->reload.event, &count, sizeof count) == (ssize_t)sizeof count)
        d->reload.loaded = true;
}

static void refuse(tfa_daemon *d)
{
    const reload *r = &d->reload;
    char text[sizeof r->reason + 64];
    const char *status = tfa_status_text(r->status);
    log_of(d)(TFA_LOG_ERROR, "reload: refused (%s), everything stays as it was", status);
    if (r->of_topic)
        describe(d, r->urdf.error[0] ? r->urdf.error : status);
    const int length =
        snprintf(text, sizeof text, "error: refused, everything stays as it was:\n%s",
                 *r->reason ? r->reason : status);
    if (text[length - 1] == '\n')
        text[length - 1] = 0;
    finish_reload(d, text);
}

static void finish_loading(tfa_daemon *d)
{
    reload *r = &d->reload;
    pthread_join(r->thread, NULL);
    r->loaded = false;
    if (r->status != TFA_OK) {
        refuse(d);
        return;
    }
    r->phase = RELOAD_DRAINING;
    start_draining(d);
}

void reload_tick(tfa_daemon *d)
{
    if (d->reload.phase == RELOAD_LOADING && d->reload.loaded)
        finish_loading(d);
    if (d->reload.phase == RELOAD_DRAINING && all_detached(d))
        commit(d);
    if (d->reload.phase == RELOAD_OFFERED && all_taken(d))
        complete_reload(d);
    if (d->reload.phase == RELOAD_NONE)
        begin_next(d); /* a description that rested */
}

bool reload_abandon(tfa_daemon *d)
{
    struct timespec end;
    clock_gettime(CLOCK_REALTIME, &end);
    end.tv_nsec += ABANDON_NS;
    end.tv_sec += end.tv_nsec / 1000000000;
    end.tv_nsec %= 1000000000;
    if (d->reload.phase == RELOAD_LOADING &&
        pthread_timedjoin_np(d->reload.thread, NULL, &end) != 0) {
        pthread_detach(d->reload.thread);
        return false;
    }
    if (d->reload.phase != RELOAD_NONE)
        release_reload(d, &d->reload);
    return true;
}
