/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * What stands behind the gateway in a test: the daemon's worker in a thread, and the gateway's own
 * solvers.
 */
#ifndef TFA_TESTS_DDS_TEST_WORKER_H
#define TFA_TESTS_DDS_TEST_WORKER_H

#include "robots.h"

#include <stdbool.h>
#include <stdint.h>

struct tfa_worker;
struct tfa_worker_robot;

/* Starts it; each answer takes delay_us longer than it would. NULL if it cannot. */
struct tfa_worker *test_worker_start(const test_robot robots[TEST_ROBOTS], uint32_t delay_us);
/* Until it is called again by the same thread, with false, the worker answers nothing that is
 * computed. */
void test_worker_hold(bool hold);
void test_worker_stop(struct tfa_worker *worker);

/* Solvers for the gateway, one for each robot; as slow as the worker's. */
const struct tfa_worker_robot *test_gateway_solvers(void);

#endif
