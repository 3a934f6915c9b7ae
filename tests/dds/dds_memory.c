/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Memory of totalforced with DDS: a robot that nobody asks much of takes little, and large replies
 * are answered all the same.
 */
#include "dds_test.h"

#include "harness.h"
#include "herald.h"
#include "models.h"

#include <signal.h>

#define FEW 2
#define MANY 18
#define ROBOT_KIB 8192 /* two workspaces of 2 MiB, and little else */
#define BATCH 64       /* the default max_batch */
#define JOINTS 7

static harness serve(uint32_t robots)
{
    char yaml[96 * MANY];
    int at = snprintf(yaml, sizeof yaml, ARM);
    for (uint32_t i = 1; i < robots; i++)
        at += snprintf(yaml + at, sizeof yaml - (size_t)at,
                       "  - name: arm%u\n    urdf: @/config/robots/arm7.urdf\n", i);
    const harness h = harness_serve(yaml, dds_yaml(test_domain(), TEST_LEASE_MS));
    assert_true(harness_logged(&h, "ready:"));
    return h;
}

static void stop(harness *h)
{
    assert_int_equal(harness_stop(h, SIGTERM), 0);
    harness_remove(h);
}

TEST(a_robot_takes_little)
{
    long kib[2];
    for (int i = 0; i < 2; i++) {
        harness h = serve(i ? MANY : FEW);
        kib[i] = harness_resident_kib(&h);
        stop(&h);
    }
    const long robot = (kib[1] - kib[0]) / (MANY - FEW);
    print_message("%d robots %ld KiB, %d robots %ld KiB: %ld KiB a robot\n", FEW, kib[0], MANY,
                  kib[1], robot);
    assert_true(robot < ROBOT_KIB);
}

/* The same requests again need no more memory, and large ones between small ones are answered. */
TEST(large_replies_are_answered)
{
    enum { WARM = 200, ASKED = 2000 };
    static double q[BATCH * JOINTS], answer[BATCH * JOINTS * JOINTS * 2];
    harness h = serve(1);
    dds_herald(test_domain(), "arm");
    SCOPED_DDS_CLIENT *client = dds_connect(test_domain(), "arm");
    long warm = 0;
    for (int i = 0; i < ASKED; i++) {
        const tfa_request request = {.op = TFA_OP_MASS_MATRIX,
                                     .refine = TFA_REFINE_DEFAULT,
                                     .count = i % 3 ? 1 : BATCH,
                                     .q = q};
        tfa_reply reply = {.mass_matrix = answer};
        assert_int_equal(tfa_dds_client_call(client, &request, &reply, WAIT_NS, NULL), TFA_OK);
        warm = i == WARM ? harness_resident_kib(&h) : warm;
    }
    const long grown = harness_resident_kib(&h) - warm;
    print_message("%d requests: %+ld KiB\n", ASKED - WARM, grown);
    assert_true(grown < ROBOT_KIB);
    stop(&h);
}

int main(void)
{
    return test_run(NULL, NULL);
}
