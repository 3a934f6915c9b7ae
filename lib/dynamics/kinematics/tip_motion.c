/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Motion of one tip by the bodies of its support.
 */
#include "dynamics/kinematics/tip_motion.h"

#include "dynamics/core/frame.h"
#include "dynamics/core/recursions.h"
#include "dynamics/core/velocity_step.h"
#include "dynamics/kinematics/world_pose.h"

/* s->tip_path of a support whose world poses are there */
static void find_path(struct state *s, int32_t i, uint32_t length)
{
    if (s->path_body == i)
        return;
    s->path_body = i;
    for (uint32_t at = length; i >= 0; i = s->body[i].parent)
        s->tip_path[--at] = (uint32_t)i;
}

void TFA_V(locate_tips)(struct state *s)
{
    for (uint32_t t = 0; t < s->tips; t++) {
        const int32_t body = s->m->frame[s->tip[t]].body;
        if (body >= 0)
            locate_support(s, body, s->body[body].depth);
        s->located |= 1u << t;
    }
}

void TFA_V(tip_locate)(struct state *s, uint32_t t, tfa_reference_frame mode, struct tip *out)
{
    const uint32_t frame = s->tip[t];
    const int32_t body = s->m->frame[frame].body;
    out->frame = mode;
    out->length = 0;
    out->moved = 0;
    TFA_V(frame_in_body)(s, frame, &out->axes, &out->origin);
    if (body >= 0) {
        out->length = s->body[body].depth;
        out->moved = TFA_V(frame_freedoms)(s, frame);
        if (s->located >> t & 1)
            find_path(s, body, out->length);
        else
            locate_support(s, body, out->length);
        s->located |= 1u << t;
        world_frame(&s->world[body], &out->axes, &out->origin);
    }
    const vec3 p = mode == TFA_FRAME_WORLD ? v3_zero() : out->origin;
    out->p = vec3_simd_of(p.x, p.y, p.z);
}

void TFA_V(tip_velocities)(struct state *s, const struct tip *t)
{
    for (uint32_t k = 0; s->moving && !s->body_velocity && k < t->length; k++)
        velocity_step(s, s->tip_path[k], &s->body[s->tip_path[k]]);
}

/* Freedoms of the body at place k of the support that move the tip */
static uint32_t freedoms_at(const struct state *s, const struct tip *t, uint32_t k)
{
    return k + 1 < t->length ? s->body[s->tip_path[k]].n : t->moved;
}

/* Velocity and velocity product of the tip's part of the last body: within a fused joint those of
 * its first joints */
static void last_motion(const struct state *s, const struct tip *t, svec *v, svec *c)
{
    const uint32_t i = s->tip_path[t->length - 1];
    const struct tfa_body *b = &s->body[i];
    *v = s->v[i];
    *c = s->c[i];
    if (t->moved == b->n)
        return;
    *v = b->parent < 0 ? sv_zero() : xform_motion(&s->X[i], s->v[b->parent]);
    *c = sv_zero();
    for (uint32_t k = 0; k < t->moved; k++) {
        const svec joint = sv_scale(joint_nd_axis(&s->joint_nd[b->joint_nd], k), s->qd[b->v + k]);
        *c = sv_add(*c, cross_motion(*v, joint));
        *v = sv_add(*v, joint);
    }
}

/* A motion in world axes at the tip's point, linear first, in the axes asked for */
static void store_motion(const struct tip *t, svec m, num out[6])
{
    if (t->frame == TFA_FRAME_LOCAL)
        m = (svec){m3_tmul(t->axes, m.w), m3_tmul(t->axes, m.v)};
    sv_store(out, (svec){m.v, m.w});
}

static svec velocity_at_point(const struct state *s, const struct tip *t)
{
    svec v, c;
    last_motion(s, t, &v, &c);
    return motion_simd_store(motion_at_point(&s->world[s->tip_path[t->length - 1]], v, t->p));
}

