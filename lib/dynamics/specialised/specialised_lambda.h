/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Lambda^-1 of one tip of one robot: inertias of the tree that it stands in, and six unit wrenches
 * along its path. The body of the tip is a constant at every call.
 */
#ifndef TFA_DYNAMICS_SPECIALISED_SPECIALISED_LAMBDA_H
#define TFA_DYNAMICS_SPECIALISED_SPECIALISED_LAMBDA_H

#include "dynamics/osim/propagate_step.h"
#include "dynamics/specialised/specialised_recursions.h"

/* Past the joint of body i, whatever it is */
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

/* Is body i on the path from body `tip` to the world? The indices are constants, and so is the
 * answer. */
TFA_INLINE int is_on_path(int32_t i, int32_t tip)
{
#pragma GCC unroll 64
    for (int k = 0; k < ROBOT_BODIES && tip > i; k++)
        tip = robot_body[tip].parent;
    return tip == i;
}

#define ROBOT_POSE_TREE(i)                                                                         \
    if (robot_body[i].tree == robot_body[tip].tree)                                                \
        pose_body(s, i);
#define ROBOT_ABA_BACKWARD_TREE(i)                                                                 \
    if (robot_body[i].tree == robot_body[tip].tree)                                                \
        aba_backward_step(s, i, NULL, ABA_INERTIA | ABA_FULL_SWEEP | ABA_SENTINEL);

/* Only the subtree of the tip's first moving ancestor */
TFA_INLINE void factor_tree(struct state *s, int32_t tip)
{
    ROBOT_OUTWARD(ROBOT_POSE_TREE) ROBOT_INWARD(ROBOT_ABA_BACKWARD_TREE)
}

/* The world in body coordinates: its axes, and its origin */
#define ROBOT_AXES(i)                                                                              \
    if (robot_body[i].parent < 0 && is_on_path(i, tip))                                            \
        R = s->X[i].E;                                                                             \
    else if (is_on_path(i, tip))                                                                   \
        R = m3_mm(s->X[i].E, R);
#define ROBOT_ORIGIN(i)                                                                            \
    if (is_on_path(i, tip))                                                                        \
        p = m3_mul(s->X[i].E, v3_sub(p, s->X[i].r));
#define ROBOT_PROPAGATE(i)                                                                         \
    if (is_on_path(i, tip))                                                                        \
        propagate_body(s, i, &P, &C);

typedef uint64_t vector_bits __attribute__((vector_size(sizeof(num_vec))));

/* As all_are_finite, of a matrix in vectors */
TFA_INLINE int matrix_is_finite(const struct mat6_simd *C)
{
    vector_bits sign[VEC6_VECS] = {{0}};
    uint64_t any = 0;
    for (int e = 0; e < 6; e++)
        for (int k = 0; k < VEC6_VECS; k++)
            sign[k] |= ((vector_bits)C->row[e].vec[k] & DOUBLE_EXPONENT) + DOUBLE_TOO_LARGE;
    for (int e = 0; e < 6; e++)
        any |= vec_lane(sign[e / NUM_VEC_LANES], e % NUM_VEC_LANES);
    return !(any >> 63);
}

TFA_INLINE int store_lambda(const struct mat6_simd *C, double *out)
{
    for (int e = 0; e < 6; e++)
        vec6_store(out + 6 * e, &C->row[e]);
    return matrix_is_finite(C);
}

/* C = Lambda^-1 with the factors that are there; f: the tip's frame */
TFA_INLINE struct mat6_simd propagate_to_world(const struct state *s, int32_t tip,
                                               const struct tfa_frame *f, tfa_reference_frame mode)
{
    mat3 R = m3_load(f->R);
    if (mode != TFA_FRAME_LOCAL) {
        ROBOT_OUTWARD(ROBOT_AXES)
    }
    vec3 p = v3_load(f->p);
    if (mode == TFA_FRAME_WORLD) {
        p = v3_zero();
        ROBOT_OUTWARD(ROBOT_ORIGIN)
    }
    const struct mat3_simd mat3_simd = mat3_simd_of(R);
    struct wrench_columns P = wrench_columns_at(&mat3_simd, p);
    struct mat6_simd C = mat6_simd_zero();
    ROBOT_INWARD(ROBOT_PROPAGATE)
    return C;
}

#endif
