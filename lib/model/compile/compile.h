/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * From a draft to the compiled model.
 */
#ifndef TFA_MODEL_COMPILE_COMPILE_H
#define TFA_MODEL_COMPILE_COMPILE_H

#include "model/draft/draft.h"

/* Bytes of the compiled model. */
size_t tfa_compiled_size(const struct draft *d);

/* Compiles into `memory`: 64-byte aligned, tfa_compiled_size bytes. Cannot fail. */
const struct tfa_model *tfa_compile(const struct draft *d, void *memory);

#endif
