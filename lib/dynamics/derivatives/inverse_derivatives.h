/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Derivatives of inverse dynamics, ID(q, v, qdd), by spatial vectors in world axes: S. Singh, R.
 * Russell, P. Wensing, Efficient analytical derivatives of rigid-body dynamics using spatial vector
 * algebra, IEEE RA-L 2022, arXiv 2105.05102. With j an ancestor of i, or i itself,
 *
 *     dtau_i/dq_j = S_i^T (2 B_i Psi'_j + I_i Psi''_j)
 *     dtau_j/dq_i = S_j^T (2 B_i Psi'_i + I_i Psi''_i + S_i x* f_i)          j before i
 *     dtau_i/dv_j = S_i^T (2 B_i S_j + I_i (Psi'_j + S'_j))
 *     dtau_j/dv_i = S_j^T (2 B_i S_i + I_i (Psi'_i + S'_i))
 *
 * I, B and f of the subtree; Psi' = v x S and Psi'' = a x S + v x Psi' with v and a of the body
 * before the joint, S' = v x S with v of the body behind it. q along motions of the joints
 * (docs/conventions.md). 2 B m = v x* I m - I (v x m) + m x* I v needs twelve numbers a body: on a
 * translation it is 0, on a rotation w it is (A w, -2 P x w) with the linear momentum P. O(N d)
 */
#ifndef TFA_DYNAMICS_DERIVATIVES_INVERSE_DERIVATIVES_H
#define TFA_DYNAMICS_DERIVATIVES_INVERSE_DERIVATIVES_H

#include <totalforce/dynamics.h>

#include "layout/state.h"
#include "spatial/vec6.h"

/* An external wrench (world axes, about the reference point) that does not follow its body rigidly:
 * held by axes of the world, or on a link inside a fused joint */
struct held_wrench {
    int32_t body;
    uint32_t freedoms; /* of the body's joint that move its link */
    tfa_reference_frame frame;
    vec3 at; /* its point, relative to the reference point */
    svec wrench;
};

/* Columns of several matrices of public freedoms stand in one row of numbers: four of each matrix,
 * or as many as a vector holds, then the next ones of each. */
enum { DERIVATIVES_GROUP = NUM_VEC_LANES > 4 ? NUM_VEC_LANES : 4, DERIVATIVES_MATRICES = 3 };

static inline size_t derivatives_column(uint32_t j)
{
    return DERIVATIVES_GROUP * DERIVATIVES_MATRICES * (size_t)(j / DERIVATIVES_GROUP) +
           j % DERIVATIVES_GROUP;
}

/* Matrices of public freedoms, zero before, a row of `stride` numbers for each force */
struct inverse_derivatives {
    num *dq, *dv;
    size_t stride;
    vec3 origin; /* the reference point */
    int of_world; /* at qdd of the world, not at those of a boosted state, which depend on w */
    const struct held_wrench *held;
    uint32_t held_count;
};

/* The reference point for a state: near the robot, so that no digit is lost far from the world's
 * origin. Writes world poses. */
vec3 TFA_V(derivatives_origin)(struct state *s);

/* Derivatives at s->qdd. Needs world poses and s->public_row. */
void TFA_V(inverse_derivatives)(struct state *s, const struct inverse_derivatives *d);

#endif
