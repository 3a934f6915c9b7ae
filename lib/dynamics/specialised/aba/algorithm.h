/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Algorithm `aba`: articulated bodies.
 */
#ifndef TFA_DYNAMICS_SPECIALISED_ALGORITHM_H
#define TFA_DYNAMICS_SPECIALISED_ALGORITHM_H

#include "dynamics/core/aba_step.h"
#include "dynamics/specialised/specialised_recursions.h"

#define ROBOT_BY_CRBA 0

/* The factors are IA, U and D of the state. */
struct robot_factors {
    char none;
};

#define ROBOT_ABA_BACKWARD(i)                                                                      \
    aba_backward_step(s, i, tau,                                                                   \
                      ABA_INERTIA | ABA_FORCE | ABA_BIAS | ABA_FULL_SWEEP | ABA_SENTINEL);
#define ROBOT_ABA_FORWARD(i)                                                                       \
    aba_forward_step(s, i, parent_motion(&robot_unit[i], s->a, ground), qdd, 1);

/* qdd = M^-1 (tau - h) */
TFA_INLINE void solve_forward(struct state *s, struct robot_factors *factors, const num *tau,
                              num *qdd)
{
    const svec ground = {v3_zero(), v3_neg(s->gravity)};
    (void)factors;
    ROBOT_UNITS_OUTWARD(ROBOT_POSE)
    ROBOT_UNITS_OUTWARD(ROBOT_VELOCITY)
    ROBOT_UNITS_INWARD(ROBOT_ABA_BACKWARD)
    ROBOT_UNITS_OUTWARD(ROBOT_ABA_FORWARD)
}

#endif
