/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Answers of kinematics: motion of tips, of all frames, and of the robot as a whole.
 */
#include <math.h>

#include "dynamics/kinematics/centroid.h"
#include "dynamics/kinematics/frame.h"
#include "dynamics/kinematics/tip_motion.h"
#include "dynamics/kinematics/world_pose.h"
#include "dynamics/solve/answer.h"
#include "dynamics/solve/load.h"
#include "interface/traits.h"

static void store(double *out, const num *x, uint32_t count)
{
    for (uint32_t e = 0; e < count; e++)
        out[e] = (double)x[e];
}

static void store_vec3(double *out, vec3 x)
{
    out[0] = (double)x.x;
    out[1] = (double)x.y;
    out[2] = (double)x.z;
}

static void zero(double *out, size_t count)
{
    for (size_t e = 0; e < count; e++)
        out[e] = 0;
}

/* As doubles: a wider number may be too large for one. */
static int is_finite(const double *x, size_t count)
{
    double even = 0, odd = 0; /* one sum alone waits for itself */
    for (size_t e = 0; e + 1 < count; e += 2) {
        even += x[e] - x[e];
        odd += x[e + 1] - x[e + 1];
    }
    if (count % 2)
        even += x[count - 1] - x[count - 1];
    return even + odd == 0;
}

/* Columns of a public matrix, the base first */
static size_t public_freedoms(const struct state *s)
{
    return (size_t)s->m->base_freedoms + s->m->v_count;
}

/* ---- poses ---- */

/* Quaternion x y z w with w >= 0 of a rotation matrix, by the largest of its four squares. */
static void quaternion(const double R[9], double q[4])
{
    const double t[4] = {R[0] - R[4] - R[8], R[4] - R[0] - R[8], R[8] - R[0] - R[4],
                         R[0] + R[4] + R[8]};
    const double off[3] = {R[7] - R[5], R[2] - R[6], R[3] - R[1]};
    int k = 3;
    for (int e = 0; e < 3; e++)
        if (t[e] > t[k])
            k = e;
    q[k] = sqrt(1 + t[k]) / 2;
    const double f = 1 / (4 * q[k]);
    for (int e = 0; e < 3; e++)
        if (k == 3)
            q[e] = off[e] * f;
        else if (e != k)
            q[e] = (R[3 * e + k] + R[3 * k + e]) * f;
    if (k != 3)
        q[3] = off[k] * f;
    if (q[3] < 0)
        for (int e = 0; e < 4; e++)
            q[e] = -q[e];
}

/* Position and quaternion of a frame. Returns 1 when all of it is finite. */
static int store_pose(const struct state *s, uint32_t frame, double out[7])
{
    const int32_t body = s->m->frame[frame].body;
    const xform at = frame_in_body(s, frame);
    const mat3 axes = body < 0 ? at.E : axes_in_world(&s->world[body], at.E);
    const double R[9] = {(double)axes.xx, (double)axes.xy, (double)axes.xz,
                         (double)axes.yx, (double)axes.yy, (double)axes.yz,
                         (double)axes.zx, (double)axes.zy, (double)axes.zz};
    store_vec3(out, body < 0 ? at.r : vec3_of_simd(point_in_world(&s->world[body], at.r)));
    quaternion(R, out + 3);
    return is_finite(out, 7);
}

/* ---- tips ---- */

/* Tip t of state k. Returns 1 when all of it is finite. */
static int answer_tip(struct state *s, const tfa_request *r, uint32_t flags, size_t k, uint32_t t,
                      tfa_reply *reply)
{
    const uint32_t rows = rows_of(r), moves = TFA_WANT_TWISTS | TFA_WANT_BIAS_ACCELERATION;
    const size_t n = public_freedoms(s), tip = s->tips * k + t;
    struct tip at;
    struct tip_velocity motion;
    num x[6];
    int finite = 1;
    TFA_V(tip_locate)(s, t, r->frame, &at);
    if (flags & TFA_WANT_JACOBIAN && reply->jacobian) {
        double *J = reply->jacobian + rows * n * tip;
        zero(J, rows * n);
        finite &= TFA_V(tip_jacobian)(s, &at, rows, J, n, flags & moves ? &motion : NULL);
        if (NUM_EPSILON < 0x1p-60 || !s->identity_map) /* smaller numbers, or sums of columns */
            finite &= is_finite(J, rows * n);
    } else if (flags & moves) {
        TFA_V(tip_velocity)(s, &at, &motion);
    }
    if (flags & TFA_WANT_POSES && reply->poses)
        finite &= store_pose(s, s->tip[t], reply->poses + 7 * tip);
    if (flags & TFA_WANT_TWISTS && reply->twists) {
        TFA_V(tip_twist)(&at, &motion, x);
        store(reply->twists + 6 * tip, x, 6);
        finite &= is_finite(reply->twists + 6 * tip, 6);
    }
    if (flags & TFA_WANT_BIAS_ACCELERATION && reply->bias_acceleration) {
        TFA_V(tip_acceleration)(s, &at, &motion, s->boosted ? s->boost_rate : NULL, x);
        store(reply->bias_acceleration + rows * tip, x, rows);
        finite &= is_finite(reply->bias_acceleration + rows * tip, rows);
    }
    return finite;
}

