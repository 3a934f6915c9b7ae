/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Independent limbs of a tree side by side.
 */
#ifndef TFA_PLAN_LIMBS_H
#define TFA_PLAN_LIMBS_H

#include "model/model.h"
#include "plan/packing.h"

/* Trees with more bodies are not packed: the plan is made without memory of its own. */
#define TFA_LIMBS_BODIES_MAX 256
#define TFA_LIMBS_LANES_MAX 8

/* A packing of all bodies in as few steps as `lanes` lanes allow, in `table`, which has room for a
 * step for each body. O(N^2). Returns no steps for more than TFA_LIMBS_BODIES_MAX bodies, and where a
 * floating base is not the only root. */
struct tfa_packing tfa_limbs_pack(const struct tfa_model *model, uint32_t lanes, int32_t *table);

#endif
