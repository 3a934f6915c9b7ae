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

#include <stdio.h>

#include "dds_gateway/dds_convert.h"
#include "dds_gateway/dds_domain.h"
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

/* ---- the configuration ---- */

/* The domain of the robot. @param common  that of section "ros2" or the environment */
static uint32_t domain_id(const config_robot *robot, uint32_t common)
{
    return robot->ros2.domain == CONFIG_ROS_DOMAIN_ID ? common : robot->ros2.domain;
}

static bool have_same_node(const config_robot *a, const config_robot *b, uint32_t common)
{
    return a->ros2.enabled && b->ros2.enabled && domain_id(a, common) == domain_id(b, common) &&
           tfa_ros2_same_node(&a->ros2, &b->ros2);
}

static int check_nodes(const config *settings, uint32_t common)
{
    char path[64], at[256];
    for (size_t i = 0; i < settings->robots_count; i++)
        for (size_t k = 0; k < i; k++) {
            const config_robot *robot = &settings->robots[i], *other = &settings->robots[k];
            if (!have_same_node(robot, other, common))
                continue;
            snprintf(path, sizeof path, "robots[%zu].ros2", i);
            config_location(settings, path, at, sizeof at);
            tfa_log(TFA_LOG_ERROR,
                    "%s: %s: namespace and node are those of robot '%s', whose answers would be on "
                    "the same topics; give it a namespace of its own",
                    at, path, other->name);
            return TFA_E_ARGUMENT;
        }
    return TFA_OK;
}

/* Domain and settings of ROS 2; free `xml`. */
static int find_settings(const config *settings, uint32_t *common, char **xml)
{
    char error[200];
    *xml = NULL;
    if (!settings->ros2.enabled)
        return TFA_OK;
    const int status = tfa_ros2_domain(&settings->ros2, common, xml, error, sizeof error);
    if (status == TFA_E_ARGUMENT)
        tfa_log(TFA_LOG_ERROR, "ros2: %s", error);
    return status == TFA_OK ? check_nodes(settings, *common) : status;
}

int gateways_check(const config *settings)
{
    uint32_t common = 0;
    char *xml;
    const int status = find_settings(settings, &common, &xml);
    free(xml);
    return status;
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

static void dds_set_tap(void *dds, uint32_t robot, struct tfa_tap *tap)
{
    tfa_dds_set_tap(dds, robot, tap);
}

static int dds_announce(void *dds, uint32_t robot, const tfa_model *model)
{
    return tfa_dds_announce(dds, robot, model);
}

static tfa_dds_leadership dds_leadership(void *dds, uint32_t robot)
{
    return tfa_dds_get_leadership(dds, robot);
}

/* The domain of a robot of the set, and its number there; NULL: it has no topics of ROS 2. */
static const ros2_domain *find_domain(const gateways *g, uint32_t robot, uint32_t *number)
{
    for (uint32_t i = 0; i < g->ros2_count; i++)
        for (uint32_t k = 0; k < g->ros2[i].count; k++)
            if (g->ros2[i].robots[k] == robot) {
                *number = k;
                return &g->ros2[i];
            }
    return NULL;
}

static int ros2_exchange(void *self, uint32_t robot, const tfa_model *next,
                         const tfa_worker_robot *solver)
{
    uint32_t number;
    const ros2_domain *domain = find_domain(self, robot, &number);
    return domain ? tfa_ros2_exchange(domain->gateway, number, next, solver) : TFA_OK;
}

static bool ros2_set_tap(void *self, uint32_t robot, struct tfa_tap *tap)
{
    uint32_t number;
    const ros2_domain *domain = find_domain(self, robot, &number);
    if (domain)
        tfa_ros2_set_tap(domain->gateway, number, tap);
    return domain != NULL;
}

static void ros2_describe(void *self, uint32_t robot, const char *error)
{
    uint32_t number;
    const ros2_domain *domain = find_domain(self, robot, &number);
    if (domain)
        tfa_ros2_describe(domain->gateway, number, error);
}

/* ---- what a ROS 2 gateway asks ---- */

static void receive_description(void *self, uint32_t robot, const char *text)
{
    const ros2_domain *domain = self;
    descriptions_receive(domain->all->daemon, domain->config[robot], text);
}

/* Without DDS topics of its own there is no standby. */
static bool leads(void *self, uint32_t robot)
{
    const ros2_domain *domain = self;
    const gateways *g = domain->all;
    const uint32_t number = domain->robots[robot];
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
                                     .notice = log_leadership,
                                     .messages = &g->daemon->statistics.header->dds_messages,
                                     .statistics = g->daemon->statistics.robots,
                                     .states =
                                         statistics_gateway_states(g->daemon, TFA_SOURCE_DDS)};
    const int status = tfa_dds_create(&options, &g->dds);
    if (status != TFA_OK) {
        tfa_log(TFA_LOG_ERROR, "dds: domain %u: %s", settings->dds.domain, tfa_dds_error());
        errno = 0; /* some library's */
    }
    g->dds_count = count;
    free(robots);
    return status;
}

