/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Hash of a model.
 */
#ifndef TFA_MODEL_HASH_H
#define TFA_MODEL_HASH_H

#include "model/model.h"

/* Sets hash and hash_text, from all constants that decide answers and the names in their order. */
void tfa_hash_model(struct tfa_model *m);

/* Hash without gravity. Models that share it share a specialised kernel, which reads gravity from
 * the model. */
void tfa_hash_without_gravity(const struct tfa_model *m, uint8_t hash[32]);

#endif
