/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Motion of one tip by the bodies of its support.
 */
#include "dynamics/kinematics/tip_motion.h"

#include "dynamics/core/modes.h"
#include "dynamics/kinematics/frame.h"
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
    const xform at = frame_in_body(s, frame);
    out->frame = mode;
    out->length = 0;
    out->moved = 0;
    out->handle = s->m->frame[frame].handle;
    out->axes = at.E;
    out->p = vec3_simd_of(at.r.x, at.r.y, at.r.z);
    if (body >= 0) {
        out->length = s->body[body].depth;
        out->moved = TFA_V(frame_freedoms)(s, frame);
        if (s->located >> t & 1)
            find_path(s, body, out->length);
        else
            locate_support(s, body, out->length);
        s->located |= 1u << t;
        out->p = point_in_world(&s->world[body], at.r);
        if (mode == TFA_FRAME_LOCAL)
            out->axes = axes_in_world(&s->world[body], at.E);
    }
    if (mode == TFA_FRAME_WORLD)
        out->p = vec3_simd_of(num_of(0), num_of(0), num_of(0));
}

/* Freedoms of the body at place k of the support that move the tip */
static uint32_t freedoms_at(const struct state *s, const struct tip *t, uint32_t k)
{
    return k + 1 < t->length ? s->body[s->tip_path[k]].n : t->moved;
}

/* The handle that carries what comes behind the body at place k of the support; -1: none */
static int32_t handle_behind(const struct state *s, const struct tip *t, uint32_t k)
{
    return k + 1 < t->length ? s->body[s->tip_path[k + 1]].handle : t->handle;
}

/* A motion in world axes at the tip's point, in the axes asked for */
TFA_INLINE struct motion_simd in_axes(const struct tip *t, const struct mat3_simd *axes,
                                      struct motion_simd m)
{
    if (t->frame != TFA_FRAME_LOCAL)
        return m;
    return (struct motion_simd){mat3_simd_apply_t(axes, vec3_of_simd(m.w)),
                                mat3_simd_apply_t(axes, vec3_of_simd(m.v))};
}

/* The same as numbers, linear first: lane by lane, as through memory it takes five times as long
 * (arm of 7, AMD EPYC Zen 5, gcc 12, 2026-11-24). */
TFA_INLINE void store_motion(const struct tip *t, struct motion_simd m, num out[6])
{
    const struct mat3_simd axes = mat3_simd_of(t->axes);
    m = in_axes(t, &axes, m);
    for (int e = 0; e < 3; e++) {
        out[e] = vec3_simd_lane(&m.v, e);
        out[3 + e] = vec3_simd_lane(&m.w, e);
    }
}

/* v x m of motions about the same point */
static inline struct motion_simd motion_simd_cross(struct motion_simd v, struct motion_simd m)
{
    return (struct motion_simd){
        vec3_simd_cross(v.w, m.w),
        vec3_simd_add(vec3_simd_cross(v.w, m.v), vec3_simd_cross(v.v, m.w))};
}

static inline struct motion_simd motion_simd_sub(struct motion_simd a, struct motion_simd b)
{
    return (struct motion_simd){vec3_simd_sub(a.w, b.w), vec3_simd_sub(a.v, b.v)};
}

/* A column of J to row 0 .. rows - 1 of `out` */
TFA_INLINE void put_column(const struct tip *t, const struct mat3_simd *axes, struct motion_simd H,
                           uint32_t rows, double *out, size_t stride)
{
    H = in_axes(t, axes, H);
    for (int e = 0; e < 3; e++)
        out[(size_t)e * stride] = (double)vec3_simd_lane(&H.v, e);
    for (int e = 0; rows == 6 && e < 3; e++)
        out[(size_t)(3 + e) * stride] = (double)vec3_simd_lane(&H.w, e);
}

