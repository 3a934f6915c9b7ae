/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A thread's stack, there before the first request.
 */
#include <stddef.h>

#include "totalforce/dynamics.h"

/* A write to every page; in a frame of its own, which is given back. */
__attribute__((noinline)) void tfa_stack_prepare(void)
{
    volatile unsigned char buffer[TFA_STACK_BYTES];
    for (size_t k = 0; k < sizeof buffer; k += 4096)
        buffer[k] = 0;
}
