/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Lambda^-1 by the factorisation (74)-(78) of Fijany & Featherstone 2013: one block solve with six
 * right-hand sides for each tip, along a chain whose side branches are reduced.
 *
 *   Lambda^-1 = Omega G A^-1 Pi,   Pi_i = B_i H_i^T P_i,   P_i: the tip's unit wrenches in frame i
 *
 * G takes the total forces F = A^-1 Pi to the accelerations of the bodies relative to each other,
 * and Omega carries these to the tip and adds them up. That sum telescopes: it is the tip's own
 * acceleration, I^-1 (F - X^T F of the next body). Term by term it cancels and loses up to seven
 * digits more (on a helix of 512 bodies 6e-9 for 1e-11), so it is never formed. A tip on a side
 * branch stands for its wrenches on the body that carries the branch, and for the response of the
 * joints in between.
 *
 * Refined: x = M^-1 J^T and r = J^T - M x joint by joint, then Lambda^-1 = J x + Omega G A^-1 B r.
 */
#include "dynamics/chain/chain.h"
#include "dynamics/chain/tfa_motion.h"
#include "dynamics/osim/lambda.h"

/* A tip's wrenches where they meet the chain, on body -1: nowhere (struct tip_wrenches) */
struct tip_on_chain {
    int32_t body;
    uint32_t moved;
    svec P[6];
};

/* A chain, the method that solves for it, and the tips on it */
struct chain_solver {
    const struct tfa_chain *chain;
    const struct chain_method *method;
    void *rows;
    struct tip_on_chain at[TFA_MAX_TIPS];
};

/* The tips of this tree, through their side branches */
static void find_tips(struct state *s, tfa_reference_frame frame, struct chain_solver *x)
{
    for (uint32_t t = 0; t < s->tips; t++) {
        struct tip_wrenches w;
        TFA_V(tip_start)(s, t, frame, &w);
        if (w.body < (int32_t)x->chain->first || w.body >= (int32_t)x->chain->end)
            w.body = -1;
        while (w.body >= 0 && !chain_has(s, x->chain, w.body))
            TFA_V(tip_through_joint)(s, t, &w);
        x->at[t].body = w.body;
        x->at[t].moved = w.moved;
        if (w.body >= 0)
            wrench_columns_store(&w.P, x->at[t].P);
    }
}

/* psi = H^T P of the chain's joints; 0 for those that do not move the tip */
static void joint_forces(struct state *s, const struct chain_solver *x, uint32_t t)
{
    struct tip_on_chain w = x->at[t];
    for (uint32_t k = x->chain->length; k-- > 0;) {
        const uint32_t i = x->chain->body[k];
        const struct tfa_body *b = &s->body[i];
        const int moves = (int32_t)i == w.body;
        for (int e = 0; e < 6; e++) {
            num h[6] = {0};
            if (moves)
                joint_force(s, b, w.P[e], h);
            for (uint32_t j = 0; j < b->n; j++)
                tip_columns(s, s->psi, b->v + j, t)[e] = j < w.moved ? h[j] : num_of(0);
            if (moves)
                w.P[e] = xform_t_force(&s->X[i], w.P[e]);
        }
        if (moves) {
            w.body = b->parent;
            w.moved = 6;
        }
    }
}

/* F = A^-1 B psi for the six columns of tip u */
static struct row *total_forces(struct state *s, const struct chain_solver *x, uint32_t u)
{
    return x->method->forces_6rhs(s, x->chain, x->rows, tip_columns(s, s->psi, 0, u),
                                  (size_t)6 * s->tips);
}

static inline svec force(const struct row *r, int e)
{
    const num *F = r->F + e;
    return (svec){{F[0], F[6], F[12]}, {F[18], F[24], F[30]}};
}

/* a_k = I_k^-1 (F_k - X_{k+1}^T F_{k+1}) */
static inline svec acceleration(const struct state *s, const struct chain_solver *x,
                                const struct row *row, uint32_t k, int e)
{
    svec net = force(&row[k], e);
    if (k + 1 < x->chain->length)
        net = sv_sub(net, xform_t_force(&s->X[x->chain->body[k + 1]], force(&row[k + 1], e)));
    return s6_mul(&row[k].Iinv, net);
}

/* The acceleration of a tip on a body whose parent has `up` and whose joint has qdd: of a joint of
 * several parts the first freedoms may move the tip alone. */
static svec tip_acceleration(const struct state *s, const struct tip_on_chain *w, svec up, num *qdd)
{
    const struct tfa_body *b = &s->body[w->body];
    svec a = xform_motion(&s->X[w->body], up);
    for (uint32_t j = w->moved; j < b->n; j++)
        qdd[j] = num_of(0);
    add_joint_motion(s, b, qdd, &a);
    return a;
}

/* Lambda^-1_tu += P_t^T a, the mean of both triangles for a tip with itself */
static void add_block(struct state *s, const struct chain_solver *x, uint32_t t, uint32_t u,
                      const svec a[6])
{
    const svec *P = x->at[t].P;
    for (uint32_t e = 0; e < 6; e++)
        for (uint32_t f = 0; f < 6; f++) {
            const num sum = sv_dot(P[e], a[f]);
            *lambda_entry(s, t, u, e, f) += t == u ? (sum + sv_dot(P[f], a[e])) / 2 : sum;
        }
}

