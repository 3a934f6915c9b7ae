/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The hash of a model.
 */
#ifndef TFA_MODEL_HASH_H
#define TFA_MODEL_HASH_H

#include "model/model.h"

/* Fills hash and hash_text from all that decides the answers and the names in their order. */
void tfa_hash_model(struct tfa_model *m);

/* The hash of all but gravity, or but rotor inertias: models with the same one may share what reads these
 * from the model at hand. */
void tfa_hash_without(const struct tfa_model *m, int gravity, int armature, uint8_t hash[32]);

#endif
