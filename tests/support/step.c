/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * One explicit Euler step of a state. See step.h.
 */
#include "step.h"

#include <math.h>

/* A free pose by a twist in its own axes: x' = R v, quat' = quat (w, 0) / 2. */
static void step_pose(const double *pose, const double *twist, double dt, double *out)
{
    const double *u = pose + 3, w = pose[6], *v = twist, *spin = twist + 3;
    double norm = sqrt(u[0] * u[0] + u[1] * u[1] + u[2] * u[2] + w * w);
    double turned[4], t[3];
    for (int i = 0; i < 3; i++) { /* t = 2 u x v, turned = v + w t + u x t */
        int a = (i + 1) % 3, b = (i + 2) % 3;
        t[i] = 2 * (u[a] * v[b] - u[b] * v[a]) / (norm * norm);
    }
    for (int i = 0; i < 3; i++) {
        int a = (i + 1) % 3, b = (i + 2) % 3;
        out[i] = pose[i] + dt * (v[i] + w * t[i] + u[a] * t[b] - u[b] * t[a]);
        turned[i] = u[i] + dt / 2 * (w * spin[i] + u[a] * spin[b] - u[b] * spin[a]);
    }
    turned[3] = w - dt / 2 * (u[0] * spin[0] + u[1] * spin[1] + u[2] * spin[2]);
    norm = sqrt(turned[0] * turned[0] + turned[1] * turned[1] + turned[2] * turned[2] +
                turned[3] * turned[3]);
    for (int i = 0; i < 4; i++)
        out[3 + i] = turned[i] / norm;
}

/* The same for one joint; returns the number of its coordinates. */
static uint32_t step_joint(tfa_joint_type type, const double *q, const double *v, double dt,
                           double *out)
{
    switch (type) {
    case TFA_JOINT_FIXED:
        return 0;
    case TFA_JOINT_REVOLUTE:
    case TFA_JOINT_CONTINUOUS:
    case TFA_JOINT_PRISMATIC:
        out[0] = q[0] + dt * v[0];
        return 1;
    case TFA_JOINT_PLANAR: /* v in the axes that have turned with the child */
        out[0] = q[0] + dt * (cos(q[2]) * v[0] - sin(q[2]) * v[1]);
        out[1] = q[1] + dt * (sin(q[2]) * v[0] + cos(q[2]) * v[1]);
        out[2] = q[2] + dt * v[2];
        return 3;
    case TFA_JOINT_FLOATING:
        step_pose(q, v, dt, out);
        return 7;
    }
    return 0;
}

void step_state(const tfa_description *description, const oracle *o, const random_states *from,
                const double *qdd, const double *base_acceleration, double dt, random_states *to)
{
    const double *q = from->q;
    double *out = to->q;
    for (uint32_t k = 0, within; k < oracle_v_count(o); k++) {
        const tfa_joint *j = &description->joints[oracle_joint_of_freedom(o, k, &within)];
        if (within == 0) {
            uint32_t count = step_joint(j->type, q, from->v + k, dt, out);
            q += count;
            out += count;
        }
        to->v[k] = from->v[k] + dt * qdd[k];
    }
    step_pose(from->base_pose, from->base_twist, dt, to->base_pose);
    for (int k = 0; k < 6; k++)
        to->base_twist[k] = from->base_twist[k] + dt * base_acceleration[k];
}

void step_model(const tfa_model *model, const double *q, const double *pose, const double *v,
                double dt, double *q_out, double *pose_out)
{
    const uint32_t six = tfa_model_base_freedoms(model);
    for (uint32_t k = 0; k < tfa_model_joint_count(model); k++) {
        const tfa_joint_info j = tfa_model_joint(model, k);
        (void)step_joint(j.type, q + j.q_index, v + six + j.v_index, dt, q_out + j.q_index);
    }
    if (six)
        step_pose(pose, v, dt, pose_out);
}

void rotate_vector(const double quat[4], const double v[3], double out[3])
{
    double t[3], turned[3];
    for (int i = 0; i < 3; i++)
        t[i] = 2 * (quat[(i + 1) % 3] * v[(i + 2) % 3] - quat[(i + 2) % 3] * v[(i + 1) % 3]);
    for (int i = 0; i < 3; i++)
        turned[i] = v[i] + quat[3] * t[i] + quat[(i + 1) % 3] * t[(i + 2) % 3] -
                    quat[(i + 2) % 3] * t[(i + 1) % 3];
    for (int i = 0; i < 3; i++)
        out[i] = turned[i];
}
