/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Changes of the robot by a request: payloads, locked joints, the part of it that the
 * answer depends on; wrenches, and modes of flexible links.
 */
#include <string.h>

#include "dynamics/chain/chain.h"
#include "dynamics/chain/tfa.h"
#include "dynamics/core/lock.h"
#include "dynamics/core/modes.h"
#include "dynamics/kinematics/frame.h"
#include "dynamics/solve/load.h"
#include "dynamics/solve/method.h"
#include "interface/traits.h"
#include "layout/body.h"
#include "model/payload.h"
#include "model/tips.h"

/* ---- payloads ---- */

static int same_payloads(const struct state *s, const tfa_request *r)
{
    if (!s->payloads && !r->payload_count)
        return 1;
    return s->payloads == r->payload_count &&
           memcmp(s->payload_frame, r->payload_frames, s->payloads * sizeof(uint32_t)) == 0 &&
           memcmp(s->payload, r->payloads, s->payloads * TFA_PAYLOAD_NUMBERS * sizeof(double)) == 0;
}

#ifdef NUM_QUAD
static void restore_body_quad(struct state *s, uint32_t body)
{
    s->payload_body_quad[body] = *s->m->body[body].quad;
    s->payload_body[body].quad = &s->payload_body_quad[body];
}

static void add_payload_quad(struct state *s, uint32_t frame, const double *numbers)
{
    tfa_payload p = {.mass = numbers[0]};
    memcpy(p.com, numbers + 1, sizeof p.com);
    memcpy(p.inertia, numbers + 4, sizeof p.inertia);
    tfa_mass_properties_add_payload(&s->payload_body_quad[s->m->frame[frame].body].mass,
                                    &s->m->frame_quad[frame], &p);
}
#endif

/* The model's constants of a body, for payloads to be added to */
static void restore_body(struct state *s, uint32_t body)
{
    s->payload_body[body] = s->m->body[body];
#ifdef NUM_QUAD
    restore_body_quad(s, body);
#endif
}

static void add_payload(struct state *s, uint32_t frame, const double *numbers)
{
    const struct tfa_frame *f = &s->m->frame[frame];
    tfa_body_add_payload(&s->payload_body[f->body], f, numbers);
#ifdef NUM_QUAD
    add_payload_quad(s, frame, numbers);
#endif
}

/* Bodies with a payload, now or in the request before: constants of the model, then what is
 * added now. */
static void load_payloads(struct state *s, const tfa_request *r)
{
    const struct tfa_model *m = s->m;
    if (s->body == m->body) {
        for (uint32_t i = 0; i < m->bodies; i++)
            restore_body(s, i);
        s->body = s->payload_body;
    }
    uint32_t changed[2 * TFA_MAX_PAYLOADS], count = 0;
    for (uint32_t k = 0; k < s->payloads; k++)
        if (m->frame[s->payload_frame[k]].body >= 0)
            changed[count++] = (uint32_t)m->frame[s->payload_frame[k]].body;
    for (uint32_t k = 0; k < count; k++)
        restore_body(s, changed[k]);
    s->payloads = r->payload_count;
    for (uint32_t k = 0; k < s->payloads; k++) {
        const struct tfa_frame *f = &m->frame[r->payload_frames[k]];
        const double *numbers = r->payloads + TFA_PAYLOAD_NUMBERS * (size_t)k;
        s->payload_frame[k] = r->payload_frames[k];
        memcpy(s->payload + TFA_PAYLOAD_NUMBERS * (size_t)k, numbers,
               TFA_PAYLOAD_NUMBERS * sizeof *numbers);
        if (f->body < 0)
            continue; /* the world carries it */
        add_payload(s, r->payload_frames[k], numbers);
        changed[count++] = (uint32_t)f->body;
    }
    for (uint32_t k = 0; k < count; k++)
        TFA_V(tfa_precompute_body)(s, changed[k]);
    if (!s->payloads)
        s->body = m->body;
    tfa_payload_size(m, s->payloads, s->payload, s->payload_size);
}

/* ---- locked joints ---- */

/* Which inner freedoms are locked. Returns whether they are those of the request before. */
static int load_locks(struct state *s, const tfa_request *r)
{
    const struct tfa_model *m = s->m;
    const uint32_t nb = m->base_freedoms;
    if (!r->locked_count && !s->locked)
        return 1;
    int same = 1;
    for (uint32_t k = 0; k < m->v_count; k++)
        s->mark[k] = 0;
    for (uint32_t k = 0; k < r->locked_count; k++) {
        const tfa_joint_info *joint = &m->joint[r->locked[k]];
        for (uint32_t j = 0; j < joint->v_count; j++)
            s->mark[joint->v_index + j] = 1;
    }
    s->locked = 0;
    for (uint32_t j = nb; j < m->freedoms - m->modes; j++) {
        const uint8_t lock = s->mark[m->freedom[j - nb].from];
        same &= lock == s->lock[j];
        s->lock[j] = lock;
        s->locked |= lock;
    }
    return same;
}

/* May bodies that nothing moves be left out? Only where neither forces nor poses are requested. */
static int may_skip(const tfa_request *r)
{
    return r->op == TFA_OP_FORWARD_DYNAMICS && !r->tip_count && !r->wrench_count && !r->flags &&
           r->estimate != TFA_ESTIMATE_ALWAYS &&
           (r->refine == 0 || r->refine == TFA_REFINE_DEFAULT);
}

