/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Inverse inertias: of a body, and in the frame of the next body outboard.
 */
#ifndef TFA_SPATIAL_INVERSE_H
#define TFA_SPATIAL_INVERSE_H

#include "spatial/dense.h"
#include "spatial/spatial.h"

/* S^-1 of a positive definite 6 x 6 by LDL^T; 0 when a pivot is not positive. */
static inline int s6_invert(const sym6 *S, sym6 *inverse)
{
    num L[36], columns[36];
    num_mask positive = num_of(0) == num_of(0);
    s6_dense(L, S);
    ldl_factor(L, 6);
    for (int k = 0; k < 6; k++)
        positive &= L[7 * k] > num_of(0);
    if (!num_all(positive))
        return 0;
    for (int k = 0; k < 6; k++) {
        for (int e = 0; e < 6; e++)
            columns[6 * k + e] = num_of(e == k);
        ldl_solve(L, 6, columns + 6 * k);
    }
    *inverse = s6_from_dense(columns);
    return 1;
}

/* TI = T I^-1 and TIT = T I^-1 T^T for the tree transform T of a body and the inverse inertia of
 * its parent */
static inline void inverse_inertia_to_child(const xform *T, const sym6 *up, num *TI, sym6 *TIT)
{
    *TIT = s6_inv_to_child(T, up);
    for (int k = 0; k < 6; k++) {
        num column[6];
        sv_store(column, xform_motion(T, s6_column(up, k)));
        for (int e = 0; e < 6; e++)
            TI[6 * e + k] = column[e];
    }
}

#endif
