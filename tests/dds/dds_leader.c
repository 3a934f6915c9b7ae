/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The leader of a robot over DDS: what it says of the robot, when it resigns, how it is found.
 */
#include "dds_gateway/dds_topics.h"
#include "dds_test.h"
#include "gateway_process.h"
#include "raw_dds.h"
#include "robots.h"

#include <pthread.h>
#include <string.h>

#define JOINTS RAW_DDS_JOINTS

/* Takes all that comes within the time. @return q_count of the last info about the arm; 0: none */
static uint32_t last_q_count(dds_entity_t reader, int timeout_ms, uint32_t awaited)
{
    uint32_t last = 0;
    static totalforce_dds_RobotInfo info;

    for (int i = 0; i < timeout_ms && last != awaited; i++)
        while (raw_dds_take(reader, &info, 1))
            if (strcmp(info.robot, "arm") == 0)
                last = info.q_count;
    return last;
}

/* A daemon that led on the other side of a partition is heard again, and so is what it said of the
 * robot: the leader has the last word. */
static void the_leader_describes_the_robot_again(void **state)
{
    test_daemon daemon = test_daemon_start(test_domain(), NULL);
    const raw_dds r = raw_dds_open(test_domain());
    const dds_entity_t leaders = tfa_dds_create_topic(r.participant, TFA_DDS_LEADER);
    const dds_entity_t infos = tfa_dds_create_topic(r.participant, TFA_DDS_ROBOT_INFO);
    const dds_entity_t leader = tfa_dds_create_leader_writer(r.participant, leaders, DDS_SECS(10));
    const dds_entity_t writer =
        tfa_dds_create_writer(r.participant, infos, TFA_DDS_ROBOT_INFO, NULL);
    const dds_entity_t reader =
        tfa_dds_create_reader(r.participant, infos, TFA_DDS_ROBOT_INFO, NULL);
    totalforce_dds_RobotInfo info = {.q_count = 99};
    totalforce_dds_Leader said = {.role = totalforce_dds_LEADER_STANDBY, .lease_ms = 1000};
    dds_guid_t guid;

    (void)state;
    raw_dds_await(&r, "arm", TFA_OK);
    assert_int_equal(last_q_count(reader, 10000, JOINTS), JOINTS);
    assert_true(tfa_dds_set_robot(info.robot, "arm") && tfa_dds_set_robot(said.robot, "arm"));
    assert_int_equal(dds_get_guid(r.participant, &guid), DDS_RETCODE_OK);
    memcpy(said.daemon, guid.v, sizeof said.daemon);
    for (int i = 0; i < 3; i++) { /* it comes; it goes without a word; it comes and leaves */
        assert_int_equal(dds_write(writer, &info), DDS_RETCODE_OK);
        assert_int_equal(last_q_count(reader, 10000, 99), 99);
        if (i % 2 == 0)
            assert_int_equal(dds_write(leader, &said), DDS_RETCODE_OK);
        assert_int_equal(last_q_count(reader, 10000, JOINTS), JOINTS);
    }
    assert_int_equal(dds_write(writer, &info), DDS_RETCODE_OK);
    assert_int_equal(dds_dispose(leader, &said), DDS_RETCODE_OK);
    assert_int_equal(last_q_count(reader, 10000, JOINTS), JOINTS);
    assert_int_equal(dds_delete(r.participant), DDS_RETCODE_OK);
    test_daemon_stop(&daemon);
}

/* Waits until the daemon's advertisement of the arm is disposed. */
static bool resigns(dds_entity_t reader)
{
    totalforce_dds_Leader said;
    dds_sample_info_t info;

    for (int i = 0; i < 5000; i++, dds_sleepfor(DDS_MSECS(1)))
        while (dds_take(reader, (void *[]){&said}, &info, 1, 1) == 1)
            if (strcmp(said.robot, "arm") == 0 &&
                info.instance_state == DDS_NOT_ALIVE_DISPOSED_INSTANCE_STATE)
                return true;
    return false;
}

