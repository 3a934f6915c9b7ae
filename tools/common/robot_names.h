/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Names of a robot on the command line: from a model (in process) or the description of a daemon
 * (shm, dds), with the same messages.
 */
#ifndef TOOLS_COMMON_ROBOT_NAMES_H
#define TOOLS_COMMON_ROBOT_NAMES_H

#include <totalforce/text.h>

typedef tfa_names robot_names;
typedef tfa_joint_span robot_joint;

static inline const char *robot_names_frame_name(const robot_names *names, uint32_t frame)
{
    return tfa_names_frame(names, frame);
}

static inline void robot_names_describe(const robot_names *names, int of_q, char *text, size_t size)
{
    (void)tfa_names_describe(names, of_q, text, size);
}

#endif
