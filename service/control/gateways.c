/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * See gateways.h.
 */
#include "control/gateways.h"

#include <stdio.h>
#include <stdlib.h>

#include "control/daemon.h"
#include "dds/ros2/ros2.h"
#include "dds/topics/dds.h"
#include "platform/log.h"

static const struct gateway *const kinds[TFA_GATEWAY_SOURCES] = {
    [TFA_SOURCE_DDS] = &tfa_gateway_dds,
    [TFA_SOURCE_ROS2] = &tfa_gateway_ros2,
};

/* ---- the configuration ---- */

int gateways_check(const config *settings)
{
    int status = TFA_OK;
    for (int k = 0; k < TFA_GATEWAY_SOURCES && status == TFA_OK; k++)
        if (kinds[k]->check)
            status = kinds[k]->check(settings);
    return status;
}

static void log_refusal(const config *settings, size_t robot, const char *gateway,
                        const gateway_error *error)
{
    char path[128], at[256];
    snprintf(path, sizeof path, "robots[%zu].%s.%s", robot, gateway, error->path);
    config_location(settings, path, at, sizeof at);
    tfa_log(TFA_LOG_ERROR, "%s: %s: %s", at, path, error->text);
}

int gateways_check_robot(const config *settings, const config_robot *robot, const tfa_robot *served,
                         char *text, size_t size)
{
    gateway_error error;
    for (int k = 0; k < TFA_GATEWAY_SOURCES; k++) {
        const int status =
            kinds[k]->check_robot ? kinds[k]->check_robot(settings, robot, served, &error) : TFA_OK;
        if (status == TFA_OK)
            continue;
        log_refusal(settings, (size_t)(robot - settings->robots), kinds[k]->name, &error);
        if (text)
            snprintf(text, size, "%s: %.120s", error.path, error.text);
        return status;
    }
    return TFA_OK;
}

/* ---- what the gateways ask of each other and of the daemon: any thread ---- */

static void receive_description(void *daemon, size_t robot, const char *text)
{
    descriptions_receive(daemon, robot, text);
}

/* Where no gateway elects a leader there is no standby. */
static bool leads(void *daemon, uint32_t robot)
{
    const tfa_daemon *d = daemon;
    gateway_leadership l;
    for (const gateway_slot *g = d->gateways; g < d->gateways + TFA_GATEWAY_SOURCES; g++)
        if (g->self && g->kind->leadership && g->kind->leadership(g->self, robot, &l))
            return l.leads;
    return true;
}

/* ---- their life ---- */

int gateways_join(tfa_daemon *d)
{
    int status = gateways_check(d->settings);
    for (uint32_t k = 0; k < TFA_GATEWAY_SOURCES && status == TFA_OK; k++) {
        const gateway_context context = {.settings = d->settings,
                                         .robots = d->robot_set.robots,
                                         .robot_count = d->robot_set.count,
                                         .messages = &d->statistics.header->dds_messages,
                                         .statistics = d->statistics.robots,
                                         .states = statistics_gateway_states(d, kinds[k]->source),
                                         .self = d,
                                         .description = receive_description,
                                         .leads = leads};
        d->gateways[k].kind = kinds[k];
        status = kinds[k]->join(&context, &d->gateways[k].self);
    }
    return status;
}

static int start(tfa_daemon *d, gateway_slot *g)
{
    const uint32_t count = d->robot_set.count;
    tfa_worker_robot *solvers = calloc(count, sizeof *solvers);
    int status = solvers ? TFA_OK : TFA_E_MEMORY;
    for (uint32_t i = 0; i < count && status == TFA_OK; i++)
        if (g->kind->serves(g->self, i))
            status = daemon_make_solver(d, i, false, &g->solvers, &solvers[i]);
    if (status == TFA_OK)
        status = g->kind->start(g->self, d->workers[0].worker, solvers);
    free(solvers);
    return status;
}

int gateways_start(tfa_daemon *d)
{
    int status = TFA_OK;
    for (uint32_t k = 0; k < TFA_GATEWAY_SOURCES && status == TFA_OK; k++)
        if (d->gateways[k].self)
            status = start(d, &d->gateways[k]);
    statistics_update(d);
    return status;
}

void gateways_stop(tfa_daemon *d)
{
    for (uint32_t k = TFA_GATEWAY_SOURCES; k > 0; k--) {
        gateway_slot *g = &d->gateways[k - 1];
        if (g->self)
            g->kind->stop(g->self);
        g->self = NULL;
    }
}

const gateway_slot *gateways_of_robot(const tfa_daemon *d, uint32_t source, uint32_t robot)
{
    const gateway_slot *g = &d->gateways[source];
    return g->self && g->kind->serves(g->self, robot) ? g : NULL;
}

const gateway_slot *gateways_next(const tfa_daemon *d, uint32_t robot, const gateway_slot *last)
{
    const gateway_slot *found = NULL;
    for (long k = last ? last - d->gateways + 1 : 0; k < TFA_GATEWAY_SOURCES && !found; k++)
        found = gateways_of_robot(d, (uint32_t)k, robot);
    return found;
}
