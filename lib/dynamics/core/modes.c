/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Flexible bodies in the recursions (modes.h).
 */
#include "dynamics/core/modes.h"

#include "dynamics/core/aba_step.h"
#include "spatial/dense.h"

#define MOST TFA_MAX_LINK_MODES

/* ---- recursive Newton-Euler ---- */

void TFA_V(modes_force)(const struct state *s, int32_t handle, svec f, num *tau)
{
    const struct tfa_flexible *x = carrier_of(s, handle);
    for (uint32_t k = 0; k < x->n; k++)
        tau[x->v + k] += sv_dot(phi_of(s, handle, k), f);
}

void TFA_V(modes_euler)(struct state *s, uint32_t i, const num *qdd, num *tau, int products)
{
    if (s->body[i].flexible < 0)
        return;
    const struct tfa_flexible *f = flexible_of(s, i);
    const struct modal_body *w = &s->modal[s->body[i].flexible];
    const num *x = qdd + f->v;
    s->f[i] =
        sv_add(s->f[i], sv_add(s6_mul(&w->change, s->a[i]), TFA_V(modes_momentum_by)(s, i, qdd)));
    for (uint32_t k = 0; k < f->n; k++) {
        num sum = sv_dot(sv_from(w->B + 6 * k), s->a[i]);
        if (products)
            sum += w->r[k];
        for (uint32_t j = 0; j < f->n; j++)
            sum += num_of(f->M[f->n * k + j]) * x[j];
        tau[f->v + k] = sum;
    }
    for (int32_t k = f->riders; k >= 0; k = s->m->handle[k].next) {
        const svec motion = TFA_V(modes_motion)(s, k, qdd);
        s->f[i] = sv_add(s->f[i], s6_mul(&s->handle[k].I, motion));
        TFA_V(modes_force)(s, k, s6_mul(&s->handle[k].I, sv_add(s->a[i], motion)), tau);
    }
}

void TFA_V(modes_euler_parent)(const struct state *s, uint32_t i, svec up, num *tau)
{
    if (s->body[i].handle >= 0)
        TFA_V(modes_force)(s, s->body[i].handle, up, tau);
}

svec TFA_V(modes_parent)(const struct state *s, uint32_t i, svec parent, const num *x)
{
    return modes_at_handle(s, s->body[i].handle, parent, x);
}

/* ---- articulated bodies ---- */

void TFA_V(modes_start_body)(struct state *s, uint32_t i, const num *tau, int flags)
{
    const struct tfa_flexible *f = flexible_of(s, i);
    struct modal_body *w = &s->modal[s->body[i].flexible];
    if (flags & ABA_INERTIA) {
        s6_add(&s->IA[i], &w->change);
        for (uint32_t k = 0; k < f->n; k++) {
            sv_store(w->W + 6 * k, sv_from(w->B + 6 * k));
            for (uint32_t j = 0; j <= k; j++)
                w->D[MOST * k + j] = num_of(f->M[f->n * k + j]);
        }
        for (int32_t k = f->riders; k >= 0; k = s->m->handle[k].next)
            TFA_V(modes_add_inertia)(s, k, &s->handle[k].I);
    }
    for (uint32_t k = 0; flags & ABA_FORCE && k < f->n; k++)
        w->u[k] = flags & ABA_BIAS ? tau[f->v + k] - w->r[k] : tau[f->v + k];
}

void TFA_V(modes_add_inertia)(struct state *s, int32_t handle, const sym6 *IA)
{
    const struct tfa_flexible *f = carrier_of(s, handle);
    struct modal_body *w = &s->modal[s->m->handle[handle].flexible];
    for (uint32_t k = 0; k < f->n; k++) {
        const svec IAPhi = s6_mul(IA, phi_of(s, handle, k));
        sv_store(w->W + 6 * k, sv_add(sv_from(w->W + 6 * k), IAPhi));
        for (uint32_t j = 0; j <= k; j++)
            w->D[MOST * k + j] += sv_dot(phi_of(s, handle, j), IAPhi);
    }
}

void TFA_V(modes_add_force)(struct state *s, int32_t handle, svec pA)
{
    const struct tfa_flexible *f = carrier_of(s, handle);
    for (uint32_t k = 0; k < f->n; k++)
        s->modal[s->m->handle[handle].flexible].u[k] -= sv_dot(phi_of(s, handle, k), pA);
}

