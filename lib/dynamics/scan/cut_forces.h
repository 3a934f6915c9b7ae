/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Forces at the cuts of a chain: the constraint force algorithm (cfa_row.h) with segments for
 * bodies. Segments float: an element leaves out the joint by which its segment hangs on the one
 * before, and nothing is known beyond its end. a1, f1 are of its first body, a2, f2 of its end:
 *
 *   a1 = P (f1 - A^T f2 - g),   a2 = A a1 - C f2 + v          P = J^-1, J: the articulated inertia
 *   f1 = F = Wa tau + W lambda,   f2 = X^T F of the next
 *
 *   S lambda = b,   S_kk = W^T (P + X (A P A^T + C)_{k-1} X^T) W,
 *                   S_{k,k-1} = -W^T X (A P W)_{k-1}
 *                   b_k = W^T (c + X e2_{k-1} - e1_k),   e1, e2: a1, a2 by Wa tau alone
 *
 * The first segment stands on the ground, its first joint included: a2 = A a_ground - C f2 + v, and
 * C is all that S_11 has of it. With one body a segment A = 1, C = 0, and S is that of cfa with the
 * first row eliminated. Only the inertias of whole segments are inverted.
 */
#ifndef TFA_DYNAMICS_SCAN_CUT_FORCES_H
#define TFA_DYNAMICS_SCAN_CUT_FORCES_H

#include "dynamics/chain/cfa_row.h"
#include "dynamics/chain/conjugate.h"
#include "dynamics/scan/scan.h"

/* The joint by which a segment hangs on the one before */
struct cut {
    xform X;
    struct cfa_joint joint;
    svec c;
    num f[6];  /* Wa tau; then F */
    num J[36]; /* of the segment: LDL^T factors */
    num P[36];
};

struct cut_forces {
    struct cut *cut;           /* one a segment; that of the first is not used */
    struct cyclic_row *system; /* the same */
    /* Of conjugate gradients: what they leave of the gaps that segments without constraint forces
     * have; 0: cyclic reduction */
    num tolerance;
    int iterations; /* of the last solve; -1: they did not suffice */
    int failed;     /* so it is, or what the forces left open shows that they have no digits */
};

/* Memory of so many segments */
size_t TFA_V(cut_forces_bytes)(size_t segments);
struct cut_forces *TFA_V(cut_forces_layout)(void *memory, size_t segments);

/* Factors of the system from X and joint of every cut and the elements. Returns 0 and the segment
 * whose inertia is not positive definite. */
int TFA_V(cut_forces_factor)(const struct scan *scan, uint32_t *singular);

/* a_in and f_out of every segment from f and c of the cuts, v and g of the segments, and the
 * acceleration of the ground. */
void TFA_V(cut_forces_solve)(struct scan *scan, svec ground);

/* Corrections of a_in and f_out, in their place, where segments end on an acceleration that the
 * next one has not started from. Returns 0 where forces and corrections are of no use. */
int TFA_V(cut_forces_close_gaps)(struct scan *scan);

#endif
