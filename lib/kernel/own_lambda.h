/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Lambda^-1 of one tip of one robot: inertias of the tree that it stands in, and six unit wrenches
 * along its path. The body of the tip is a constant at every call.
 */
#ifndef TFA_KERNEL_OWN_LAMBDA_H
#define TFA_KERNEL_OWN_LAMBDA_H

#include "kernel/carry_step.h"
#include "kernel/own_walk.h"

/* Past the joint of body i, whatever it is */
TFA_INLINE void carry_past(const struct state *s, int32_t i, struct wrenches *P, struct block *C)
{
    const struct tfa_body *b = body_terms(s, (uint32_t)i);
    if (is_revolute(b->kind) && !terms_geared(b) && !s->locked)
        carry_z(s, i, P, C);
    else if (is_revolute(b->kind))
        carry_1(s, i, AXIS_RZ, P, C);
    else if (is_prismatic(b->kind))
        carry_1(s, i, AXIS_TZ, P, C);
    else
        carry_base(&s->multi[b->multi], P, C);
}

/* Is body i on the path from body `tip` to the world? The indices are constants, and so is the answer. */
TFA_INLINE int own_supports(int32_t i, int32_t tip)
{
#pragma GCC unroll 64
    for (int k = 0; k < OWN_BODIES && tip > i; k++)
        tip = own_body[tip].parent;
    return tip == i;
}

#define OWN_POSE_TREE(i)                                                                           \
    if (own_body[i].tree == own_body[tip].tree)                                                    \
        pose_body(s, i);
#define OWN_FOLD_TREE(i)                                                                           \
    if (own_body[i].tree == own_body[tip].tree)                                                    \
        fold(s, i, NULL, FOLD_INERTIA | FOLD_FRESH | FOLD_WATCH);

/* Only of what hangs from the tip's first moving ancestor */
TFA_INLINE void own_factor(struct state *s, int32_t tip)
{
    OWN_OUTWARD(OWN_POSE_TREE) OWN_INWARD(OWN_FOLD_TREE)
}

/* The world in body coordinates: its axes, and its origin */
#define OWN_AXES(i)                                                                                \
    if (own_body[i].parent < 0 && own_supports(i, tip))                                            \
        R = s->X[i].E;                                                                             \
    else if (own_supports(i, tip))                                                                 \
        R = m3_mm(s->X[i].E, R);
#define OWN_ORIGIN(i)                                                                              \
    if (own_supports(i, tip))                                                                      \
        p = m3_mul(s->X[i].E, v3_sub(p, s->X[i].r));
#define OWN_CARRY(i)                                                                               \
    if (own_supports(i, tip))                                                                      \
        carry_past(s, i, &P, &C);

typedef uint64_t own_row_bits __attribute__((vector_size(sizeof(num_row))));

/* As own_is_sound, of a matrix in vectors */
TFA_INLINE int own_block_is_sound(const struct block *C)
{
    own_row_bits sign[SIX_ROWS] = {{0}};
    uint64_t any = 0;
    for (int e = 0; e < 6; e++)
        for (int k = 0; k < SIX_ROWS; k++)
            sign[k] |= ((own_row_bits)C->row[e].row[k] & OWN_EXPONENT) + OWN_TOO_LARGE;
    for (int e = 0; e < 6; e++)
        any |= row_lane(sign[e / NUM_ROW], e % NUM_ROW);
    return !(any >> 63);
}

TFA_INLINE int own_give_lambda(const struct block *C, double *out)
{
    for (int e = 0; e < 6; e++)
        six_store(out + 6 * e, &C->row[e]);
    return own_block_is_sound(C);
}

/* C = Lambda^-1 with the factors that are there; f: the tip's frame */
TFA_INLINE struct block own_carry(const struct state *s, int32_t tip, const struct tfa_frame *f,
                                  tfa_reference_frame mode)
{
    mat3 R = m3_load(f->R);
    if (mode != TFA_FRAME_LOCAL) {
        OWN_OUTWARD(OWN_AXES)
    }
    vec3 p = v3_load(f->p);
    if (mode == TFA_FRAME_WORLD) {
        p = v3_zero();
        OWN_OUTWARD(OWN_ORIGIN)
    }
    const struct axes axes = axes_of(R);
    struct wrenches P = wrenches_at(&axes, p);
    struct block C = block_zero();
    OWN_INWARD(OWN_CARRY)
    return C;
}

#endif
