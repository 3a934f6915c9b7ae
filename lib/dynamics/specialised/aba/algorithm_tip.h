/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Algorithm `aba` for tips: six unit wrenches propagated inward.
 */
#ifndef TFA_DYNAMICS_SPECIALISED_ALGORITHM_TIP_H
#define TFA_DYNAMICS_SPECIALISED_ALGORITHM_TIP_H

#include "algorithm.h"
#include "dynamics/osim/propagate_step.h"

#define ROBOT_ABA_BACKWARD_TREE(i)                                                                 \
    if (robot_body[i].tree == robot_body[tip].tree)                                                \
        aba_backward_step(s, i, NULL, ABA_INERTIA | ABA_FULL_SWEEP | ABA_SENTINEL);

/* Factors of the subtree of the tip's first moving ancestor, whose poses are there */
TFA_INLINE void factor_tree(struct state *s, struct robot_factors *factors, int32_t tip)
{
    (void)factors;
    ROBOT_INWARD(ROBOT_ABA_BACKWARD_TREE)
}

/* Through the joint of body i, whatever it is */
TFA_INLINE void propagate_body(const struct state *s, int32_t i, struct wrench_columns *P,
                               struct mat6_simd *C)
{
    const struct tfa_body *b = body_constants_of(s, (uint32_t)i);
    if (is_revolute(b->kind) && !body_has_armature(b) && !s->locked)
        propagate_revolute(s, i, P, C);
    else if (is_revolute(b->kind))
        propagate_1dof(s, i, AXIS_RZ, P, C);
    else if (is_prismatic(b->kind))
        propagate_1dof(s, i, AXIS_TZ, P, C);
    else
        propagate_base(&s->joint_nd[b->joint_nd], P, C);
}

#define ROBOT_PROPAGATE(i)                                                                         \
    if (is_on_path(i, tip))                                                                        \
        propagate_body(s, i, &P, &C);

/* Lambda^-1 of six unit wrenches P on body `tip`, with the factors that are there */
TFA_INLINE struct mat6_simd response_of_tip(const struct state *s,
                                            const struct robot_factors *factors, int32_t tip,
                                            struct wrench_columns P)
{
    struct mat6_simd C = mat6_simd_zero();
    (void)factors;
    ROBOT_INWARD(ROBOT_PROPAGATE)
    return C;
}

#endif