/* The same with mimics: to that of the freedom that moves it, and what others have added there */
static void add_column(const struct state *s, const struct tip *t, struct motion_simd H, uint32_t j,
                       uint32_t rows, double *out, size_t stride)
{
    num multiplier = num_of(1), column[6];
    out += TFA_V(reduced_freedom)(s->m, j, &multiplier);
    store_motion(t, H, column);
    for (uint32_t e = 0; e < rows; e++)
        out[e * stride] += (double)(multiplier * column[e]);
}

/* In world axes */
static vec3_simd boost_of_root(const struct state *s, uint32_t i)
{
    const num *x = s->boost + s->body[i].v;
    const num o = num_of(0);
    return is_free(s->body[i].kind) ? mat3_simd_apply_t(&s->world[i].E, v3(x[0], x[1], x[2]))
                                    : vec3_simd_of(o, o, o);
}

/* Motion of a handle of body i by its modes: v <- v + Phi eta', product gets what the rates of both
 * add. */
static void add_modes(const struct state *s, const struct tip *t, uint32_t i, int32_t handle,
                      struct motion_simd *v, struct motion_simd *product)
{
    const svec local = TFA_V(modes_motion)(s, handle, s->qd);
    const struct motion_simd motion = motion_at_point(&s->world[i], local, t->p),
                             rate = motion_at_point(&s->world[i],
                                                    TFA_V(modes_rate)(s, handle, local), t->p);
    *product = motion_simd_add(*product, motion_simd_add(motion_simd_cross(*v, motion), rate));
    *v = motion_simd_add(*v, motion);
}

/* One pass over the support, joint by joint outward: the columns H of J, unless `rows` is 0; and
 * v <- v + H qd with the sum of v x H qd, c of the joint, unless `motion` is NULL. The axes of a
 * fused joint turn with its freedoms before. Returns 1 when all columns are finite. */
TFA_INLINE int pass(const struct state *s, const struct tip *t, uint32_t rows, double *J,
                    size_t stride, struct tip_velocity *motion)
{
    const vec3_simd zero = vec3_simd_of(num_of(0), num_of(0), num_of(0));
    const struct mat3_simd axes = mat3_simd_of(t->axes);
    struct motion_simd v = {zero, zero}, product = {zero, zero}, rest = {zero, zero};
    for (uint32_t k = 0; k < t->length; k++) {
        const uint32_t i = s->tip_path[k], first = s->body[i].v, n = freedoms_at(s, t, k);
        struct motion_simd before = v;
        for (uint32_t j = 0; j < n; j++) {
            const struct motion_simd H = joint_axis_at_point(s, i, j, t->p);
            if (rows)
                rest = motion_simd_add(rest, motion_simd_sub(H, H));
            if (rows && s->identity_map)
                put_column(t, &axes, H, rows, J + first + j, stride);
            else if (rows)
                add_column(s, t, H, first + j, rows, J, stride);
            if (!motion)
                continue;
            const struct motion_simd joint = motion_simd_scale(s->qd[first + j], H);
            if (k > 0 || is_fused(s->body[i].kind)) /* others start from rest at the root */
                product = motion_simd_add(product, motion_simd_cross(before, joint));
            v = motion_simd_add(v, joint);
            if (is_fused(s->body[i].kind))
                before = v;
        }
        if (motion && handle_behind(s, t, k) >= 0) {
            struct motion_simd in_memory[2] = {v, product}; /* or the sums never are in registers */
            add_modes(s, t, i, handle_behind(s, t, k), &in_memory[0], &in_memory[1]);
            v = in_memory[0];
            product = in_memory[1];
        }
    }
    if (motion)
        *motion = (struct tip_velocity){v, product, s->boosted, zero};
    if (motion && s->boosted && t->length)
        motion->boost = boost_of_root(s, s->tip_path[0]);
    const vec3 none = vec3_of_simd(vec3_simd_add(rest.w, rest.v));
    return none.x + none.y + none.z == num_of(0);
}