/* W^T D^-1 W as a sum of n rank-1 terms, by V = L^-1 W */
static void eliminate_inertia(const struct tfa_flexible *f, struct modal_body *w, sym6 *IA)
{
    svec V[MOST];
    ldl_factor_rows(w->D, (int)f->n, MOST);
    for (uint32_t k = 0; k < f->n; k++) {
        V[k] = sv_from(w->W + 6 * k);
        for (uint32_t j = 0; j < k; j++)
            V[k] = sv_add_scaled(V[k], V[j], -w->D[MOST * k + j]);
        s6_rank1(IA, V[k], w->D[MOST * k + k]);
    }
}

void TFA_V(modes_eliminate_body)(struct state *s, uint32_t i, int flags)
{
    const struct tfa_flexible *f = flexible_of(s, i);
    struct modal_body *w = &s->modal[s->body[i].flexible];
    if (flags & ABA_INERTIA)
        eliminate_inertia(f, w, &s->IA[i]);
    if (!(flags & ABA_FORCE))
        return;
    num x[MOST];
    (void)TFA_V(modes_solve)(s, i, x);
    for (uint32_t k = 0; k < f->n; k++)
        s->pA[i] = sv_add_scaled(s->pA[i], sv_from(w->W + 6 * k), x[k]);
}

void TFA_V(modes_forward_body)(struct state *s, uint32_t i, num *x)
{
    const struct tfa_flexible *f = flexible_of(s, i);
    const struct modal_body *w = &s->modal[s->body[i].flexible];
    x += f->v;
    for (uint32_t k = 0; k < f->n; k++)
        x[k] = w->u[k] - sv_dot(sv_from(w->W + 6 * k), s->a[i]);
    ldl_solve_rows(w->D, (int)f->n, MOST, x);
}

void TFA_V(modes_inward)(struct state *s, const num *tau, int flags)
{
    if (flags & ABA_INERTIA)
        sentinel_reset(s);
    for (uint32_t k = s->spans; k-- > 0;)
        for (uint32_t i = s->span[k].first; i < s->span[k].end; i++) {
            aba_backward_start(s, i, flags);
            modes_start(s, i, tau, flags);
        }
    for (uint32_t k = s->spans; k-- > 0;)
        for (uint32_t i = s->span[k].end; i-- > s->span[k].first;) {
            modes_eliminate(s, i, flags);
            TFA_V(aba_backward_body)(s, i, tau, flags | ABA_SENTINEL | ABA_MODES);
        }
}

void TFA_V(modes_outward)(struct state *s, svec ground, num *qdd, int bias)
{
    for (uint32_t i = 0; i < s->bodies; i++) {
        const svec parent = parent_motion(&s->body[i], s->a, ground);
        aba_forward_step(s, i, TFA_V(modes_parent)(s, i, parent, qdd), qdd, bias);
        modes_forward(s, i, qdd);
    }
}

/* ---- chains ---- */

static void copy(num *to, const num *from, uint32_t count)
{
    for (uint32_t k = 0; k < count; k++)
        to[k] = from[k];
}

uint32_t TFA_V(modes_solve)(const struct state *s, uint32_t i, num *x)
{
    const struct tfa_flexible *f = flexible_of(s, i);
    const struct modal_body *w = &s->modal[s->body[i].flexible];
    copy(x, w->u, f->n);
    ldl_solve_rows(w->D, (int)f->n, MOST, x);
    return f->n;
}

void TFA_V(modes_save_body)(struct state *s, uint32_t i)
{
    struct modal_body *w = &s->modal[s->body[i].flexible];
    copy(w->side_W, w->W, 6 * MOST);
    copy(w->side_D, w->D, MOST * MOST);
}

void TFA_V(modes_restore_body)(struct state *s, uint32_t i)
{
    struct modal_body *w = &s->modal[s->body[i].flexible];
    copy(w->W, w->side_W, 6 * MOST);
    copy(w->D, w->side_D, MOST * MOST);
}

uint32_t TFA_V(modes_propagate)(const struct state *s, uint32_t i, int32_t handle, svec P[6],
                                num *psi, num *phi)
{
    const struct tfa_flexible *f = flexible_of(s, i);
    const struct modal_body *w = &s->modal[s->body[i].flexible];
    for (uint32_t e = 0; e < 6; e++) {
        num x[MOST];
        for (uint32_t k = 0; k < f->n; k++)
            psi[6 * k + e] = x[k] = handle < 0 ? num_of(0) : sv_dot(phi_of(s, handle, k), P[e]);
        ldl_solve_rows(w->D, (int)f->n, MOST, x);
        for (uint32_t k = 0; k < f->n; k++) {
            phi[6 * k + e] = x[k];
            P[e] = sv_add_scaled(P[e], sv_from(w->W + 6 * k), -x[k]);
        }
    }
    return f->n;
}
