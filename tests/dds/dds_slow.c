/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Requests over DDS that take long, come in bursts or come too late.
 */
#include "dds/topics/dds_topics.h"
#include "dds_test.h"
#include "gateway_process.h"
#include "models.h"
#include "raw_dds.h"
#include "robots.h"
#include "test.h"

#define JOINTS RAW_DDS_JOINTS

#define LONG_US 1000 /* the receiving thread answers what is shorter by far */

/* Requests that take long are answered by the worker, in order; more of them than slots are refused
 * at once, and their refusals overtake. */
TEST(slow_answers_come_in_order)
{
    enum { SLOTS = 8, SENT = 12 };
    const test_daemon_options slow = {.delay_us = LONG_US, .slots = SLOTS};
    SCOPED_DAEMON daemon = test_daemon_start(test_domain(), &slow);
    SCOPED_DDS_CLIENT *client = dds_connect(test_domain(), "arm");
    const tfa_request request = request_fd(raw_dds_zeros, NULL, NULL);
    uint64_t ids[SENT];
    double qdd[JOINTS];
    tfa_reply first = {.qdd = qdd}; /* answered in the receiving thread, which learns its cost */
    assert_int_equal(tfa_dds_client_call(client, &request, &first, WAIT_NS, NULL), TFA_OK);
    const unsigned long refused = test_daemon_hold(&daemon, true) + SENT - SLOTS;
    for (int i = 0; i < SENT; i++)
        assert_int_equal(tfa_dds_client_send(client, &request, &ids[i]), TFA_OK);
    assert_true(WAIT_FOR(test_daemon_hold(&daemon, true) == refused));
    test_daemon_hold(&daemon, false);
    for (int i = 0; i < SENT; i++) {
        tfa_reply reply = {.qdd = qdd};
        tfa_exchange times;
        const int status = tfa_dds_client_receive(client, &reply, WAIT_NS, &times);
        assert_int_equal(status, i < SLOTS ? TFA_OK : TFA_E_AGAIN);
        assert_int_equal(times.id, ids[i]);
    }
}

/* A client asks for one kind of long request after the other, each for the first time: nobody's
 * requests wait for them in the receiving thread. */
TEST(long_kinds_go_to_the_worker)
{
    enum { KINDS = 300, TIPS = TFA_DEFAULT_TIPS };
    test_daemon daemon = test_daemon_start(test_domain(), NULL);
    const raw_dds r = raw_dds_open(test_domain());
    uint32_t tips[TIPS] = {0, 1, 2, 3, 4, 5, 6, 7};
    totalforce_dds_Request s = raw_dds_request();
    raw_dds_await(&r, "arm", TFA_OK);
    s.op = TFA_OP_OPERATIONAL_INERTIA;
    s.tips = (dds_sequence_unsigned_long){TIPS, TIPS, tips, false};
    for (uint32_t i = 0; i < KINDS; i++) {
        s.flags = TFA_WANT_LAMBDA | i;
        assert_int_equal(raw_dds_ask(&r, &s)->status, TFA_OK);
    }
    assert_int_equal(dds_delete(r.participant), DDS_RETCODE_OK);
    test_daemon_stop(&daemon);
    print_message("%d long requests, %lu handed over\n", KINDS, daemon.handovers);
    assert_true(daemon.handovers >= KINDS);
}

/* The daemon forgets that a stream is long, as it does when its samples turn out to be short, while
 * one of them is at the worker: the next does not overtake. */
