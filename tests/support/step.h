/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * One explicit Euler step of a state, for tests that differentiate along a motion.
 */
#ifndef TESTS_SUPPORT_STEP_H
#define TESTS_SUPPORT_STEP_H

#include "random_robot.h"

/**
 * Moves state 0 of `from` by dt into state 0 of `to` (made with the same sizes):
 * q follows v, v follows qdd, the base pose follows base_twist, that base_acceleration.
 */
void step_state(const tfa_description *description, const oracle *o, const random_states *from,
                const double *qdd, const double *base_acceleration, double dt, random_states *to);

/** The same of a model's coordinates and base pose with velocities v, base first. `q_out` and
 *  `pose_out` may be `q` and `pose`. Along one freedom the error has even powers of dt only. */
void step_model(const tfa_model *model, const double *q, const double *pose, const double *v,
                double dt, double *q_out, double *pose_out);

/** out = v turned by the unit quaternion, x y z w; `out` may be `v`. */
void rotate_vector(const double quat[4], const double v[3], double out[3]);

#endif
