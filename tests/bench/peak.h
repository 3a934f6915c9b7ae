/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * What the machine could do: fused multiplications and additions in registers, nothing else.
 */
#ifndef TFA_BENCH_PEAK_H
#define TFA_BENCH_PEAK_H

#ifdef __cplusplus
extern "C"
#endif
/* Floating-point operations in a nanosecond of this thread (CPU time) with the vectors of that
 * instruction set (tfa_isa_name()), floats or doubles. One round of some 100 us. */
double peak_flops(const char *isa, int floats);

#endif
