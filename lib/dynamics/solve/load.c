/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * From the caller's arrays to the state and back: base first, doubles outside, inner order inside.
 * Notices while copying whether the state before is still good.
 */
#include "dynamics/solve/load.h"

#include "dynamics/core/recursions.h"
#include "interface/traits.h"
#include "spatial/friction.h"

static num coordinate_of(const struct state *s, const tfa_request *r, uint32_t k)
{
    const coordinate *c = &s->coordinate[k];
    return num_of(c->multiplier) * gather_joint(s, r->q, s->m->q_count, c->from) +
           num_of(c->offset);
}

/* Inner coordinates of the bodies in a span. Returns whether they are unchanged. */
static int load_coordinates(struct state *s, const tfa_request *r, struct span span)
{
    num_mask same = num_of(0) == num_of(0);
    if (span.first == span.end)
        return 1; /* nothing moves */
    const uint32_t end = span.end < s->bodies ? s->body[span.end].q : s->coordinates;
    for (uint32_t k = s->body[span.first].q; k < end; k++) {
        const num x =
            s->identity_map ? gather_states(s, r->q, s->m->q_count, k) : coordinate_of(s, r, k);
        same &= x == s->q[k];
        s->q[k] = x;
    }
    return num_all(same);
}

static int load_base(struct state *s, const tfa_request *r)
{
    num_mask same = num_of(0) == num_of(0);
    for (uint32_t k = 0; s->m->base_freedoms && k < 7; k++) {
        const num x = gather_states(s, r->base_pose, 7, k);
        same &= x == s->base[k];
        s->base[k] = x;
    }
    return num_all(same);
}

/* Is what was computed of these spans there? What was computed of everything serves for a part of
 * it; what was computed of a part serves for the same part only. */
static int covers(const struct state *s, const struct span *wanted, uint32_t count)
{
    if (s->have && s->spans == 1 && s->span[0].end - s->span[0].first == s->bodies)
        return 1;
    int same = count == s->spans;
    for (uint32_t k = 0; same && k < count; k++)
        same = wanted[k].first == s->span[k].first && wanted[k].end == s->span[k].end;
    return same;
}

/* Spans that the answer depends on: coordinates of other trees are not read. */
static void load_pose(struct state *s, const tfa_request *r)
{
    struct span wanted[TFA_MAX_TIPS];
    int same = TFA_V(load_changes)(s, r);
    const uint32_t count = TFA_V(load_spans)(s, r, wanted);
    for (uint32_t k = 0; k < count; k++)
        same &= load_coordinates(s, r, wanted[k]);
    same &= load_base(s, r);
    if (HAS_MODES(s))
        same &= TFA_V(load_modes)(s, r);
    if (same && covers(s, wanted, count))
        return;
    s->have = 0;
    s->spans = count;
    for (uint32_t k = 0; k < count; k++) {
        s->span[k].first = wanted[k].first;
        s->span[k].end = wanted[k].end;
    }
}

/* Numbers of the joints: as they come where the inner ones are the public ones in the same order.
 * In a loop of their own: compilers leave the question in a common one, for 3 % of a batch's time
 * (bench_suite, batch-f64, arm7 and humanoid, gcc 12, AMD EPYC Zen 4 VM, 2026-11-22). Returns
 * whether all are zero. */
static num_mask load_joints(const struct state *s, num *out, const double *joints, uint32_t count)
{
    const size_t stride = s->m->v_count;
    num_mask none = num_of(0) == num_of(0);
    for (uint32_t j = 0; s->identity_map && j < count; j++) {
        out[j] = gather_states(s, joints, stride, j);
        none &= out[j] == num_of(0);
    }
    for (uint32_t j = 0; !s->identity_map && j < count; j++) {
        const freedom *f = &s->freedom[j];
        out[j] = num_of(f->multiplier) * gather_joint(s, joints, stride, f->from);
        none &= out[j] == num_of(0);
    }
    return none;
}

/* out = base six, then joints; a NULL input is zero. Returns whether anything is not zero. */
int TFA_V(load_freedoms)(const struct state *s, num *out, const double *base, const double *joints)
{
    const uint32_t nb = s->m->base_freedoms, n = s->freedoms - s->m->modes;
    num_mask none = num_of(0) == num_of(0);
    for (uint32_t j = 0; j < nb; j++) {
        out[j] = base ? gather_states(s, base, 6, j) : num_of(0);
        none &= out[j] == num_of(0);
    }
    if (joints)
        none &= load_joints(s, out + nb, joints, n - nb);
    for (uint32_t j = joints ? n : nb; j < s->freedoms; j++)
        out[j] = num_of(0); /* modes, too */
    return !num_all(none);
}

