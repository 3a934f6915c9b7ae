/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Layout `specialised`: the constant terms of one robot's bodies are tables that the compiler
 * knows.
 */
#ifndef TFA_LAYOUT_SPECIALISED_BODY_H
#define TFA_LAYOUT_SPECIALISED_BODY_H

#include "layout/scalar/layout_body.h"
#include "robot_tables.h"

#endif
