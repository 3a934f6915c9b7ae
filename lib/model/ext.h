/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Vectors and rotations in quadruple precision. The f128 kernel reads constants as compiled; the
 * others read them rounded to double once.
 */
#ifndef TFA_MODEL_EXT_H
#define TFA_MODEL_EXT_H

#include <string.h>

#include "model/quad.h"

typedef tfa_quad ext;

/* Row and column of each of the six numbers xx xy xz yy yz zz */
static const int ext_row[6] = {0, 0, 0, 1, 1, 2}, ext_col[6] = {0, 1, 2, 1, 2, 2};

static inline ext ext_abs(ext x)
{
    return x < 0 ? -x : x;
}

static inline ext ext_hypot(ext x, ext y)
{
    return TFA_QUAD_SQRT(x * x + y * y);
}

/* c = a b, row major; c may not be a or b */
static inline void ext_mul(ext *c, const ext *a, const ext *b)
{
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            c[3 * i + j] = a[3 * i] * b[j] + a[3 * i + 1] * b[3 + j] + a[3 * i + 2] * b[6 + j];
}

static inline void ext_transpose(ext *t, const ext *a)
{
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            t[3 * i + j] = a[3 * j + i];
}

/* y = a x + b; y may not be x */
static inline void ext_apply(ext *y, const ext *a, const ext *x, const ext *b)
{
    for (int i = 0; i < 3; i++)
        y[i] = a[3 * i] * x[0] + a[3 * i + 1] * x[1] + a[3 * i + 2] * x[2] + b[i];
}

/* c += a x b; c may not be a or b */
static inline void ext_add_cross(ext *c, const ext *a, const ext *b)
{
    for (int i = 0; i < 3; i++)
        c[i] += a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
}

/* y = a^T x; y may not be x */
static inline void ext_apply_transposed(ext *y, const ext *a, const ext *x)
{
    for (int i = 0; i < 3; i++)
        y[i] = a[i] * x[0] + a[3 + i] * x[1] + a[6 + i] * x[2];
}

static inline void ext_from_double(ext *to, const double *from, int count)
{
    for (int k = 0; k < count; k++)
        to[k] = from[k];
}

/* Numbers given as the sum of two doubles */
static inline void ext_from_parts(ext *to, const double *high, const double *low, int count)
{
    for (int k = 0; k < count; k++)
        to[k] = (ext)high[k] + low[k];
}

static inline void ext_to_parts(double *high, double *low, const ext *from, int count)
{
    for (int k = 0; k < count; k++) {
        high[k] = (double)from[k];
        low[k] = (double)(from[k] - high[k]);
    }
}

static inline void ext_round(double *to, const ext *from, int count)
{
    for (int k = 0; k < count; k++)
        to[k] = (double)from[k];
}

/* Entries this small beside what they are added to are rounding of a file's decimals: 1.5707963268
 * and its like for a right angle leave 4e-16 and less where a 0 is meant. Doubles get the 0, so
 * that specialised kernels have no code for it, and single precision no subnormal products. The
 * quadruple-precision constants stay as written. */
#define EXT_ZERO 0x1p-50

static inline double ext_round_or_zero(ext x, ext size)
{
    return ext_abs(x) > EXT_ZERO * size ? (double)x : 0;
}

static inline void ext_round_rotation(double *to, const ext *from)
{
    for (int k = 0; k < 9; k++)
        to[k] = ext_round_or_zero(from[k], 1);
}

/* size: of the vector, or of what it is measured from, if that is larger */
static inline void ext_round_vector(double *to, const ext *from, ext size)
{
    size += ext_hypot(from[0], ext_hypot(from[1], from[2]));
    for (int k = 0; k < 3; k++)
        to[k] = ext_round_or_zero(from[k], size);
}

/* xx xy xz yy yz zz; products of inertia are measured by their two moments */
static inline void ext_round_inertia(double *to, const ext *from)
{
    static const int diagonal[3] = {0, 3, 5};
    for (int k = 0; k < 6; k++) {
        const ext a = from[diagonal[ext_row[k]]], b = from[diagonal[ext_col[k]]];
        const ext size = a > 0 && b > 0 ? TFA_QUAD_SQRT(a * b) : 0;
        to[k] = ext_round_or_zero(from[k], ext_row[k] == ext_col[k] ? 0 : size);
    }
}

static inline void ext_identity(ext *R)
{
    memset(R, 0, 9 * sizeof *R);
    R[0] = R[4] = R[8] = 1;
}

/* Rotation matrix (moved axes to fixed axes) of a quaternion x y z w, normalised here. */
static inline void ext_rotation(ext *R, const ext *quat)
{
    ext x = quat[0], y = quat[1], z = quat[2], w = quat[3];
    ext s = 2 / (x * x + y * y + z * z + w * w);
    ext m[9] = {1 - s * (y * y + z * z), s * (x * y - w * z),     s * (x * z + w * y),
                s * (x * y + w * z),     1 - s * (x * x + z * z), s * (y * z - w * x),
                s * (x * z - w * y),     s * (y * z + w * x),     1 - s * (x * x + y * y)};
    memcpy(R, m, sizeof m);
}

#endif
