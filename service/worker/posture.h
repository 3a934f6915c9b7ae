/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Coordinates for requests of the daemon's own.
 */
#ifndef TFA_SERVICE_WORKER_POSTURE_H
#define TFA_SERVICE_WORKER_POSTURE_H

#include <string.h>
#include <totalforce/model.h>

/** This quaternion for each joint that has one. */
static inline void tfa_posture_set_quaternions(const tfa_model *model, const double quaternion[4],
                                               double *q)
{
    for (uint32_t i = 0; i < tfa_model_joint_count(model); i++) {
        const tfa_joint_info joint = tfa_model_joint(model, i);
        const int32_t first = tfa_joint_type_describe(joint.type).quaternion;
        if (first >= 0)
            memcpy(q + joint.q_index + first, quaternion, 4 * sizeof *q);
    }
}

/** A posture in which nothing is zero or aligned, another one for each offset. */
static inline void tfa_posture_set(const tfa_model *model, double offset,
                                   const double quaternion[4], double *q)
{
    for (uint32_t i = 0; i < tfa_model_q_count(model); i++)
        q[i] = offset + 0.07 * (i % 11) - 0.05 * (i % 5);
    tfa_posture_set_quaternions(model, quaternion, q);
}

#endif
