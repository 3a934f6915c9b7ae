/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The law of batches, for robots with a specialised kernel: a state has the same bits alone, in a
 * batch however it is cut, on any number of threads, and beside any other state.
 */
#ifndef TESTS_SPECIALISED_SAME_BITS_H
#define TESTS_SPECIALISED_SAME_BITS_H

#include <totalforce/totalforce.h>

/** Fails unless the law holds for every kind of request that kernels answer. */
void assert_same_bits(const tfa_model *model, const tfa_specialised *kernel);

#endif
