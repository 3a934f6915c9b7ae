/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The element of the segment scan and its associative combination: the articulated-body recursion
 * made associative. The element, with bodies in place of time steps, is that of S. Sarkka and
 * A. F. Garcia-Fernandez, Temporal Parallelisation of Dynamic Programming and Linear Quadratic
 * Control, arXiv 2104.03186.
 *
 * An element spans bodies a .. b of a chain. a_in is the acceleration of the body before a, f_out
 * the force that b passes on, in b's frame; a_out the acceleration of b, f_in the force on the
 * body before a:
 *
 *   a_out = A a_in - C f_out + v         C, J symmetric and positive semidefinite
 *   f_in  = J a_in + A^T f_out + g
 */
#ifndef TFA_DYNAMICS_SCAN_SCAN_COMBINE_H
#define TFA_DYNAMICS_SCAN_SCAN_COMBINE_H

#include "spatial/mat6_rows.h"
#include "spatial/spatial.h"

struct scan_element {
    num A[MAT6_PADDED], C[MAT6_PADDED],
        J[MAT6_PADDED]; /* row major; motion per motion, motion per force, force per motion */
};

/* A <- (A + A^T) / 2 */
static inline void m6_symmetrise(num *A)
{
    for (int i = 0; i < 6; i++)
        for (int j = i + 1; j < 6; j++)
            A[6 * i + j] = A[6 * j + i] = (A[6 * i + j] + A[6 * j + i]) / 2;
}

/* E = 1 + C J_out, factored. All eigenvalues of E are at least 1; C and J are rank deficient, so
 * that LU needs row exchanges. Returns the sum of the eigenvalues of C J_out: how
 * many times larger the outboard inertia is than the element's own apparent inertia. */
static inline num scan_factor_interface(struct mat6_rows_lu *E, const num *C, const num *outer)
{
    num ratio = 0;
    struct row6 J[6];
    mat6_rows_load(J, outer);
    mat6_rows_mul(E->U, C, J);
    for (uint32_t e = 0; e < 6; e++) {
        num *diagonal = row6_at(&E->U[e], e);
        ratio += *diagonal;
        *diagonal += 1;
    }
    mat6_rows_lu_factor(E);
    return ratio;
}

/* The element with the inertia `outer` attached to its end, E = 1 + C outer from
 * scan_factor_interface. The rest of f_out is the outboard part's bias force.
 *   EA = E^-1 A,   J = x->J + A^T outer EA */
static inline void scan_attach(const struct scan_element *x, const struct mat6_rows_lu *E,
                               const num *outer, num *EA, num *J)
{
    struct row6 a[6], b[6];
    mat6_rows_load(a, x->A);
    mat6_rows_lu_solve(E, a);
    mat6_rows_store(EA, a);
    mat6_rows_mul(b, outer, a);
    mat6_rows_tmul(a, x->A, b);
    for (int k = 0; k < 6; k++)
        a[k] = row6_add_scaled(a[k], row6_load(x->J + 6 * k), 1);
    mat6_rows_store(J, a);
    m6_symmetrise(J);
}

/* `out` is outboard of `in`. Associative: a tree or cyclic reduction may combine in any order.
 *   J = J1 + A1^T J2 E^-1 A1,   C = C2 + A2 E^-1 C1 A2^T,   A = A2 E^-1 A1,   E = 1 + C1 J2 */
static inline struct scan_element scan_combine(const struct scan_element *in,
                                               const struct scan_element *out)
{
    struct scan_element sum = *in;
    struct mat6_rows_lu E;
    struct row6 a[6], b[6];
    num At[MAT6_PADDED] = {0}, EA[MAT6_PADDED];
    (void)scan_factor_interface(&E, in->C, out->J);
    scan_attach(in, &E, out->J, EA, sum.J);
    mat6_rows_load(a, in->C);
    mat6_rows_lu_solve(&E, a);
    mat6_rows_store(sum.C, a);
    m6_symmetrise(sum.C);
    for (int i = 0; i < 6; i++)
        for (int j = 0; j < 6; j++)
            At[6 * i + j] = out->A[6 * j + i];
    mat6_rows_load(a, At);
    mat6_rows_mul(b, sum.C, a);
    mat6_rows_mul(a, out->A, b);
    for (int k = 0; k < 6; k++)
        a[k] = row6_add_scaled(a[k], row6_load(out->C + 6 * k), 1);
    mat6_rows_store(sum.C, a);
    m6_symmetrise(sum.C);
    mat6_rows_load(a, EA);
    mat6_rows_mul(b, out->A, a);
    mat6_rows_store(sum.A, b);
    return sum;
}

#endif
