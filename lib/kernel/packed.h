/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A state whose bodies stand side by side in the lanes of its numbers (packed variants only). The
 * sources of the steps are those of one body after the other: pose.c, velocity.c, aba.c, load.c.
 */
#ifndef TFA_KERNEL_PACKED_H
#define TFA_KERNEL_PACKED_H

#include "kernel/state.h"
#include "plan/packing.h"

/* Steps, coordinates and freedoms of a packing of all bodies with as many lanes as this variant. */
struct extent TFA_V(packed_extent)(const struct tfa_model *m, const struct tfa_packing *p);

/* A state in memory of the size that state_walk gives for that extent: constants in lane order, and
 * where each lane has its numbers from. The packing is not used afterwards. */
struct state *TFA_V(packed_init)(const struct tfa_model *m, const struct tfa_packing *p,
                                 void *memory);

#endif
