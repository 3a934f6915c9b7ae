/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * What stands behind the gateway in a test: the daemon's worker in a thread (test_worker.c), or a
 * double of the ring that computes at submission (ring_double.c).
 */
#ifndef TFA_TESTS_DDS_TEST_WORKER_H
#define TFA_TESTS_DDS_TEST_WORKER_H

#include "robots.h"

#include <stdint.h>

struct tfa_worker;

/* Starts it; each answer takes delay_us longer than it would. NULL if it cannot. */
struct tfa_worker *test_worker_start(const test_robot robots[TEST_ROBOTS], uint32_t delay_us);
void test_worker_stop(struct tfa_worker *worker);

#endif
