/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Operations through a revolute joint without rotor inertia, by value: the entries that the
 * projection makes zero are left out, row and column z of Ia = IA - U D^-1 U^T and the z components
 * of c.
 */
#ifndef TFA_DYNAMICS_CORE_REVOLUTE_H
#define TFA_DYNAMICS_CORE_REVOLUTE_H

#include "spatial/spatial.h"

/* U = IA H, column z */
TFA_INLINE svec revolute_U(const sym6 *IA)
{
    return (svec){{IA->A.xz, IA->A.yz, IA->A.zz}, {IA->B.zx, IA->B.zy, IA->B.zz}};
}

/* U D^-1, whose component z is 1 */
TFA_INLINE svec revolute_gain(svec U, num Dinv)
{
    return (svec){{U.w.x * Dinv, U.w.y * Dinv, num_of(1)}, v3_scale(U.v, Dinv)};
}

/* Ia = IA - U D^-1 U^T with k = U D^-1 */
TFA_INLINE sym6 revolute_project(const sym6 *IA, svec U, svec k)
{
    const num o = num_of(0);
    return (sym6){
        {IA->A.xx - k.w.x * U.w.x, IA->A.xy - k.w.x * U.w.y, o, IA->A.yy - k.w.y * U.w.y, o, o},
        {IA->B.xx - k.w.x * U.v.x, IA->B.xy - k.w.x * U.v.y, IA->B.xz - k.w.x * U.v.z,
         IA->B.yx - k.w.y * U.v.x, IA->B.yy - k.w.y * U.v.y, IA->B.yz - k.w.y * U.v.z, o, o, o},
        {IA->M.xx - k.v.x * U.v.x, IA->M.xy - k.v.x * U.v.y, IA->M.xz - k.v.x * U.v.z,
         IA->M.yy - k.v.y * U.v.y, IA->M.yz - k.v.y * U.v.z, IA->M.zz - k.v.z * U.v.z}};
}

/* pA + U D^-1 u */
TFA_INLINE svec revolute_force(svec pA, svec k, num u)
{
    return sv_add_scaled(pA, (svec){{k.w.x, k.w.y, num_of(1)}, k.v}, u);
}

/* f + Ia c, where c.w.z and c.v.z are 0 */
TFA_INLINE svec revolute_add_bias(svec f, const sym6 *Ia, svec c)
{
    f.w.x += Ia->A.xx * c.w.x + Ia->A.xy * c.w.y + Ia->B.xx * c.v.x + Ia->B.xy * c.v.y;
    f.w.y += Ia->A.xy * c.w.x + Ia->A.yy * c.w.y + Ia->B.yx * c.v.x + Ia->B.yy * c.v.y;
    f.v.x += Ia->B.xx * c.w.x + Ia->B.yx * c.w.y + Ia->M.xx * c.v.x + Ia->M.xy * c.v.y;
    f.v.y += Ia->B.xy * c.w.x + Ia->B.yy * c.w.y + Ia->M.xy * c.v.x + Ia->M.yy * c.v.y;
    f.v.z += Ia->B.xz * c.w.x + Ia->B.yz * c.w.y + Ia->M.xz * c.v.x + Ia->M.yz * c.v.y;
    return f;
}

/* v x H qd of a joint whose body moves with v */
TFA_INLINE svec revolute_velocity_product(svec v, num qd)
{
    return (svec){v3(v.w.y * qd, -v.w.x * qd, num_of(0)), v3(v.v.y * qd, -v.v.x * qd, num_of(0))};
}

/* X = Z(q) T: axes turned by the angle about z, the first two rows of E mix, the third stays */
TFA_INLINE mat3 revolute_rotate(mat3 E, num s, num c)
{
    return (mat3){c * E.xx + s * E.yx,
                  c * E.xy + s * E.yy,
                  c * E.xz + s * E.yz,
                  c * E.yx - s * E.xx,
                  c * E.yy - s * E.xy,
                  c * E.yz - s * E.xz,
                  E.zx,
                  E.zy,
                  E.zz};
}

#endif
