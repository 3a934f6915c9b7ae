/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Six wrenches on their way inward, side by side (six.h): what joints yield to them and what they
 * pass on.
 *   psi = H^T P,  phi = D^-1 psi,  P <- X^T (P - U phi),  C = sum of psi^T phi
 */
#include "kernel/aba_step.h"
#include "kernel/carry_step.h"
#include "kernel/kernel.h"
#include "kernel/lambda.h"

/* Past the joint of body i, any. Returns its freedoms. */
static inline uint32_t past(const struct state *s, int32_t i, uint32_t moved, struct wrenches *P,
                            six psi[6], six phi[6])
{
    const struct tfa_body *b = &s->body[i];
    if (is_revolute(b->kind))
        past_1(s, i, AXIS_RZ, P, psi, phi);
    else if (is_prismatic(b->kind))
        past_1(s, i, AXIS_TZ, P, psi, phi);
    else
        past_n(s, b, moved, P, psi, phi);
    return b->n;
}

void TFA_V(propagate)(const struct state *s, int32_t i, uint32_t moved, struct wrenches *P,
                      six psi[6], six phi[6])
{
    (void)past(s, i, moved, P, psi, phi);
    wrenches_to_parent(&s->X[i], P, 0);
}

/* Past the joint of body i, any, with what it yields */
TFA_INLINE void carry_body(const struct state *s, int32_t i, uint32_t moved, struct wrenches *p,
                           struct block *c)
{
    const struct tfa_body *b = &s->body[i];
    if (is_revolute(b->kind) && !(b->armature > 0) && !s->locked) {
        carry_z(s, i, p, c);
    } else if (is_revolute(b->kind)) {
        carry_1(s, i, AXIS_RZ, p, c);
    } else if (is_prismatic(b->kind)) {
        carry_1(s, i, AXIS_TZ, p, c);
    } else {
        struct wrenches P; /* in memory, for steps that are out of line */
        struct block C;
        wrenches_copy(&P, p);
        block_copy(&C, c);
        if (b->base)
            carry_base(&s->multi[b->multi], &P, &C);
        else
            carry_n(s, i, moved, &P, &C);
        wrenches_copy(p, &P);
        block_copy(c, &C);
    }
}

/* From body i on, past all whose s->support is `tips`; 0: past all */
TFA_INLINE int32_t carry_past(const struct state *s, int32_t i, uint32_t tips, uint32_t moved,
                              struct wrenches *p, struct block *c)
{
    for (; i >= 0 && (!tips || s->support[i] == tips); i = s->body[i].parent) {
        carry_body(s, i, moved, p, c);
        moved = 6;
    }
    return i;
}

int32_t TFA_V(carry)(const struct state *s, int32_t i, uint32_t tips, uint32_t moved,
                     struct wrenches *P, struct block *C)
{
    struct wrenches p;
    struct block c;
    wrenches_copy(&p, P);
    block_copy(&c, C);
    i = carry_past(s, i, tips, moved, &p, &c);
    wrenches_copy(P, &p);
    block_copy(C, &c);
    return i;
}

void TFA_V(carry_home)(const struct state *s, const struct tip_wrenches *w, num lambda[36])
{
    struct wrenches p;
    struct block c = block_zero();
    wrenches_copy(&p, &w->P);
    (void)carry_past(s, w->body, 0, w->moved, &p, &c);
    for (int e = 0; e < 6; e++)
        six_store(lambda + 6 * e, &c.row[e]);
}

void TFA_V(lambda_fold)(struct state *s, tfa_reference_frame frame)
{
    struct tip_wrenches w;
    struct wrenches p;
    struct block c = block_zero();
    TFA_V(tip_start)(s, 0, frame, &w);
    wrenches_copy(&p, &w.P);
    sentinel_reset(s);
    for (uint32_t k = s->spans; k-- > 0;)
        for (uint32_t i = s->span[k].end; i-- > s->span[k].first;) {
            fold(s, i, NULL, FOLD_INERTIA | FOLD_FRESH | FOLD_WATCH);
            if ((int32_t)i != w.body)
                continue;
            carry_body(s, w.body, w.moved, &p, &c);
            w.body = s->body[i].parent;
            w.moved = 6;
        }
    have_aba(s);
    for (int e = 0; e < 6; e++)
        six_store(s->lambda + 6 * e, &c.row[e]);
}
