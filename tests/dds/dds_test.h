/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * What the DDS tests share: a domain of their own on the loopback interface, and numbers.
 */
#ifndef TFA_TESTS_DDS_TEST_H
#define TFA_TESTS_DDS_TEST_H

#include "support/domain.h"

/* A client misses a silent daemon after five leases: 30 s. It hears of the leader five times a
 * lease, and a daemon that starts is silent for one, unless there is a herald. */
#define TEST_LEASE_MS 6000

/* Pseudo-random numbers in [-1, 1), the same in every run. */
static inline double test_random(uint64_t *seed)
{
    *seed = *seed * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
    return (double)(int64_t)*seed * 0x1p-63;
}

#endif
