/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Motion of the tips in the metric of the kinetic energy: B = D^-1/2 L^-1 J^T with M = L D L^T, so
 * that Lambda^-1 = B^T B without a product of rounding errors. Rows are the freedoms of the bodies
 * that support a tip: the unit wrenches of the tips, propagated inward, leave H^T P at each joint
 * of articulated inertia D. With mimics they are the freedoms of T^T M T.
 */
#ifndef TFA_DYNAMICS_OSIM_TIP_ROWS_H
#define TFA_DYNAMICS_OSIM_TIP_ROWS_H

#include "layout/state.h"
#include "spatial/row_vectors.h"

/* Rows of all tips in answers; of constraints, those that they hold */
static inline uint32_t all_tip_rows(const struct state *s)
{
    return s->closings ? s->closing_rows : s->tip_rows * s->tips;
}

/* Vector number `which` of s->task, with a number for each of them */
static inline num *task_vector(const struct state *s, uint32_t which)
{
    return s->task + (size_t)which * all_tip_rows(s);
}

/* From row to row of matrices with a column for each of them */
static inline uint32_t tip_stride(const struct state *s)
{
    return row_stride(all_tip_rows(s));
}

/* Of row e of a tip in the metric: what a radian counts */
static inline num tip_row_scale(const struct state *s, uint32_t e)
{
    return e < 3 ? num_of(1) : s->tip_length;
}

/* The same of row j of all (all_tip_rows) */
static inline num scale_of(const struct state *s, uint32_t j)
{
    if (s->closings)
        return tip_row_scale(s, s->closing_row[j] % 6);
    return s->tip_rows == 6 ? tip_row_scale(s, j % 6) : num_of(1);
}

/* B of the tips, or of constraints, by s->tip_freedoms rows into s->phi (tip_stride); angular
 * columns times s->tip_length. Needs the articulated-body factors, with mimics those of T^T M T.
 * Writes s->psi and s->support, unless a propagation kept them (s->psi_frame). */
void TFA_V(tip_rows)(struct state *s, tfa_reference_frame frame);

/* z = D^-1/2 L^-1 tau, so that J M^-1 tau = B^T z. Needs tip_rows and, without mimics, that a solve
 * by the same factors has just left tau - H^T pA of these forces. NULL: of s->tau - h, where
 * forward dynamics by aba was that solve. */
void TFA_V(force_rows)(struct state *s, const num *tau, num *z);

/* s->u of the inward pass of forward dynamics becomes that of tau - J^T F, with z = B F. Neither
 * locked joints nor mimics. */
void TFA_V(subtract_force_rows)(struct state *s, const num *z);

#endif