TEST(streams_stay_in_order)
{
    enum { KINDS = 1024 }; /* of requests: many times the rows of the cost model */
    const test_daemon_options slow = {.delay_us = 100};
    SCOPED_DAEMON daemon = test_daemon_start(test_domain(), &slow);
    SCOPED_DDS_CLIENT *client = dds_connect(test_domain(), "arm");
    double qdd[JOINTS];
    tfa_dds_torques torques = {.seq = 1, .q = raw_dds_zeros};
    tfa_dds_accelerations got = {.qdd = qdd};
    assert_int_equal(tfa_dds_stream_open(client, WAIT_MS), TFA_OK);
    assert_int_equal(tfa_dds_stream_publish(client, &torques), TFA_OK);
    assert_int_equal(tfa_dds_stream_take(client, &got, WAIT_NS), TFA_OK);
    test_daemon_hold(&daemon, true);
    torques.seq = 2;
    assert_int_equal(tfa_dds_stream_publish(client, &torques), TFA_OK);
    for (uint32_t i = 0; i < KINDS; i++) {
        const tfa_request request = {.op = TFA_OP_INVERSE_DYNAMICS,
                                     .refine = TFA_REFINE_DEFAULT,
                                     .flags = i & TFA_WANT_ALL,
                                     .count = 1,
                                     .q = raw_dds_zeros};
        double answer[JOINTS * JOINTS * 6];
        tfa_reply reply = {.tau = answer};
        (void)!tfa_dds_client_call(client, &request, &reply, WAIT_NS, NULL);
    }
    torques.seq = 3;
    assert_int_equal(tfa_dds_stream_publish(client, &torques), TFA_OK);
    sleep_ms(50);
    test_daemon_hold(&daemon, false);
    for (uint64_t seq = 2; seq <= 3; seq++) {
        assert_int_equal(tfa_dds_stream_take(client, &got, WAIT_NS), TFA_OK);
        assert_int_equal(got.seq, seq);
    }
}

/* Bursts of large replies, 3 kB each: as many as a client may have under way, none is lost. */
TEST(bursts_are_not_lost)
{
    static double answer[TEST_BATCH * JOINTS * JOINTS];
    const test_daemon_options roomy = {.slots = 64};
    test_daemon daemon = test_daemon_start(test_domain(), &roomy);
    SCOPED_DDS_CLIENT *client = dds_connect(test_domain(), "arm");
    const tfa_request request = {.op = TFA_OP_MASS_MATRIX,
                                 .refine = TFA_REFINE_DEFAULT,
                                 .count = TEST_BATCH,
                                 .q = raw_dds_zeros};
    uint64_t id;
    for (int round = 0; round < 20; round++) {
        for (int i = 0; i < 64; i++)
            assert_int_equal(tfa_dds_client_send(client, &request, &id), TFA_OK);
        assert_int_equal(tfa_dds_client_send(client, &request, &id), TFA_E_AGAIN);
        for (int i = 0; i < 64; i++) {
            tfa_reply reply = {.mass_matrix = answer};
            assert_int_equal(tfa_dds_client_receive(client, &reply, WAIT_NS, NULL), TFA_OK);
        }
    }
    assert_int_equal(test_daemon_stop(&daemon), 0);
}

/* A call that times out is forgotten; its late reply is not taken for the next one's. */
TEST(late_replies_are_dropped)
{
    const test_daemon_options slow = {.delay_us = LONG_US};
    SCOPED_DAEMON daemon = test_daemon_start(test_domain(), &slow);
    SCOPED_DDS_CLIENT *client = dds_connect(test_domain(), "arm");
    double q[JOINTS] = {0}, first[JOINTS], second[JOINTS];
    const tfa_request request = request_fd(q, NULL, NULL);
    tfa_reply reply = {.qdd = first};
    assert_int_equal(tfa_dds_client_call(client, &request, &reply, WAIT_NS, NULL), TFA_OK);
    q[1] = 1;
    test_daemon_hold(&daemon, true);
    assert_int_equal(tfa_dds_client_call(client, &request, &reply, 1000000, NULL), TFA_E_TIMEOUT);
    test_daemon_hold(&daemon, false);
    q[1] = 0;
    reply.qdd = second;
    assert_int_equal(tfa_dds_client_call(client, &request, &reply, WAIT_NS, NULL), TFA_OK);
    assert_memory_equal(first, second, sizeof first);
}

int main(int argc, char **argv)
{
    test_daemon_main(argc, argv);
    return test_run(NULL, NULL);
}
