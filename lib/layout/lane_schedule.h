/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Schedule that assigns the bodies of one state to SIMD lanes: as many bodies at a time as
 * there are lanes. It is a table of steps: walked in order it meets parents before children,
 * in reverse order children before parents.
 */
#ifndef TFA_LAYOUT_LANE_SCHEDULE_H
#define TFA_LAYOUT_LANE_SCHEDULE_H

#include <stdint.h>

struct tfa_lane_schedule {
    uint32_t lanes, steps;
    const int32_t *body; /* steps x lanes; -1: none. Bodies of one step have the same kind of
                            joint; one with several freedoms has a step of its own, a floating
                            base in lane 0 */
};

#endif
