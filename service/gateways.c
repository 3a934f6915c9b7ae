/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * See gateways.h.
 */
#include "gateways.h"

#include <errno.h>
#include <stdlib.h>

#include "platform/log.h"

#ifdef TFA_HAVE_DDS

#include "dds_gateway/dds_convert.h"
#include "ros2/domain.h"
#include "ros2/ros2.h"

static void log_cyclone(const char *text)
{
    tfa_log_client(TFA_LOG_WARNING, "dds: %s", text);
}

static void log_leadership(bool warning, const char *text)
{
    tfa_log(warning ? TFA_LOG_WARNING : TFA_LOG_INFO, "dds: %s", text);
}

/* ---- what the reload sees of them ---- */

static void dds_expect(void *dds, uint32_t robot, const tfa_model *next,
                       const tfa_worker_robot *solver)
{
    tfa_dds_expect(dds, robot, next, solver);
}

static bool dds_detach(void *dds, uint32_t robot)
{
    return tfa_dds_detach(dds, robot);
}

static int dds_announce(void *dds, uint32_t robot, const tfa_model *model)
{
    return tfa_dds_announce(dds, robot, model);
}

static tfa_dds_counters dds_count(const void *dds)
{
    return tfa_dds_count(dds);
}

static tfa_dds_leadership dds_leadership(void *dds, uint32_t robot)
{
    return tfa_dds_get_leadership(dds, robot);
}

/* Number of a robot of the set in the ROS 2 gateway; its count if it is not there. */
static uint32_t ros2_number(const gateways *g, uint32_t robot)
{
    uint32_t k = 0;
    while (k < g->ros2_count && g->ros2_robots[k] != robot)
        k++;
    return k;
}

static int ros2_exchange(void *self, uint32_t robot, const tfa_model *next,
                         const tfa_worker_robot *solver)
{
    const gateways *g = self;
    return tfa_ros2_exchange(g->ros2, ros2_number(g, robot), next, solver);
}

static void ros2_describe(void *self, uint32_t robot, const char *error)
{
    const gateways *g = self;
    tfa_ros2_describe(g->ros2, ros2_number(g, robot), error);
}

/* ---- what the ROS 2 gateway asks ---- */

static void receive_description(void *self, uint32_t robot, const char *text)
{
    const gateways *g = self;
    descriptions_receive(g->daemon, g->ros2_config[robot], text);
}

/* Without DDS topics of its own there is no standby. */
static bool leads(void *self, uint32_t robot)
{
    const gateways *g = self;
    const uint32_t number = g->ros2_robots[robot];
    return !g->dds || number >= g->dds_count || tfa_dds_leads(g->dds, number);
}

/* ---- joining ---- */

static int join_dds(gateways *g, const char *xml, size_t sample_bytes)
{
    const config *settings = g->daemon->settings;
    const robot_set *f = &g->daemon->robot_set;
    const uint32_t count = f->dds_count;
    tfa_dds_robot *robots = calloc(count, sizeof *robots);
    if (!robots)
        return TFA_E_MEMORY;
    for (uint32_t i = 0; i < count; i++)
        robots[i] = (tfa_dds_robot){.name = f->robots[i].name,
                                    .model = f->robots[i].model,
                                    .max_batch = f->robots[i].shape.max_batch,
                                    .max_tips = f->robots[i].shape.max_tips};
    const tfa_dds_options options = {.domain = settings->dds.domain,
                                     .settings = xml,
                                     .sample_bytes = sample_bytes,
                                     .robots = robots,
                                     .robot_count = count,
                                     .max_age_us = 1000 * settings->dds.max_age_ms,
                                     .priority = settings->dds.priority,
                                     .lease_ms = settings->dds.lease_ms,
                                     .log = log_cyclone,
                                     .notice = log_leadership};
    const int status = tfa_dds_create(&options, &g->dds);
    if (status != TFA_OK) {
        tfa_log(TFA_LOG_ERROR, "dds: domain %u: %s", settings->dds.domain, tfa_dds_error());
        errno = 0; /* some library's */
    }
    g->dds_count = count;
    free(robots);
    return status;
}

/* Robots with topics of ROS 2; a scene has none. */
static int find_ros2_robots(gateways *g)
{
    const robot_set *f = &g->daemon->robot_set;
    g->ros2_robots = calloc(f->count, sizeof *g->ros2_robots);
    g->ros2_config = calloc(f->count, sizeof *g->ros2_config);
    if (!g->ros2_robots || !g->ros2_config)
        return TFA_E_MEMORY;
    for (uint32_t i = 0; i < f->count; i++) {
        const tfa_robot *robot = &f->robots[i];
        if (robot->scene || !robot->config->ros2.enabled)
            continue;
        g->ros2_robots[g->ros2_count] = i;
        g->ros2_config[g->ros2_count++] = (size_t)(robot->config - g->daemon->settings->robots);
    }
    return TFA_OK;
}

static int join_ros2(gateways *g, uint32_t domain, const char *xml)
{
    const robot_set *f = &g->daemon->robot_set;
    tfa_ros2_robot *robots = calloc(g->ros2_count, sizeof *robots);
    if (!robots)
        return TFA_E_MEMORY;
    for (uint32_t k = 0; k < g->ros2_count; k++) {
        const tfa_robot *robot = &f->robots[g->ros2_robots[k]];
        robots[k] = (tfa_ros2_robot){robot->name, robot->config, robot->model};
    }
    const tfa_ros2_options options = {.domain = domain,
                                      .settings = xml,
                                      .robots = robots,
                                      .robot_count = g->ros2_count,
                                      .self = g,
                                      .description = receive_description,
                                      .leads = leads,
                                      .log = g->dds ? NULL : log_cyclone};
    const int status = tfa_ros2_create(&options, &g->ros2);
    if (status != TFA_OK) {
        tfa_log(TFA_LOG_ERROR, "ros2: domain %u: %s", domain, tfa_ros2_error());
        errno = 0; /* some library's */
    }
    g->ros2_domain = domain;
    free(robots);
    return status;
}

