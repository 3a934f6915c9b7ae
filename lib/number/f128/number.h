/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Number type: one quadruple-precision number, the reference of tests and charts.
 */
#ifndef TFA_NUMBER_H
#define TFA_NUMBER_H

#if defined(__x86_64__) || defined(__i386__)
__extension__ typedef __float128 num;
/* glibc >= 2.26 has these; its header declares them for compilers with _Float128 only */
extern void sincosf128(num x, num *s, num *c);
extern num sqrtf128(num x);
#define num_sincos sincosf128
#define num_sqrt sqrtf128
#else
/* on aarch64 long double is the quadruple-precision type */
#include <math.h>
typedef long double num;
#define num_sincos sincosl
#define num_sqrt sqrtl
#endif

#define num_rounded(x) ((num)(double)(x))
#define TFA_INLINE static inline /* calls gain nothing from code written out */
#define NUM_NO_VECTORS /* of __float128 */
#define NUM_QUAD       /* reads the constants of a model as they were before they became doubles */
#define NUM_EPSILON ((num)0x1p-56 * (num)0x1p-56)

#endif
