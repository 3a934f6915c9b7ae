/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A state whose bodies are in the lanes of its numbers (body-lanes variants only). The
 * sources of the steps are those of one body after the other: pose.c, velocity.c, aba.c, load.c.
 */
#ifndef TFA_DYNAMICS_SIMD_BODY_LANES_INIT_H
#define TFA_DYNAMICS_SIMD_BODY_LANES_INIT_H

#include "layout/lane_schedule.h"
#include "layout/state.h"

/* Steps, coordinates and freedoms of a schedule of all bodies with as many lanes as this
 * variant. */
struct extent TFA_V(body_lanes_extent)(const struct tfa_model *m,
                                       const struct tfa_lane_schedule *p);

/* A state in memory of the size that state_walk gives for that extent: constants in lane order, and
 * where each lane has its numbers from. The schedule is not used afterwards. */
struct state *TFA_V(body_lanes_init)(const struct tfa_model *m, const struct tfa_lane_schedule *p,
                                     void *memory);

#endif
