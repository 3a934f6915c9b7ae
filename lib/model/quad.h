/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Number type of compilation: IEEE quadruple precision.
 */
#ifndef TFA_MODEL_QUAD_H
#define TFA_MODEL_QUAD_H

#if defined(__x86_64__) || defined(__i386__)
__extension__ typedef __float128 tfa_quad;
/* glibc >= 2.26 has these; its header declares them for compilers with _Float128 only */
extern tfa_quad sqrtf128(tfa_quad x);
extern void sincosf128(tfa_quad x, tfa_quad *s, tfa_quad *c);
#define TFA_QUAD_SQRT sqrtf128
#define TFA_QUAD_SINCOS sincosf128
#else
/* on aarch64 long double is the quadruple-precision type */
#include <math.h>
typedef long double tfa_quad;
#define TFA_QUAD_SQRT sqrtl
#define TFA_QUAD_SINCOS sincosl
#endif

#endif
