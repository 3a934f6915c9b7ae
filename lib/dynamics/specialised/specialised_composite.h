/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Composite rigid bodies of one robot, inward: f = Ic_k H_k of a joint with one freedom, carried
 * along the path to the world, gives row k of M. Featherstone 2008, 6.2.
 */
#ifndef TFA_DYNAMICS_SPECIALISED_SPECIALISED_COMPOSITE_H
#define TFA_DYNAMICS_SPECIALISED_SPECIALISED_COMPOSITE_H

#include "dynamics/specialised/specialised_recursions.h"
#include "spatial/rigid.h"

TFA_INLINE num axis_force(const body_constants *b, svec f)
{
    return is_revolute(b->kind) ? f.w.z : f.v.z;
}

/* Ic_k; Ic: sums over the children, to which it is added. All in body coordinates. */
TFA_INLINE rigid composite_step(const struct state *s, rigid *Ic, int32_t k)
{
    const body_constants *b = body_constants_of(s, (uint32_t)k);
    const struct tfa_body *loaded = body_with_payload(s, (uint32_t)k);
    const rigid own = {body_mass(loaded), body_h(loaded), body_I(loaded)};
    const rigid sum = rigid_add(&own, &Ic[k]);
    if (b->parent >= 0) {
        const screw e = body_screw(s, (uint32_t)k, b);
        const rigid up =
            body_axial(b) ? screw_rigid_to_parent(&e, &sum) : rigid_to_parent(&s->X[k], &sum);
        Ic[b->parent] = rigid_add(&Ic[b->parent], &up);
    }
    return sum;
}

/* row[j] = H_j^T f of the bodies j on the path from body k to the world; returns f on the last. */
TFA_INLINE svec composite_row(const struct state *s, int32_t k, const rigid *Ic, num *row)
{
    const body_constants *b = body_constants_of(s, (uint32_t)k);
    svec f = is_revolute(b->kind) ? rigid_column_rz(Ic) : rigid_column_tz(Ic);
    row[k] = axis_force(b, f) + body_armature(b);
    int32_t child = k;
#pragma GCC unroll 128
    for (int32_t j = ROBOT_BODIES - 1; j >= 0; j--)
        if (j < k && is_on_path(j, k)) {
            f = force_to_parent(s, (uint32_t)child, &robot_body[child], f);
            row[j] = axis_force(&robot_body[j], f);
            child = j;
        }
    return f;
}

#endif
