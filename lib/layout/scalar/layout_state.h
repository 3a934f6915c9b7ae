/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Layout `scalar`: struct state of one state, or of a batch with one state in each lane.
 */
#ifndef TFA_LAYOUT_SCALAR_STATE_H
#define TFA_LAYOUT_SCALAR_STATE_H

#include <totalforce/dynamics.h>

#include "model/model.h"

/* Constants that are not rounded: in quadruple precision only */
#ifdef NUM_QUAD
#define STATE_QUADS(count) (count)
#else
#define STATE_QUADS(count) 0
#endif

#define STATE_TIPS (NUM_LANES == 1 ? TFA_TIP_COLUMNS : 0) /* batches have none */
#define STATE_MASS (reserves_method(n.methods, TFA_METHOD_CRBA) ? m->mass_entries : 0)
#define STATE_DENSE (STATE_MASS && m->mimics ? m->freedoms - m->mimics : 0)

/* Of bodies that do not share lanes */
#define TFA_LAYOUT_ARRAYS(ARRAY)                                                                   \
    ARRAY(double, residual_exchange, nv, "", "joint", "refine: exchange with the residual kernel") \
    ARRAY(sym6, Ic, nb, "kg m2, kg m, kg", "i",                                                    \
          "crba: composite inertia; efpa: inverse inertias Omega")                                 \
    ARRAY(struct composite, rigid, nb, "kg, kg m, kg m2", "i", "lock: composite without freedom")  \
    ARRAY(struct tfa_body, payload_body, nb, "", "i",                                              \
          "payload: constants of bodies that carry one")                                           \
    ARRAY(struct tfa_body_quad, payload_body_quad, STATE_QUADS(nb), "", "i",                       \
          "payload: the same in quad")                                                             \
    ARRAY(uint8_t, mark, nv, "", "", "load: scratch, by public freedom")                           \
    ARRAY(num, W, (size_t)m->mimics *nv, "", "joint", "mimic: rows M^-1 G^T")                      \
    ARRAY(num, S, (size_t)m->mimics * m->mimics, "", "mimic", "mimic: LDL factors of G M^-1 G^T")  \
    ARRAY(num, Mr, STATE_DENSE *STATE_DENSE, "kg m2", "joint",                                     \
          "mimic: T^T M T, then its LDL factors")                                                  \
    ARRAY(num, y, m->mimics ? nv : 0, "", "joint", "mimic: right-hand sides of T^T M T and of S")  \
    ARRAY(uint8_t, side, nb, "", "", "tfa: SIDE, CHAIN, CARRIES of each body")                     \
    ARRAY(uint32_t, path, m->depth, "", "", "tfa: a tip's chain, root first")                      \
    ARRAY(char, rows, TFA_V(chain_bytes)(m, n.methods), "", "",                                    \
          "factor: factors of a method along chains")                                              \
    ARRAY(sym6, Iinv, nb, "1/(kg m2), 1/kg", "i", "precompute: inverse of the rigid inertia")      \
    ARRAY(struct model_constants, model_constants, reserves_inverse(n.methods) ? nb : 0, "", "i",  \
          "precompute: constant terms of tfa")                                                     \
    ARRAY(num, M, STATE_MASS, "kg m2", "joint", "crba: rows of M, then its LDL factors")           \
    ARRAY(num, psi, nv *STATE_TIPS, "1, m", "joint", "lambda: H^T P of each tip column")           \
    ARRAY(num, phi, nv *STATE_TIPS, "1/kg", "joint", "lambda: D^-1 psi, or M^-1 J^T")              \
    ARRAY(num, lambda, STATE_TIPS *STATE_TIPS, "1/kg", "tip", "lambda: answer")                    \
    ARRAY(uint8_t, support, nb, "", "", "lambda: bit t set: body supports tip t")

/* Where inner coordinates and freedoms come from: the number of a public one */
typedef uint32_t source;
typedef struct tfa_coordinate coordinate;
typedef struct tfa_freedom freedom;

#include "layout/state_struct.h"

static inline int model_has_identity_map(const struct tfa_model *m)
{
    int identity_map = m->inner_q == m->q_count && m->freedoms - m->base_freedoms == m->v_count;
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
