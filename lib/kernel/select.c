/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Which compiled variant answers: the best one whose every CPU feature is present.
 */
#include <stdlib.h>
#include <string.h>

#include "kernel/table.h"

/* best first among those of one precision */
#ifdef TFA_HAVE_X86_VARIANTS
#define VARIANTS(X) X(f64_avx512) X(f64_avx2) X(f64_base) X(f32_avx512) X(f32_avx2) X(f32_base)
#define LANES(X)                                                                                   \
    X(f64x8_avx512) X(f64x4_avx2) X(f64x2_base) X(f32x16_avx512) X(f32x8_avx2) X(f32x4_base)
#else
#define VARIANTS(X) X(f64_base) X(f32_base)
#define LANES(X) X(f64x2_base) X(f32x4_base)
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

#ifdef TFA_HAVE_X86_VARIANTS
#define PACKED(X) X(packed4_avx512) X(packed8_avx512) X(packed4_avx2) X(packed2_base)
#else
#define PACKED(X) X(packed2_base)
#endif
#define DECLARE_LIMBS(variant) extern const struct tfa_limbs tfa_limbs_##variant;
PACKED(DECLARE_LIMBS)

const struct tfa_limbs *tfa_limbs_select(uint32_t k)
{
#define ADDRESS_LIMBS(variant) &tfa_limbs_##variant,
    static const struct tfa_limbs *const all[] = {PACKED(ADDRESS_LIMBS)};
    const struct tfa_kernel *one = tfa_kernel_select(TFA_F64);
    for (size_t j = 0; j < sizeof all / sizeof *all; j++)
        if (strcmp(all[j]->isa, one->isa) == 0 && k-- == 0)
            return all[j];
    return NULL;
}

#define DECLARE_LANES(variant) extern const struct tfa_lanes tfa_lanes_##variant;
LANES(DECLARE_LANES)

#define ADDRESS_LANES(variant) &tfa_lanes_##variant,
static const struct tfa_lanes *const lane_kernels[] = {LANES(ADDRESS_LANES)};

const struct tfa_lanes *tfa_lanes_select(tfa_precision precision)
{
    const struct tfa_kernel *one = tfa_kernel_select(precision);
    for (size_t k = 0; k < sizeof lane_kernels / sizeof *lane_kernels; k++)
        if (lane_kernels[k]->precision == precision && strcmp(lane_kernels[k]->isa, one->isa) == 0)
            return lane_kernels[k];
    return NULL;
}

#ifdef TFA_HAVE_X86_VARIANTS
#define CHAIN_LANES(X) X(f64x8_avx512) X(f64x4_avx2) X(f64x2_base)
#else
#define CHAIN_LANES(X) X(f64x2_base)
#endif
#define DECLARE_CHAINS(variant)                                                                    \
    extern const struct tfa_strips_kernel tfa_strips_##variant;                                    \
    extern const struct tfa_pieces tfa_pieces_##variant;
CHAIN_LANES(DECLARE_CHAINS)

#define ADDRESS_STRIPS(variant) &tfa_strips_##variant,
#define ADDRESS_PIECES(variant) &tfa_pieces_##variant,
static const struct tfa_strips_kernel *const strips_kernels[] = {CHAIN_LANES(ADDRESS_STRIPS)};
static const struct tfa_pieces *const pieces_kernels[] = {CHAIN_LANES(ADDRESS_PIECES)};

/* Which of the lanes for chains is of the instruction set that tfa_kernel_select takes; there is one of
 * each. */
static size_t chain_lanes(void)
{
    const struct tfa_kernel *one = tfa_kernel_select(TFA_F64);
    size_t k = 0;
    while (strcmp(strips_kernels[k]->isa, one->isa) != 0)
        k++;
    return k;
}

const struct tfa_strips_kernel *tfa_strips_select(void)
{
    return strips_kernels[chain_lanes()];
}

const struct tfa_pieces *tfa_pieces_select(void)
{
    return pieces_kernels[chain_lanes()];
}