/* ---- all bodies ---- */

static int answer_frame_poses(struct state *s, double *out)
{
    int finite = 1;
    for (uint32_t f = 0; f < s->m->frames; f++)
        finite &= store_pose(s, f, out + 7 * (size_t)f);
    return finite;
}

static int answer_com(struct state *s, size_t k, tfa_reply *reply)
{
    const size_t n = public_freedoms(s);
    int finite = 1;
    vec3 com;
    const num mass = TFA_V(centre_of_mass)(s, &com);
    if (reply->com) {
        store_vec3(reply->com + 3 * k, com);
        finite &= is_finite(reply->com + 3 * k, 3);
    }
    if (reply->mass)
        reply->mass[k] = (double)mass;
    if (reply->com_velocity) {
        const vec3 linear = TFA_V(momentum)(s, com).v;
        store_vec3(reply->com_velocity + 3 * k, mass > 0 ? v3_scale(linear, 1 / mass) : linear);
        finite &= is_finite(reply->com_velocity + 3 * k, 3);
    }
    if (reply->com_jacobian) {
        double *J = reply->com_jacobian + 3 * n * k;
        zero(J, 3 * n);
        TFA_V(com_jacobian)(s, J, n);
        finite &= is_finite(J, 3 * n);
    }
    return finite;
}

static int answer_bodies(struct state *s, uint32_t flags, size_t k, tfa_reply *reply)
{
    int finite = 1;
    TFA_V(world_poses)(s);
    if (flags & FLAGS_VELOCITY && s->boosted)
        TFA_V(return_boost)(s);
    if (flags & TFA_WANT_FRAME_POSES && reply->frame_poses)
        finite &= answer_frame_poses(s, reply->frame_poses + 7 * (size_t)s->m->frames * k);
    if (flags & TFA_WANT_COM)
        finite &= answer_com(s, k, reply);
    if (flags & TFA_WANT_MOMENTUM && reply->momentum) {
        vec3 com;
        (void)TFA_V(centre_of_mass)(s, &com);
        const svec h = TFA_V(momentum)(s, com);
        store_vec3(reply->momentum + 6 * k, h.v);
        store_vec3(reply->momentum + 6 * k + 3, h.w);
        finite &= is_finite(reply->momentum + 6 * k, 6);
    }
    if (flags & TFA_WANT_ENERGY && reply->energy) {
        reply->energy[2 * k] = (double)TFA_V(kinetic_energy)(s);
        reply->energy[2 * k + 1] = (double)TFA_V(potential_energy)(s);
        finite &= is_finite(reply->energy + 2 * k, 2);
    }
    return finite;
}

int TFA_V(answer_motion_loaded)(struct state *s, const tfa_request *r, uint32_t flags, uint32_t k,
                                tfa_reply *reply)
{
    int finite = 1;
    flags &= r->flags;
    for (uint32_t t = 0; flags & (FLAGS_TIP_MOTION | TFA_WANT_POSES) && t < s->tips; t++)
        finite &= answer_tip(s, r, flags, k, t, reply);
    if (flags & FLAGS_BODY_MOTION & ~TFA_WANT_GENERALISED_MOMENTUM)
        finite &= answer_bodies(s, flags, k, reply);
    if (flags & TFA_WANT_GENERALISED_MOMENTUM)
        finite &= TFA_V(answer_momentum)(s, k, reply);
    return finite;
}

/* Loads what the flags need and no more. */
int TFA_V(answer_motion)(struct state *s, const tfa_request *r, struct tfa_resolved by,
                         uint32_t flags, uint32_t k, tfa_reply *reply)
{
    tfa_request motion = *r;
    motion.op = TFA_OP_KINEMATICS;
    motion.flags &= flags;
    s->by = by;
    TFA_V(load)(s, &motion, k, 1);
    return TFA_V(answer_motion_loaded)(s, &motion, motion.flags, k, reply);
}
