/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Layout `scalar`: struct state of one state, or of a batch with one state in each lane.
 */
#ifndef TFA_LAYOUT_SCALAR_STATE_H
#define TFA_LAYOUT_SCALAR_STATE_H

#include <totalforce/dynamics.h>

#include "layout/derivative_terms.h"
#include "model/model.h"
#include "spatial/rigid.h"
#include "spatial/world_axes.h"

/* Constants that are not rounded: in quadruple precision only */
#ifdef NUM_QUAD
#define STATE_QUADS(count) (count)
#else
#define STATE_QUADS(count) 0
#endif

/* A flexible body (dynamics/core/modes.h). Rows of six: angular first, one for each mode. */
struct modal_body {
    vec3 moved; /* sum eta_k l_k */
    sym6 change; /* of the rigid inertia by eta, riders included */
    num B[6 * TFA_MAX_LINK_MODES];
    num W[6 * TFA_MAX_LINK_MODES];
    num D[TFA_MAX_LINK_MODES * TFA_MAX_LINK_MODES]; /* then its LDL factors */
    num r[TFA_MAX_LINK_MODES], u[TFA_MAX_LINK_MODES];
    num side_W[6 * TFA_MAX_LINK_MODES], side_D[TFA_MAX_LINK_MODES * TFA_MAX_LINK_MODES];
    num psi[6 * TFA_MAX_LINK_MODES]; /* scan: of the forces that its segment passes on */
};

/* Where a handle stands, in its body's frame */
struct modal_handle {
    mat3 E; /* from the body's axes to those turned with the handle */
    vec3 p, theta;
    num scale;                       /* 1 / (1 + theta^2 / 4) */
    sym6 I;                          /* of the links that are fixed to it */
    num Phi[6 * TFA_MAX_LINK_MODES]; /* motion by each mode */
};

#define HAS_MODES(s) ((s)->m->modes != 0)

#define STATE_DERIVATIVES_MAX                                                                      \
    (NUM_LANES == 1 ? TFA_DERIVATIVES_FREEDOMS_MAX : TFA_DERIVATIVES_LANES_FREEDOMS_MAX)
#define STATE_DERIVATIVES (nv <= STATE_DERIVATIVES_MAX ? (size_t)nv : 0)
#define STATE_TIPS (NUM_LANES == 1 ? (size_t)n.tips : 0) /* batches have none */
#define STATE_COLUMNS (6 * STATE_TIPS)
#define STATE_ROW ((STATE_COLUMNS + 7) / 8 * 8) /* in whole registers (row_vectors.h) */
#define STATE_PAIRS (STATE_TIPS ? STATE_TIPS * (STATE_TIPS - 1) : 0)
#define STATE_MASS (reserves_method(n.methods, TFA_METHOD_CRBA) ? m->mass_entries : 0)
#define STATE_DENSE (STATE_MASS && m->mimics ? m->freedoms - m->mimics : 0)

