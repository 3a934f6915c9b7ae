/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Statistics of the ROS 2 gateway in shared memory.
 */
#include "dds/ros2/ros2_internal.h"

#include <stdio.h>

_Static_assert(ROS2_INPUTS_MAX <= TFA_STATISTICS_INPUTS_MAX, "a place for every input");

void ros2_publish_statistics(const ros2_robot *robot)
{
    tfa_ros2_statistics s = {.input_count = robot->input_count,
                             .subscribers = robot->subscribers,
                             .refused = robot->counts.refused};
    if (!robot->own.statistics)
        return;
    snprintf(s.refusal, sizeof s.refusal, "%s", robot->counts.refusal);
    for (uint32_t k = 0; k < robot->input_count; k++) {
        const ros2_input *in = &robot->inputs[k];
        tfa_input_statistics *to = &s.inputs[k];
        snprintf(to->name, sizeof to->name, "%.*s", (int)sizeof to->name - 1, in->name);
        to->publishers = in->publishers;
        to->received = in->received;
        to->refused = in->refused;
        to->oversized = atomic_load_explicit(&in->oversized, memory_order_relaxed);
        to->last = (uint64_t)in->last;
    }
    tfa_record_write(&robot->own.statistics->ros2.version, robot->own.statistics->ros2.words, &s,
                     sizeof s);
}
