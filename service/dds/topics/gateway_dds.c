/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The DDS gateway as the daemon sees it.
 */
#include "dds/topics/dds_internal.h"

#include "dds/common/ros_domain.h"
#include "platform/log.h"

#include <errno.h>
#include <stdlib.h>

static void log_cyclone(const char *text)
{
    tfa_log_client(TFA_LOG_WARNING, "dds: %s", text);
}

/* Also for ROS 2: both speak DDS. */
static int check(const config *settings)
{
    if ((settings->dds.enabled || settings->ros2.enabled) && !tfa_dds_has_security())
        tfa_log(TFA_LOG_INFO, "dds: no DDS Security in CYCLONEDDS_URI: every participant of the "
                              "domain may ask, command and lead");
    return TFA_OK;
}

/* The first of all gateways: the log of Cyclone is theirs, too, and so are the settings of a domain
 * that both join. */
static int join(const gateway_context *c, void **self)
{
    const config *settings = c->settings;
    const uint32_t domain = settings->dds.domain;
    uint32_t count = 0, common = 0;
    char *xml = NULL, error[200];
    tfa_dds *gateway = NULL;
    int status = TFA_OK;

    tfa_dds_log_to(log_cyclone);
    while (count < c->robot_count && c->robots[count].config->dds)
        count++;
    if (!settings->dds.enabled || count == 0)
        tfa_log(TFA_LOG_INFO, "dds: off: %s",
                settings->dds.enabled ? "no robot has it" : "dds.enabled is not set");
    else if (settings->ros2.enabled)
        status = tfa_ros2_domain(&settings->ros2, &common, &xml, error, sizeof error);
    if (status == TFA_OK && settings->dds.enabled && count > 0) {
        status = tfa_dds_create(c, count, tfa_ros2_is_in(settings, domain, common) ? xml : NULL, 0,
                                &gateway);
        if (status != TFA_OK)
            tfa_log(TFA_LOG_ERROR, "dds: domain %u: %s", domain, tfa_dds_error());
        errno = 0; /* some library's */
    }
    free(xml);
    *self = gateway;
    return status;
}

static int start(void *self, struct tfa_worker *first, const tfa_worker_robot *solvers)
{
    const tfa_dds *gateway = self;
    dds_domainid_t domain = 0;
    const int status = tfa_dds_start(self, first, solvers);

    (void)dds_get_domainid(gateway->member.participant, &domain);
    if (status == TFA_OK)
        tfa_log(TFA_LOG_INFO,
                "dds: domain %u, %u robots: %s and %s, stream %s and %s, described by %s", domain,
                gateway->robot_count, TFA_DDS_TOPIC_REQUEST, TFA_DDS_TOPIC_REPLY,
                TFA_DDS_TOPIC_TORQUES, TFA_DDS_TOPIC_ACCELERATIONS, TFA_DDS_TOPIC_ROBOT_INFO);
    return status;
}

static bool serves(const void *self, uint32_t robot)
{
    return robot < ((const tfa_dds *)self)->robot_count;
}

static void announce(void *self, uint32_t robot, const tfa_model *model)
{
    const tfa_dds *gateway = self;

    if (tfa_dds_announce(self, robot, model) != TFA_OK)
        tfa_log(TFA_LOG_ERROR, "reload: robot '%s' could not be announced over DDS",
                gateway->robots[robot].name);
}

static void describe(const void *self, uint32_t robot, tfa_served_robot *served)
{
    served->dds = serves(self, robot);
}

static void stop(void *self)
{
    tfa_dds_stop(self);
}

const struct gateway tfa_gateway_dds = {
    .name = "dds",
    .source = TFA_SOURCE_DDS,
    .check = check,
    .join = join,
    .start = start,
    .serves = serves,
    .exchange = tfa_dds_exchange,
    .detach = tfa_dds_detach,
    .announce = announce,
    .set_tap = tfa_dds_set_tap,
    .leadership = tfa_dds_get_leadership,
    .describe = describe,
    .stop = stop,
};
