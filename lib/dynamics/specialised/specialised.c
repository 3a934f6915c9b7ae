/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A kernel specialised for one robot: the steps of the kernels, compiled with that robot's tables
 * (robot_tables.h, written by `totalforce specialise`) as constants. Four objects: one number at a
 * time, which exports the table; the robot's branches in lanes (specialised_body_lanes.c); a batch
 * of states; and one number at a time with inertias that are read at run time (ROBOT_PAYLOADS), for
 * payloads. Inertias as inputs of all four would make inverse dynamics of a humanoid 1.5 times as
 * slow (docs/specialised.md).
 *
 * Compilers are told that numbers are finite and zeros have no sign, or 0 x would not be 0. Numbers
 * that are not finite are found by their bits.
 */
#include "dynamics/specialised/specialised_forward.h"

static __attribute__((flatten, noinline)) int inverse_dynamics(const struct tfa_host_api *host,
                                                               const tfa_request *r, uint32_t k,
                                                               uint32_t count, tfa_reply *reply)
{
    const struct lane_states at = lanes_of_states(k, count);
    struct robot_inputs in;
    struct state s;
    num tau[ROBOT_FREEDOMS];
    load_positions(&in, host, r, &at);
    gather_freedoms(in.qd, &at, r->base_twist, r->v);
    gather_freedoms(in.x, &at, r->base_acceleration, r->qdd);
    init_state(&s, &in, host, r);
    inverse_rnea(&s, in.x, tau);
    add_damping(tau, in.qd, 1);
    scatter_outputs(tau, state_array(reply->base_wrench, 6, k),
                    state_array(reply->tau, ROBOT_V_COUNT, k), count);
    return all_are_finite(tau, ROBOT_FREEDOMS);
}

#if NUM_LANES > 1 || defined ROBOT_PAYLOADS
int TFA_V(specialised)(const struct tfa_host_api *host, const tfa_request *r, uint32_t k,
                       uint32_t count, tfa_reply *reply)
{
    return r->op == TFA_OP_INVERSE_DYNAMICS || !ROBOT_HAS_FORWARD
               ? inverse_dynamics(host, r, k, count, reply)
               : forward_dynamics(host, r, k, count, reply);
}
#else
#include "dynamics/specialised/specialised_lambda.h"
#include "dynamics/specialised/specialised_supports.h"

/* ---- tips, one number at a time ---- */

#define ROBOT_GATHER_TREE(i)                                                                       \
    if (!is_identity_map() && robot_body[i].tree == robot_body[tip].tree && !robot_body[i].base)   \
        gather_position(in, at, r, robot_body[i].q);
#define ROBOT_COUNT_TREE(i)                                                                        \
    end += robot_body[i].tree == robot_body[tip].tree && !robot_body[i].base;

/* Coordinates of the tree that hangs where the tip's does; they stand together. */
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

/* Lambda^-1 alone, of the tip on body `tip` */
TFA_INLINE int lambda_of(const struct tfa_host_api *host, const tfa_request *r, uint32_t k,
                         int32_t tip, tfa_reply *reply)
{
    const struct lane_states at = lanes_of_states(k, 1);
    struct robot_inputs in;
    struct state s;
    load_tree_positions(&in, host, r, &at, tip);
    init_state(&s, &in, host, r);
    factor_tree(&s, tip);
    const struct mat6_simd C =
        propagate_to_world(&s, tip, &host->model->frame[r->tips[0]], r->frame);
    return store_lambda(&C, reply->lambda_inv + 36 * (size_t)k) && !needs_generic_kernel(&s, r);
}

#define ROBOT_LAMBDA_CASE(i)                                                                       \
    case i:                                                                                        \
        return ROBOT_HAS_TIP(i) ? lambda_of(host, r, k, i, reply) : 0;

static __attribute__((flatten, noinline)) int
lambda(const struct tfa_host_api *host, const tfa_request *r, uint32_t k, tfa_reply *reply)
{
    switch (host->model->frame[r->tips[0]].body) {
        ROBOT_OUTWARD(ROBOT_LAMBDA_CASE)
    default:
        return 0;
    }
}

#ifdef ROBOT_BODY_LANES
int tfa_specialised_body_lanes(const struct tfa_host_api *host, const tfa_request *r, uint32_t k,
                               uint32_t count, tfa_reply *reply);

static int forward_state(const struct tfa_host_api *host, const tfa_request *r, uint32_t k,
                         tfa_reply *reply)
{
    return tfa_specialised_body_lanes(host, r, k, 1, reply);
}

