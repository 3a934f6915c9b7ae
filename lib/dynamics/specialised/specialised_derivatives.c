/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Derivatives of one fixed robot's forward and inverse dynamics. Motions, inertias and M are
 * written out; pairs of freedoms and M^-1 are loops as for any robot (dynamics/derivatives):
 * written out they take as long. Compiled for one state and for states in lanes.
 */
#include "dynamics/derivatives/blocks.h"
#include "dynamics/derivatives/derivatives_step.h"
#include "dynamics/specialised/specialised_mass.h"
#include "dynamics/specialised/specialised_wrenches.h"

#if ROBOT_HAS_DERIVATIVES

#define ROBOT_BLOCK_NUMBERS                                                                        \
    (ROBOT_MASS_ROWS * BLOCKS * DERIVATIVES_GROUP *                                                \
     ((ROBOT_MASS_ROWS + DERIVATIVES_GROUP - 1) / DERIVATIVES_GROUP))

struct derivative_state {
    struct world_pose world[ROBOT_BODIES];
    struct subtree subtree[ROBOT_BODIES];
    struct freedom_terms terms[ROBOT_FREEDOMS];
    struct sentinel_size composite[ROBOT_BODIES];
    num M[ROBOT_FREEDOMS * (ROBOT_FREEDOMS + 1) / 2]; /* then its factors */
    uint32_t row[ROBOT_FREEDOMS];                     /* public freedoms */
    num blocks[ROBOT_BLOCK_NUMBERS];
};

/* ---- M and its factors ---- */

TFA_INLINE void put_row(const struct state *s, struct derivative_state *d, rigid *Ic, int32_t k)
{
    const rigid sum = composite_step(s, Ic, k);
    num entries[ROBOT_BODIES], *const row = d->M + s->m->dof_row[robot_body[k].v];
    d->composite[k] = (struct sentinel_size){s3_trace(sum.I), 3 * sum.m};
    (void)composite_row(s, k, &sum, entries);
#pragma GCC unroll 64
    for (int32_t j = 0; j < ROBOT_BODIES; j++)
        if (j <= k && is_on_path(j, k))
            row[robot_body[j].depth - 1] = entries[j];
}

/* Margin of the sentinel over the factors, for bodies of these sizes; as sentinel.c */
static __attribute__((noinline)) num factors_margin(const struct tfa_model *m, const num *M,
                                                    const struct sentinel_size *size)
{
    const num length = num_of(m->length);
    num x[ROBOT_FREEDOMS], margin = num_of(1);
    for (uint32_t i = 0; i < ROBOT_BODIES; i++) {
        const int angular = is_revolute(robot_body[i].kind);
        margin =
            sentinel_margin_row(m, M, robot_body[i].v, angular ? size[i].angular : size[i].linear,
                                angular ? num_of(1) : length, 0, x, margin);
    }
    return margin;
}

static __attribute__((noinline)) void factor(const struct tfa_model *m, num *M)
{
    factor_mass_rows(m, M);
}

#define ROBOT_PUT_ROW(i) put_row(s, d, Ic, i);

/* qdd = M^-1 (tau - h) by the factors of M; poses */
TFA_INLINE void solve_by_mass(struct state *s, struct derivative_state *d, const num *tau, num *qdd)
{
    const num none[ROBOT_FREEDOMS] = {0};
    rigid Ic[ROBOT_BODIES];
#pragma GCC unroll 64
    for (int i = 0; i < ROBOT_BODIES; i++)
        Ic[i] = rigid_zero();
    inverse_rnea(s, none, qdd);
    ROBOT_INWARD(ROBOT_PUT_ROW)
    factor(s->m, d->M);
#pragma GCC unroll 64
    for (int k = 0; k < ROBOT_FREEDOMS; k++)
        qdd[k] = tau[k] - qdd[k];
    solve_mass_rows(s->m, d->M, qdd);
    sentinel_see(s, factors_margin(s->m, d->M, d->composite));
}

/* ---- derivatives by motion ---- */

TFA_INLINE void pose_bodies(struct state *s){ROBOT_OUTWARD(ROBOT_POSE)}

TFA_INLINE struct world_pose
    pose_in_world(const struct state *s, const struct derivative_state *d, uint32_t i)
{
    const int32_t parent = robot_body[i].parent;
    return parent < 0 ? world_pose_of_root(&s->X[i])
                      : world_pose_step(&s->X[i], &d->world[parent < 0 ? 0 : parent]);
}

TFA_INLINE void terms_of_body(const struct state *s, struct derivative_state *d, uint32_t i,
                              const num *qdd)
{
    const body_constants *b = &robot_body[i];
    struct subtree *t = &d->subtree[i];
    d->world[i] = pose_in_world(s, d, i);
    const vec3_simd p = d->world[0].r;
    const struct joint_motion j = {
        .S = {motion_simd_store(joint_axis_in_world(b, &d->world[i], 0, p))},
        .multiplier = {num_of(robot_freedom[b->v].multiplier)},
        .qd = s->qd + b->v,
        .qdd = qdd + b->v,
        .n = 1,
        .in_parts = 1,
        .boost = v3_zero()};
    t->v = b->parent < 0 ? sv_zero() : d->subtree[b->parent < 0 ? 0 : b->parent].v;
    t->a = b->parent < 0 ? (svec){v3_zero(), v3_neg(s->gravity)}
                         : d->subtree[b->parent < 0 ? 0 : b->parent].a;
    joint_terms(&j, d->terms + b->v, t);
    body_terms(b, &d->world[i], vec3_of_simd(p), t);
}

