/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Included before every kernel source that is compiled as C++: what the kernels call and are called
 * from is C.
 */
#ifndef TFA_COUNT_C_LINKAGE_H
#define TFA_COUNT_C_LINKAGE_H

#include <cmath>
#include <cstddef>
#include <cstdint>

#define _Alignas alignas
#define _Static_assert static_assert

extern "C" {
#include "dynamics/scan/chain_cut.h"
#include "interface/kernel_table.h"
#include "model/model.h"
#include "model/payload.h"
extern const struct tfa_kernel tfa_kernel_count_base;
}

#endif