/* Of bodies that do not share lanes */
#define TFA_LAYOUT_ARRAYS(ARRAY)                                                                   \
    ARRAY(double, residual_exchange, nv, "", "joint", "refine: exchange with the residual kernel") \
    ARRAY(rigid, composite, STATE_MASS ? nb : 0, "kg, kg m, kg m2", "i",                           \
          "crba: composite inertia")                                                               \
    ARRAY(sym6, Ic, nb, "1/(kg m2), 1/kg", "i", "efpa: inverse inertias Omega")                    \
    ARRAY(struct composite, rigid, nb, "kg, kg m, kg m2", "i", "lock: composite without freedom")  \
    ARRAY(struct tfa_body, payload_body, nb, "", "i",                                              \
          "payload: constants of bodies that carry one")                                           \
    ARRAY(struct tfa_body_quad, payload_body_quad, STATE_QUADS(nb), "", "i",                       \
          "payload: the same in quad")                                                             \
    ARRAY(uint8_t, mark, nv, "", "", "load: scratch, by public freedom")                           \
    ARRAY(num, eta, m->modes, "", "mode", "load: modal coordinates")                               \
    ARRAY(struct modal_body, modal, m->flexible_bodies, "", "i", "modes: flexible bodies")         \
    ARRAY(struct modal_handle, handle, m->handles, "", "i", "modes: what moves with them")         \
    ARRAY(num, W, (size_t)m->mimics *nv, "", "joint", "mimic: rows M^-1 G^T")                      \
    ARRAY(num, S, (size_t)m->mimics * m->mimics, "", "mimic", "mimic: LDL factors of G M^-1 G^T")  \
    ARRAY(num, Mr, STATE_DENSE *STATE_DENSE, "kg m2", "joint",                                     \
          "mimic: T^T M T, then its LDL factors")                                                  \
    ARRAY(num, y, m->mimics ? nv : 0, "", "joint", "mimic: right-hand sides of T^T M T and of S")  \
    ARRAY(uint8_t, side, nb, "", "", "tfa: SIDE, CHAIN, CARRIES of each body")                     \
    ARRAY(struct world_pose, world, nb, "1, m", "world", "world_poses")                            \
    ARRAY(uint32_t, tip_path, m->depth, "", "", "motion: a tip's support, root first")             \
    ARRAY(uint32_t, path, m->depth, "", "", "tfa: a tip's chain, root first")                      \
    ARRAY(char, rows, TFA_V(chain_bytes)(m, n.methods), "", "",                                    \
          "factor: factors of a method along chains")                                              \
    ARRAY(sym6, Iinv, nb, "1/(kg m2), 1/kg", "i", "precompute: inverse of the rigid inertia")      \
    ARRAY(struct model_constants, model_constants, reserves_inverse(n.methods) ? nb : 0, "", "i",  \
          "precompute: constant terms of tfa")                                                     \
    ARRAY(num, M, STATE_MASS, "kg m2", "joint", "crba: rows of M, then its LDL factors")           \
    ARRAY(num, psi, nv *STATE_COLUMNS, "1, m", "joint", "lambda: H^T P of each tip column")        \
    ARRAY(num, phi, nv *STATE_ROW, "1/kg", "joint",                                                \
          "lambda: D^-1 psi, or M^-1 J^T; tip_rows: B by rows")                                    \
    ARRAY(num, lambda, STATE_COLUMNS *STATE_ROW, "1/kg", "tip",                                    \
          "lambda: answer; lambda_dense: scratch")                                                 \
    ARRAY(num, triangle, STATE_COLUMNS *STATE_ROW, "1", "tip",                                     \
          "lambda_factor: U by rows; then the other side of the singular directions")              \
    ARRAY(num, direction, STATE_COLUMNS *STATE_ROW, "kg^-1/2", "tip",                              \
          "lambda_factor: rows of U^-T, or singular directions times their singular values")       \
    ARRAY(num, weight, STATE_COLUMNS, "kg, kg^2", "tip",                                           \
          "lambda_factor: Lambda is the sum of weight times direction^T direction")                \
    ARRAY(num, pivot_square, STATE_COLUMNS, "1/kg", "tip", "lambda_factor: S")                     \
    ARRAY(uint32_t, pivot, STATE_COLUMNS, "", "tip", "lambda_factor: order of the columns")        \
    ARRAY(num, eigenvalue, STATE_COLUMNS, "1/kg", "tip", "lambda_factor: of lambda")               \
    ARRAY(num, gain, STATE_COLUMNS, "kg", "tip", "lambda_factor: 1 / eigenvalue, or less")         \
    ARRAY(struct closing, closing, STATE_TIPS ? m->constraints : 0, "1, m", "world",               \
          "constraints_activate, constraints_locate: of the request under way")                    \
    ARRAY(struct relative_motion, relative, STATE_TIPS ? m->constraints : 0, "", "first frame",    \
          "constraints_locate: of the same")                                                       \
    ARRAY(uint8_t, closing_row, STATE_COLUMNS, "", "",                                             \
          "constraints_activate: held rows, 6 x place in closing + component")                     \
    ARRAY(num, arm, 3 * STATE_TIPS, "m", "world", "lambda_factor: to the tip's point")             \
    ARRAY(num, coefficient, 2 * STATE_ROW, "", "tip", "lambda_factor, lambda_force: scratch")      \
    ARRAY(num, force_row, STATE_TIPS ? nv : 0, "N kg^-1/2", "joint", "lambda_force: scratch")      \
    ARRAY(num, task, 5 * STATE_COLUMNS, "", "tip", "task: accelerations, forces, scratch")         \
    ARRAY(num, task_force, STATE_TIPS ? nv : 0, "N m, N", "joint", "task: posture torques - h")    \
    ARRAY(num, shared_wrenches, 36 * STATE_PAIRS, "N, N m", "i",                                   \
          "lambda: wrenches of each tip where its support meets another's")                        \
    ARRAY(struct freedom_terms, freedom_terms, STATE_DERIVATIVES, "", "world", "derivatives")      \
    ARRAY(struct subtree, subtree, STATE_DERIVATIVES ? nb : 0, "", "world", "derivatives")         \
    ARRAY(num, derivatives, 3 * (STATE_DERIVATIVES + 7) * STATE_DERIVATIVES, "", "joint",          \
          "derivatives: of forces by q, by v; M^-1")                                               \
    ARRAY(uint32_t, public_row, STATE_DERIVATIVES, "", "", "derivatives: of inner freedoms")       \
    ARRAY(svec, link_force, m->frames, "N m, N", "body of the link",                               \
          "joint_forces: force across each link's joint")                                          \
    ARRAY(uint32_t, support, nb, "", "", "lambda: bit t set: body supports tip t")

/* Where inner coordinates and freedoms come from: the number of a public one */
typedef uint32_t source;
typedef struct tfa_coordinate coordinate;
typedef struct tfa_freedom freedom;

#include "layout/state_struct.h"

/* The modes of flexible body i; those that move a handle, and its motion by mode k */
static inline const struct tfa_flexible *flexible_of(const struct state *s, uint32_t i)
{
    return &s->m->flexible[s->body[i].flexible];
}

static inline const struct tfa_flexible *carrier_of(const struct state *s, int32_t handle)
{
    return &s->m->flexible[s->m->handle[handle].flexible];
}

static inline svec phi_of(const struct state *s, int32_t handle, uint32_t k)
{
    return sv_from(s->handle[handle].Phi + 6 * k);
}

static inline int model_has_identity_map(const struct tfa_model *m)
{
    int identity_map =
        m->inner_q == m->q_count && m->freedoms - m->base_freedoms - m->modes == m->v_count;
    for (uint32_t k = 0; identity_map && k < m->inner_q; k++)
        identity_map = m->coordinate[k].from == k && m->coordinate[k].multiplier == 1 &&
                       m->coordinate[k].offset == 0;
    for (uint32_t k = 0; identity_map && k < m->v_count; k++)
        identity_map = m->freedom[k].from == k && m->freedom[k].multiplier == 1;
    return identity_map;
}

/* Constants that the state reads from the model */
static inline void state_read_model(struct state *s)
{
    s->body = s->m->body;
    s->coordinate = s->m->coordinate;
    s->freedom = s->m->freedom;
    s->identity_map = model_has_identity_map(s->m);
}

#include "layout/state_walk.h"

#endif
