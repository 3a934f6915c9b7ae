/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The gateways of a build without DDS: there are none.
 */
#include "dds/ros2/ros2.h"
#include "dds/topics/dds.h"
#include "platform/log.h"

static int refuse(const char *section)
{
    tfa_log(TFA_LOG_ERROR, "%s.enabled: this totalforced was built without DDS", section);
    return TFA_E_UNSUPPORTED;
}

static int check_dds(const config *settings)
{
    return settings->dds.enabled ? refuse("dds") : TFA_OK;
}

static int check_ros2(const config *settings)
{
    return settings->ros2.enabled ? refuse("ros2") : TFA_OK;
}

static int join(const gateway_context *context, void **self)
{
    (void)context;
    *self = NULL;
    return TFA_OK;
}

const struct gateway tfa_gateway_dds = {
    .name = "dds", .source = TFA_SOURCE_DDS, .check = check_dds, .join = join};

const struct gateway tfa_gateway_ros2 = {.name = "ros2",
                                         .source = TFA_SOURCE_ROS2,
                                         .check = check_ros2,
                                         .check_robot = tfa_ros2_check_robot,
                                         .join = join};
