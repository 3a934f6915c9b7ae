/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Rotations and axes from the doubles of a file, in quadruple precision: each number becomes a
 * double and its remainder.
 */
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
