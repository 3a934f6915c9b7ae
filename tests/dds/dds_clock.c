/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The daemon's wall clock jumps while it serves (libfaketime, which leaves the monotonic clock):
 * epochs and stamps come from it, nothing else; leases, deadlines and waits go on.
 */
#include "dds_test.h"
#include "harness.h"
#include "raw_dds.h"
#include "test.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define HALF_HOUR_US 1800000000u
#define LIBRARY "/usr/lib/" TFA_TRIPLET "/faketime/libfaketimeMT.so.1"

static void set_clock(const harness *h, const char *offset)
{
    char path[160], next[160];
    harness_write(h, "offset.next", offset);
    snprintf(next, sizeof next, "%s/offset.next", h->directory);
    snprintf(path, sizeof path, "%s/offset", h->directory);
    assert_int_equal(rename(next, path), 0);
}

static harness serve(void)
{
    harness h = harness_make(ARM, dds_yaml(test_domain(), TEST_LEASE_MS));
    char path[160];
    set_clock(&h, "+0");
    snprintf(path, sizeof path, "%s/offset", h.directory);
    snprintf(h.preload, sizeof h.preload, "%s", LIBRARY);
    assert_int_equal(setenv("FAKETIME_TIMESTAMP_FILE", path, 1), 0);
    assert_int_equal(setenv("FAKETIME_NO_CACHE", "1", 1), 0);
    assert_int_equal(setenv("FAKETIME_DONT_FAKE_MONOTONIC", "1", 1), 0);
    harness_start(&h, "arm");
    return h;
}

/* An hour ahead, back, ten years back and ahead again: the same leader answers, requests over
 * shared memory keep their deadlines, and over DDS a deadline is judged by the daemon's clock. */
TEST(the_wall_clock_jumps)
{
    static const struct {
        const char *offset;
        int status; /* of a request with a deadline of half an hour over DDS */
    } jumps[] = {{"+0", TFA_OK},         {"+3600", TFA_E_LATE},      {"-3600", TFA_OK},
                 {"-315360000", TFA_OK}, {"+315360000", TFA_E_LATE}, {"+0", TFA_OK}};
    SCOPED_HARNESS h = serve();
    dds_herald(test_domain(), "arm");
    const SCOPED_RAW_DDS r = raw_dds_open(test_domain());
    totalforce_dds_Request s = raw_dds_request();
    raw_dds_await(&r, "arm", TFA_OK);
    const uint64_t epoch = raw_dds_ask(&r, &s)->epoch;
    tfa_client_options options = harness_options(&h, "arm");
    options.deadline_us = HALF_HOUR_US;
    SCOPED_CLIENT *client = harness_connect_with(&options);
    for (size_t i = 0; i < sizeof jumps / sizeof *jumps; i++) {
        double qdd[RAW_DDS_JOINTS];
        struct timespec now;
        set_clock(&h, jumps[i].offset);
        assert_int_equal(ask_arm(client, 0.1 * (double)i, qdd, WAIT_NS), TFA_OK);
        clock_gettime(CLOCK_REALTIME, &now);
        s.stamp = INT64_C(1000000000) * now.tv_sec;
        s.deadline_us = HALF_HOUR_US;
        assert_int_equal(raw_dds_ask(&r, &s)->status, jumps[i].status);
        s.deadline_us = 0;
        const totalforce_dds_Reply *reply = raw_dds_ask(&r, &s);
        assert_int_equal(reply->status, TFA_OK);
        assert_true(reply->epoch == epoch);
    }
    assert_int_equal(harness_log_lines(&h, "leads, epoch"), 1);
    assert_int_equal(harness_log_lines(&h, "stood still"), 0);
}

int main(void)
{
    if (access(LIBRARY, R_OK) != 0) {
        fprintf(stderr, "dds_clock: skipped: no %s (tools/setup)\n", LIBRARY);
        return 77;
    }
    return test_run(NULL, NULL);
}
