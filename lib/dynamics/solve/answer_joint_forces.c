/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Total forces: the wrench that each joint transmits, fixed joints included, from accelerations
 * that are known. The total force of Fijany and Featherstone (2013), of which (58) is
 * H^T F = tau and the equations of motion of the links are the rest. Across joints that move it is
 * the force of inverse dynamics; links behind fixed joints are added up by themselves.
 */
#include "dynamics/core/recursions.h"
#include "dynamics/kinematics/frame.h"
#include "dynamics/kinematics/world_pose.h"
#include "dynamics/solve/answer.h"
#include "dynamics/solve/load.h"
#include "layout/body.h"
#include "spatial/rigid.h"
#include "spatial/rows.h"

/* What a link weighs by itself, about the origin of its body's frame */
static rigid link_inertia(const struct tfa_link_mass *l)
{
#ifdef NUM_QUAD
    const struct tfa_mass_properties *p = l->quad;
#else
    const struct tfa_link_mass *p = l;
#endif
    const constant *I = p->I;
    return (rigid){constant_of(p->mass),
                   constant_vec3(p->h),
                   {constant_of(I[0]), constant_of(I[1]), constant_of(I[2]), constant_of(I[3]),
                    constant_of(I[4]), constant_of(I[5])}};
}

/* The same of payload k of the request */
static rigid payload_inertia(const struct state *s, const tfa_request *r, uint32_t k)
{
    const double *n = r->payloads + TFA_PAYLOAD_NUMBERS * (size_t)k;
    const xform f = frame_xform(s->m, r->payload_frames[k]);
    const sym3 I = {num_of(n[4]), num_of(n[5]), num_of(n[6]),
                    num_of(n[7]), num_of(n[8]), num_of(n[9])};
    const rigid centred = {num_of(n[0]), v3_zero(), s3_congruence_t(m3_t(f.E), I)};
    return rigid_shift(v3_add(m3_mul(f.E, v3_load(n + 1)), f.r), &centred);
}

/* I a + v x* I v of what moves with a body, or stands in the world */
static svec inertial_force(const struct state *s, int32_t body, const rigid *c)
{
    if (body < 0)
        return s6_rigid_mul(c->I, c->h, c->m, (svec){v3_zero(), v3_neg(s->gravity)});
    const svec f = s6_rigid_mul(c->I, c->h, c->m, s->a[body]);
    return s->moving ? sv_add(f, s6_rigid_bias(c->I, c->h, c->m, s->v[body])) : f;
}

/* ---- forces on links, in the frames of their bodies ---- */

/* F of a link: of the first one of a body that of the recursion */
static const svec *force_on(const struct state *s, uint32_t frame)
{
    return s->m->link[frame].is_first ? &s->f[s->m->frame[frame].body] : &s->link_force[frame];
}

static void add_force(struct state *s, uint32_t frame, svec f)
{
    s->link_force[frame] = sv_add(s->link_force[frame], f);
}

/* What moves a link besides its joint and its children's, negative: of links behind fixed joints */
static void load_link_forces(struct state *s, const tfa_request *r)
{
    const struct tfa_link_mass *link = s->m->link;
    for (uint32_t f = 0; f < s->m->frames; f++)
        if (!link[f].is_first)
            s->link_force[f] = sv_zero();
    for (uint32_t w = 0; w < r->wrench_count; w++)
        if (!link[r->wrench_frames[w]].is_first)
            add_force(s, r->wrench_frames[w], sv_neg(TFA_V(wrench_of)(s, r, w)));
    for (uint32_t p = 0; p < r->payload_count; p++) {
        const uint32_t frame = r->payload_frames[p];
        if (link[frame].is_first)
            continue;
        const rigid I = payload_inertia(s, r, p);
        add_force(s, frame, inertial_force(s, s->m->frame[frame].body, &I));
    }
}