/* The blocks of tip u and those before it from the total forces */
static void add_forces(struct state *s, const struct chain_solver *x, const struct row *row,
                       uint32_t u)
{
    for (uint32_t t = 0; t <= u; t++) {
        const struct tip_on_chain *w = &x->at[t];
        svec a[6];
        if (w->body < 0)
            continue;
        const uint32_t k = s->body[w->body].depth - 1;
        for (int e = 0; e < 6; e++) {
            num qdd[6];
            a[e] = acceleration(s, x, row, k, e);
            if (w->moved >= s->body[w->body].n)
                continue;
            const svec up = k > 0 ? acceleration(s, x, row, k - 1, e) : sv_zero();
            joint_acceleration(s, (uint32_t)w->body, a[e], up, qdd, 0);
            a[e] = tip_acceleration(s, w, up, qdd);
        }
        add_block(s, x, t, u, a);
    }
}

/* ---- refinement ---- */

/* phi += G F, joint accelerations; a fresh phi is 0 before */
static void add_rates(struct state *s, const struct chain_solver *x, const struct row *row,
                      uint32_t u, int fresh)
{
    for (int e = 0; e < 6; e++) {
        svec up = sv_zero();
        for (uint32_t k = 0; k < x->chain->length; k++) {
            const uint32_t i = x->chain->body[k];
            const svec a = acceleration(s, x, row, k, e);
            num qdd[6];
            joint_acceleration(s, i, a, up, qdd, 0);
            for (uint32_t j = 0; j < s->body[i].n; j++) {
                num *phi = tip_columns(s, s->phi, s->body[i].v + j, u) + e;
                *phi = fresh ? qdd[j] : *phi + qdd[j];
            }
            up = a;
        }
    }
}

static inline void joint_rates(const struct state *s, uint32_t i, uint32_t u, int e, num *qdd)
{
    for (uint32_t j = 0; j < s->body[i].n; j++)
        qdd[j] = tip_columns(s, s->phi, s->body[i].v + j, u)[e];
}

/* The accelerations of the chain's bodies that phi gives, in place of F: column e at F[6 e] */
static void move_bodies(const struct state *s, const struct chain_solver *x, struct row *row,
                        uint32_t u)
{
    for (int e = 0; e < 6; e++) {
        svec a = sv_zero();
        for (uint32_t k = 0; k < x->chain->length; k++) {
            const uint32_t i = x->chain->body[k];
            num qdd[6];
            joint_rates(s, i, u, e, qdd);
            a = xform_motion(&s->X[i], a);
            add_joint_motion(s, &s->body[i], qdd, &a);
            sv_store(row[k].F + 6 * e, a);
        }
    }
}

/* J phi, from these accelerations */
static void add_motion(struct state *s, const struct chain_solver *x, const struct row *row,
                       uint32_t u)
{
    for (uint32_t t = 0; t <= u; t++) {
        const struct tip_on_chain *w = &x->at[t];
        svec a[6];
        if (w->body < 0)
            continue;
        const uint32_t k = s->body[w->body].depth - 1;
        for (int e = 0; e < 6; e++) {
            num qdd[6];
            joint_rates(s, (uint32_t)w->body, u, e, qdd);
            a[e] = tip_acceleration(s, w, k > 0 ? sv_from(row[k - 1].F + 6 * e) : sv_zero(), qdd);
        }
        add_block(s, x, t, u, a);
    }
}

/* psi -= M phi, from these accelerations; I is the inertia with the side branches added */
static void residual(struct state *s, const struct chain_solver *x, const struct row *row,
                     uint32_t u)
{
    for (int e = 0; e < 6; e++) {
        svec f = sv_zero();
        for (uint32_t k = x->chain->length; k-- > 0;) {
            const uint32_t i = x->chain->body[k];
            const struct tfa_body *b = &s->body[i];
            num h[6];
            f = sv_add(f, s6_mul(&s->IA[i], sv_from(row[k].F + 6 * e)));
            joint_force(s, b, f, h);
            for (uint32_t j = 0; j < b->n; j++)
                tip_columns(s, s->psi, b->v + j, u)[e] -=
                    h[j] + joint_armature(s, b, j) * tip_columns(s, s->phi, b->v + j, u)[e];
            f = xform_t_force(&s->X[i], f);
        }
    }
}

static void answer_tip(struct state *s, const struct chain_solver *x, uint32_t u, uint32_t refine)
{
    joint_forces(s, x, u);
    struct row *row = total_forces(s, x, u);
    for (uint32_t step = 1; step <= refine; step++) {
        add_rates(s, x, row, u, step == 1);
        move_bodies(s, x, row, u);
        if (step == refine)
            add_motion(s, x, row, u);
        joint_forces(s, x, u);
        residual(s, x, row, u);
        row = total_forces(s, x, u);
    }
    add_forces(s, x, row, u);
}

void TFA_V(lambda_chain)(struct state *s, tfa_reference_frame frame,
                         const struct chain_method *method, uint32_t refine)
{
    char *rows = s->rows;
    TFA_V(lambda_clear)(s);
    for (uint32_t c = 0; c < s->m->trees; c++) {
        struct chain_solver x;
        x.chain = &s->m->chain[c];
        x.method = method;
        x.rows = rows;
        find_tips(s, frame, &x);
        for (uint32_t u = 0; u < s->tips; u++)
            if (x.at[u].body >= 0)
                answer_tip(s, &x, u, refine);
        rows += method->bytes(x.chain->length);
    }
    TFA_V(lambda_joints)(s);
    TFA_V(lambda_mirror)(s);
}
