/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Layout `specialised`: a recursion passes bodies.
 */
#ifndef TFA_LAYOUT_SPECIALISED_STATE_H
#define TFA_LAYOUT_SPECIALISED_STATE_H

#include "layout_body.h"

#define robot_unit robot_body
#define ROBOT_UNITS ROBOT_BODIES
#define ROBOT_UNIT_COORDINATES ROBOT_COORDINATES
#define ROBOT_UNIT_FREEDOMS ROBOT_FREEDOMS
#define ROBOT_UNITS_OUTWARD ROBOT_OUTWARD
#define ROBOT_UNITS_INWARD ROBOT_INWARD

#include "layout/specialised_state.h"

#endif