void TFA_V(load_forces)(struct state *s, const double *base, const double *joints)
{
    const struct tfa_model *m = s->m;
    TFA_V(load_freedoms)(s, s->tau, base, joints);
    for (uint32_t k = 0; k < m->mimics; k++)
        s->tau[m->mimic[k].follower] = num_of(0);
}

void TFA_V(load_tau)(struct state *s, const tfa_request *r)
{
    TFA_V(load_forces)(s, r->base_wrench, r->tau);
    for (uint32_t j = 0; s->has_passive_force && j < s->freedoms; j++)
        s->tau[j] += s->passive_force[j];
}

/* ---- velocities, forces ---- */

static void clear_passive_force(struct state *s)
{
    if (!s->has_passive_force)
        return;
    for (uint32_t j = 0; j < s->freedoms; j++)
        s->passive_force[j] = num_of(0);
    s->has_passive_force = 0;
}

/* Damping, then friction, as TFA_V(dissipative_force) adds them */
static void load_dissipation(struct state *s)
{
    const struct tfa_model *m = s->m;
    const num scale = num_of(m->friction_velocity);
    for (uint32_t j = m->base_freedoms; m->damping && j < s->freedoms; j++)
        s->passive_force[j] -= load_damping_of(s, j) * s->qd[j];
    for (uint32_t j = m->base_freedoms; m->friction && j < s->freedoms; j++)
        s->passive_force[j] -= load_friction_of(s, j) * friction_sign(s->qd[j], scale);
    s->has_passive_force |= m->damping || m->friction;
}

/* Of the free joint whose freedoms start at j. Lanes at rest keep every bit. */
static void leave_boost_of_root(struct state *s, uint32_t j, int held)
{
    num *qd = s->qd + j, *boost = s->boost + j, *rate = s->boost_rate + j;
    num_mask none = num_of(0) == num_of(0);
    for (uint32_t k = 0; k < 3; k++) {
        boost[k] = held ? num_of(0) : qd[k];
        none &= boost[k] == num_of(0);
    }
    const vec3 r = v3_cross(v3(qd[3], qd[4], qd[5]), v3(boost[0], boost[1], boost[2]));
    rate[0] = r.x;
    rate[1] = r.y;
    rate[2] = r.z;
    for (uint32_t k = 0; k < 3; k++)
        qd[k] = num_select(boost[k] == num_of(0), qd[k], num_of(0));
    s->boosted |= !num_all(none);
}

void TFA_V(leave_boost)(struct state *s)
{
    s->boosted = 0;
    for (uint32_t t = 0; t < s->m->trees; t++) {
        const uint32_t root = s->m->chain[t].first;
        const struct tfa_body *b = &s->m->body[root];
        if (is_free(b->kind))
            leave_boost_of_root(s, s->body[body_at(s, root)].v,
                                (s->locked && s->lock[b->v]) || s->m->armature[b->v] > 0);
    }
}

/* x + y; x to the bit where y is 0 */
static num shifted(num x, num y)
{
    return num_select(y == num_of(0), x, x + y);
}

void TFA_V(load_accelerations)(struct state *s, const double *base, const double *joints)
{
    TFA_V(load_freedoms)(s, s->qdd, base, joints);
    for (uint32_t j = 0; s->boosted && j < s->freedoms; j++)
        s->qdd[j] = shifted(s->qdd[j], s->boost_rate[j]);
}

const num *TFA_V(world_accelerations)(const struct state *s)
{
    for (uint32_t j = 0; s->boosted && j < s->freedoms; j++)
        s->dx[j] = shifted(s->qdd[j], -s->boost_rate[j]);
    return s->boosted ? s->dx : s->qdd;
}

void TFA_V(round_accelerations)(struct state *s)
{
    const num *world = TFA_V(world_accelerations)(s);
    for (uint32_t j = 0; s->boosted && j < s->freedoms; j++)
        s->qdd[j] = shifted(world[j], s->boost_rate[j]);
}