/* The domain with this id; a new one if there is none. */
static ros2_domain *domain_of(gateways *g, uint32_t id)
{
    const uint32_t robots = g->daemon->robot_set.count;
    uint32_t i = 0;
    while (i < g->ros2_count && g->ros2[i].id != id)
        i++;
    if (i < g->ros2_count)
        return &g->ros2[i];
    ros2_domain *made = &g->ros2[g->ros2_count++];
    *made = (ros2_domain){.all = g, .id = id};
    made->robots = calloc(robots, sizeof *made->robots);
    made->config = calloc(robots, sizeof *made->config);
    return made->robots && made->config ? made : NULL;
}

/* Robots with topics of ROS 2 by domain; a scene has none. */
static int find_ros2_robots(gateways *g, uint32_t common)
{
    const robot_set *f = &g->daemon->robot_set;
    g->ros2 = calloc(f->count, sizeof *g->ros2);
    if (!g->ros2)
        return TFA_E_MEMORY;
    for (uint32_t i = 0; i < f->count; i++) {
        const tfa_robot *robot = &f->robots[i];
        if (robot->scene || !robot->config->ros2.enabled)
            continue;
        ros2_domain *domain = domain_of(g, domain_id(robot->config, common));
        if (!domain)
            return TFA_E_MEMORY;
        domain->config[domain->count] = (size_t)(robot->config - g->daemon->settings->robots);
        domain->robots[domain->count++] = i;
    }
    return TFA_OK;
}

static int join_ros2(gateways *g, ros2_domain *domain, const char *xml)
{
    const robot_set *f = &g->daemon->robot_set;
    tfa_ros2_robot *robots = calloc(domain->count, sizeof *robots);
    if (!robots)
        return TFA_E_MEMORY;
    for (uint32_t k = 0; k < domain->count; k++) {
        const tfa_robot *robot = &f->robots[domain->robots[k]];
        robots[k] = (tfa_ros2_robot){
            robot->name, robot->config, robot->model,
            &g->daemon->statistics.robots[domain->robots[k]],
            &statistics_gateway_states(g->daemon, TFA_SOURCE_ROS2)[domain->robots[k]]};
        g->daemon->ros2_domains[domain->robots[k]] = domain->id + 1;
    }
    const tfa_ros2_options options = {.domain = domain->id,
                                      .settings = xml,
                                      .robots = robots,
                                      .robot_count = domain->count,
                                      .self = domain,
                                      .description = receive_description,
                                      .leads = leads};
    const int status = tfa_ros2_create(&options, &domain->gateway);
    if (status != TFA_OK) {
        tfa_log(TFA_LOG_ERROR, "ros2: domain %u: %s", domain->id, tfa_ros2_error());
        errno = 0; /* some library's */
    }
    free(robots);
    return status;
}

