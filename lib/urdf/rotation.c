/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Rotations and axes from the doubles of a file, in quadruple precision: each number becomes a
 * double and its remainder.
 */
#include <totalforce/constraints.h>

#include "model/ext.h"
#include "urdf/urdf.h"

/* R = Rz(yaw) Ry(pitch) Rx(roll) */
void tfa_rotation_from_rpy(const double rpy[3], tfa_rotation *rotation)
{
    ext s[3], c[3];
    for (int k = 0; k < 3; k++)
        TFA_QUAD_SINCOS((ext)rpy[k] / 2, &s[k], &c[k]);
    const ext quat[4] = {
        s[0] * c[1] * c[2] - c[0] * s[1] * s[2],
        c[0] * s[1] * c[2] + s[0] * c[1] * s[2],
        c[0] * c[1] * s[2] - s[0] * s[1] * c[2],
        c[0] * c[1] * c[2] + s[0] * s[1] * s[2],
    };
    ext_to_parts(rotation->quat, rotation->low, quat, 4);
}

/* high + low = x / |x|; returns |x|, with 0 nothing is written */
static double normalise(const double *x, int count, double *high, double *low)
{
    ext a[4], square = 0;
    ext_from_double(a, x, count);
    for (int k = 0; k < count; k++)
        square += a[k] * a[k];
    const ext length = TFA_QUAD_SQRT(square);
    if (!(length > 0))
        return 0;
    for (int k = 0; k < count; k++)
        a[k] /= length;
    ext_to_parts(high, low, a, count);
    return (double)length;
}

double tfa_rotation_from_xyzw(const double xyzw[4], tfa_rotation *rotation)
{
    return normalise(xyzw, 4, rotation->quat, rotation->low);
}

double tfa_axis_normalise(double axis[3], double low[3])
{
    return normalise(axis, 3, axis, low);
}

static void multiply(ext out[4], const ext a[4], const ext b[4])
{
    out[0] = a[3] * b[0] + a[0] * b[3] + a[1] * b[2] - a[2] * b[1];
    out[1] = a[3] * b[1] - a[0] * b[2] + a[1] * b[3] + a[2] * b[0];
    out[2] = a[3] * b[2] + a[0] * b[1] - a[1] * b[0] + a[2] * b[3];
    out[3] = a[3] * b[3] - a[0] * b[0] - a[1] * b[1] - a[2] * b[2];
}

static void load(const tfa_rotation *r, ext quat[4])
{
    ext_from_parts(quat, r->quat, r->low, 4);
}

void tfa_rotation_product(const tfa_rotation *a, const tfa_rotation *b, tfa_rotation *product)
{
    ext x[4], y[4], xy[4];
    load(a, x);
    load(b, y);
    multiply(xy, x, y);
    ext_to_parts(product->quat, product->low, xy, 4);
}

void tfa_rotation_inverse(const tfa_rotation *r, tfa_rotation *inverse)
{
    *inverse = *r;
    for (int k = 0; k < 3; k++) {
        inverse->quat[k] = -r->quat[k];
        inverse->low[k] = -r->low[k];
    }
}

/* The shortest rotation to the axis, or to its opposite and then by half a turn about x */
void tfa_rotation_from_z(const double axis[3], tfa_rotation *rotation)
{
    static const ext half_turn[4] = {1, 0, 0, 0};
    const double sign = axis[2] < 0 ? -1 : 1;
    const ext to[4] = {-sign * axis[1], sign * axis[0], 0, 1 + (ext)(sign * axis[2])};
    const ext length = TFA_QUAD_SQRT(to[0] * to[0] + to[1] * to[1] + to[3] * to[3]);
    ext quat[4], turned[4];
    for (int k = 0; k < 4; k++)
        quat[k] = to[k] / length;
    multiply(turned, quat, half_turn);
    ext_to_parts(rotation->quat, rotation->low, sign < 0 ? turned : quat, 4);
}

void tfa_rotate_back(const tfa_rotation *r, double axis[3])
{
    ext q[4], inverse[4], half[4], out[4];
    const ext x[4] = {axis[0], axis[1], axis[2], 0};
    load(r, q);
    for (int k = 0; k < 4; k++)
        inverse[k] = k < 3 ? -q[k] : q[k];
    multiply(half, inverse, x);
    multiply(out, half, q);
    for (int k = 0; k < 3; k++)
        axis[k] = (double)out[k];
}

void tfa_constraint_set_pose(double pose[7], const double *xyz, const double *rpy)
{
    static const double zeros[3];
    tfa_rotation rotation;
    tfa_rotation_from_rpy(rpy ? rpy : zeros, &rotation);
    for (int k = 0; k < 7; k++)
        pose[k] = k >= 3 ? rotation.quat[k - 3] : xyz ? xyz[k] : 0;
}
