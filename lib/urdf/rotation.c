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

double tfa_axis_normalise(double axis[3], double low[3])
{
    ext a[3];
    ext_from_double(a, axis, 3);
    const ext length = TFA_QUAD_SQRT(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]);
    if (!(length > 0))
        return 0;
    for (int k = 0; k < 3; k++)
        a[k] /= length;
    ext_to_parts(axis, low, a, 3);
    return (double)length;
}