void TFA_V(tip_twist)(const struct state *s, const struct tip *t, num twist[6])
{
    const int moves = s->moving && t->length;
    store_motion(t, moves ? velocity_at_point(s, t) : sv_zero(), twist);
}

/* sum of c over the support; with world axes at a point that moves along, the velocity of that
 * point turns too */
static svec velocity_product(const struct state *s, const struct tip *t)
{
    svec v, c;
    last_motion(s, t, &v, &c);
    const struct world_pose *W = &s->world[s->tip_path[t->length - 1]];
    struct motion_simd sum = motion_at_point(W, c, t->p);
    for (uint32_t k = 0; k + 1 < t->length; k++) {
        const uint32_t i = s->tip_path[k];
        sum = motion_simd_add(sum, motion_at_point(&s->world[i], s->c[i], t->p));
    }
    if (t->frame == TFA_FRAME_LOCAL_WORLD_ALIGNED) {
        const struct motion_simd tip = motion_at_point(W, v, t->p);
        sum.v = vec3_simd_add(sum.v, vec3_simd_cross(tip.w, tip.v));
    }
    return motion_simd_store(sum);
}

/* sum of H x over the support */
static svec jacobian_mul(const struct state *s, const struct tip *t, const num *x)
{
    svec sum = sv_zero();
    for (uint32_t k = 0; k < t->length; k++) {
        const uint32_t i = s->tip_path[k], first = s->body[i].v;
        for (uint32_t j = 0; j < freedoms_at(s, t, k); j++)
            sum = sv_add(
                sum, sv_scale(motion_simd_store(joint_axis_at_point(s, i, j, t->p)), x[first + j]));
    }
    return sum;
}

void TFA_V(tip_acceleration)(const struct state *s, const struct tip *t, const num *qdd,
                             num acceleration[6])
{
    svec a = s->moving && t->length ? velocity_product(s, t) : sv_zero();
    if (qdd)
        a = sv_add(a, jacobian_mul(s, t, qdd));
    store_motion(t, a, acceleration);
}

void TFA_V(tip_jacobian_mul)(const struct state *s, const struct tip *t, const num *x, num out[6])
{
    store_motion(t, jacobian_mul(s, t, x), out);
}

void TFA_V(tip_jacobian_tmul)(const struct state *s, const struct tip *t, const num F[6], num *tau)
{
    svec f = {v3(F[3], F[4], F[5]), v3(F[0], F[1], F[2])};
    if (t->frame == TFA_FRAME_LOCAL)
        f = (svec){m3_mul(t->axes, f.w), m3_mul(t->axes, f.v)};
    for (uint32_t k = 0; k < t->length; k++) {
        const uint32_t i = s->tip_path[k], first = s->body[i].v;
        for (uint32_t j = 0; j < freedoms_at(s, t, k); j++)
            tau[first + j] += sv_dot(motion_simd_store(joint_axis_at_point(s, i, j, t->p)), f);
    }
}

/* Column j of J; with mimics that of the freedom that moves it, and what others have added there */
static void add_column(const struct state *s, uint32_t j, const num column[6], uint32_t rows,
                       double *out, size_t stride)
{
    num multiplier = num_of(1);
    double *at = out + TFA_V(reduced_freedom)(s->m, j, &multiplier);
    for (uint32_t e = 0; e < rows; e++)
        at[e * stride] += (double)(multiplier * column[e]);
}

void TFA_V(tip_jacobian)(const struct state *s, const struct tip *t, uint32_t rows, double *out,
                         size_t stride)
{
    for (uint32_t k = 0; k < t->length; k++) {
        const uint32_t i = s->tip_path[k], first = s->body[i].v;
        for (uint32_t j = 0; j < freedoms_at(s, t, k); j++) {
            num column[6];
            store_motion(t, motion_simd_store(joint_axis_at_point(s, i, j, t->p)), column);
            if (!s->identity_map) {
                add_column(s, first + j, column, rows, out, stride);
                continue;
            }
            for (uint32_t e = 0; e < rows; e++)
                out[e * stride + first + j] = (double)column[e];
        }
    }
}
