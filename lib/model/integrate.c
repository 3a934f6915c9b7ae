/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Exponentials of twists that are constant in the moved frame:
 *
 *     x' = x + R (v + (1 - cos a) / a^2 w x v + (a - sin a) / a^3 w x (w x v)),   t = 1
 *     quat' = quat (w sin(a/2) / a, cos(a/2)),   a = |w|
 */
#include "model/integrate.h"

#include <math.h>

static void cross(const double a[3], const double b[3], double out[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
}

/* Way of the origin, in the axes at the start; w and v times t */
static void arc(const double w[3], const double v[3], double out[3])
{
    const double square = w[0] * w[0] + w[1] * w[1] + w[2] * w[2], a = sqrt(square);
    const double half = a > 0 ? sin(a / 2) / a : 0.5;
    const double cubic = a > 0.01 ? (a - sin(a)) / (a * square) : (1 - square / 20) / 6;
    double first[3], second[3];
    cross(w, v, first);
    cross(w, first, second);
    for (int i = 0; i < 3; i++)
        out[i] = v[i] + 2 * half * half * first[i] + cubic * second[i];
}

static void move_pose(const double *twist, double time, double *pose)
{
    double *u = pose + 3, v[3], w[3], way[3], twice[3], more[3], turned[3];
    const double norm = sqrt(u[0] * u[0] + u[1] * u[1] + u[2] * u[2] + u[3] * u[3]);
    double moved = 0;
    for (int i = 0; i < 3; i++) {
        v[i] = time * twist[i];
        w[i] = time * twist[3 + i];
        moved += fabs(v[i]) + fabs(w[i]);
    }
    if (moved == 0)
        return; /* with every bit, whatever the norm */
    for (int i = 0; i < 4; i++)
        u[i] /= norm;
    arc(w, v, way);
    cross(u, way, twice); /* R way = way + 2 u4 (u x way) + u x 2 (u x way) */
    cross(u, twice, more);
    const double a = sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2]);
    const double s = a > 0 ? sin(a / 2) / a : 0.5, c = cos(a / 2), real = u[3];
    for (int i = 0; i < 3; i++) {
        pose[i] += way[i] + 2 * (real * twice[i] + more[i]);
        w[i] *= s;
    }
    cross(u, w, turned);
    u[3] = real * c - (u[0] * w[0] + u[1] * w[1] + u[2] * w[2]);
    for (int i = 0; i < 3; i++)
        u[i] = c * u[i] + real * w[i] + turned[i];
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

void tfa_integrate(const struct tfa_model *m, const double *v, const double *twist, double time,
                   double *q, double *base_pose)
{
    for (uint32_t k = 0; k < m->joints; k++) {
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
