/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Layout `body_lanes`: struct state of one state whose bodies share lanes.
 */
#ifndef TFA_LAYOUT_BODY_LANES_STATE_H
#define TFA_LAYOUT_BODY_LANES_STATE_H

#include <stdint.h>

#include "layout_body.h"

/* Of one state whose bodies share lanes; written once by body_lanes_init.c */
#define TFA_LAYOUT_ARRAYS(ARRAY)                                                                   \
    ARRAY(body_constants, lane_constants, nb, "", "i", "constant terms in lane order")             \
    ARRAY(struct branch, branch, m->bodies, "", "", "lanes whose children stand in other lanes")   \
    ARRAY(struct lane_ref, child, m->bodies, "", "", "children of each body, the last one first")  \
    ARRAY(uint32_t, first_child, m->bodies, "", "", "a body's first among them")                   \
    ARRAY(coordinate, coordinates_of, nq, "", "", "where coordinates come from")                   \
    ARRAY(freedom, freedoms_of, nv, "", "", "where freedoms come from and go to")                  \
    ARRAY(num, lane_damping, nv, "N m s", "joint", "damping of each freedom")                      \
    ARRAY(num, lane_friction, nv, "N m", "joint", "friction of each freedom")                      \
    ARRAY(num, in_body_order, m->freedoms, "", "joint", "freedoms in the order of the bodies")     \
    ARRAY(uint32_t, step_of, m->bodies, "", "", "where a body stands: its step")                   \
    ARRAY(uint32_t, lane_of, m->bodies, "", "", "and its lane")                                    \
    ARRAY(uint32_t, children, m->bodies, "", "", "how many a body has")

#define HAS_MODES(s) 0 /* robots with flexible links have no body lanes */

/* Where inner coordinates and freedoms come from: one number for each lane */
typedef struct lane_indices source;
typedef struct coordinate {
    source from;
    double multiplier, offset; /* without mimics the same in all lanes */
} coordinate;
typedef struct freedom {
    source from;
    double multiplier;
    uint32_t lane_mask; /* bit l: lane l holds a body, others repeat one */
} freedom;

#include "layout/state_struct.h"

/* Everything is scheduled by body_lanes_init.c. */
static inline void state_read_model(struct state *s)
{
    (void)s;
}

#include "layout/state_walk.h"

#endif
