/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Coordinates after a motion at constant velocities.
 */
#ifndef TFA_MODEL_INTEGRATE_H
#define TFA_MODEL_INTEGRATE_H

#include "model/model.h"

/* Moves q, and the pose of a floating base unless `twist` is NULL, along v and twist for a time,
 * which may be negative. Exact, so that times add up; quaternions keep the norm 1. */
void tfa_integrate(const struct tfa_model *m, const double *v, const double *twist, double time,
                   double *q, double *base_pose);

#endif
