/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Which compiled variant answers: the best one whose every CPU feature is present.
 */
#include <stdlib.h>
#include <string.h>

#include "kernel/table.h"

extern const struct tfa_lanes tfa_lanes_f64x2_base, tfa_lanes_f64x4_avx2, tfa_lanes_f64x8_avx512;

/* best first among those of one precision */
#ifdef TFA_HAVE_X86_VARIANTS
#define VARIANTS(X) X(f64_avx512) X(f64_avx2) X(f64_base) X(f32_avx512) X(f32_avx2) X(f32_base)
#else
#define VARIANTS(X) X(f64_base) X(f32_base)
#endif

#define DECLARE(variant) extern const struct tfa_kernel tfa_kernel_##variant;
VARIANTS(DECLARE)
DECLARE(f128_base)

#define ADDRESS(variant) &tfa_kernel_##variant,
static const struct tfa_kernel *const kernels[] = {VARIANTS(ADDRESS) ADDRESS(f128_base)};

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

static const struct tfa_lanes *const lane_kernels[] = {
#ifdef TFA_HAVE_X86_VARIANTS
    &tfa_lanes_f64x8_avx512,
    &tfa_lanes_f64x4_avx2,
#endif
    &tfa_lanes_f64x2_base,
};

const struct tfa_lanes *tfa_lanes_select(void)
{
    const struct tfa_kernel *one = tfa_kernel_select(TFA_F64);
    for (size_t k = 0; k < sizeof lane_kernels / sizeof *lane_kernels; k++)
        if (strcmp(lane_kernels[k]->isa, one->isa) == 0)
            return lane_kernels[k];
    return NULL;
}
