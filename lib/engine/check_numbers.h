/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Checks of the numbers that a request reads.
 */
#ifndef TFA_ENGINE_CHECK_NUMBERS_H
#define TFA_ENGINE_CHECK_NUMBERS_H

#include "interface/inputs.h"

/* Arrays that a request of this form reads */
void tfa_inputs_of(const tfa_model *model, const tfa_request *request, struct tfa_inputs *out);

/* Checks that arrays are there, numbers finite and quaternions of length 1: those of `inputs`, in a
 * request whose choices, sizes and indices are valid. zero: their zero_of_inputs. */
int tfa_check_numbers(const tfa_model *model, const tfa_request *request,
                      const struct tfa_inputs *inputs, double zero, tfa_reply *reply);

/* Checks an array of `count` states, `width` numbers each; NULL passes. */
int tfa_check_finite(tfa_reply *reply, tfa_field field, const double *x, size_t width,
                     size_t count);

#endif
