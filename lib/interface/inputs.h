/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Arrays of numbers that a request reads.
 */
#ifndef TFA_INTERFACE_INPUTS_H
#define TFA_INTERFACE_INPUTS_H

#include <string.h>

#include <totalforce/dynamics.h>

struct tfa_input {
    uint16_t member;     /* offset of the pointer in tfa_request */
    uint8_t field;       /* tfa_field */
    uint8_t every_state; /* 1: `width` numbers for each state; 0: for all */
    uint32_t width;
};

/* In the order in which faults are named */
#define TFA_INPUTS_MAX 12
struct tfa_inputs {
    uint32_t count;
    struct tfa_input input[TFA_INPUTS_MAX];
};

static inline const double *input_array(const tfa_request *r, const struct tfa_input *in)
{
    const double *x;
    memcpy(&x, (const char *)r + in->member, sizeof x);
    return x;
}

static inline size_t input_states(const tfa_request *r, const struct tfa_input *in)
{
    return in->every_state ? r->count : 1;
}

#ifdef __AVX__
#define INPUT_LANES 4
#else
#define INPUT_LANES 2
#endif
typedef double input_lanes __attribute__((vector_size(INPUT_LANES * sizeof(double))));

/* 0 of each lane, or NaN: 0 x, without branches */
static inline input_lanes zeros_of(const double *x)
{
    input_lanes v;
    memcpy(&v, x, sizeof v);
    return v * 0;
}

/* sum + 0 if all numbers are finite, else NaN; the last vector overlaps the one before if
 * necessary. */
static inline input_lanes add_zeros_of(input_lanes sum, const double *x, size_t n)
{
    if (n < INPUT_LANES) {
        for (size_t k = 0; k < n; k++)
            sum += x[k] * 0;
        return sum;
    }
    const double *const last = x + (n - INPUT_LANES);
    for (; x < last; x += INPUT_LANES)
        sum += zeros_of(x);
    return sum + zeros_of(last);
}

/* 0 if all numbers of these arrays are finite, else NaN. An array that is not there has none. */
static inline double zero_of_inputs(const tfa_request *r, const struct tfa_inputs *inputs)
{
    input_lanes sum = {0};
    for (uint32_t k = 0; k < inputs->count; k++) {
        const struct tfa_input *in = &inputs->input[k];
        const double *x = input_array(r, in);
        if (x)
            sum = add_zeros_of(sum, x, in->width * input_states(r, in));
    }
    double zero = 0;
    for (int l = 0; l < INPUT_LANES; l++)
        zero += sum[l];
    return zero;
}

#endif
