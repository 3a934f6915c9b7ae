/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Recursive Newton-Euler: inverse dynamics, and the residual of every other method.
 *
 * A residual shows what a method loses, but not what pose, velocities and the residual itself lose to
 * rounding, which every method shares with it. An estimate takes it with all of them shaken: each
 * number times 1 + e or 1 - e, e some roundings, by turns that look random.
 */
#include "kernel/body.h"
#include "kernel/kernel.h"

/* So many roundings a number is shaken by: what a body computes from it and adds up. test_estimates
 * 5000 saw 89 of 884724 answers whose error was above 30 estimates with 4, 77 with 8, 2026-11-22. */
#define LOUD 8

static inline num shake(num x, uint32_t *turn)
{
    const num e = LOUD * (num)NUM_EPSILON;
    *turn = *turn * 1664525u + 1013904223u;
    return x * (*turn >> 31 ? 1 + e : 1 - e);
}

static inline vec3 shake_vec3(vec3 x, uint32_t *turn)
{
    return (vec3){shake(x.x, turn), shake(x.y, turn), shake(x.z, turn)};
}

static inline svec shake_svec(svec x, uint32_t *turn)
{
    return (svec){shake_vec3(x.w, turn), shake_vec3(x.v, turn)};
}

/* One row of E; each entry lost as much as `size`, what it was summed from. */
static inline vec3 shake_row(vec3 row, vec3 size, uint32_t *turn)
{
    return v3_add(row, v3_sub(shake_vec3(size, turn), size));
}

/* E = Z T: one freedom mixes the first two rows of T at most, more may mix all three. */
static inline place shake_place(const place *X, int single, uint32_t *turn)
{
    const mat3 *E = &X->E;
    vec3 size = {num_abs(E->xx) + num_abs(E->yx), num_abs(E->xy) + num_abs(E->yy),
                 num_abs(E->xz) + num_abs(E->yz)};
    vec3 last = {num_abs(E->zx), num_abs(E->zy), num_abs(E->zz)};
    if (!single)
        last = size = v3_add(size, last);
    const vec3 x = shake_row((vec3){E->xx, E->xy, E->xz}, size, turn),
               y = shake_row((vec3){E->yx, E->yy, E->yz}, size, turn),
               z = shake_row((vec3){E->zx, E->zy, E->zz}, last, turn);
    return (place){{x.x, x.y, x.z, y.x, y.y, y.z, z.x, z.y, z.z}, shake_vec3(X->r, turn)};
}

/* c_i and p_i, or what they are of a shaken velocity */
static inline void products_of(const struct state *s, uint32_t i, int shaken, uint32_t *turn,
                               svec *c, svec *p)
{
    *c = s->c[i];
    *p = s->p[i];
    if (!shaken)
        return;
    const svec v = s->v[i], momentum = rigid_mul(&s->body[i], shake_svec(v, turn));
    *c = shake_svec(*c, turn);
    *p = sv_sub(cross_force(shake_svec(v, turn), momentum), shake_svec(s->wrench[i], turn));
}

static inline __attribute__((always_inline)) void newton_euler(struct state *s, const num *qdd,
                                                               num *tau, int bias, int shaken)
{
    const struct tfa_model *m = s->m;
    const int products = bias && s->moving;
    uint32_t turn = 1;
    const svec ground = {{0, 0, 0}, bias ? v3_neg(s->gravity) : v3(0, 0, 0)};

    /* a_i = X_i a_parent + H_i qdd_i + c_i,  f_i = I_i a_i + p_i */
    for (uint32_t i = 0; i < m->bodies; i++) {
        const struct tfa_body *b = &s->body[i];
        const place X = shaken ? shake_place(&s->X[i], b->n == 1, &turn) : s->X[i];
        svec a = x_motion(&X, b->parent < 0 ? ground : s->a[b->parent]), c, p = sv_zero();
        if (products) {
            products_of(s, i, shaken, &turn, &c, &p);
            a = sv_add(a, c);
        }
        add_joint_motion(s, b, qdd + b->v, &a);
        s->a[i] = a;
        s->f[i] = rigid_mul(b, a);
        if (products)
            s->f[i] = sv_add(s->f[i], p);
    }

    /* tau_i = H_i^T f_i + R_i qdd_i,  f_parent += X_i^T f_i */
    for (uint32_t i = m->bodies; i-- > 0;) {
        const struct tfa_body *b = &s->body[i];
        joint_force(s, b, s->f[i], tau + b->v);
        for (uint32_t k = 0; k < b->n; k++)
            tau[b->v + k] += joint_armature(s, b, k) * qdd[b->v + k];
        if (b->parent < 0)
            continue;
        const place X = shaken ? shake_place(&s->X[i], b->n == 1, &turn) : s->X[i];
        s->f[b->parent] = sv_add(s->f[b->parent], x_t_force(&X, s->f[i]));
    }
}

void TFA_V(rnea)(struct state *s, const num *qdd, num *tau, int bias)
{
    newton_euler(s, qdd, tau, bias, 0);
}

void TFA_V(rnea_shaken)(struct state *s, const num *qdd, num *tau, int bias)
{
    newton_euler(s, qdd, tau, bias, 1);
}