void TFA_V(tip_velocity)(const struct state *s, const struct tip *t, struct tip_velocity *out)
{
    (void)pass(s, t, 0, NULL, 0, out);
}

/* The number of rows is known where columns are written. */
int TFA_V(tip_jacobian)(const struct state *s, const struct tip *t, uint32_t rows, double *J,
                        size_t stride, struct tip_velocity *motion)
{
    if (rows == 6)
        return motion ? pass(s, t, 6, J, stride, motion) : pass(s, t, 6, J, stride, NULL);
    return pass(s, t, 3, J, stride, motion);
}

void TFA_V(tip_twist)(const struct tip *t, const struct tip_velocity *motion, num twist[6])
{
    struct motion_simd sum = motion->twist;
    if (motion->boosted)
        sum.v = vec3_simd_add(sum.v, motion->boost);
    store_motion(t, sum, twist);
}

/* With world axes at a point that moves along, the velocity of that point turns too; otherwise the
 * frame's velocity passes by. */
static struct motion_simd velocity_product(const struct tip *t, const struct tip_velocity *motion)
{
    struct motion_simd sum = motion->product;
    if (t->frame == TFA_FRAME_LOCAL_WORLD_ALIGNED)
        sum.v = vec3_simd_add(sum.v, vec3_simd_cross(motion->twist.w, motion->twist.v));
    else if (motion->boosted)
        sum.v = vec3_simd_sub(sum.v, vec3_simd_cross(motion->twist.w, motion->boost));
    return sum;
}

/* sum of H x over the support */
static struct motion_simd jacobian_mul(const struct state *s, const struct tip *t, const num *x)
{
    const vec3_simd zero = vec3_simd_of(num_of(0), num_of(0), num_of(0));
    struct motion_simd sum = {zero, zero};
    for (uint32_t k = 0; k < t->length; k++) {
        const uint32_t i = s->tip_path[k], first = s->body[i].v;
        for (uint32_t j = 0; j < freedoms_at(s, t, k); j++)
            sum = motion_simd_add(
                sum, motion_simd_scale(x[first + j], joint_axis_at_point(s, i, j, t->p)));
        const int32_t handle = handle_behind(s, t, k);
        if (handle >= 0)
            sum = motion_simd_add(
                sum, motion_at_point(&s->world[i], TFA_V(modes_motion)(s, handle, x), t->p));
    }
    return sum;
}

void TFA_V(tip_acceleration)(const struct state *s, const struct tip *t,
                             const struct tip_velocity *motion, const num *qdd, num acceleration[6])
{
    struct motion_simd a = velocity_product(t, motion);
    if (qdd)
        a = motion_simd_add(a, jacobian_mul(s, t, qdd));
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
    const struct motion_simd wrench = {vec3_simd_of(f.w.x, f.w.y, f.w.z),
                                       vec3_simd_of(f.v.x, f.v.y, f.v.z)};
    for (uint32_t k = 0; k < t->length; k++) {
        const uint32_t i = s->tip_path[k], first = s->body[i].v;
        for (uint32_t j = 0; j < freedoms_at(s, t, k); j++)
            tau[first + j] += motion_simd_dot(joint_axis_at_point(s, i, j, t->p), wrench);
    }
}

void TFA_V(tips_jacobian_tmul)(struct state *s, tfa_reference_frame frame, const num *F, num *tau)
{
    for (uint32_t j = 0; j < s->freedoms; j++)
        tau[j] = num_of(0);
    for (uint32_t t = 0; t < s->tips; t++) {
        struct tip at;
        num wrench[6] = {num_of(0), num_of(0), num_of(0), num_of(0), num_of(0), num_of(0)};
        TFA_V(tip_locate)(s, t, frame, &at);
        for (uint32_t e = 0; e < s->tip_rows; e++)
            wrench[e] = F[s->tip_rows * t + e];
        TFA_V(tip_jacobian_tmul)(s, &at, wrench, tau);
    }
}
