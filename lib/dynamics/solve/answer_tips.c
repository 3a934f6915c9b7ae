/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Answers for the tips of a request with factors that another kernel computed: body lanes
 * (body_lanes.c) leave the six wrenches of each tip, which fill vectors themselves, to one number
 * at a time.
 */
#include "dynamics/core/sentinel.h"
#include "dynamics/kinematics/tip_motion.h"
#include "dynamics/osim/constraint_rows.h"
#include "dynamics/solve/answer.h"
#include "dynamics/solve/load.h"
#include "dynamics/solve/method.h"
#include "interface/kernel_table.h"
#include "interface/traits.h"

struct tfa_factor_buffers TFA_V(factor_buffers)(struct state *s)
{
    return (struct tfa_factor_buffers){.X = s->X,
                                       .U = s->U,
                                       .Dinv = s->Dinv,
                                       .c = s->c,
                                       .u = s->u,
                                       .v = s->v,
                                       .a = s->a,
                                       .f = s->f,
                                       .moving = &s->moving,
                                       .part = (char *)s->joint_nd->part,
                                       .H = (char *)s->joint_nd->H,
                                       .joint_nd_U = (char *)s->joint_nd->U,
                                       .L = (char *)s->joint_nd->L,
                                       .joint_nd_u = (char *)s->joint_nd->u,
                                       .joint_nd_bytes = sizeof *s->joint_nd};
}

/* c and u came with the factors: the forces of forward dynamics. Where directions are lost more is
 * read than there is. */
static int answer_task(struct state *s, const tfa_request *r, uint32_t k, tfa_reply *reply,
                       tfa_answer *out)
{
    s->keeps_force = KEEPS_FORCE_GIVEN;
    TFA_V(load_forces)(s, r->base_wrench, r->tau);
    TFA_V(task_error)(s, r, k);
    return TFA_V(lambda_after)(s, r, k, METHOD_OF_ESTIMATES, 0, reply) &&
           TFA_V(answer_operational)(s, r, k, reply, out) == TFA_OK;
}

/* The same of constrained dynamics: forces, and what they leave of u for the other kernel */
static int answer_constraints(struct state *s, const tfa_request *r, uint32_t k, tfa_reply *reply,
                              tfa_answer *out)
{
    s->keeps_force = KEEPS_FORCE_GIVEN;
    TFA_V(constraints_activate)(s, r->constraints);
    return TFA_V(constraint_forces)(s, r, k, reply, out) == TFA_OK;
}

int TFA_V(residual_of_reply)(struct state *s, uint32_t k, tfa_reply *reply)
{
    TFA_V(load_accelerations)(s, reply->base_acceleration, reply->qdd);
    return TFA_V(constraint_residual)(s, k, reply);
}

/* The other's factors are those of some bodies at a q that was never loaded: nothing is kept. */
int TFA_V(answer_tips)(struct state *s, const tfa_request *r, struct tfa_resolved by, uint32_t k,
                       tfa_reply *reply, tfa_answer *out)
{
    const uint32_t motion = r->flags & (FLAGS_TIP_MOTION | TFA_WANT_POSES);
    int finite = 1;
    s->by = by;
    load_indices(s, r, k, 1);
    (void)TFA_V(load_changes)(s, r);
    s->spans = TFA_V(load_spans)(s, r, s->span);
    s->have = HAVE_POSE | HAVE_ABA;
    sentinel_reset(s); /* of these factors it was asked before */
    if (motion)
        TFA_V(locate_tips)(s);
    if (motion ||
        TFA_OP_BIT(r->op) &
            (TRAIT_TASK | TRAIT_CONSTRAINED_FD)) { /* poses came with the factors, these did not */
        (void)TFA_V(load_freedoms)(s, s->qd, r->base_twist, r->v);
        TFA_V(leave_boost)(s);
    }
    if (r->op == TFA_OP_TASK_TORQUES)
        finite = answer_task(s, r, k, reply, out);
    else if (r->op == TFA_OP_CONSTRAINED_DYNAMICS)
        finite = answer_constraints(s, r, k, reply, out);
    else if (r->op == TFA_OP_OPERATIONAL_INERTIA)
        finite = TFA_V(answer_lambda)(s, r, k, reply, out) == TFA_OK;
    else if (reply->lambda_inv)
        finite = TFA_V(lambda_after)(s, r, k, METHOD_OF_ESTIMATES, 0, reply);
    if (motion)
        finite &= TFA_V(answer_motion_loaded)(s, r, motion, k, reply);
    s->have = 0;
    return finite;
}
