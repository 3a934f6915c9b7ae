/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Table of instruction sets.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "interface/kernel_table.h"

/* ROW(isa, that of the kernel of one state at a time, lanes of doubles, lanes of floats, body-lanes
 * kernel, other body-lanes kernel or NULL) */
#define BASE(ROW) ROW(base, base, 2, 4, &tfa_body_lanes_bodies2_base, NULL)
#ifdef TFA_HAVE_X86_VARIANTS
extern const struct tfa_body_lanes_kernel tfa_body_lanes_bodies4_avx512,
    tfa_body_lanes_bodies8_avx512, tfa_body_lanes_bodies4_avx2;
#define BACKENDS(ROW)                                                                              \
    ROW(avx512, avx2, 8, 16, &tfa_body_lanes_bodies4_avx512, &tfa_body_lanes_bodies8_avx512)       \
    ROW(avx2, avx2, 4, 8, &tfa_body_lanes_bodies4_avx2, NULL)                                      \
    BASE(ROW)
#else
#define BACKENDS(ROW) BASE(ROW)
#endif

#define DECLARE(isa, one, doubles, floats, first, second)                                          \
    extern const struct tfa_kernel tfa_kernel_f64_##one, tfa_kernel_f64x##doubles##_##isa,         \
        tfa_kernel_f32x##floats##_##isa;                                                           \
    extern const struct tfa_segment_lanes_kernel tfa_segment_lanes_chain##doubles##_##isa;
BACKENDS(DECLARE)
extern const struct tfa_body_lanes_kernel tfa_body_lanes_bodies2_base;

#define ROW(isa, one, doubles, floats, first, second)                                              \
    {#isa,                                                                                         \
     &tfa_kernel_f64_##one,                                                                        \
     &tfa_kernel_f64x##doubles##_##isa,                                                            \
     &tfa_kernel_f32x##floats##_##isa,                                                             \
     {first, second},                                                                              \
     &tfa_segment_lanes_chain##doubles##_##isa},
static const struct tfa_backend backends[] = {BACKENDS(ROW)}; /* best first */

const struct tfa_backend *tfa_backend_select(void)
{
    const char *forced = getenv("TFA_ISA");
    forced = forced && *forced ? forced : NULL;
    for (size_t k = 0; k < sizeof backends / sizeof *backends; k++)
        if (backends[k].batch_f64->supported() && (!forced || strcmp(forced, backends[k].isa) == 0))
            return &backends[k];
    return NULL;
}

void tfa_isa_names(char *text, size_t size)
{
    size_t used = 0;
    for (size_t k = 0; k < sizeof backends / sizeof *backends && used < size; k++)
        if (backends[k].batch_f64->supported())
            used += (size_t)snprintf(text + used, size - used, "%s%s", used ? ", " : "",
                                     backends[k].isa);
}

const char *tfa_isa_name(void)
{
    const struct tfa_backend *backend = tfa_backend_select();
    return backend ? backend->isa : "none";
}
