/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Lambda^-1 of one tip of one robot: factors of the tree that it stands in, and six unit wrenches
 * along its path. The body of the tip is a constant at every call.
 */
#ifndef TFA_DYNAMICS_SPECIALISED_SPECIALISED_TIP_H
#define TFA_DYNAMICS_SPECIALISED_SPECIALISED_TIP_H

#include "algorithm_tip.h"
#include "dynamics/specialised/specialised_forward.h"
#include "dynamics/specialised/specialised_supports.h"

/* ---- inputs: coordinates of the tree that hangs where the tip's does; they stand together ---- */

#define ROBOT_GATHER_TREE(i)                                                                       \
    if (!is_identity_map() && robot_body[i].tree == robot_body[tip].tree && !robot_body[i].base)   \
        gather_position(in, at, r, robot_body[i].q);
#define ROBOT_COUNT_TREE(i)                                                                        \
    end += robot_body[i].tree == robot_body[tip].tree && !robot_body[i].base;

TFA_INLINE void load_tree_positions(struct robot_inputs *in, const struct tfa_host_api *host,
                                    const tfa_request *r, const struct lane_states *at, int32_t tip)
{
    const struct tfa_body *root = &robot_body[robot_body[tip].tree];
    size_t end = root->base ? 0 : root->q;
    const size_t first = end;
    in->angle = joint_angles(in, at, r);
    ROBOT_OUTWARD(ROBOT_GATHER_TREE)
    ROBOT_OUTWARD(ROBOT_COUNT_TREE)
    for (size_t k = 0; ROBOT_BASE && k < 7; k++)
        in->base[k] = gather_input(at, r->base_pose, 7, k);
    joint_sincos(in, host, first, end);
}

/* ---- the six unit wrenches ---- */

/* The world in body coordinates: its axes, and its origin */
#define ROBOT_AXES(i)                                                                              \
    if (robot_body[i].parent < 0 && is_on_path(i, tip))                                            \
        R = s->X[i].E;                                                                             \
    else if (is_on_path(i, tip))                                                                   \
        R = m3_mm(s->X[i].E, R);
#define ROBOT_ORIGIN(i)                                                                            \
    if (is_on_path(i, tip))                                                                        \
        p = m3_mul(s->X[i].E, v3_sub(p, s->X[i].r));

/* In the frame that is asked for, on body `tip`; f: the tip's frame */
TFA_INLINE struct wrench_columns unit_wrenches(const struct state *s, int32_t tip,
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
    return wrench_columns_at(&mat3_simd, p);
}

/* ---- output ---- */

#if NUM_LANES > 1
/* The first `count` lanes of C; returns whether all are finite */
TFA_INLINE int store_lambda(const struct mat6_simd *C, double *out, uint32_t count)
{
    const num *entry = (const num *)C;
    for (uint32_t l = 0; l < count; l++)
#pragma GCC unroll 36
        for (int e = 0; e < 36; e++)
            out[36 * l + (uint32_t)e] = num_lane(entry[e], l);
    return all_are_finite(entry, 36);
}
#else
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

TFA_INLINE int store_lambda(const struct mat6_simd *C, double *out, uint32_t count)
{
    (void)count;
    for (int e = 0; e < 6; e++)
        vec6_store(out + 6 * e, &C->row[e]);
    return matrix_is_finite(C);
}
#endif

/* ---- the operations ---- */

#define ROBOT_POSE_TREE(i)                                                                         \
    if (robot_body[i].tree == robot_body[tip].tree)                                                \
        pose_body(s, i);

TFA_INLINE void pose_tree(struct state *s, int32_t tip)
{
    ROBOT_OUTWARD(ROBOT_POSE_TREE)
}

/* Lambda^-1 alone, of the tip on body `tip` */
TFA_INLINE int lambda_of(const struct tfa_host_api *host, const tfa_request *r, uint32_t k,
                         uint32_t count, int32_t tip, tfa_reply *reply)
{
    const struct lane_states at = lanes_of_states(k, count);
    struct robot_inputs in;
    struct state s;
    struct robot_factors factors;
    load_tree_positions(&in, host, r, &at, tip);
    init_state(&s, &in, host, r);
    pose_tree(&s, tip);
    factor_tree(&s, &factors, tip);
    const struct mat6_simd C = response_of_tip(
        &s, &factors, tip, unit_wrenches(&s, tip, &host->model->frame[r->tips[0]], r->frame));
    return store_lambda(&C, reply->lambda_inv + 36 * (size_t)k, count) &&
           !needs_generic_kernel(&s, r);
}

#define ROBOT_LAMBDA_CASE(i)                                                                       \
    case i:                                                                                        \
        return ROBOT_HAS_TIP(i) ? lambda_of(host, r, k, count, i, reply) : 0;

static __attribute__((flatten, noinline)) int lambda(const struct tfa_host_api *host,
                                                     const tfa_request *r, uint32_t k,
                                                     uint32_t count, tfa_reply *reply)
{
    switch (host->model->frame[r->tips[0]].body) {
        ROBOT_OUTWARD(ROBOT_LAMBDA_CASE)
    default:
        return 0;
    }
}

#define ROBOT_TIP_CASE(i)                                                                          \
    case i:                                                                                        \
        if (!ROBOT_HAS_TIP(i))                                                                     \
            return 0;                                                                              \
        C = response_of_tip(&s, &factors, i, unit_wrenches(&s, i, f, r->frame));                   \
        break;

/* Forward dynamics, and Lambda^-1 with the same factors */
static __attribute__((flatten, noinline)) int forward_and_lambda(const struct tfa_host_api *host,
                                                                 const tfa_request *r, uint32_t k,
                                                                 uint32_t count, tfa_reply *reply)
{
    const struct lane_states at = lanes_of_states(k, count);
    struct robot_inputs in;
    struct state s;
    struct robot_factors factors;
    struct mat6_simd C;
    num qdd[ROBOT_FREEDOMS];
    const struct tfa_frame *f = &host->model->frame[r->tips[0]];
    load_forward_inputs(&in, host, r, &at);
    init_state(&s, &in, host, r);
    solve_forward(&s, &factors, in.x, qdd);
    scatter_outputs(qdd, state_array(reply->base_acceleration, 6, k),
                    state_array(reply->qdd, ROBOT_V_COUNT, k), count);
    switch (f->body) {
        ROBOT_OUTWARD(ROBOT_TIP_CASE)
    default:
        return 0;
    }
    return all_are_finite(qdd, ROBOT_FREEDOMS) && !needs_generic_kernel(&s, r) &&
           store_lambda(&C, reply->lambda_inv + 36 * (size_t)k, count);
}

#endif
