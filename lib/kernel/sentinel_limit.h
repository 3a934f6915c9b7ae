/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Where the sentinel trips (sentinel.h).
 */
#ifndef TFA_KERNEL_SENTINEL_LIMIT_H
#define TFA_KERNEL_SENTINEL_LIMIT_H

#include "spatial/num.h"

/* docs/accuracy.md, "The sentinel" */
#ifdef TFA_TRIP_EXPERIMENT
extern double tfa_trip;
#define SENTINEL_LIMIT tfa_trip
#else
#define SENTINEL_LIMIT (NUM_EPSILON > 0x1p-30 ? 1e-3 : 1e-8)
#endif

#endif
