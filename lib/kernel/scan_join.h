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

#include "spatial/dense.h"
#include "spatial/spatial.h"

struct scan_element {
    num A[36], C[36], J[36]; /* row major; motion per motion, motion per force, force per motion */
};

/* out = A^T B for 6 x 6 */
static inline void m6_tmul(num *out, const num *A, const num *B)
{
    for (int i = 0; i < 6; i++)
        for (int j = 0; j < 6; j++) {
            num s = A[i] * B[j];
            for (int k = 1; k < 6; k++)
                s += A[6 * k + i] * B[6 * k + j];
            out[6 * i + j] = s;
        }
}

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
static inline num scan_meet(struct lu6 *E, const num *C, const num *outer)
{
    num ratio = 0;
    m6_mul(E->a, C, outer);
    for (int e = 0; e < 6; e++) {
        ratio += E->a[7 * e];
        E->a[7 * e] += 1;
    }
    lu6_factor(E);
    return ratio;
}

/* The element with the inertia `outer` hung on its end, E = 1 + C outer from scan_meet. What is
 * left of f_out is the outboard part's bias force.
 *   EA = E^-1 A,   J = x->J + A^T outer EA */
static inline void scan_hang(const struct scan_element *x, const struct lu6 *E, const num *outer,
                             num *EA, num *J)
{
    num F[36], G[36];
    for (int k = 0; k < 36; k++)
        EA[k] = x->A[k];
    lu6_solve(E, EA, 6);
    m6_mul(F, outer, EA);
    m6_tmul(G, x->A, F);
    for (int k = 0; k < 36; k++)
        J[k] = x->J[k] + G[k];
    m6_symmetrise(J);
}

/* `out` is outboard of `in`. Associative: a tree or cyclic reduction may join in any order.
 *   J = J1 + A1^T J2 E^-1 A1,   C = C2 + A2 E^-1 C1 A2^T,   A = A2 E^-1 A1,   E = 1 + C1 J2 */
static inline struct scan_element scan_join(const struct scan_element *in,
                                            const struct scan_element *out)
{
    struct scan_element sum = *in;
    struct lu6 E;
    num F[36], At[36], EA[36];
    (void)scan_meet(&E, in->C, out->J);
    scan_hang(in, &E, out->J, EA, sum.J);
    lu6_solve(&E, sum.C, 6);
    m6_symmetrise(sum.C);
    for (int i = 0; i < 6; i++)
        for (int j = 0; j < 6; j++)
            At[6 * i + j] = out->A[6 * j + i];
    m6_mul(F, sum.C, At);
    m6_mul(sum.C, out->A, F);
    for (int k = 0; k < 36; k++)
        sum.C[k] += out->C[k];
    m6_symmetrise(sum.C);
    m6_mul(sum.A, out->A, EA);
    return sum;
}

#endif
