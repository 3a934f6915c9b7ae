/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Where a chain is cut into segments, from the constants of its bodies alone: the same cuts for
 * every number type, lane and thread.
 */
#ifndef TFA_DYNAMICS_SCAN_CHAIN_CUT_H
#define TFA_DYNAMICS_SCAN_CHAIN_CUT_H

#include "model/model.h"

/* Largest ratio of outboard inertia to compliance at a cut (scan_factor_interface), from where on
 * one pass loses digits that ABA keeps. Chains of revolute joints seldom get there; with all types
 * of joints the worst answer had 5 times the error of ABA at 30, and 13 times at 1000. 13
 * mechanisms, N 24 to 256, 6 to 8 seeds each, 2026-11-21. */
#define TFA_SCAN_MAX_RATIO 30

/* Position of the body behind which a segment had better end: the regular one from middle - reach
 * to middle + reach with the smallest ratio, the nearest to the middle of those with about the
 * smallest. -1: none of them is regular. The chain continues behind all of them. If segments are to
 * float (cut_forces.h), the next body must be regular, too, and its joint have one freedom and no
 * rotor inertia. */
int64_t tfa_best_cut(const struct tfa_body *body, const struct tfa_chain *chain, uint32_t middle,
                     uint32_t reach, int floating);

/* Segments of about the same length that a chain of so many bodies is cut into, for lanes and
 * threads: 1, 8 or 16 */
#define TFA_SEGMENTS_MAX 16u
uint32_t tfa_segment_count(uint32_t length);
/* Position of the last body of segment k of these; -1 and `floating` as tfa_best_cut */
int64_t tfa_segment_end(const struct tfa_body *body, const struct tfa_chain *chain, uint32_t k,
                        int floating);

/* The segments of a chain that go in SIMD lanes */
struct tfa_chain_segments {
    uint32_t count; /* a multiple of 8; 0: the robot does not qualify */
    uint32_t first[TFA_SEGMENTS_MAX], length[TFA_SEGMENTS_MAX];
    uint32_t shortest, longest;
};

/* One chain of revolute joints without rotor inertia, fixed base, no mimics, long enough. */
struct tfa_chain_segments tfa_cut_segments(const tfa_model *model);

#endif
