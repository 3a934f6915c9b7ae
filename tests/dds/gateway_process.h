/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A process that serves the test robots over DDS, started and ended by a test.
 */
#ifndef TFA_TESTS_DDS_GATEWAY_PROCESS_H
#define TFA_TESTS_DDS_GATEWAY_PROCESS_H

#include "support/scoped.h"

#include <stdbool.h>
#include <stdint.h>
#include <sys/types.h>

typedef struct test_daemon {
    pid_t pid;
    int out; /* its standard output: one line when it is ready, one of counters when it ends */
    unsigned long handovers; /* requests that the worker answered: known when it ended */
} test_daemon;

/* What it does with its requests; zeros are the defaults. */
typedef struct test_daemon_options {
    uint32_t delay_us;   /* how long an answer takes at least */
    uint32_t slots;      /* requests under way for each robot */
    uint32_t max_age_ms; /* of torques; 0: any */
} test_daemon_options;

/* If the arguments say so, be such a process and never return. The first thing main does. */
void test_daemon_main(int argc, char **argv);

/* Starts one in `domain` and waits until it leads. Fails the test if it cannot. */
test_daemon test_daemon_start(uint32_t domain, const test_daemon_options *options);

/* Gives the arm its model again as a reload does that changed its arrays. The first time another
 * client took the gateway's entry at the worker, the second time there is one, and so on.
 * @return as tfa_dds_announce */
int test_daemon_reload(const test_daemon *daemon);

/* Holds computed answers until they are released. @return requests that it has refused */
unsigned long test_daemon_hold(const test_daemon *daemon, bool hold);

/* Ends it by SIGTERM; it must end well. @return the answers that DDS would not take */
unsigned long test_daemon_stop(test_daemon *daemon);
#define SCOPED_DAEMON SCOPED(test_daemon_stop) test_daemon

#endif
