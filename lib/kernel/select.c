/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Which compiled variant answers: the best one whose every CPU feature is present.
 */
#include <stdlib.h>
#include <string.h>

#include "kernel/table.h"

extern const struct tfa_kernel tfa_kernel_f64_base;
extern const struct tfa_kernel tfa_kernel_f128_base;
extern const struct tfa_kernel tfa_kernel_f64_avx2;
extern const struct tfa_kernel tfa_kernel_f64_avx512;

extern const struct tfa_lanes tfa_lanes_f64x2_base;
extern const struct tfa_lanes tfa_lanes_f64x4_avx2;
extern const struct tfa_lanes tfa_lanes_f64x8_avx512;

/* best first */
static const struct tfa_kernel *const kernels[] = {
#ifdef TFA_HAVE_X86_VARIANTS
    &tfa_kernel_f64_avx512,
    &tfa_kernel_f64_avx2,
#endif
    &tfa_kernel_f64_base,
    &tfa_kernel_f128_base,
};

const struct tfa_kernel *tfa_kernel_select(tfa_precision precision)
{
    const char *forced = getenv("TFA_ISA");
    const struct tfa_kernel *best = NULL;
    for (size_t k = 0; k < sizeof kernels / sizeof *kernels; k++) {
        if (kernels[k]->precision != precision || !kernels[k]->supported())
            continue;
        if (forced && strcmp(forced, kernels[k]->isa) == 0)
            return kernels[k];
        if (!best)
            best = kernels[k];
    }
    return best;
}

static const struct tfa_lanes *const wide[] = {
#ifdef TFA_HAVE_X86_VARIANTS
    &tfa_lanes_f64x8_avx512,
    &tfa_lanes_f64x4_avx2,
#endif
    &tfa_lanes_f64x2_base,
};

const struct tfa_lanes *tfa_lanes_select(void)
{
    const struct tfa_kernel *one = tfa_kernel_select(TFA_F64);
    for (size_t k = 0; k < sizeof wide / sizeof *wide; k++)
        if (strcmp(wide[k]->isa, one->isa) == 0)
            return wide[k];
    return NULL;
}
