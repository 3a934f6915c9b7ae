/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Exponentials of twists that are constant in the moved frame, and their inverses:
 *
 *     x' = x + R V v,   V = 1 + (1 - cos a) / a^2 [w] + (a - sin a) / a^3 [w]^2,   t = 1
 *     quat' = quat (w sin(a/2) / a, cos(a/2)),   a = |w|
 *     V^-1 = 1 - [w] / 2 + (1 - a/2 cot(a/2)) / a^2 [w]^2
 */
#include <math.h>
#include <string.h>
#include <totalforce/configuration.h>

#include "model/model.h"

static void cross(const double a[3], const double b[3], double out[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
}

/* out = way + first [w] way + second [w]^2 way */
static void polynomial(const double w[3], double first, double second, const double way[3],
                       double out[3])
{
    double once[3], twice[3];
    cross(w, way, once);
    cross(w, once, twice);
    for (int i = 0; i < 3; i++)
        out[i] = way[i] + first * once[i] + second * twice[i];
}

static double norm_of(const double *v, int count)
{
    double square = 0;
    for (int i = 0; i < count; i++)
        square += v[i] * v[i];
    return sqrt(square);
}

/* Way of the origin, in the axes at the start: V v; w and v times t */
static void arc(const double w[3], const double v[3], double out[3])
{
    const double a = norm_of(w, 3), half = a > 0 ? sin(a / 2) / a : 0.5;
    const double second = a > 0.01 ? (a - sin(a)) / (a * a * a) : (1 - a * a / 20) / 6;
    polynomial(w, 2 * half * half, second, v, out);
}

/* V^-1 way, |w| at most pi */
static void arc_inverse(const double w[3], const double way[3], double out[3])
{
    const double a = norm_of(w, 3);
    const double second = a > 0.01 ? (1 - a / 2 / tan(a / 2)) / (a * a) : (1 + a * a / 60) / 12;
    polynomial(w, -0.5, second, way, out);
}

/* out = R v; u may be out's conjugate, not out */
static void rotate(const double u[4], const double v[3], double out[3])
{
    polynomial(u, 2 * u[3], 2, v, out);
}

/* out = a b */
static void multiply(const double a[4], const double b[4], double out[4])
{
    cross(a, b, out);
    for (int i = 0; i < 3; i++)
        out[i] += b[3] * a[i] + a[3] * b[i];
    out[3] = a[3] * b[3] - (a[0] * b[0] + a[1] * b[1] + a[2] * b[2]);
}

static void move_pose(const double *twist, double time, double *pose)
{
    double v[3], w[3], way[3], moved = 0;
    for (int i = 0; i < 3; i++) {
        v[i] = time * twist[i];
        w[i] = time * twist[3 + i];
        moved += fabs(v[i]) + fabs(w[i]);
    }
    if (moved == 0)
        return; /* with every bit, whatever the norm */
    const double norm = norm_of(pose + 3, 4), a = norm_of(w, 3);
    const double s = a > 0 ? sin(a / 2) / a : 0.5;
    const double u[4] = {pose[3] / norm, pose[4] / norm, pose[5] / norm, pose[6] / norm};
    const double turn[4] = {s * w[0], s * w[1], s * w[2], cos(a / 2)};
    arc(w, v, way);
    rotate(u, way, v);
    for (int i = 0; i < 3; i++)
        pose[i] += v[i];
    multiply(u, turn, pose + 3);
}

static void move_in_plane(const double *v, double time, double *q)
{
    const double w[3] = {0, 0, time * v[2]}, along[3] = {time * v[0], time * v[1], 0};
    const double c = cos(q[2]), s = sin(q[2]);
    double way[3];
    arc(w, along, way);
    q[0] += c * way[0] - s * way[1];
    q[1] += s * way[0] + c * way[1];
    q[2] += w[2];
}

static void compare_poses(const double *pose, const double *to, double *twist)
{
    const double norm = norm_of(pose + 3, 4);
    const double back[4] = {-pose[3] / norm, -pose[4] / norm, -pose[5] / norm, pose[6] / norm};
    double turn[4], way[3], *w = twist + 3;
    multiply(back, to + 3, turn);
    const double sine = norm_of(turn, 3), cosine = fabs(turn[3]);
    const double angle = sine > 0 ? 2 * atan2(sine, cosine) / sine : 2 / norm_of(to + 3, 4);
    for (int i = 0; i < 3; i++) {
        w[i] = copysign(angle, turn[3]) * turn[i];
        twist[i] = to[i] - pose[i];
    }
    rotate(back, twist, way);
    arc_inverse(w, way, twist);
}

static void compare_in_plane(const double *q, const double *to, double *v)
{
    const double w[3] = {0, 0, remainder(to[2] - q[2], 2 * M_PI)};
    const double x = to[0] - q[0], y = to[1] - q[1], c = cos(q[2]), s = sin(q[2]);
    const double way[3] = {c * x + s * y, c * y - s * x, 0};
    arc_inverse(w, way, v);
    v[2] = w[2];
}

void tfa_integrate(const tfa_model *m, const double *v, const double *twist, double time, double *q,
                   double *base_pose)
{
    for (uint32_t k = 0; v && k < m->joints; k++) {
        const tfa_joint_info *joint = &m->joint[k];
        double *at = q + joint->q_index;
        const double *rate = v + joint->v_index;
        if (joint->type == TFA_JOINT_FLOATING)
            move_pose(rate, time, at);
        else if (joint->type == TFA_JOINT_PLANAR)
            move_in_plane(rate, time, at);
        else
            *at += time * *rate;
    }
    if (m->base_freedoms && twist)
        move_pose(twist, time, base_pose);
}

void tfa_difference(const tfa_model *m, const double *q, const double *base_pose,
                    const double *q_to, const double *base_pose_to, double *v, double *twist)
{
    for (uint32_t k = 0; k < m->joints; k++) {
        const tfa_joint_info *joint = &m->joint[k];
        const double *from = q + joint->q_index, *to = q_to + joint->q_index;
        double *rate = v + joint->v_index;
        if (joint->type == TFA_JOINT_FLOATING)
            compare_poses(from, to, rate);
        else if (joint->type == TFA_JOINT_PLANAR)
            compare_in_plane(from, to, rate);
        else
            *rate = *to - *from;
    }
    if (m->base_freedoms)
        compare_poses(base_pose, base_pose_to, twist);
}

void tfa_neutral(const tfa_model *m, double *q, double *base_pose)
{
    static const double identity[7] = {0, 0, 0, 0, 0, 0, 1};
    for (uint32_t k = 0; k < m->joints; k++) {
        const tfa_joint_info *joint = &m->joint[k];
        const double zeros[7] = {0};
        memcpy(q + joint->q_index, joint->type == TFA_JOINT_FLOATING ? identity : zeros,
               joint->q_count * sizeof *q);
    }
    if (m->base_freedoms)
        memcpy(base_pose, identity, sizeof identity);
}
