/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Exchange between the segments of a chain that are computed in SIMD lanes, and the scan
 * over them, which a kernel of one number at a time does.
 */
#ifndef TFA_DYNAMICS_SCAN_SEGMENT_BOUNDARY_H
#define TFA_DYNAMICS_SCAN_SEGMENT_BOUNDARY_H

#include "dynamics/scan/chain_cut.h"

/* SEGMENT_BOUNDARY_ARRAYS(X): X(name, numbers, meaning). Number e of segment k stands at
 * name[e * TFA_SEGMENTS_MAX + k]; letters as in scan_combine.h. */
#define TFA_SEGMENT_BOUNDARY_ARRAYS(X)                                                             \
    X(E, 9, "rotation from the frame of the body before to that of its end")                       \
    X(r, 3, "origin of the latter in the former")                                                  \
    X(v_end, 6, "velocity of its end while the body before rests; then from v_in")                 \
    X(v_in, 6, "velocity of the body before")                                                      \
    X(dv_in, 6, "correction of it")                                                                \
    X(seed, 36, "G: inertia that its factors have on its end")                                     \
    X(A, 36, "element")                                                                            \
    X(C, 36, "upper triangle")                                                                     \
    X(J, 36, "")                                                                                   \
    X(a_end, 6, "a_out without a_in and f_out; then with them")                                    \
    X(g, 6, "f_in without a_in and f_out")                                                         \
    X(a_in, 6, "from the scan; then its correction")                                               \
    X(f_out, 6, "the same")                                                                        \
    X(cut_E, 9, "of the first joint, for segments that float (cut_forces.h)")                      \
    X(cut_r, 3, "")                                                                                \
    X(cut_c, 6, "")                                                                                \
    X(cut_tau, 1, "")

/* Every array is a whole number of vectors, the first at the front. */
struct tfa_segment_boundary {
#define TFA_SEGMENT_BOUNDARY_DECLARE(name, numbers, meaning)                                       \
    double name[(numbers)*TFA_SEGMENTS_MAX];
    TFA_SEGMENT_BOUNDARY_ARRAYS(TFA_SEGMENT_BOUNDARY_DECLARE)
#undef TFA_SEGMENT_BOUNDARY_DECLARE
    uint32_t count;
    int floating; /* forces at the cuts, in place of the scan */
};

#endif
