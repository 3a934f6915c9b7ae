/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Steps that the ways to Lambda^-1 share.
 */
#ifndef TFA_KERNEL_LAMBDA_H
#define TFA_KERNEL_LAMBDA_H

#include "kernel/state.h"

/* Six unit wrenches at a frame (three forces, three moments) in the coordinates of its body.
 * Returns the body, -1 when the frame is fixed to the world. Needs the pose. */
int32_t TFA_V(frame_columns)(const struct state *s, uint32_t frame, tfa_reference_frame mode,
                             svec P[6]);

/* How many freedoms of its body's joint move a frame: all, but for one inside a fused joint. */
uint32_t TFA_V(frame_freedoms)(const struct state *s, uint32_t frame);

/* Axes of a frame (columns, row major) and its origin in the world. Needs the pose. */
void TFA_V(frame_pose)(const struct state *s, uint32_t frame, num R[9], num p[3]);

/* Takes six forces past joint i: psi = H^T P, phi = D^-1 psi, P <- X^T (P - U phi), where they act
 * on what its first `moved` freedoms move. Needs the articulated-body factors of body i. */
void TFA_V(propagate)(const struct state *s, int32_t i, uint32_t moved, svec P[6], num psi[6][6],
                      num phi[6][6]);

/* Copies the upper triangle of s->lambda to the lower one. */
void TFA_V(lambda_mirror)(struct state *s);

#endif
