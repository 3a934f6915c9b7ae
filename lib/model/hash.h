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

/* The hash of all but gravity. Models with the same one share a specialised kernel, which reads
 * gravity from the model. */
void tfa_hash_without_gravity(const struct tfa_model *m, uint8_t hash[32]);

#endif
