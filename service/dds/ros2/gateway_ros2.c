/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The ROS 2 gateway as the daemon sees it: its robots by domain.
 */
#include "dds/ros2/ros2_internal.h"

#include "dds/common/ros_domain.h"
#include "platform/log.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct ros2_domains {
    uint32_t count;
    tfa_ros2 *domain[]; /* room for one of each robot */
} ros2_domains;

/* ---- the configuration ---- */

static bool have_same_node(const config_robot *a, const config_robot *b, uint32_t common)
{
    return a->ros2.enabled && b->ros2.enabled &&
           tfa_ros2_domain_of(a, common) == tfa_ros2_domain_of(b, common) &&
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

static int check(const config *settings)
{
    char error[200], *xml;
    uint32_t common = 0;
    if (!settings->ros2.enabled)
        return TFA_OK;
    const int status = tfa_ros2_domain(&settings->ros2, &common, &xml, error, sizeof error);
    if (status == TFA_E_ARGUMENT)
        tfa_log(TFA_LOG_ERROR, "ros2: %s", error);
    if (settings->ros2.discovery == CONFIG_DISCOVERY_ENVIRONMENT && tfa_ros2_is_local_only())
        tfa_log(TFA_LOG_INFO, "ros2: ROS_LOCALHOST_ONLY=1: discovery range LOCALHOST, whatever "
                              "ROS_AUTOMATIC_DISCOVERY_RANGE says");
    free(xml);
    return status == TFA_OK ? check_nodes(settings, common) : status;
}

/* ---- join and stop ---- */

static void stop(void *self)
{
    ros2_domains *all = self;
    while (all->count)
        tfa_ros2_stop(all->domain[--all->count]);
    free(all);
}

static bool is_joined(const ros2_domains *all, uint32_t domain)
{
    uint32_t i = 0;
    while (i < all->count && all->domain[i]->id != domain)
        i++;
    return i < all->count;
}

/* @param xml  unless the DDS gateway has joined: it made the domain */
static int join_domain(const gateway_context *c, uint32_t domain, uint32_t common, const char *xml,
                       ros2_domains *all)
{
    const config *settings = c->settings;
    const bool made = settings->dds.enabled && c->robots[0].config->dds;
    const tfa_ros2_options options = {.context = c,
                                      .domain = domain,
                                      .common = common,
                                      .settings =
                                          made && domain == settings->dds.domain ? NULL : xml};
    const int status = tfa_ros2_create(&options, &all->domain[all->count]);
    if (status != TFA_OK) {
        tfa_log(TFA_LOG_ERROR, "ros2: domain %u: %s", domain, tfa_dds_error());
        errno = 0; /* some library's */
        return status;
    }
    all->count++;
    return TFA_OK;
}

static int join_all(const gateway_context *c, ros2_domains *all)
{
    char error[200], *xml;
    uint32_t common;
    int status = tfa_ros2_domain(&c->settings->ros2, &common, &xml, error, sizeof error);
    for (uint32_t i = 0; i < c->robot_count && status == TFA_OK; i++) {
        const uint32_t domain = tfa_ros2_domain_of(c->robots[i].config, common);
        if (c->robots[i].config->ros2.enabled && !is_joined(all, domain))
            status = join_domain(c, domain, common, xml, all);
    }
    free(xml);
    return status;
}

static int join(const gateway_context *c, void **self)
{
    const config *settings = c->settings;
    size_t count = 0;
    for (size_t i = 0; settings->ros2.enabled && i < settings->robots_count; i++)
        count += settings->robots[i].ros2.enabled;
    *self = NULL;
    if (count == 0) {
        tfa_log(settings->ros2.enabled ? TFA_LOG_WARNING : TFA_LOG_INFO, "ros2: off: %s",
                settings->ros2.enabled ? "no robot has 'ros2: {enabled: yes}'"
                                       : "ros2.enabled is not set");
        return TFA_OK;
    }
    ros2_domains *all = calloc(1, sizeof *all + count * sizeof all->domain[0]);
    const int status = all ? join_all(c, all) : TFA_E_MEMORY;
    if (status == TFA_OK)
        *self = all;
    else if (all)
        stop(all);
    return status;
}

static int start(void *self, struct tfa_worker *first, const tfa_worker_robot *solvers)
{
    const ros2_domains *all = self;
    int status = TFA_OK;
    (void)first;
    for (uint32_t i = 0; i < all->count && status == TFA_OK; i++) {
        status = tfa_ros2_start(all->domain[i], solvers);
        if (status == TFA_E_SYSTEM)
            tfa_log(TFA_LOG_ERROR, "ros2: %s", tfa_dds_error());
        else if (status == TFA_OK)
            tfa_log(TFA_LOG_INFO, "ros2: domain %u, %u robots, diagnostics on /diagnostics",
                    all->domain[i]->id, all->domain[i]->robot_count);
    }
    return status;
}

/* ---- its robots ---- */

/* NULL: it has no topics of ROS 2. */
static ros2_robot *find(const ros2_domains *all, uint32_t robot)
{
    for (uint32_t i = 0; i < all->count; i++)
        for (uint32_t k = 0; k < all->domain[i]->robot_count; k++)
            if (all->domain[i]->robots[k].index == robot)
                return &all->domain[i]->robots[k];
    return NULL;
}

static bool serves(const void *self, uint32_t robot)
{
    return find(self, robot) != NULL;
}

static void exchange(void *self, uint32_t index, const tfa_model *next,
                     const tfa_worker_robot *solver)
{
    ros2_robot *robot = find(self, index);
    if (ros2_exchange(robot, next, solver) != TFA_OK)
        tfa_log(TFA_LOG_ERROR,
                "reload: robot '%s': no memory for its topics of ROS 2: nothing is answered there; "
                "free some and reload",
                robot->name);
}

static void set_tap(void *self, uint32_t index, struct tfa_tap *tap)
{
    ros2_robot *robot = find(self, index);
    pthread_mutex_lock(&robot->mutex);
    robot->own.tap = tap;
    pthread_mutex_unlock(&robot->mutex);
}

static void report(void *self, uint32_t index, const char *error)
{
    ros2_robot *robot = find(self, index);
    pthread_mutex_lock(&robot->mutex);
    robot->descriptions_refused += error != NULL;
    snprintf(robot->description_error, sizeof robot->description_error, "%s", error ? error : "");
    pthread_mutex_unlock(&robot->mutex);
}

static void describe(const void *self, uint32_t index, tfa_served_robot *served)
{
    const ros2_robot *robot = find(self, index);
    _Static_assert(sizeof robot->node <= sizeof served->ros2_node, "a name fits");
    served->ros2_domain = robot->gateway->id;
    memcpy(served->ros2_namespace, robot->node_namespace, sizeof robot->node_namespace);
    memcpy(served->ros2_node, robot->node, sizeof robot->node);
}

const struct gateway tfa_gateway_ros2 = {
    .name = "ros2",
    .source = TFA_SOURCE_ROS2,
    .check = check,
    .check_robot = tfa_ros2_check_robot,
    .join = join,
    .start = start,
    .serves = serves,
    .exchange = exchange,
    .set_tap = set_tap,
    .report = report,
    .describe = describe,
    .stop = stop,
};
