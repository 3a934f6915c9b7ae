/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Limits of joints, as a file states them. No model and no answer uses them: they are
 * for programs that choose positions, velocities and forces.
 */
#ifndef TOTALFORCE_LIMITS_H
#define TOTALFORCE_LIMITS_H

#include <stddef.h>
#include <stdint.h>
#include <totalforce/status.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Limits of a joint's coordinate, its rate and its force. */
typedef struct tfa_joint_limits {
    uint32_t limited; /**< 1: the file has a range for the joint; 0: the range is all zero */
    double lower;     /**< rad or m; 0 if the file leaves it out */
    double upper;     /**< rad or m, above lower; 0 if the file leaves it out */
    double velocity;  /**< largest speed, rad/s or m/s; infinite if the file states none */
    double effort;    /**< largest force, N m or N; infinite if the file states none */
} tfa_joint_limits;

/**
 * Reads the limits of named joints. A `<limit>` without lower and upper, one that is not
 * lower < upper, and a joint that is neither revolute nor prismatic give no range;
 * negative velocities and efforts are none. Cost: O(length). Any thread.
 *
 * @param text    URDF or MJCF of `length` bytes, as tfa_urdf_parse accepts it
 * @param length  of text, bytes
 * @param names   `count` names of joints: tfa_joint_info.name or tfa_joint.name
 * @param count   of names and limits
 * @param limits  `count`; a name that the file does not have gets none
 * @return TFA_OK; TFA_E_ARGUMENT (a NULL); TFA_E_PARSE (malformed: tfa_urdf_parse reports why);
 *         TFA_E_FILE (longer than 64 MiB); TFA_E_MEMORY
 */
TFA_API TFA_CHECKED int tfa_urdf_limits(const char *text, size_t length, const char *const *names,
                                        size_t count, tfa_joint_limits *limits);

#ifdef __cplusplus
}
#endif
#endif
