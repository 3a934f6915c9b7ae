/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Recursive Newton-Euler: inverse dynamics, and the residual of every other method.
 *
 * A residual shows what a method loses, but not what pose, velocities and the residual itself lose to
 * rounding, which every method shares with it. An estimate takes the residual with all of them
 * perturbed (perturb.h).
 */
#include "kernel/join.h"
#include "kernel/kernel.h"
#include "kernel/perturb.h"
#include "kernel/rnea_step.h"

#ifndef TFA_PACKED /* limbs need the residual of estimates only */

/* tau_i = H_i^T f_i + R_i qdd_i,  f_parent += X_i^T f_i */
static inline void inward(struct state *s, uint32_t i, const num *qdd, num *tau)
{
    const struct tfa_body *b = &s->body[i];
    euler_joint(s, i, qdd, tau);
    if (b->parent >= 0)
        s->f[b->parent] = sv_add(s->f[b->parent], x_t_force(&s->X[i], s->f[i]));
}

void TFA_V(rnea)(struct state *s, const num *qdd, num *tau, int bias)
{
    const struct tfa_model *m = s->m;
    const int products = bias && s->moving;
    const svec ground = {v3_zero(), bias ? v3_neg(s->gravity) : v3_zero()};

    /* a_i = X_i a_parent + H_i qdd_i + c_i,  f_i = I_i a_i + p_i */
    for (uint32_t i = 0; i < m->bodies; i++) {
        const struct tfa_body *b = &s->body[i];
        svec a = x_motion(&s->X[i], b->parent < 0 ? ground : s->a[b->parent]);
        if (products)
            a = sv_add(a, s->c[i]);
        euler_out(s, i, a, qdd, products ? &s->p[i] : NULL);
    }
    for (uint32_t i = m->bodies; i-- > 0;)
        inward(s, i, qdd, tau);
}

#endif

/* ---- perturbed ---- */

static inline struct perturb_start perturb_start(const struct state *s, uint32_t i)
{
    struct perturb_start start;
    for (uint32_t l = 0; l < PERTURB_LANES; l++)
        start.lane[l] = PERTURB_EACH * body_in_lane(s, i, l) % PERTURB_COUNT;
    return start;
}

/* Sum of the absolute values that v_i is made of, and of c_i */
static inline svec velocity_abs(const struct state *s, const terms *b, const place *X, svec *c)
{
    svec joint = sv_zero();
    add_joint_motion(s, b, s->qd + b->v, &joint);
    joint = sv_abs(joint);
    const svec before = sv_abs(parent_motion(b, s->v, sv_zero()));
    const svec v = sv_add(x_motion_abs(X, before), joint);
    *c = cross_motion_abs(v, joint);
    return v;
}

/* a_i and f_i as in rnea, each perturbed */
static inline void outward_perturbed(struct state *s, uint32_t i, svec ground, const num *qdd,
                                     int products)
{
    const struct perturb_start start = perturb_start(s, i);
    const terms *b = body_terms(s, i);
    const svec before = parent_motion(b, s->a, ground);
    const place X = place_abs(&s->X[i], b->n == 1);
    svec a = x_motion(&s->X[i], before), size = x_motion_abs(&X, sv_abs(before)), f = sv_zero();
    if (products) {
        svec c;
        const svec v = velocity_abs(s, b, &X, &c);
        a = sv_add(a, s->c[i]);
        size = sv_add(size, c);
        f = cross_force_abs(v, rigid_mul_abs(terms_I(b), terms_h(b), terms_mass(b), v));
        f = sv_add(f, sv_abs(s->wrench[i]));
    }
    euler_out(s, i, sv_perturb(a, size, &start, 0), qdd, products ? &s->p[i] : NULL);
    f = sv_add(f, rigid_mul_abs(terms_I(b), terms_h(b), terms_mass(b), sv_abs(s->a[i])));
    s->f[i] = sv_perturb(s->f[i], f, &start, 6);
}

/* tau_i, and f_i to the parent, which stands where ABA has its bias force */
static inline void inward_perturbed(struct state *s, uint32_t i, const num *qdd, num *tau)
{
    const struct perturb_start start = perturb_start(s, i);
    const terms *b = body_terms(s, i);
    if (!b->leaf)
        s->f[i] = sv_add(s->f[i], given_force(s, i));
    euler_joint(s, i, qdd, tau);
    if (b->parent < 0)
        return;
    const place X = place_abs(&s->X[i], b->n == 1);
    const svec size = x_t_force_abs(&X, sv_abs(s->f[i]));
    give_force(s, i, sv_perturb(x_t_force(&s->X[i], s->f[i]), size, &start, 12), FOLD_FRESH);
}

void TFA_V(rnea_perturbed)(struct state *s, const num *qdd, num *tau, int bias)
{
    const svec ground = {v3_zero(), bias ? v3_neg(s->gravity) : v3_zero()};
    for (uint32_t i = 0; i < s->bodies; i++)
        outward_perturbed(s, i, ground, qdd, bias && s->moving);
    for (uint32_t i = s->bodies; i-- > 0;)
        inward_perturbed(s, i, qdd, tau);
}
