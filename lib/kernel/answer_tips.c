/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * What a request asks of its tips, with factors that another kernel computed: limbs that went side by
 * side (limbs.c) leave the six wrenches of each tip, which fill vectors themselves, to one number at a
 * time.
 */
#include "kernel/answer.h"
#include "kernel/kernel.h"
#include "kernel/load.h"
#include "kernel/method.h"
#include "kernel/table.h"

struct tfa_factors TFA_V(lend)(struct state *s)
{
    return (struct tfa_factors){.X = s->X,
                                .U = s->U,
                                .Dinv = s->Dinv,
                                .part = (char *)s->multi->part,
                                .H = (char *)s->multi->H,
                                .multi_U = (char *)s->multi->U,
                                .L = (char *)s->multi->L,
                                .multi_bytes = sizeof *s->multi};
}

/* The other's factors are those of some bodies at a q that was never loaded: nothing is kept. */
int TFA_V(answer_tips)(struct state *s, const tfa_request *r, struct tfa_resolved by, uint32_t k,
                       tfa_reply *reply, tfa_answer *out)
{
    int finite = 1;
    s->by = by;
    load_names(s, r, k, 1);
    (void)TFA_V(load_changes)(s, r);
    s->spans = TFA_V(load_spans)(s, r, s->span);
    s->have = HAVE_POSE | HAVE_ABA;
    if (r->op == TFA_OP_OPERATIONAL_INERTIA)
        finite = TFA_V(answer_lambda)(s, r, k, reply, out) == TFA_OK;
    else if (reply->lambda_inv)
        finite = TFA_V(lambda_after)(s, r, k, METHOD_OF_ESTIMATES, 0, reply);
    TFA_V(answer_poses)(s, r, k, reply);
    s->have = 0;
    return finite;
}
