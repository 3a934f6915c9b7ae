/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Frames of links on their bodies.
 */
#ifndef TFA_DYNAMICS_KINEMATICS_FRAME_H
#define TFA_DYNAMICS_KINEMATICS_FRAME_H

#include "layout/constants.h"
#include "layout/state.h"

/* The axes (columns) and the point that unit wrenches at a frame go by, in the coordinates of its
 * body, which is returned; -1: of the world, to which the frame is fixed. Needs the pose. */
int32_t TFA_V(frame_at)(const struct state *s, uint32_t frame, tfa_reference_frame mode, mat3 *R,
                        vec3 *p);

/* Six unit wrenches at a frame (three forces, three moments) in the same coordinates. Returns the
 * same. Needs the pose. */
int32_t TFA_V(frame_columns)(const struct state *s, uint32_t frame, tfa_reference_frame mode,
                             svec P[6]);

/* frame_in_body of a frame that moves in its body: on a part of a fused joint, carried on by the
 * parts behind it; on a handle of a flexible link */
xform TFA_V(frame_moved)(const struct state *s, uint32_t frame);

/* The axes (columns, E) and the origin (r) of a frame in the coordinates of its body, or in the
 * world if it is fixed there. Needs the pose if it moves there. */
static inline xform frame_in_body(const struct state *s, uint32_t frame)
{
    const struct tfa_frame *f = &s->m->frame[frame];
    return f->part || f->handle >= 0 ? TFA_V(frame_moved)(s, frame) : frame_xform(s->m, frame);
}

/* How many freedoms of its body's joint move a frame: all, but for one inside a fused joint. */
uint32_t TFA_V(frame_freedoms)(const struct state *s, uint32_t frame);

#endif