/* Two passes, one with the branches in lanes: less than one pass without. */
static int forward_and_lambda(const struct tfa_host_api *host, const tfa_request *r, uint32_t k,
                              tfa_reply *reply)
{
    return forward_state(host, r, k, reply) && lambda(host, r, k, reply);
}
#else
#define ROBOT_TIP_CASE(i)                                                                          \
    case i:                                                                                        \
        if (!ROBOT_HAS_TIP(i))                                                                     \
            return 0;                                                                              \
        C = propagate_to_world(&s, i, f, r->frame);                                                \
        break;

/* Forward dynamics, and Lambda^-1 with the same factors */
static __attribute__((flatten, noinline)) int forward_and_lambda(const struct tfa_host_api *host,
                                                                 const tfa_request *r, uint32_t k,
                                                                 tfa_reply *reply)
{
    const struct lane_states at = lanes_of_states(k, 1);
    struct robot_inputs in;
    struct state s;
    struct mat6_simd C;
    num qdd[ROBOT_FREEDOMS];
    const struct tfa_frame *f = &host->model->frame[r->tips[0]];
    load_forward_inputs(&in, host, r, &at);
    init_state(&s, &in, host, r);
    forward_aba(&s, in.x, qdd);
    scatter_outputs(qdd, state_array(reply->base_acceleration, 6, k),
                    state_array(reply->qdd, ROBOT_V_COUNT, k), 1);
    switch (f->body) {
        ROBOT_OUTWARD(ROBOT_TIP_CASE)
    default:
        return 0;
    }
    return all_are_finite(qdd, ROBOT_FREEDOMS) && !needs_generic_kernel(&s, r) &&
           store_lambda(&C, reply->lambda_inv + 36 * (size_t)k);
}

static int forward_state(const struct tfa_host_api *host, const tfa_request *r, uint32_t k,
                         tfa_reply *reply)
{
    return ROBOT_HAS_FORWARD ? forward_dynamics(host, r, k, 1, reply) : 0;
}
#endif

/* ---- the table ---- */

int TFA_V(specialised)(const struct tfa_host_api *host, const tfa_request *r, uint32_t k,
                       uint32_t count, tfa_reply *reply)
{
    (void)count;
    if (r->op == TFA_OP_INVERSE_DYNAMICS)
        return inverse_dynamics(host, r, k, 1, reply);
    if (r->op == TFA_OP_OPERATIONAL_INERTIA)
        return lambda(host, r, k, reply);
    return r->tip_count && ROBOT_HAS_FORWARD ? forward_and_lambda(host, r, k, reply)
                                             : forward_state(host, r, k, reply);
}

int tfa_specialised_payloads(const struct tfa_host_api *host, const tfa_request *r, uint32_t k,
                             uint32_t count, tfa_reply *reply);

static int solve(const struct tfa_host_api *host, const tfa_request *r, uint32_t k,
                 tfa_reply *reply)
{
    return r->payload_count ? tfa_specialised_payloads(host, r, k, 1, reply)
                            : TFA_V(specialised)(host, r, k, 1, reply);
}

#if ROBOT_BATCH_LANES
int tfa_specialised_batch(const struct tfa_host_api *host, const tfa_request *r, uint32_t k,
                          uint32_t count, tfa_reply *reply);

/* 0: states with payloads go one at a time. */
static int solve_batch(const struct tfa_host_api *host, const tfa_request *r, uint32_t k,
                       uint32_t count, tfa_reply *reply)
{
    return r->payload_count ? 0 : tfa_specialised_batch(host, r, k, count, reply);
}
#endif

#define SPECIALISED_STRING_OF(x) #x
#define SPECIALISED_STRING(x) SPECIALISED_STRING_OF(x)

__attribute__((visibility("default")))
const struct tfa_specialised_kernel tfa_specialised_kernel = {
    .abi = TFA_SPECIALISED_ABI,
    .request_bytes = sizeof(tfa_request),
    .reply_bytes = sizeof(tfa_reply),
    .model_bytes = sizeof(struct tfa_model),
    .model = ROBOT_HASH,
    .isa = SPECIALISED_STRING(TFA_ISA_NAME),
    .compiler = __VERSION__,
    .bodies = ROBOT_BODIES,
    .lanes = ROBOT_BATCH_LANES,
    .supports = supports_request,
    .solve = solve,
#if ROBOT_BATCH_LANES
    .solve_batch = solve_batch,
#endif
};
#endif
