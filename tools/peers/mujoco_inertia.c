/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Inertias of a MuJoCo model from the description, in place of those that its import of URDF made.
 * MuJoCo 2.2.2 leaves errors of 1e-8 in principal axes, and so in every answer (the bundled arms,
 * 2026-11-25: 1e-8 before, 1e-13 after). Here the axes are computed in long double.
 */
#include <math.h>
#include <string.h>

#include "mujoco_inertia.h"
#include "spatial/symmetric3.h"

typedef long double real;

/* Frame in another: rotation by rows, origin. */
typedef struct pose {
    real R[3][3], p[3];
} pose;

/* Mass properties of a body about its frame's origin, in its axes. */
typedef struct mass_properties {
    real mass, first[3], second[3][3]; /* m, m c, inertia */
} mass_properties;

static pose pose_of(const double quat[4], const double low[4], const double xyz[3])
{
    real x = quat[0], y = quat[1], z = quat[2], w = quat[3];
    x += low[0], y += low[1], z += low[2], w += low[3];
    const real s = 2 / (x * x + y * y + z * z + w * w);
    return (pose){{{1 - s * (y * y + z * z), s * (x * y - z * w), s * (x * z + y * w)},
                   {s * (x * y + z * w), 1 - s * (x * x + z * z), s * (y * z - x * w)},
                   {s * (x * z - y * w), s * (y * z + x * w), 1 - s * (x * x + y * y)}},
                  {xyz[0], xyz[1], xyz[2]}};
}

static pose compose(const pose *a, const pose *b)
{
    pose c;
    for (int i = 0; i < 3; i++) {
        c.p[i] = a->p[i];
        for (int j = 0; j < 3; j++) {
            c.R[i][j] = 0;
            for (int k = 0; k < 3; k++)
                c.R[i][j] += a->R[i][k] * b->R[k][j];
            c.p[i] += a->R[i][j] * b->p[j];
        }
    }
    return c;
}

/* Adds I about a point at p to the second moments about the origin: I + m (p^2 1 - p p^T). */
static void add_at(mass_properties *to, real mass, const real p[3], real inertia[3][3])
{
    const real square = p[0] * p[0] + p[1] * p[1] + p[2] * p[2];
    to->mass += mass;
    for (int i = 0; i < 3; i++) {
        to->first[i] += mass * p[i];
        for (int j = 0; j < 3; j++)
            to->second[i][j] += inertia[i][j] + mass * ((i == j ? square : 0) - p[i] * p[j]);
    }
}

/* Adds a link that stands at `at` in the body's frame. */
static void add_link(mass_properties *to, const tfa_link *link, const pose *at)
{
    const pose inertial = pose_of(link->quat, link->quat_low, link->com);
    const pose frame = compose(at, &inertial);
    const double *I = link->inertia;
    const real own[3][3] = {{I[0], I[1], I[2]}, {I[1], I[3], I[4]}, {I[2], I[4], I[5]}};
    real turned[3][3] = {{0}};
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            for (int k = 0; k < 3; k++)
                for (int l = 0; l < 3; l++)
                    turned[i][j] += frame.R[i][k] * own[k][l] * frame.R[j][l];
    add_at(to, link->mass, frame.p, turned);
}

/* Quaternion w x y z of a rotation matrix */
static void quaternion_of(real R[3][3], double quat[4])
{
    const real trace = R[0][0] + R[1][1] + R[2][2];
    real q[4];
    int i = 0;
    for (int k = 1; k < 3; k++)
        if (R[k][k] > R[i][i])
            i = k;
    if (trace > R[i][i]) {
        q[0] = 1 + trace;
        q[1] = R[2][1] - R[1][2];
        q[2] = R[0][2] - R[2][0];
        q[3] = R[1][0] - R[0][1];
    } else {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        q[0] = R[k][j] - R[j][k];
        q[1 + i] = 1 + R[i][i] - R[j][j] - R[k][k];
        q[1 + j] = R[i][j] + R[j][i];
        q[1 + k] = R[i][k] + R[k][i];
    }
    const real size = sqrtl(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    for (int k = 0; k < 4; k++)
        quat[k] = (double)(q[k] / size);
}

static void set_body(mjModel *m, int body, const mass_properties *from)
{
    real about[3][3], axes[3][3];
    real com[3];
    for (int i = 0; i < 3; i++)
        com[i] = from->first[i] / from->mass;
    const real square = com[0] * com[0] + com[1] * com[1] + com[2] * com[2];
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            about[i][j] =
                from->second[i][j] - from->mass * ((i == j ? square : 0) - com[i] * com[j]);
    symmetric3_diagonalise(about, axes);
    m->body_mass[body] = (double)from->mass;
    quaternion_of(axes, m->body_iquat + 4 * body);
    for (int i = 0; i < 3; i++) {
        m->body_ipos[3 * body + i] = (double)com[i];
        m->body_inertia[3 * body + i] = (double)about[i][i];
    }
}

/* All links that are fixed to `link`, itself first, at `at` in the body's frame. */
static void add_fixed(mass_properties *to, const tfa_description *d, uint32_t link, const pose *at)
{
    add_link(to, &d->links[link], at);
    for (size_t j = 0; j < d->joint_count; j++)
        if (d->joints[j].type == TFA_JOINT_FIXED && d->joints[j].parent == link) {
            const tfa_joint *joint = &d->joints[j];
            const pose origin = pose_of(joint->quat, joint->quat_low, joint->xyz);
            const pose child = compose(at, &origin);
            add_fixed(to, d, joint->child, &child);
        }
}

void peer_mujoco_set_inertias(mjModel *m, const tfa_description *d)
{
    static const pose here = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {0, 0, 0}};
    for (size_t j = 0; j < d->joint_count; j++) {
        const uint32_t link = d->joints[j].child;
        const int body = mj_name2id(m, mjOBJ_BODY, d->links[link].name);
        mass_properties properties = {0};
        if (d->joints[j].type == TFA_JOINT_FIXED || body < 0)
            continue;
        add_fixed(&properties, d, link, &here);
        if (properties.mass > 0)
            set_body(m, body, &properties);
    }
}
