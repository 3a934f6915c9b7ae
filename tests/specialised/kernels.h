/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Specialised kernels for tests that know nothing about them: whoever makes a workspace asks here,
 * and where the folder TFA_TEST_KERNELS holds the model's kernel, it is under test.
 */
#ifndef TESTS_SPECIALISED_KERNELS_H
#define TESTS_SPECIALISED_KERNELS_H

#include <totalforce/totalforce.h>

/**
 * The model's kernel, loaded once until the program ends; NULL where there is none, or no folder is
 * named. One that is refused fails the test. States that it answers are counted: a program that was
 * given a folder and has none answered by a kernel at its end fails, and one whose folder is not
 * there, as test_make_kernels leaves it without a compiler, is skipped with status 77.
 */
const tfa_specialised *kernels_find(const tfa_model *model);

/** Is this run about kernels, and has the model none? What there is to find about it the tests find
 * without
 *  TFA_TEST_KERNELS. */
int kernels_skip(const tfa_model *model);

/** States that kernels answered so far. */
uint64_t kernels_answered(void);

#endif