/* A domain that both kinds share has one set of settings: the DDS gateway makes it. */
static int join_all(gateways *g, bool dds, const char *xml)
{
    const uint32_t dds_domain = g->daemon->settings->dds.domain;
    bool shared = false;
    for (uint32_t i = 0; dds && i < g->ros2_count; i++)
        shared = shared || g->ros2[i].id == dds_domain;
    int status = dds ? join_dds(g, shared ? xml : NULL, shared ? TFA_ROS2_SAMPLE_MAX : 0) : TFA_OK;
    for (uint32_t i = 0; i < g->ros2_count && status == TFA_OK; i++)
        status = join_ros2(g, &g->ros2[i], dds && g->ros2[i].id == dds_domain ? NULL : xml);
    return status;
}

int gateways_join(gateways *g)
{
    const config *settings = g->daemon->settings;
    uint32_t common = 0;
    char *xml;
    int status = find_settings(settings, &common, &xml);
    tfa_dds_log_to(log_cyclone);
    if (status == TFA_OK && settings->ros2.enabled)
        status = find_ros2_robots(g, common);
    if (status == TFA_OK)
        status = join_all(g, settings->dds.enabled && g->daemon->robot_set.dds_count > 0, xml);
    free(xml);
    return status;
}

/* ---- opening ---- */

static int open_dds(gateways *g)
{
    tfa_daemon *d = g->daemon;
    tfa_worker_robot *solvers = calloc(d->robot_set.dds_count, sizeof *solvers);
    int status = solvers ? daemon_make_gateway_solvers(d, solvers) : TFA_E_MEMORY;
    d->gateway =
        (dds_gateway){g->dds, dds_expect, dds_detach, dds_announce, dds_leadership, dds_set_tap};
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

static int open_ros2(gateways *g, const ros2_domain *domain)
{
    tfa_worker_robot *solvers = calloc(domain->count, sizeof *solvers);
    int status = solvers
                     ? daemon_make_ros2_solvers(g->daemon, domain->robots, domain->count, solvers)
                     : TFA_E_MEMORY;
    if (status == TFA_OK)
        status = tfa_ros2_start(domain->gateway, solvers);
    if (status == TFA_E_SYSTEM)
        tfa_log(TFA_LOG_ERROR, "ros2: %s", tfa_ros2_error());
    free(solvers);
    if (status == TFA_OK)
        tfa_log(TFA_LOG_INFO, "ros2: domain %u, %u robots, diagnostics on /diagnostics", domain->id,
                domain->count);
    return status;
}

static int open_all_ros2(gateways *g)
{
    tfa_daemon *d = g->daemon;
    int status = descriptions_open(d);
    if (status == TFA_OK)
        status = control_watch_descriptions(d);
    d->ros2 = (ros2_gateway){g, ros2_exchange, ros2_describe, ros2_set_tap};
    for (uint32_t i = 0; i < g->ros2_count && status == TFA_OK; i++)
        status = open_ros2(g, &g->ros2[i]);
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
    if (status == TFA_OK && g->ros2_count)
        status = open_all_ros2(g);
    else if (status == TFA_OK)
        tfa_log(settings->ros2.enabled ? TFA_LOG_WARNING : TFA_LOG_INFO, "ros2: off: %s",
                settings->ros2.enabled ? "no robot has 'ros2: {enabled: yes}'"
                                       : "ros2.enabled is not set");
    statistics_update(g->daemon);
    return status;
}

void gateways_stop(gateways *g)
{
    for (; g->ros2_count; g->ros2_count--) {
        ros2_domain *last = &g->ros2[g->ros2_count - 1];
        tfa_ros2_stop(last->gateway);
        free(last->robots);
        free(last->config);
    }
    free(g->ros2);
    g->ros2 = NULL;
    g->daemon->ros2 = (ros2_gateway){0};
    tfa_dds_stop(g->dds);
    g->dds = NULL;
    g->daemon->gateway = (dds_gateway){0};
    tfa_dds_log_to(NULL);
}

#else

int gateways_check(const config *settings)
{
    if (!settings->dds.enabled && !settings->ros2.enabled)
        return TFA_OK;
    tfa_log(TFA_LOG_ERROR, "%s.enabled: this totalforced was built without DDS",
            settings->dds.enabled ? "dds" : "ros2");
    return TFA_E_UNSUPPORTED;
}

int gateways_join(gateways *g)
{
    return gateways_check(g->daemon->settings);
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
