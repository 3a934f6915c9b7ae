/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Shapes and slots.
 */
#include "wire_slot.h"

#include "test.h"

const tfa_wire_shape wire_arm = {
    .q_count = 7, .v_count = 7, .frames = 9, .max_batch = 1, .max_tips = TFA_DEFAULT_TIPS};
const tfa_wire_shape wire_dog = {.q_count = 12,
                                 .v_count = 11,
                                 .base_freedoms = 6,
                                 .frames = 20,
                                 .modes = 5,
                                 .max_batch = WIRE_BATCH,
                                 .max_tips = TFA_MAX_TIPS};

void *wire_slot(size_t size)
{
    void *memory = aligned_alloc(64, (size + 63) / 64 * 64);
    memset(memory, 0xa5, size);
    return memory;
}
