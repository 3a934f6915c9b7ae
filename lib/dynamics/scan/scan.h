/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The segment scan along a chain: the articulated-body algorithm inside segments, which are
 * independent of each other, and a scan over the segments. It needs no inverse inertia.
 *
 *   factor: each segment inward by itself (scan_segment_factor), with the inertia G of the next
 *           few bodies on its end; over the segments the inertia J that is outboard of each cut
 *           (scan_combine.h), of which J - G is left to the scan; segments whose ratio is still
 *           large
 *           beside it once more with all of J for G, and over all segments again: J - G is now
 *           rounding, or the improvement of the second pass.
 *   solve:  each segment inward, then the bias forces inward and the accelerations outward over
 *           the cuts, then each segment outward.
 */
#ifndef TFA_DYNAMICS_SCAN_SCAN_H
#define TFA_DYNAMICS_SCAN_SCAN_H

#include "dynamics/chain/chain.h"
#include "dynamics/osim/lambda.h"
#include "dynamics/scan/scan_combine.h"

/* One body on the chain */
struct scan_body {
    sym6 I;    /* its inertia with side branches, without the bodies outboard on the chain */
    svec P[6]; /* force on it for each unit of the force that its segment passes on, frame i */
};

/* Bodies at positions first .. end - 1 of the chain */
struct scan_segment {
    uint32_t first, end;
    int refactored;         /* factored twice */
    struct scan_element at; /* of its bodies and the inertia on its end */
    num seed[MAT6_PADDED];  /* G: inertia that its factors have on its end, that body's frame */
    num J[MAT6_PADDED];     /* articulated inertia of it and all beyond it, on the body before it */
    num remainder
        /* J - G, J of the next segment; like the members below, not of the last one */
        [MAT6_PADDED];
    struct mat6_rows_lu E; /* 1 + C left */
    num mass_ratio;        /* scan_factor_interface */
    num EA[MAT6_PADDED];   /* E^-1 A */
    svec v, g;             /* a_out and f_in without a_in and f_out; then v at a_in = 0 */
    svec a_in, f_out;      /* inputs from the scan: frames of the body before, of its end */
    svec a_end;            /* resulting acceleration of its last body */
};

struct scan {
    uint32_t segments;
    struct scan_segment *segment;
    struct scan_body *body; /* by position on the chain */
    /* NULL: the scan over the segments. Otherwise the forces at the cuts are found from a system of
     * equations, and segments float (cut_forces.h). */
    struct cut_forces *cuts;
};

/* Bytes of rows; the arrays in it. */
size_t TFA_V(scan_bytes)(size_t length);
struct scan *TFA_V(scan_layout)(void *rows, size_t length);
/* The same for so many segments and the forces at their cuts (cut_forces.h) */
size_t TFA_V(scan_with_cuts_bytes)(size_t length, size_t segments);
struct scan *TFA_V(scan_with_cuts)(void *rows, size_t length, size_t segments);

/* Where the chain is cut, from the constants of its bodies. */
void TFA_V(scan_cut)(const struct state *s, const struct tfa_chain *chain, struct scan *scan);

/* Over the segments. The inertia that is outboard of each cut, inward, and how each segment moves
 * with the part of it that its factors do not know; */
void TFA_V(scan_combine_segments)(struct scan *scan);
/* bias forces over the cuts, inward, and how the ends move when a_in = 0; */
void TFA_V(scan_inward)(struct scan *scan);
/* accelerations over the cuts, outward from the ground's, and the forces that the cuts pass on. */
void TFA_V(scan_outward)(struct scan *scan, svec ground);
/* corrections of a_in and f_out, in their place: each segment ends on an acceleration that
 * the next one has not started from. */
void TFA_V(scan_close_gaps)(struct scan *scan);

/* One segment inward: U, D, IA of its bodies and their P, its element. `outer`, the articulated
 * inertia beyond the cut, is added at its end; NULL: that of the next bodies, from their constants
 * and poses. Changes nothing of other segments. The last one passes nothing on; it has no
 * P, A, C. */
void TFA_V(scan_segment_factor)(struct state *s, const struct tfa_chain *chain, struct scan *scan,
                                struct scan_segment *segment, const num *outer);
/* One segment inward: u of its joints, v and g */
void TFA_V(scan_segment_inward)(struct state *s, const struct tfa_chain *chain, struct scan *scan,
                                struct scan_segment *segment, const num *tau, int bias);
/* One segment outward from a_in and f_out: qdd of its joints, a_end */
void TFA_V(scan_segment_outward)(struct state *s, const struct tfa_chain *chain, struct scan *scan,
                                 struct scan_segment *segment, num *qdd, int bias);
/* Corrections of qdd by a_in and f_out from scan_close_gaps */
void TFA_V(scan_segment_correct)(struct state *s, const struct tfa_chain *chain, struct scan *scan,
                                 const struct scan_segment *segment, num *qdd);

/* Segments that float, and the forces at their cuts: factors of segments that are cut already.
 * TFA_OK, or TFA_E_SINGULAR with s->bad_body. */
int TFA_V(scan_factor_floating)(struct state *s, const struct tfa_chain *chain, struct scan *scan);

/* Both methods. Factors: a second pass for segments whose cut has at least `max_ratio`
 * (scan_factor_interface). Solve: any number of times. Always TFA_OK; a singular M gives answers
 * that are not finite. */
int TFA_V(scan_factor)(struct state *s, const struct tfa_chain *chain, void *rows, num max_ratio);
void TFA_V(scan_solve)(struct state *s, const struct tfa_chain *chain, void *rows, const num *tau,
                       num *qdd, int bias);

/* Lambda^-1 of the request's tips into s->lambda, with the factors that either scan left. 0: a tip
 * reaches a chain before its last segment, or there are mimics. O(N / 16) for each tip. */
int TFA_V(scan_lambda)(struct state *s, tfa_reference_frame frame);

/* E^-1 x */
static inline svec scan_closed(const struct mat6_rows_lu *E, svec x)
{
    num v[6];
    sv_store(v, x);
    mat6_rows_lu_solve_vec(E, v);
    return sv_from(v);
}

#endif
