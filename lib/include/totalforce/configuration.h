/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Configurations of a robot as a Lie group: R for each revolute or prismatic coordinate, SE(2) for
 * a planar joint, SE(3) for a floating one and for a floating base. Velocities are those of
 * requests (docs/conventions.md): of planar and floating joints and of the base twists in the axes
 * of the moved frame. With exp and log of the group (Lynch and Park, Modern Robotics, chapter 3):
 *
 *     integrate(q, v, t) = q exp(t v),     difference(q, p) = log(q^-1 p)
 *
 * No function allocates or fails. Any thread.
 */
#ifndef TOTALFORCE_CONFIGURATION_H
#define TOTALFORCE_CONFIGURATION_H

#include <totalforce/model.h>

#ifdef __cplusplus
extern "C" {
#endif

/**
 * Moves a configuration along constant velocities for a time. Exact, so that times add up;
 * quaternions that turn get the norm 1, what does not move keeps its bits.
 *
 * @param model      of the robot
 * @param v          v_count, rad/s or m/s; NULL: the joints do not move
 * @param twist      6, m/s and rad/s, axes of the root link; NULL: the base does not move
 * @param time       s, may be negative
 * @param q          q_count, moved in place
 * @param base_pose  7, moved in place; NULL with a fixed base
 */
TFA_API void tfa_integrate(const tfa_model *model, const double *v, const double *twist,
                           double time, double *q, double *base_pose);

/**
 * Velocities that lead from one configuration to another in 1 s: tfa_integrate of them meets q_to,
 * the angle of a planar joint up to whole turns. Rotations of planar joints, floating joints and
 * the base are the short way, at most pi. Quaternions may have any norm but 0.
 *
 * @param model         of the robot
 * @param q             q_count
 * @param base_pose     7; NULL with a fixed base
 * @param q_to          q_count
 * @param base_pose_to  7; NULL with a fixed base
 * @param v             v_count, rad/s or m/s
 * @param twist         6, m/s and rad/s, axes of the root link; NULL with a fixed base
 */
TFA_API void tfa_difference(const tfa_model *model, const double *q, const double *base_pose,
                            const double *q_to, const double *base_pose_to, double *v,
                            double *twist);

/** Identity of the group: zeros, quaternions 0 0 0 1. `q`: q_count; `base_pose`: 7, NULL with a
 *  fixed base. */
TFA_API void tfa_neutral(const tfa_model *model, double *q, double *base_pose);

#ifdef __cplusplus
}
#endif
#endif
