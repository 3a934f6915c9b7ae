/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Which requests a kernel specialised for one robot answers: forward dynamics, inverse dynamics,
 * derivatives, the mass matrix, Lambda^-1 of one tip, and forward dynamics with it, of the robot as
 * its tables say, plainly.
 */
#ifndef TFA_DYNAMICS_SPECIALISED_SPECIALISED_SUPPORTS_H
#define TFA_DYNAMICS_SPECIALISED_SPECIALISED_SUPPORTS_H

#include "interface/specialised_abi.h"
#include "interface/traits.h"
#include "model/model.h"
#include "robot_tables.h"
#include "spatial/num.h"

/* More bodies that do not go side by side are left to the loop of the generic kernel. Written out,
 * a chain of 32 takes 0.80 times as long, of 40 0.86, of 48 0.90, but cold 2.8, 3.4 and 4.1 times,
 * and its compiler 20 s and more. */
#define ROBOT_UNROLLED_BODIES_MAX 40
#if ROBOT_BODIES <= ROBOT_UNROLLED_BODIES_MAX ||                                                   \
    (defined ROBOT_BODY_LANES && !defined ROBOT_PAYLOADS)
#define ROBOT_HAS_FORWARD 1
#else
#define ROBOT_HAS_FORWARD 0 /* no code for requests that are not taken */
#endif

/* Robots with more bodies have code for tips where hands and feet are: on bodies that carry none,
 * or several. It grows with bodies times tips. */
#define ROBOT_ALL_TIPS_BODIES_MAX 16
/* Larger robots have no code for tips of states in lanes. */
#define ROBOT_HAS_BATCH_TIPS (ROBOT_BODIES <= ROBOT_UNROLLED_BODIES_MAX)
/* Beyond this many bodies, forward dynamics with a tip in two passes, one with the branches in
 * lanes, takes longer than the one pass of the generic kernel: 31 bodies 1.4 times as fast, 47
 * bodies 0.7 times. */
#define ROBOT_TWO_PASS_BODIES_MAX 40

/* Inverse dynamics of one state of a larger robot, one body after the other, has no code for
 * wrenches: it is as long as an instruction cache. 47 bodies took 1.4 times as long without a
 * wrench, and 0.94 times as long as the generic kernel with one. */
#define ROBOT_HAS_INVERSE_WRENCHES (NUM_LANES > 1 || ROBOT_BODIES <= ROBOT_UNROLLED_BODIES_MAX)

/* Code of the mass matrix grows with the lengths of all paths, not with the number of bodies: a
 * humanoid of 58 bodies has less of it than a chain of 40. */
#define ROBOT_HAS_MASS (ROBOT_PATHS <= 820)
#define ROBOT_IS_CHAIN (ROBOT_PATHS == ROBOT_BODIES * (ROBOT_BODIES + 1) / 2)

#define ROBOT_HAS_DERIVATIVES (!ROBOT_BASE && ROBOT_FREEDOMS <= TFA_SPECIALISED_DERIVATIVES_MAX)

TFA_INLINE int is_branch_or_leaf(int32_t body)
{
    int children = 0;
#pragma GCC unroll 128
    for (int32_t i = 0; i < ROBOT_BODIES; i++)
        children += robot_body[i].parent == body;
    return children != 1;
}

#define ROBOT_HAS_TIP(i) (ROBOT_BODIES <= ROBOT_ALL_TIPS_BODIES_MAX || is_branch_or_leaf(i))

static int supports_tip(const struct tfa_host_api *host, const tfa_request *r)
{
    const struct tfa_frame *f = &host->model->frame[r->tips[0]];
    return r->tip_count == 1 && f->body >= 0 && f->part == 0 && ROBOT_HAS_TIP(f->body) &&
           !(r->flags & TFA_WANT_POSES);
}

/* The robot is that of the tables, but for gravity, wrenches and, without tips, payloads: with them
 * the code of tips, 0.58 (humanoid) to 0.77 (arm7) of that for one state, would be there twice.
 * Estimates need the factors of the generic kernel: computed beside an answer of this one they took
 * 1.14 (arm7) to 2.1 times as long. Of Lambda^-1 of four tips, factors of this kernel would save at
 * most 8 % (floating quadruped) to 21 % (arm7), before they are copied. */
static int supports_options(const tfa_request *r)
{
    return !r->locked_count && !(r->payload_count && r->tip_count) &&
           r->estimate != TFA_ESTIMATE_ALWAYS &&
           (r->refine == 0 || r->refine == TFA_REFINE_DEFAULT);
}

static int uses_body_lanes(const tfa_request *r)
{
#ifdef ROBOT_BODY_LANES
    return !r->payload_count;
#else
    (void)r;
    return 0;
#endif
}

static int supports_forward(const struct tfa_host_api *host, const tfa_request *r)
{
    if (ROBOT_BODIES > ROBOT_UNROLLED_BODIES_MAX && !uses_body_lanes(r))
        return 0;
    if (r->tip_count && ROBOT_BODIES > ROBOT_TWO_PASS_BODIES_MAX && uses_body_lanes(r))
        return 0;
    return !r->tip_count || supports_tip(host, r);
}

static int supports_derivatives(const tfa_request *r)
{
    return ROBOT_HAS_DERIVATIVES && !r->tip_count && !r->wrench_count && !r->payload_count;
}

/* Ops whose answers are made of M */
#define BY_MASS_MATRIX (TFA_OP_BIT(TFA_OP_MASS_MATRIX) | TRAIT_DERIVATIVES)

static int supports_request(const struct tfa_host_api *host, const tfa_request *r)
{
    if (!supports_options(r) ||
        (r->method == TFA_METHOD_CRBA && !(TFA_OP_BIT(r->op) & BY_MASS_MATRIX)))
        return 0;
    switch (r->op) {
    case TFA_OP_FORWARD_DYNAMICS:
        return supports_forward(host, r);
    case TFA_OP_INVERSE_DYNAMICS:
        return !r->tip_count;
    case TFA_OP_MASS_MATRIX:
        return ROBOT_HAS_MASS && !r->tip_count;
    case TFA_OP_OPERATIONAL_INERTIA:
        return supports_tip(host, r);
    case TFA_OP_DERIVATIVES:
    case TFA_OP_INVERSE_DYNAMICS_DERIVATIVES:
        return supports_derivatives(r);
    default:
        return 0;
    }
}

/* There is code for batches only. */
static int supports_request_f32(const struct tfa_host_api *host, const tfa_request *r)
{
    return supports_request(host, r) && (!r->tip_count || ROBOT_HAS_BATCH_TIPS) &&
           !(TFA_OP_BIT(r->op) & TRAITS_DERIVATIVES);
}

#endif