/* A domain that both share has one set of settings: the DDS gateway makes it. */
static int join_both(gateways *g, bool dds, bool ros2)
{
    const config *settings = g->daemon->settings;
    char *xml = NULL, error[200];
    uint32_t domain = 0;
    int status = TFA_OK;
    if (ros2) {
        status = tfa_ros2_domain(&settings->ros2, &domain, &xml, error, sizeof error);
        if (status == TFA_E_VALUE)
            tfa_log(TFA_LOG_ERROR, "ros2: %s", error);
    }
    const bool shared = dds && ros2 && domain == settings->dds.domain;
    if (status == TFA_OK && dds)
        status = join_dds(g, shared ? xml : NULL, shared ? TFA_ROS2_SAMPLE_MAX : 0);
    if (status == TFA_OK && ros2)
        status = join_ros2(g, domain, shared ? NULL : xml);
    free(xml);
    return status;
}

int gateways_join(gateways *g)
{
    const config *settings = g->daemon->settings;
    const int status = find_ros2_robots(g);
    if (status != TFA_OK)
        return status;
    return join_both(g, settings->dds.enabled && g->daemon->robot_set.dds_count > 0,
                     settings->ros2.enabled && g->ros2_count > 0);
}

/* ---- opening ---- */

static int open_dds(gateways *g)
{
    tfa_daemon *d = g->daemon;
    tfa_worker_robot *solvers = calloc(d->robot_set.dds_count, sizeof *solvers);
    int status = solvers ? daemon_make_gateway_solvers(d, solvers) : TFA_E_MEMORY;
    d->gateway =
        (dds_gateway){g->dds, dds_expect, dds_detach, dds_announce, dds_count, dds_leadership};
    if (status == TFA_OK)
        status = tfa_dds_start(g->dds, d->workers[0].worker, solvers);
    free(solvers);
    if (status == TFA_OK)
        tfa_log(TFA_LOG_INFO,
                "dds: domain %u, %u robots: %s and %s, stream %s and %s, described by %s",
                d->settings->dds.domain, d->robot_set.dds_count, TFA_DDS_TOPIC_REQUEST,
                TFA_DDS_TOPIC_REPLY, TFA_DDS_TOPIC_TORQUES, TFA_DDS_TOPIC_ACCELERATIONS,
                TFA_DDS_TOPIC_ROBOT_INFO);
    return status;
}

static int open_ros2(gateways *g)
{
    tfa_daemon *d = g->daemon;
    tfa_worker_robot *solvers = calloc(g->ros2_count, sizeof *solvers);
    int status = solvers ? daemon_make_ros2_solvers(d, g->ros2_robots, g->ros2_count, solvers)
                         : TFA_E_MEMORY;
    if (status == TFA_OK)
        status = descriptions_open(d);
    if (status == TFA_OK)
        status = control_watch_descriptions(d);
    d->ros2 = (ros2_gateway){g, ros2_exchange, ros2_describe};
    if (status == TFA_OK)
        status = tfa_ros2_start(g->ros2, solvers);
    if (status == TFA_E_SYSTEM)
        tfa_log(TFA_LOG_ERROR, "ros2: %s", tfa_ros2_error());
    free(solvers);
    if (status == TFA_OK)
        tfa_log(TFA_LOG_INFO, "ros2: domain %u, %u robots, diagnostics on /diagnostics",
                g->ros2_domain, g->ros2_count);
    return status;
}

int gateways_open(gateways *g)
{
    const config *settings = g->daemon->settings;
    int status = TFA_OK;
    if (g->dds)
        status = open_dds(g);
    else
        tfa_log(TFA_LOG_INFO, "dds: off: %s",
                settings->dds.enabled ? "no robot has it" : "dds.enabled is not set");
    if (status == TFA_OK && g->ros2)
        status = open_ros2(g);
    else if (settings->ros2.enabled && !g->ros2)
        tfa_log(TFA_LOG_WARNING, "ros2: off: no robot has 'ros2: {enabled: yes}'");
    return status;
}

void gateways_stop(gateways *g)
{
    tfa_ros2_stop(g->ros2);
    g->ros2 = NULL;
    g->daemon->ros2 = (ros2_gateway){0};
    tfa_dds_stop(g->dds);
    g->dds = NULL;
    g->daemon->gateway = (dds_gateway){0};
    free(g->ros2_robots);
    free(g->ros2_config);
    g->ros2_robots = NULL;
    g->ros2_config = NULL;
}

#else

int gateways_join(gateways *g)
{
    const config *settings = g->daemon->settings;
    if (!settings->dds.enabled && !settings->ros2.enabled)
        return TFA_OK;
    tfa_log(TFA_LOG_ERROR, "%s.enabled: this totalforced was built without DDS",
            settings->dds.enabled ? "dds" : "ros2");
    return TFA_E_UNSUPPORTED;
}

int gateways_open(gateways *g)
{
    (void)g;
    return TFA_OK;
}

void gateways_stop(gateways *g)
{
    (void)g;
}

#endif