/* ---- bodies that the answer depends on ---- */

/* Lambda^-1 by force propagation, and kinematics of tips, see the trees of the tips only. */
static int depends_on_tips_only(const struct state *s, const tfa_request *r)
{
    if (r->flags & (FLAGS_BODY_MOTION | TFA_WANT_MU | TFA_WANT_P))
        return 0;
    if (r->op == TFA_OP_KINEMATICS)
        return 1;
    return r->op == TFA_OP_OPERATIONAL_INERTIA && r->estimate != TFA_ESTIMATE_ALWAYS &&
           has_articulated_factors(s->by.method) &&
           (r->refine == 0 || r->refine == TFA_REFINE_DEFAULT) && !s->m->mimics && !s->locked;
}

uint32_t TFA_V(load_spans)(const struct state *s, const tfa_request *r,
                           struct span out[TFA_MAX_TIPS])
{
    const struct tfa_chain *tree[TFA_MAX_TIPS];
    if (!depends_on_tips_only(s, r)) {
        out[0] = (struct span){0, s->m->bodies};
        return 1;
    }
    const uint32_t count = tfa_trees_of_tips(s->m, r, tree);
    for (uint32_t k = 0; k < count; k++)
        out[k] = (struct span){tree[k]->first, tree[k]->end};
    return count;
}

/* ---- all of it ---- */

int TFA_V(load_changes)(struct state *s, const tfa_request *r)
{
    int same = 1;
    if (!same_payloads(s, r)) {
        load_payloads(s, r);
        same = 0;
    }
    if (!load_locks(s, r) || (s->locked && s->skips_unused != may_skip(r))) {
        s->skips_unused = may_skip(r);
        TFA_V(lock_plan)(s, s->skips_unused);
        same = 0;
    }
    return same;
}

/* ---- wrenches ---- */

/* Sum of the unit wrenches at its frame times the six numbers of wrench w */
svec TFA_V(wrench_of)(const struct state *s, const tfa_request *r, uint32_t w)
{
    svec P[6], sum = sv_zero();
    (void)TFA_V(frame_columns)(s, r->wrench_frames[w], r->frame, P);
    for (int e = 0; e < 6; e++)
        sum = sv_add(sum, sv_scale(P[e], gather_states(s, r->wrenches, (size_t)6 * r->wrench_count,
                                                       (size_t)6 * w + (size_t)e)));
    return sum;
}

/* On a frame inside a fused joint it acts as on the body, but for the freedoms behind it, which it
 * does not load. */
static void add_wrench(struct state *s, const tfa_request *r, uint32_t w)
{
    const uint32_t frame = r->wrench_frames[w];
    const int32_t body = s->m->frame[frame].body;
    if (body < 0)
        return;
    const svec sum = TFA_V(wrench_of)(s, r, w);
    s->wrench[body] = sv_add(s->wrench[body], sum);
    const struct tfa_body *b = &s->body[body];
    if (s->m->frame[frame].handle >= 0)
        TFA_V(modes_force)(s, s->m->frame[frame].handle, sum, s->passive_force);
    const uint32_t moved = TFA_V(frame_freedoms)(s, frame);
    if (moved == b->n)
        return;
    num x[6];
    joint_force(s, b, sum, x);
    for (uint32_t k = moved; k < b->n; k++)
        s->passive_force[b->v + k] -= x[k];
    s->has_passive_force = 1;
}

void TFA_V(load_wrenches)(struct state *s, const tfa_request *r)
{
    if (!r->wrench_count && !s->wrenched)
        return;
    for (uint32_t i = 0; i < s->m->bodies; i++)
        s->wrench[i] = sv_zero();
    for (uint32_t w = 0; w < r->wrench_count; w++)
        add_wrench(s, r, w);
    s->wrenched = r->wrench_count > 0;
}

/* ---- modes ---- */

int TFA_V(load_modes)(struct state *s, const tfa_request *r)
{
    num_mask same = num_of(0) == num_of(0);
    for (uint32_t k = 0; k < s->m->modes; k++) {
        const num x = r->modes ? gather_states(s, r->modes, s->m->modes, k) : num_of(0);
        same &= x == s->eta[k];
        s->eta[k] = x;
    }
    return num_all(same);
}

int TFA_V(load_mode_velocities)(struct state *s, const tfa_request *r)
{
    num_mask none = num_of(0) == num_of(0);
    num *qd = s->qd + (s->freedoms - s->m->modes);
    for (uint32_t k = 0; r->mode_velocities && k < s->m->modes; k++) {
        qd[k] = gather_states(s, r->mode_velocities, s->m->modes, k);
        none &= qd[k] == num_of(0);
    }
    for (uint32_t i = 0; i < s->m->flexible_bodies; i++) {
        const struct tfa_flexible *f = &s->m->flexible[i];
        for (uint32_t k = 0; k < f->n; k++)
            for (uint32_t j = 0; j < f->n; j++)
                s->passive_force[f->v + k] -= num_of(f->K[f->n * k + j]) * s->eta[f->first + j] +
                                              num_of(f->D[f->n * k + j]) * s->qd[f->v + j];
        s->has_passive_force = 1;
    }
    return !num_all(none);
}
