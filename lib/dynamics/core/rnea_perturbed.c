/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The residual of an estimate: recursive Newton-Euler with pose, velocities and forces perturbed
 * (perturb.h). A residual shows the loss of a method, but not the rounding of pose, velocities and
 * the residual itself, which every method shares.
 */
#include "dynamics/core/modes.h"
#include "dynamics/core/perturb.h"
#include "dynamics/core/rnea_step.h"
#include "layout/parent_transfer.h"

static inline struct perturb_start perturb_start(const struct state *s, uint32_t i)
{
    struct perturb_start start;
    for (uint32_t l = 0; l < LAYOUT_BODIES_IN_LANES; l++)
        start.lane[l] = PERTURB_EACH * body_in_lane(s, i, l) % PERTURB_COUNT;
    return start;
}

/* Sum of the absolute values that v_i is made of, and of c_i */
static inline svec velocity_abs(const struct state *s, const body_constants *b, const xform *X,
                                svec *c)
{
    svec joint = sv_zero();
    add_joint_motion(s, b, s->qd + b->v, &joint);
    joint = sv_abs(joint);
    const svec before = sv_abs(parent_motion(b, s->v, sv_zero()));
    const svec v = sv_add(xform_motion_abs(X, before), joint);
    *c = cross_motion_abs(v, joint);
    return v;
}

/* a_i and f_i as in rnea, each perturbed */
static inline void outward_perturbed(struct state *s, uint32_t i, svec ground, const num *qdd,
                                     num *tau, int products)
{
    const struct perturb_start start = perturb_start(s, i);
    const body_constants *b = body_constants_of(s, i);
    svec before = parent_motion(b, s->a, ground);
    if (HAS_MODES(s))
        before = TFA_V(modes_parent)(s, i, before, qdd);
    const xform X = xform_abs(&s->X[i], b->n == 1);
    svec a = xform_motion(&s->X[i], before), size = xform_motion_abs(&X, sv_abs(before)),
         f = sv_zero();
    if (products) {
        svec c;
        const svec v = velocity_abs(s, b, &X, &c);
        a = sv_add(a, s->c[i]);
        size = sv_add(size, c);
        f = rigid_bias_abs(body_I(b), body_h(b), body_mass(b), v);
        f = sv_add(f, sv_abs(s->wrench[i]));
    }
    euler_out(s, i, sv_perturb(a, size, &start, 0), qdd, products ? &s->p[i] : NULL);
    if (HAS_MODES(s))
        TFA_V(modes_euler)(s, i, qdd, tau, products);
    f = sv_add(f, rigid_mul_abs(body_I(b), body_h(b), body_mass(b), sv_abs(s->a[i])));
    s->f[i] = sv_perturb(s->f[i], f, &start, 6);
}

/* tau_i, and f_i to the parent, which stands where ABA has its bias force */
static inline void inward_perturbed(struct state *s, uint32_t i, const num *qdd, num *tau)
{
    const struct perturb_start start = perturb_start(s, i);
    const body_constants *b = body_constants_of(s, i);
    if (!b->leaf)
        s->f[i] = sv_add(s->f[i], force_from_children(s, i));
    euler_joint(s, i, qdd, tau);
    if (b->parent < 0)
        return;
    const xform X = xform_abs(&s->X[i], b->n == 1);
    const svec size = xform_t_force_abs(&X, sv_abs(s->f[i]));
    const svec up = sv_perturb(xform_t_force(&s->X[i], s->f[i]), size, &start, 12);
    if (HAS_MODES(s))
        TFA_V(modes_euler_parent)(s, i, up, tau);
    add_force_to_parent(s, i, up, ABA_FULL_SWEEP);
}

void TFA_V(rnea_perturbed)(struct state *s, const num *qdd, num *tau, int bias)
{
    const svec ground = {v3_zero(), bias ? v3_neg(s->gravity) : v3_zero()};
    for (uint32_t i = 0; i < s->bodies; i++)
        outward_perturbed(s, i, ground, qdd, tau, bias && s->moving);
    for (uint32_t i = s->bodies; i-- > 0;)
        inward_perturbed(s, i, qdd, tau);
}
