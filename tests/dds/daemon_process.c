/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The process that serves the test robots over DDS is totalforced itself.
 */
#include "dds_test.h"
#include "gateway_process.h"
#include "harness.h"
#include "herald.h"
#include "robots.h"
#include "support/closed_dog.h"
#include "test.h"

#include <signal.h>
#include <sys/wait.h>

static harness running;

void test_daemon_main(int argc, char **argv)
{
    (void)argc;
    (void)argv;
}

/* Robots that DDS must not know stand before and between those that it serves. */
test_daemon test_daemon_start(uint32_t domain, const test_daemon_options *options)
{
    char robots[1536];
    (void)options;
    snprintf(robots, sizeof robots,
             "  - name: hidden\n    urdf: @/config/robots/quadruped.urdf\n    dds: false\n" ARM
             "    estimate: never\n    max_batch: %d\n"
             "  - name: secret\n    urdf: @/config/robots/arm7.urdf\n    dds: false\n"
             "  - name: four\n    urdf: @/config/robots/quadruped.urdf\n    base: floating\n"
             "    estimate: never\n    max_batch: %d\n" CLOSED_DOG_YAML,
             TEST_BATCH, TEST_BATCH);
    running = harness_serve(robots, dds_yaml(domain, TEST_LEASE_MS));
    assert_true(harness_logged(&running, "ready:"));
    dds_herald(domain, "arm");
    dds_herald(domain, "four.closed");
    return (test_daemon){.pid = running.pid, .out = -1};
}

unsigned long test_daemon_stop(test_daemon *daemon)
{
    assert_int_equal(daemon->pid, running.pid);
    const int status = harness_stop(&running, SIGTERM);
    assert_true(WIFEXITED(status));
    assert_int_equal(WEXITSTATUS(status), 0);
    harness_remove(&running);
    return 0;
}
