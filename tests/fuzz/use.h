/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Uses a robot in every way that the library offers, with random options, scenes and requests.
 */
#ifndef TESTS_FUZZ_USE_H
#define TESTS_FUZZ_USE_H

#include "random.h"

#include <totalforce/model.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Compiles the description with random options; what compiles also computes. */
void use_description(const tfa_description *description, struct random_source *c);

/* Every op with every method that answers it, in random states. */
void use_model(const tfa_model *model, struct random_source *c);

#ifdef __cplusplus
}
#endif
#endif
