/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Number type: one double.
 */
#ifndef TFA_VARIANT_H
#define TFA_VARIANT_H

#include "variants/sincos_f64.h"

typedef double num;
#define NUM_EPSILON 0x1p-52
#define num_sincos_many sincos_f64

#endif
