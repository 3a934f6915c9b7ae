/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Two robots for the DDS tests: "arm" on a fixed base, and "four.closed", which floats and has two
 * constraints.
 */
#ifndef TFA_TESTS_DDS_ROBOTS_H
#define TFA_TESTS_DDS_ROBOTS_H

#include <totalforce/description.h>
#include <totalforce/model.h>

#define TEST_ROBOTS 2
#define TEST_BATCH 8 /* states of one request */

typedef struct test_robot {
    const char *name;
    tfa_model *model;
} test_robot;

/* Compiles both; release the models with tfa_model_free */
void test_robots_make(test_robot robots[TEST_ROBOTS]);

#endif
