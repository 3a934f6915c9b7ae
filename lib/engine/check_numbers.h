/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Arrays of numbers that a request reads, and their checks.
 */
#ifndef TFA_ENGINE_CHECK_NUMBERS_H
#define TFA_ENGINE_CHECK_NUMBERS_H

#include <totalforce/dynamics.h>

/* Arrays that a request of this form reads, in the order in which faults are named */
#define TFA_INPUTS_MAX 12
struct tfa_inputs {
    uint32_t count;
    struct tfa_input {
        uint16_t member;     /* offset of the pointer in tfa_request */
        uint8_t field;       /* tfa_field */
        uint8_t every_state; /* 1: `width` numbers for each state; 0: for all */
        uint32_t width;
    } input[TFA_INPUTS_MAX];
};

void tfa_inputs_of(const tfa_model *model, const tfa_request *request, struct tfa_inputs *out);

/* Checks that arrays are there, numbers finite and quaternions of length 1: those of `inputs`, in a
 * request whose choices, sizes and indices are valid. */
int tfa_check_numbers(const tfa_model *model, const tfa_request *request,
                      const struct tfa_inputs *inputs, tfa_reply *reply);

/* Checks an array of `count` states, `width` numbers each; NULL passes. */
int tfa_check_finite(tfa_reply *reply, tfa_field field, const double *x, size_t width,
                     size_t count);

#endif
