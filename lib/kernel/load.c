/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * From the caller's arrays to the state and back: base first, doubles outside, inner order inside.
 * Notices while copying whether the state before is still good.
 */
#include "kernel/load.h"

#include <float.h>

#include "kernel/kernel.h"

/* Inner coordinates and base pose. Returns whether they are those of the request before. */
static int load_coordinates(struct state *s, const tfa_request *r)
{
    const struct tfa_model *m = s->m;
    num_mask same = num_of(0) == num_of(0);
    for (uint32_t k = 0; k < m->inner_q; k++) {
        const struct tfa_coordinate *c = &m->coordinate[k];
        const num x =
            num_of(c->multiplier) * take(s, r->q, m->q_count, c->from) + num_of(c->offset);
        same &= x == s->q[k];
        s->q[k] = x;
    }
    for (uint32_t k = 0; m->base_freedoms && k < 7; k++) {
        const num x = take(s, r->base_pose, 7, k);
        same &= x == s->base[k];
        s->base[k] = x;
    }
    return num_all(same);
}

/* out = base six, then joints; a NULL input is zero. Returns whether anything is not zero. */
static int load_freedoms(const struct state *s, num *out, const double *base, const double *joints)
{
    const struct tfa_model *m = s->m;
    const uint32_t nb = m->base_freedoms, n = m->freedoms;
    num_mask none = num_of(0) == num_of(0);
    for (uint32_t j = 0; j < nb; j++) {
        out[j] = base ? take(s, base, 6, j) : num_of(0);
        none &= out[j] == num_of(0);
    }
    for (uint32_t j = nb; j < n; j++) {
        const struct tfa_freedom *f = &m->freedom[j - nb];
        const num x = joints ? take(s, joints, m->v_count, f->from) : num_of(0);
        none &= x == num_of(0);
        out[j] = num_of(f->multiplier) * x;
    }
    return !num_all(none);
}

/* Forces of the joints alone: a follower's is part of its leader's already. */
static void load_forces(struct state *s, const double *base, const double *joints)
{
    const struct tfa_model *m = s->m;
    load_freedoms(s, s->tau, base, joints);
    for (uint32_t k = 0; k < m->mimics; k++)
        s->tau[m->mimic[k].follower] = num_of(0);
}

/* ---- velocities, forces ---- */

static void know_nothing(struct state *s)
{
    if (!s->known_any)
        return;
    for (uint32_t j = 0; j < s->m->freedoms; j++)
        s->known[j] = num_of(0);
    s->known_any = 0;
}

/* known -= d qd */
static void load_damping(struct state *s)
{
    if (!s->m->damping)
        return;
    for (uint32_t j = s->m->base_freedoms; j < s->m->freedoms; j++)
        s->known[j] -= num_of(s->m->damping[j]) * s->qd[j];
    s->known_any = 1;
}

static void load_motion(struct state *s, const tfa_request *r)
{
    know_nothing(s);
    TFA_V(load_wrenches)(s, r);
    s->moving = load_freedoms(s, s->qd, r->base_twist, r->v);
    load_damping(s);
    s->moving |= s->wrenched;
    if (r->op == TFA_OP_FORWARD_DYNAMICS) {
        load_forces(s, r->base_wrench, r->tau);
        for (uint32_t j = 0; s->known_any && j < s->m->freedoms; j++)
            s->tau[j] += s->known[j];
    } else {
        load_freedoms(s, s->qdd, r->base_acceleration, r->qdd);
        for (uint32_t j = 0; s->stopped && j < s->m->freedoms; j++)
            if (s->stop[j])
                s->qdd[j] = num_of(0);
    }
}

void TFA_V(load)(struct state *s, const tfa_request *r, uint32_t k, uint32_t count)
{
    s->lanes = count;
    for (uint32_t l = 0; l < NUM_LANES; l++)
        s->lane[l] = k + (l < count ? l : count - 1);
    s->gravity = v3_load(r->gravity ? r->gravity : s->m->gravity);
    s->tips = r->tip_count;
    for (uint32_t t = 0; t < r->tip_count; t++)
        s->tip[t] = r->tips[t];
    int same = load_coordinates(s, r);
    if (!TFA_V(load_changes)(s, r, same))
        s->have = 0;
    TFA_V(pose)(s);
    if (r->op == TFA_OP_OPERATIONAL_INERTIA || r->op == TFA_OP_MASS_MATRIX)
        return;
    load_motion(s, r);
    TFA_V(velocity)(s);
}

/* Every lane's number to its place; whether it is finite, as a double too: x - x is 0 or not a
 * number. */
static num_mask give(const struct state *s, num x, double *array, size_t stride)
{
    for (uint32_t l = 0; array && l < s->lanes; l++)
        array[stride * l] = (double)num_lane(x, l);
    num_mask finite = x - x == num_of(0);
    finite &= x <= num_of(DBL_MAX);
    finite &= x >= num_of(-DBL_MAX);
    return finite;
}

int TFA_V(unload)(const struct state *s, const num *x, double *base, double *joints)
{
    const struct tfa_model *m = s->m;
    const uint32_t nb = m->base_freedoms;
    num_mask finite = num_of(0) == num_of(0);
    for (uint32_t j = 0; j < nb; j++)
        finite &= give(s, x[j], base ? base + j : NULL, 6);
    for (uint32_t j = nb; j < m->freedoms; j++) {
        const struct tfa_freedom *f = &m->freedom[j - nb];
        double *out = joints && f->multiplier == 1 ? joints + f->from : NULL;
        finite &= give(s, x[j], out, m->v_count);
    }
    return num_all(finite);
}
