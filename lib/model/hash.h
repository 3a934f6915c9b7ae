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

#endif
