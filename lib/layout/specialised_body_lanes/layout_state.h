/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Layout `specialised_body_lanes`: a recursion passes steps of bodies that share lanes.
 */
#ifndef TFA_LAYOUT_SPECIALISED_BODY_LANES_STATE_H
#define TFA_LAYOUT_SPECIALISED_BODY_LANES_STATE_H

#include "layout_body.h"

#define robot_unit robot_step
#define ROBOT_UNITS ROBOT_STEPS
#define ROBOT_UNIT_COORDINATES (ROBOT_STEP_FREEDOMS - ROBOT_BASE)
#define ROBOT_UNIT_FREEDOMS ROBOT_STEP_FREEDOMS
#define ROBOT_UNITS_OUTWARD ROBOT_STEPS_OUTWARD
#define ROBOT_UNITS_INWARD ROBOT_STEPS_INWARD

#include "layout/specialised_state.h"

#endif
