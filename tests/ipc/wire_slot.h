/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Two robots on the wire, and memory for their slots.
 */
#ifndef TFA_TESTS_WIRE_SLOT_H
#define TFA_TESTS_WIRE_SLOT_H

#include "ipc/wire.h"

#define WIRE_BATCH 3

/** A fixed arm of 7 joints, one state. */
extern const tfa_wire_shape wire_arm;
/** A floating base with a quaternion joint, WIRE_BATCH states. */
extern const tfa_wire_shape wire_dog;

/** Memory of a slot, every byte 0xa5; the caller frees it. */
void *wire_slot(size_t size);

#endif
