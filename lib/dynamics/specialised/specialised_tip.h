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

#define ROBOT_COUNT_TREE(i)                                                                        \
    end += robot_body[i].tree == robot_body[tip].tree && !robot_body[i].base;

TFA_INLINE void load_tree_positions(struct robot_inputs *in, const tfa_request *r,
                                    const struct lane_states *at, int32_t tip)
{
    const struct tfa_body *root = &robot_body[robot_body[tip].tree];
    size_t end = root->base ? 0 : root->q;
    const size_t first = end;
    ROBOT_OUTWARD(ROBOT_COUNT_TREE)
    gather_positions(in, at, r, first, end);
    joint_sincos(in, first, end);
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

/* x + zero is never -0: of which sign a zero is depends on the lanes, to compilers that are told
 * that it has none. */
#if NUM_LANES > 1
/* Returns the states whose entries are finite. */
TFA_INLINE num_mask store_lambda(struct mat6_simd *C, const struct lane_states *at, double *out)
{
    num *entry = (num *)C, zero = num_of(0);
    __asm__("" : ROBOT_REGISTER(zero)); /* known to no compiler */
#pragma GCC unroll 36
    for (int e = 0; e < 36; e++)
        entry[e] += zero;
    scatter_numbers(entry, at->lane, out, 36, 36);
    return finite_states(entry, 36);
}
#else
typedef int64_t vector_bits __attribute__((vector_size(sizeof(num_vec))));

/* As finite_states, of a matrix in vectors */
TFA_INLINE int matrix_is_finite(const struct mat6_simd *C)
{
    vector_bits too_large[VEC6_VECS] = {{0}};
    int64_t any = 0;
    for (int e = 0; e < 6; e++)
        for (int k = 0; k < VEC6_VECS; k++)
            too_large[k] |= ((vector_bits)C->row[e].vec[k] & LANE_EXPONENT) >= LANE_EXPONENT_MAX;
    for (int e = 0; e < 6; e++)
        any |= vec_lane(too_large[e / NUM_VEC_LANES], e % NUM_VEC_LANES);
    return !any;
}

TFA_INLINE num_mask store_lambda(struct mat6_simd *C, const struct lane_states *at, double *out)
{
    num_vec zero = {0};
    __asm__("" : ROBOT_REGISTER(zero));
    out += (size_t)36 * at->lane[0];
    for (int e = 0; e < 6; e++)
        for (int k = 0; k < VEC6_VECS; k++)
            C->row[e].vec[k] += zero;
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

/* Robots with more bodies have one copy of the code of factors for each tree, not for each tip:
 * half of the code of a humanoid, and of a floating quadruped, whose batches of Lambda^-1 take 0.91
 * times as long and one state 1.01 times. Batches of arm7 would take 1.15 times as long. Measured
 * with bench_suite --kernels on an AMD EPYC (Zen 5) VM, gcc 12, 2026-11-24. */
#define ROBOT_OWN_FACTORS_BODIES_MAX 9
#define ROBOT_TIP_GROUP(i) (ROBOT_BODIES > ROBOT_OWN_FACTORS_BODIES_MAX ? robot_body[i].tree : i)

#define ROBOT_GROUP_TIP_CASE(i)                                                                    \
    case i:                                                                                        \
        if (ROBOT_TIP_GROUP(i) != group || !ROBOT_HAS_TIP(i))                                      \
            return 0;                                                                              \
        C = response_of_tip(&s, &factors, i, unit_wrenches(&s, i, f, r->frame));                   \
        break;

/* Lambda^-1 alone, of a tip of this group, which is a body of the tips' tree */
TFA_INLINE uint32_t lambda_of_group(const struct tfa_host_api *host, const tfa_request *r,
                                    uint32_t k, uint32_t count, int32_t group, tfa_reply *reply)
{
    const struct lane_states at = lanes_of_states(k, count);
    const struct tfa_frame *f = &host->model->frame[r->tips[0]];
    struct robot_inputs in;
    struct state s;
    struct robot_factors factors;
    struct mat6_simd C;
    load_tree_positions(&in, r, &at, group);
    init_state(&s, &in, host, r);
    pose_tree(&s, group);
    factor_tree(&s, &factors, group);
    switch (f->body) {
        ROBOT_OUTWARD(ROBOT_GROUP_TIP_CASE)
    default:
        return 0;
    }
    return answered_states(&s, r, store_lambda(&C, &at, reply->lambda_inv));
}

#define ROBOT_GROUP_CASE(i)                                                                        \
    case i:                                                                                        \
        return ROBOT_TIP_GROUP(i) == i ? lambda_of_group(host, r, k, count, i, reply) : 0;

static __attribute__((flatten, noinline)) uint32_t lambda(const struct tfa_host_api *host,
                                                          const tfa_request *r, uint32_t k,
                                                          uint32_t count, tfa_reply *reply)
{
    const int32_t body = host->model->frame[r->tips[0]].body;
    if (body < 0)
        return 0;
    switch (ROBOT_TIP_GROUP(body)) {
        ROBOT_OUTWARD(ROBOT_GROUP_CASE)
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
static __attribute__((flatten, noinline)) uint32_t
forward_and_lambda(const struct tfa_host_api *host, const tfa_request *r, uint32_t k,
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
    shift_accelerations(qdd, &in, -1);
    scatter_outputs(qdd, &at, reply->base_acceleration, reply->qdd);
    switch (f->body) {
        ROBOT_OUTWARD(ROBOT_TIP_CASE)
    default:
        return 0;
    }
    return answered_states(
        &s, r, store_lambda(&C, &at, reply->lambda_inv) & finite_states(qdd, ROBOT_FREEDOMS));
}

#endif
