/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Which requests a kernel of one robot's own answers: forward dynamics, inverse dynamics, Lambda^-1 of
 * one tip, and forward dynamics with it, of the robot as its tables say, plainly.
 */
#ifndef TFA_KERNEL_OWN_TAKES_H
#define TFA_KERNEL_OWN_TAKES_H

#include "kernel/own_abi.h"
#include "model/model.h"

/* Robots with more bodies have code for tips where hands and feet are: on bodies that carry none, or
 * several. It grows with bodies times tips. */
#define OWN_TIPS_EVERYWHERE 16
/* More bodies than this, and forward dynamics with a tip in two walks, one with all limbs side by side, take longer
 * than the one walk of the generic kernel: 31 bodies 1.4 times as fast, 47 bodies 0.7 times (docs/specialised.md). */
#define OWN_TWO_WALKS_MAX 40

TFA_INLINE int own_forks(int32_t body)
{
    int children = 0;
#pragma GCC unroll 128
    for (int32_t i = 0; i < OWN_BODIES; i++)
        children += own_body[i].parent == body;
    return children != 1;
}

#define OWN_HAS_TIP(i) (OWN_BODIES <= OWN_TIPS_EVERYWHERE || own_forks(i))

static int own_takes_tip(const struct tfa_own_host *host, const tfa_request *r)
{
    const struct tfa_frame *f = &host->model->frame[r->tips[0]];
    return r->tip_count == 1 && f->body >= 0 && f->part == 0 && OWN_HAS_TIP(f->body) &&
           !(r->flags & TFA_WANT_POSES);
}

/* The robot is that of the tables, but for gravity and, without tips, payloads. */
static int own_takes_robot(const tfa_request *r)
{
    return !r->wrench_count && !r->locked_count && !(r->payload_count && r->tip_count) &&
           r->estimate != TFA_ESTIMATE_ALWAYS &&
           (r->refine == 0 || r->refine == TFA_REFINE_DEFAULT);
}

static int own_goes_by_limbs(const tfa_request *r)
{
#ifdef OWN_LIMB_LANES
    return !r->payload_count;
#else
    (void)r;
    return 0;
#endif
}

static int own_takes_forward(const struct tfa_own_host *host, const tfa_request *r)
{
    if (OWN_BODIES > OWN_WALK_MAX && !own_goes_by_limbs(r))
        return 0;
    if (r->tip_count && OWN_BODIES > OWN_TWO_WALKS_MAX && own_goes_by_limbs(r))
        return 0;
    return !r->tip_count || own_takes_tip(host, r);
}

static int own_takes(const struct tfa_own_host *host, const tfa_request *r)
{
    if (!own_takes_robot(r))
        return 0;
    switch (r->op) {
    case TFA_OP_FORWARD_DYNAMICS:
        return own_takes_forward(host, r);
    case TFA_OP_INVERSE_DYNAMICS:
        return !r->tip_count;
    case TFA_OP_OPERATIONAL_INERTIA:
        return own_takes_tip(host, r);
    default:
        return 0;
    }
}

#endif