static void load_motion(struct state *s, const tfa_request *r)
{
    clear_passive_force(s);
    if (reads_wrenches(r))
        TFA_V(load_wrenches)(s, r);
    s->moving = TFA_V(load_freedoms)(s, s->qd, r->base_twist, r->v);
    if (HAS_MODES(s))
        s->moving |= TFA_V(load_mode_velocities)(s, r);
    load_dissipation(s);
    TFA_V(leave_boost)(s);
    s->moving |= s->wrenched && reads_wrenches(r);
    if (TFA_OP_BIT(r->op) & TRAITS_FORWARD) {
        TFA_V(load_tau)(s, r);
    } else if (TFA_OP_BIT(r->op) & TRAITS_DYNAMICS) {
        TFA_V(load_accelerations)(s, r->base_acceleration, r->qdd);
        for (uint32_t j = 0; s->locked && j < s->freedoms; j++)
            if (s->lock[j])
                s->qdd[j] = num_of(0);
    }
}

/* 1: only bodies that carry tips are loaded; tips need no velocities of bodies */
static int sees_tips_only(const struct state *s, const tfa_request *r)
{
    return !(TFA_OP_BIT(r->op) & TRAITS_DYNAMICS) &&
           !(r->flags & (FLAGS_BODY_MOTION | TFA_WANT_MU)) && s->lanes == 1;
}

void TFA_V(load)(struct state *s, const tfa_request *r, uint32_t k, uint32_t count)
{
    load_indices(s, r, k, count);
    load_pose(s, r);
    TFA_V(pose)(s);
    if (!reads_velocity(r))
        return;
    load_motion(s, r);
    if (!sees_tips_only(s, r))
        TFA_V(velocity)(s);
}

int TFA_V(unload)(const struct state *s, const num *x, double *base, double *joints)
{
    const uint32_t nb = s->m->base_freedoms, end = s->freedoms - s->m->modes;
    num sum = num_of(0);
    for (uint32_t j = 0; j < s->freedoms; j++)
        sum += nonfinite(x[j]);
    for (uint32_t j = 0; base && j < nb; j++)
        scatter_states(s, x[j], base + j, 6);
    for (uint32_t j = nb; s->identity_map && joints && j < end; j++)
        scatter_states(s, x[j], joints + (j - nb), s->m->v_count);
    for (uint32_t j = nb; !s->identity_map && joints && j < end; j++)
        scatter_joint(s, x[j], joints, &s->freedom[j - nb]);
    return num_all(sum == num_of(0));
}

void TFA_V(gather_on_leaders)(struct state *s, num *tau)
{
    const struct tfa_model *m = s->m;
    for (uint32_t k = 0; k < m->mimics; k++)
        tau[m->mimic[k].leader] += num_of(m->mimic[k].multiplier) * tau[m->mimic[k].follower];
    for (uint32_t k = 0; k < m->mimics; k++)
        tau[m->mimic[k].follower] = num_of(0);
}

int TFA_V(unload_force)(struct state *s, num *x, double *base, double *joints)
{
    TFA_V(gather_on_leaders)(s, x);
    for (uint32_t j = 0; j < s->m->mimics; j++) /* one public force stands for both */
        x[s->m->mimic[j].follower] = x[s->m->mimic[j].leader];
    return TFA_V(unload)(s, x, base, joints);
}

int TFA_V(inverse_dynamics)(struct state *s, uint32_t k, tfa_reply *reply)
{
    TFA_V(rnea)(s, s->qdd, s->res, 1);
    for (uint32_t j = 0; s->has_passive_force && j < s->freedoms; j++)
        s->res[j] -= s->passive_force[j];
    return TFA_V(unload_force)(s, s->res,
                               reply->base_wrench ? reply->base_wrench + 6 * (size_t)k : NULL,
                               reply->tau ? reply->tau + (size_t)s->m->v_count * k : NULL);
}

int TFA_V(unload_qdd)(const struct state *s, uint32_t k, tfa_reply *reply)
{
    const num *qdd = TFA_V(world_accelerations)(s);
    for (uint32_t j = 0; reply->modes && j < s->m->modes; j++)
        scatter_states(s, qdd[s->freedoms - s->m->modes + j],
                       reply->modes + (size_t)s->m->modes * k + j, s->m->modes);
    return TFA_V(unload)(s, qdd,
                         reply->base_acceleration ? reply->base_acceleration + 6 * (size_t)k : NULL,
                         reply->qdd ? reply->qdd + (size_t)s->m->v_count * k : NULL);
}
