/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The element of the segment scan, and how two of them become one: the articulated-body recursion
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
#ifndef TFA_KERNEL_SCAN_JOIN_H
#define TFA_KERNEL_SCAN_JOIN_H

#include "spatial/rows.h"
#include "spatial/spatial.h"

struct scan_element {
    num A[M6_NUMBERS], C[M6_NUMBERS],
        J[M6_NUMBERS]; /* row major; motion per motion, motion per force, force per motion */
};

/* A <- (A + A^T) / 2 */
static inline void m6_symmetrise(num *A)
{
    for (int i = 0; i < 6; i++)
        for (int j = i + 1; j < 6; j++)
            A[6 * i + j] = A[6 * j + i] = (A[6 * i + j] + A[6 * j + i]) / 2;
}

/* E = 1 + C J_out, factored. All eigenvalues of E are at least 1; C and J are rank deficient, so
 * that LU with row exchanges is what works. Returns the sum of the eigenvalues of C J_out: how
 * many times heavier the outboard part is than what the element yields by itself. */
static inline num scan_meet(struct rows_lu *E, const num *C, const num *outer)
{
    num ratio = 0;
    struct row6 J[6];
    rows_load(J, outer);
    rows_mul(E->U, C, J);
    for (uint32_t e = 0; e < 6; e++) {
        num *diagonal = row_at(&E->U[e], e);
        ratio += *diagonal;
        *diagonal += 1;
    }
    rows_factor(E);
    return ratio;
}

/* The element with the inertia `outer` hung on its end, E = 1 + C outer from scan_meet. What is
 * left of f_out is the outboard part's bias force.
 *   EA = E^-1 A,   J = x->J + A^T outer EA */
static inline void scan_hang(const struct scan_element *x, const struct rows_lu *E,
                             const num *outer, num *EA, num *J)
{
    struct row6 a[6], b[6];
    rows_load(a, x->A);
    rows_solve(E, a);
    rows_store(EA, a);
    rows_mul(b, outer, a);
    rows_tmul(a, x->A, b);
    for (int k = 0; k < 6; k++)
        a[k] = row_add(a[k], row_load(x->J + 6 * k), 1);
    rows_store(J, a);
    m6_symmetrise(J);
}

/* `out` is outboard of `in`. Associative: a tree or cyclic reduction may join in any order.
 *   J = J1 + A1^T J2 E^-1 A1,   C = C2 + A2 E^-1 C1 A2^T,   A = A2 E^-1 A1,   E = 1 + C1 J2 */
static inline struct scan_element scan_join(const struct scan_element *in,
                                            const struct scan_element *out)
{
    struct scan_element sum = *in;
    struct rows_lu E;
    struct row6 a[6], b[6];
    num At[M6_NUMBERS] = {0}, EA[M6_NUMBERS];
    (void)scan_meet(&E, in->C, out->J);
    scan_hang(in, &E, out->J, EA, sum.J);
    rows_load(a, in->C);
    rows_solve(&E, a);
    rows_store(sum.C, a);
    m6_symmetrise(sum.C);
    for (int i = 0; i < 6; i++)
        for (int j = 0; j < 6; j++)
            At[6 * i + j] = out->A[6 * j + i];
    rows_load(a, At);
    rows_mul(b, sum.C, a);
    rows_mul(a, out->A, b);
    for (int k = 0; k < 6; k++)
        a[k] = row_add(a[k], row_load(out->C + 6 * k), 1);
    rows_store(sum.C, a);
    m6_symmetrise(sum.C);
    rows_load(a, EA);
    rows_mul(b, out->A, a);
    rows_store(sum.A, b);
    return sum;
}

#endif