/* F = I a + v x* I v - wrench + sum of the children's F, of the same links */
static void sum_inward(struct state *s)
{
    const struct tfa_model *m = s->m;
    for (uint32_t k = m->frames; k-- > 0;) {
        const uint32_t frame = m->link_order[k];
        const struct tfa_link_mass *l = &m->link[frame];
        const int32_t body = m->frame[frame].body;
        if (!l->is_first && (l->mass != 0 || l->I[0] != 0 || l->I[3] != 0 || l->I[5] != 0)) {
            const rigid I = link_inertia(l);
            add_force(s, frame, inertial_force(s, body, &I));
        }
        if (l->parent < 0 || m->link[l->parent].is_first)
            continue;
        const svec f = *force_on(s, frame);
        add_force(s, (uint32_t)l->parent, l->is_first ? xform_t_force(&s->X[body], f) : f);
    }
}

/* ---- the answer ---- */

/* Writes F of a link in the frame that the request asks for. Returns 0, or not a number where it is
 * not finite. */
static num store_force(const struct state *s, uint32_t frame, tfa_reference_frame mode, double *out)
{
    const int32_t body = s->m->frame[frame].body;
    const svec f = *force_on(s, frame);
    vec3 force = f.v, moment = f.w;
    if (mode != TFA_FRAME_WORLD)
        moment = v3_sub(moment, v3_cross(frame_in_body(s, frame).r, force));
    if (mode == TFA_FRAME_LOCAL) {
        const mat3 R = frame_in_body(s, frame).E;
        force = m3_tmul(R, force);
        moment = m3_tmul(R, moment);
    } else if (body >= 0) {
        const struct world_pose *W = &s->world[body];
        force = vec3_of_simd(mat3_simd_apply_t(&W->E, force));
        moment = vec3_of_simd(mat3_simd_apply_t(&W->E, moment));
        if (mode == TFA_FRAME_WORLD)
            moment = v3_add(moment, v3_cross(vec3_of_simd(W->r), force));
    }
    const num x[6] = {force.x, force.y, force.z, moment.x, moment.y, moment.z};
    num sum = num_of(0);
    scatter_numbers(x, s->lane, out, 6 * (size_t)s->m->frames, 6);
    for (int e = 0; e < 6; e++)
        sum += nonfinite(x[e]);
    return sum;
}

/* Of motions and forces that are there */
static int answer_links(struct state *s, const tfa_request *r, tfa_reply *reply)
{
    num sum = num_of(0);
    load_link_forces(s, r);
    sum_inward(s);
    if (r->frame != TFA_FRAME_LOCAL)
        TFA_V(world_poses)(s);
    for (uint32_t f = 0; f < s->m->frames; f++)
        sum += store_force(s, f, r->frame, reply->joint_forces + 6 * (size_t)f);
    return num_all(sum == num_of(0));
}

int TFA_V(answer_joint_forces_loaded)(struct state *s, const tfa_request *r, tfa_reply *reply)
{
    const struct tfa_model *m = s->m;
    if (r->op == TFA_OP_FORWARD_DYNAMICS) {
        if ((m->v_count && !reply->qdd) || (m->base_freedoms && !reply->base_acceleration))
            return 0;
        TFA_V(load_accelerations)(s, reply->base_acceleration, reply->qdd);
        TFA_V(rnea)(s, s->qdd, s->dx, 1);
    }
    return answer_links(s, r, reply);
}

#if NUM_LANES == 1
int TFA_V(answer_joint_forces)(struct state *s, const tfa_request *r, struct tfa_resolved by,
                               uint32_t k, int given, tfa_reply *reply)
{
    s->by = by;
    if (given) { /* of a q that was never loaded: nothing is kept */
        load_indices(s, r, k, 1);
        s->have = 0;
        return answer_links(s, r, reply);
    }
    TFA_V(load)(s, r, k, 1);
    if (r->op == TFA_OP_INVERSE_DYNAMICS)
        TFA_V(rnea)(s, s->qdd, s->dx, 1);
    return TFA_V(answer_joint_forces_loaded)(s, r, reply);
}
#endif
