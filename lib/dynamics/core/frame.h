/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Frames of links on their bodies.
 */
#ifndef TFA_DYNAMICS_CORE_FRAME_H
#define TFA_DYNAMICS_CORE_FRAME_H

#include "layout/state.h"

/* The axes (columns) and the point that unit wrenches at a frame go by, in the coordinates of its
 * body, which is returned; -1: the frame is fixed to the world. Needs the pose. */
int32_t TFA_V(frame_at)(const struct state *s, uint32_t frame, tfa_reference_frame mode, mat3 *R,
                        vec3 *p);

/* Six unit wrenches at a frame (three forces, three moments) in the coordinates of its body.
 * Returns the body, -1 when the frame is fixed to the world. Needs the pose. */
int32_t TFA_V(frame_columns)(const struct state *s, uint32_t frame, tfa_reference_frame mode,
                             svec P[6]);

/* The axes (columns) and the origin of a frame in the coordinates of its body, or in the world if
 * it is fixed there; one inside a fused joint is carried on by the parts behind it. */
void TFA_V(frame_in_body)(const struct state *s, uint32_t frame, mat3 *R, vec3 *p);

/* How many freedoms of its body's joint move a frame: all, but for one inside a fused joint. */
uint32_t TFA_V(frame_freedoms)(const struct state *s, uint32_t frame);

#endif