/* A leader that lost its place at the worker in a reload lets another daemon lead, and is back
 * after the next. */
static void a_leader_that_cannot_answer_resigns(void **state)
{
    test_daemon daemon = test_daemon_start(test_domain(), NULL);
    const raw_dds r = raw_dds_open(test_domain());
    const dds_entity_t leaders = tfa_dds_create_topic(r.participant, TFA_DDS_LEADER);
    const dds_entity_t reader = tfa_dds_create_reader(r.participant, leaders, TFA_DDS_LEADER, NULL);
    totalforce_dds_Request s = raw_dds_request();
    static totalforce_dds_Reply reply;

    (void)state;
    raw_dds_await(&r, "arm", TFA_OK);
    assert_int_not_equal(test_daemon_reload(&daemon), TFA_OK);
    assert_true(resigns(reader));
    while (raw_dds_take(r.reader, &reply, 100)) /* late hellos */
        ;
    assert_int_equal(dds_write(r.writer, &s), DDS_RETCODE_OK);
    assert_false(raw_dds_take(r.reader, &reply, 300));
    assert_int_equal(test_daemon_reload(&daemon), TFA_OK);
    raw_dds_await(&r, "arm", TFA_OK);
    assert_int_equal(raw_dds_ask(&r, &s)->status, TFA_OK);
    assert_int_equal(dds_delete(r.participant), DDS_RETCODE_OK);
    test_daemon_stop(&daemon);
}

/* A daemon that was restarted is believed by those who drop older epochs. */
static void epochs_grow_over_restarts(void **state)
{
    const raw_dds r = raw_dds_open(test_domain());
    totalforce_dds_Request s = raw_dds_request();
    uint64_t last = 0;

    (void)state;
    for (int i = 0; i < 3; i++) {
        test_daemon daemon = test_daemon_start(test_domain(), NULL);
        raw_dds_await(&r, "arm", TFA_OK);
        const uint64_t epoch = raw_dds_ask(&r, &s)->epoch;
        assert_true(epoch > last);
        last = epoch;
        test_daemon_stop(&daemon);
    }
    assert_int_equal(dds_delete(r.participant), DDS_RETCODE_OK);
}

static void *connect_soon(void *client)
{
    *(tfa_dds_client **)client = raw_dds_connect(test_domain());
    return NULL;
}

/* Another daemon announces its robots before ours does: ours is waited for. */
static void a_daemon_that_starts_is_waited_for(void **state)
{
    const dds_entity_t p = dds_create_participant(test_domain(), NULL, NULL);
    const dds_entity_t topic = tfa_dds_create_topic(p, TFA_DDS_ROBOT_INFO);
    const dds_entity_t writer = tfa_dds_create_writer(p, topic, TFA_DDS_ROBOT_INFO, NULL);
    totalforce_dds_RobotInfo info = {.q_count = 1};
    tfa_dds_client *client = NULL;
    pthread_t thread;

    (void)state;
    assert_true(tfa_dds_set_robot(info.robot, "another"));
    assert_int_equal(dds_write(writer, &info), DDS_RETCODE_OK);
    assert_int_equal(pthread_create(&thread, NULL, connect_soon, &client), 0);
    dds_sleepfor(DDS_MSECS(1500));
    test_daemon daemon = test_daemon_start(test_domain(), NULL);
    assert_int_equal(pthread_join(thread, NULL), 0);
    assert_non_null(client);
    tfa_dds_client_close(client);
    assert_int_equal(dds_delete(p), DDS_RETCODE_OK);
    test_daemon_stop(&daemon);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_leader_describes_the_robot_again),
        cmocka_unit_test(a_leader_that_cannot_answer_resigns),
        cmocka_unit_test(epochs_grow_over_restarts),
        cmocka_unit_test(a_daemon_that_starts_is_waited_for),
    };

    test_daemon_main(argc, argv);
    return cmocka_run_group_tests(tests, NULL, NULL);
}
