/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * From the caller's arrays to the state and back: base first, doubles outside.
 */
#include "kernel/load.h"

#include <math.h>

#include "kernel/kernel.h"
#include "kernel/lambda.h"

/* out = base six, then joints; a NULL input is zero. Returns whether anything is not zero. */
static int load_freedoms(const struct state *s, num *out, const double *base, const double *joints)
{
    const uint32_t nb = s->m->base_freedoms, n = s->m->freedoms;
    int any = 0;
    for (uint32_t j = 0; j < nb; j++) {
        double x = base ? base[j] : 0;
        any |= x != 0;
        out[j] = (num)x;
    }
    for (uint32_t j = nb; j < n; j++) {
        double x = joints ? joints[j - nb] : 0;
        any |= x != 0;
        out[j] = (num)x;
    }
    return any;
}

static const double *at(const double *array, size_t stride, uint32_t k)
{
    return array ? array + stride * k : NULL;
}

/* Sum of the unit wrenches at a frame times the six numbers given */
static void add_wrench(struct state *s, uint32_t frame, tfa_reference_frame mode, const double *w)
{
    svec P[6];
    int32_t body = TFA_V(frame_columns)(s, frame, mode, P);
    for (int e = 0; body >= 0 && e < 6; e++)
        s->wrench[body] = sv_add(s->wrench[body], sv_scale(P[e], (num)w[e]));
}

static void load_wrenches(struct state *s, const tfa_request *r, uint32_t k)
{
    if (!r->wrench_count && !s->wrenched)
        return;
    for (uint32_t i = 0; i < s->m->bodies; i++)
        s->wrench[i] = sv_zero();
    for (uint32_t w = 0; w < r->wrench_count; w++)
        add_wrench(s, r->wrench_frames[w], r->frame,
                   r->wrenches + 6 * ((size_t)r->wrench_count * k + w));
    s->wrenched = r->wrench_count > 0;
}

void TFA_V(load)(struct state *s, const tfa_request *r, uint32_t k)
{
    const struct tfa_model *m = s->m;
    const size_t nj = m->freedoms - m->base_freedoms;
    s->gravity = v3_load(r->gravity ? r->gravity : m->gravity);
    s->tips = r->tip_count;
    for (uint32_t t = 0; t < r->tip_count; t++)
        s->tip[t] = r->tips[t];
    TFA_V(pose)(s, at(r->base_pose, 7, k), at(r->q, m->q_count, k));
    if (r->op == TFA_OP_OPERATIONAL_INERTIA || r->op == TFA_OP_MASS_MATRIX)
        return;
    load_wrenches(s, r, k);
    s->moving = load_freedoms(s, s->qd, at(r->base_twist, 6, k), at(r->v, nj, k));
    s->moving |= s->wrenched;
    if (r->op == TFA_OP_FORWARD_DYNAMICS)
        load_freedoms(s, s->tau, at(r->base_wrench, 6, k), at(r->tau, nj, k));
    else
        load_freedoms(s, s->qdd, at(r->base_acceleration, 6, k), at(r->qdd, nj, k));
    TFA_V(velocity)(s);
}

int TFA_V(unload)(const struct state *s, const num *x, double *base, double *joints)
{
    const uint32_t nb = s->m->base_freedoms;
    int finite = 1;
    for (uint32_t j = 0; j < s->m->freedoms; j++) {
        double value = (double)x[j];
        finite &= isfinite(value) != 0;
        if (j >= nb && joints)
            joints[j - nb] = value;
        else if (j < nb && base)
            base[j] = value;
    }
    return finite;
}
