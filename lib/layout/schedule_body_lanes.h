/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Schedule of the independent branches of a tree in SIMD lanes.
 */
#ifndef TFA_LAYOUT_SCHEDULE_BODY_LANES_H
#define TFA_LAYOUT_SCHEDULE_BODY_LANES_H

#include "layout/lane_schedule.h"
#include "model/model.h"

/* Trees with more bodies are not scheduled: the scheduler allocates no memory. */
#define TFA_BODY_LANES_BODIES_MAX 256
#define TFA_BODY_LANES_MAX 8

/* A schedule of all bodies in as few steps as `lanes` lanes allow, in `table`, which has room for a
 * step for each body. O(N^2). Returns no steps for more than TFA_BODY_LANES_BODIES_MAX bodies, and
 * where a floating base is not the only root. */
struct tfa_lane_schedule tfa_schedule_body_lanes(const struct tfa_model *model, uint32_t lanes,
                                                 int32_t *table);

#endif