static __attribute__((noinline)) void pairs_of_body(const struct derivative_pairs *p,
                                                    const struct subtree *t, uint32_t j)
{
    const struct freedom_terms x = forces_of(t, &p->terms[j], t->f);
    add_pairs(p, &x, j, j, j + 1);
}

#define ROBOT_TERMS(i) terms_of_body(s, d, i, qdd);
#define ROBOT_PAIRS(i)                                                                             \
    pairs_of_body(&p, &d->subtree[i], robot_body[i].v);                                            \
    if (robot_body[i].parent >= 0)                                                                 \
        add_subtree(&d->subtree[robot_body[i].parent], &d->subtree[i]);

/* Of inverse dynamics at qdd; needs the poses. */
TFA_INLINE void by_motion(const struct state *s, struct derivative_state *d, const num *qdd,
                          const struct blocks *b)
{
    const struct derivative_pairs p = {b->X[BY_Q], b->X[BY_V], b->stride,
                                       d->terms,   d->row,     s->m->dof_parent};
    ROBOT_OUTWARD(ROBOT_TERMS)
    ROBOT_INWARD(ROBOT_PAIRS)
    for (uint32_t k = 0; ROBOT_DAMPED && k < ROBOT_FREEDOMS; k++) {
        const double x = robot_freedom[k].multiplier;
        *entry(&p, p.dv, k, k) += num_of(x * x * robot_damping[k]);
    }
    for (uint32_t k = 0; ROBOT_HAS_FRICTION && k < ROBOT_FREEDOMS; k++) {
        const double x = robot_freedom[k].multiplier;
        *entry(&p, p.dv, k, k) += num_of(x * x * robot_friction[k]) *
                                  friction_slope(s->qd[k], num_of(robot_friction_velocity));
    }
}

/* Derivatives are made about one point, to which light bodies far from it lose digits. */
TFA_INLINE void see_reference_point(struct state *s, const struct derivative_state *d)
{
    struct sentinel_size size[ROBOT_BODIES];
#pragma GCC unroll 64
    for (int i = 0; i < ROBOT_BODIES; i++)
        size[i] = (struct sentinel_size){s3_trace(d->subtree[i].I), 3 * d->subtree[i].m};
    sentinel_see(s, factors_margin(s->m, d->M, size));
}

/* ---- the operations ---- */

static __attribute__((noinline)) void
solve_blocks(const struct tfa_model *m, const struct derivative_state *d, const struct blocks *b)
{
    const struct mass_factors f = {m, d->M, d->row};
    solve_rows(&f, b);
}

static __attribute__((noinline)) num unload(const struct blocks *b, double sign,
                                            const struct lane_states *at)
{
    num zero = num_of(0);
    __asm__("" : ROBOT_REGISTER(zero)); /* known to no compiler */
    return unload_blocks(b, num_of(sign), zero, at->lane);
}

TFA_INLINE void load_inputs(struct robot_inputs *in, struct derivative_state *d,
                            const tfa_request *r, const struct lane_states *at, int forward)
{
    load_positions(in, r, at);
    gather_freedoms(in->qd, at, NULL, r->v);
    gather_freedoms(in->x, at, NULL, forward ? r->tau : r->qdd);
    if (forward)
        add_dissipation(in->x, in->qd, -1);
#pragma GCC unroll 64
    for (size_t k = 0; k < ROBOT_FREEDOMS; k++)
        d->row[k] = (uint32_t)public_freedom(k);
}

/* Those asked of forward or of inverse dynamics */
static __attribute__((flatten, noinline)) uint32_t derivatives(const struct tfa_host_api *host,
                                                               const tfa_request *r, uint32_t k,
                                                               uint32_t count, tfa_reply *reply)
{
    const int forward = r->op == TFA_OP_DERIVATIVES;
    double *const matrices[BLOCKS] = {forward ? reply->dqdd_dq : reply->dtau_dq,
                                      forward ? reply->dqdd_dv : reply->dtau_dv,
                                      forward ? reply->dqdd_dtau : NULL};
    const struct lane_states at = lanes_of_states(k, count);
    struct robot_inputs in;
    struct state s;
    struct derivative_state d;
    num qdd[ROBOT_FREEDOMS];
    num_mask finite = num_is_moderate(num_of(0));
    const struct blocks b = clear_blocks(matrices, d.blocks, ROBOT_MASS_ROWS);
    if (!b.asked)
        return TFA_SPECIALISED_NO_CODE;
    const int by_q_or_v = b.out[BY_Q] || b.out[BY_V];
    load_inputs(&in, &d, r, &at, forward);
    init_state(&s, &in, host, r);
    if (forward)
        solve_by_mass(&s, &d, in.x, qdd);
    else
        pose_bodies(&s);
    if (by_q_or_v)
        by_motion(&s, &d, forward ? qdd : in.x, &b);
    if (forward) {
        if (by_q_or_v)
            see_reference_point(&s, &d);
        solve_blocks(host->model, &d, &b);
        finite &= finite_states(qdd, ROBOT_FREEDOMS);
    }
    finite &= num_is_moderate(unload(&b, forward ? -1 : 1, &at));
    return answered_states(&s, r, finite);
}

robot_solve TFA_V(robot);
uint32_t TFA_V(robot)(const struct tfa_host_api *host, const tfa_request *r, uint32_t k,
                      uint32_t count, tfa_reply *reply)
{
    return derivatives(host, r, k, count, reply);
}

#endif
