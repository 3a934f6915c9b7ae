/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Axes of a joint and pose of its child (docs/conventions.md), in quadruple precision.
 */
#include <math.h>
#include <string.h>

#include "model/draft/draft.h"

static int normalise(ext *a)
{
    const ext norm = TFA_QUAD_SQRT(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]);
    if (!(norm > 0 && norm < (ext)INFINITY))
        return TFA_E_MODEL;
    for (int i = 0; i < 3; i++)
        a[i] /= norm;
    return TFA_OK;
}

/* With the axis along a coordinate axis e_k the others follow cyclically, and every entry is 0 or
 * +-1 exactly. */
static int align(ext *R, const double axis[3], const double low[3])
{
    ext a[3];
    ext_from_parts(a, axis, low, 3);
    if (normalise(a) != TFA_OK)
        return TFA_E_MODEL;
    int k = 0;
    for (int i = 1; i < 3; i++)
        if (ext_abs(a[i]) > ext_abs(a[k]))
            k = i;
    ext x[3];
    const int e = (k + 1) % 3;
    for (int i = 0; i < 3; i++)
        x[i] = (i == e) - a[i] * a[e];
    (void)normalise(x); /* a[e] is not the largest: at least 1/sqrt(2) long */
    const ext y[3] = {a[1] * x[2] - a[2] * x[1], a[2] * x[0] - a[0] * x[2],
                      a[0] * x[1] - a[1] * x[0]};
    for (int i = 0; i < 3; i++) {
        R[3 * i] = x[i];
        R[3 * i + 1] = y[i];
        R[3 * i + 2] = a[i];
    }
    return TFA_OK;
}

int tfa_joint_axes(ext R[9], const tfa_joint *joint)
{
    ext_identity(R);
    return tfa_joint_type_describe(joint->type).quaternion >= 0
               ? TFA_OK
               : align(R, joint->axis, joint->axis_low);
}

/* Rodrigues: R = cos 1 + sin [n]x + (1 - cos) n n^T; exactly 1 at 0 */
static void axis_rotation(ext *R, const ext *axes, ext angle)
{
    const ext n[3] = {axes[2], axes[5], axes[8]};
    ext s, c;
    TFA_QUAD_SINCOS(angle, &s, &c);
    const ext skew[9] = {0, -n[2], n[1], n[2], 0, -n[0], -n[1], n[0], 0};
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            R[3 * i + j] = (i == j ? c : 0) + s * skew[3 * i + j] + (1 - c) * n[i] * n[j];
}

int tfa_joint_transform(const tfa_joint *joint, const ext *q, ext R[9], ext t[3])
{
    ext axes[9];
    ext_identity(R);
    memset(t, 0, 3 * sizeof *t);
    if (joint->type == TFA_JOINT_FIXED)
        return TFA_OK;
    if (joint->type == TFA_JOINT_FLOATING) {
        memcpy(t, q, 3 * sizeof *t);
        ext_rotation(R, q + 3);
        return TFA_OK;
    }
    if (tfa_joint_axes(axes, joint) != TFA_OK)
        return TFA_E_MODEL;
    for (int i = 0; i < 3; i++) {
        if (joint->type == TFA_JOINT_PRISMATIC)
            t[i] = axes[3 * i + 2] * q[0];
        else if (joint->type == TFA_JOINT_PLANAR)
            t[i] = axes[3 * i] * q[0] + axes[3 * i + 1] * q[1];
    }
    if (joint->type != TFA_JOINT_PRISMATIC)
        axis_rotation(R, axes, joint->type == TFA_JOINT_PLANAR ? q[2] : q[0]);
    return TFA_OK;
}
