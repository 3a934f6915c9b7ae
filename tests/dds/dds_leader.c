/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The leader of a robot over DDS: what it says of the robot, when it resigns, how it is found.
 */
#include "dds/topics/dds_topics.h"
#include "dds_test.h"
#include "gateway_process.h"
#include "herald.h"
#include "raw_dds.h"
#include "robots.h"
#include "test.h"

#include <pthread.h>
#include <string.h>

#define JOINTS RAW_DDS_JOINTS

static uint32_t last_described; /* joints of the arm in the last info that was read */

/* What has come: the last info about the arm is this one. */
static bool is_described(dds_entity_t reader, uint32_t q_count)
{
    static totalforce_dds_RobotInfo info;
    while (raw_dds_take(reader, &info))
        if (strcmp(info.robot, "arm") == 0)
            last_described = info.q_count;
    return last_described == q_count;
}

typedef struct other_daemon {
    dds_entity_t leader, writer, reader;
    totalforce_dds_RobotInfo info;
    totalforce_dds_Leader said;
} other_daemon;

static other_daemon make_other_daemon(const raw_dds *r)
{
    const dds_entity_t p = r->participant;
    const dds_entity_t leaders = tfa_dds_create_topic(p, TFA_DDS_LEADER);
    const dds_entity_t infos = tfa_dds_create_topic(p, TFA_DDS_ROBOT_INFO);
    dds_guid_t guid;
    last_described = 0; /* by another test's reader */
    other_daemon o = {
        .leader = tfa_dds_create_leader_writer(p, leaders, DDS_INFINITY),
        .writer = tfa_dds_create_writer(p, infos, TFA_DDS_ROBOT_INFO, NULL),
        .reader = tfa_dds_create_reader(p, infos, TFA_DDS_ROBOT_INFO, NULL),
        .info = {.q_count = 99},
        .said = {.role = totalforce_dds_LEADER_STANDBY, .lease_ms = 10 * WAIT_MS},
    };
    assert_true(tfa_dds_set_robot(o.info.robot, "arm") && tfa_dds_set_robot(o.said.robot, "arm"));
    assert_int_equal(dds_get_guid(p, &guid), DDS_RETCODE_OK);
    memcpy(o.said.daemon, guid.v, sizeof o.said.daemon);
    return o;
}

/* It has the last word. */
static void describe_wrong(const other_daemon *o)
{
    assert_int_equal(dds_write(o->writer, &o->info), DDS_RETCODE_OK);
    assert_true(WAIT_FOR(is_described(o->reader, 99)));
}

static void come(const other_daemon *o)
{
    describe_wrong(o);
    assert_int_equal(dds_write(o->leader, &o->said), DDS_RETCODE_OK);
    assert_true(WAIT_FOR(is_described(o->reader, JOINTS)));
}

/* Its lease runs out when it has had the last word; otherwise another attempt follows. */
static bool go_without_a_word(other_daemon *o)
{
    o->said.lease_ms = TEST_LEASE_MS / 2;
    assert_int_equal(dds_write(o->leader, &o->said), DDS_RETCODE_OK);
    describe_wrong(o);
    const uint64_t end = now_ns() + 3 * UINT64_C(1000000) * TEST_LEASE_MS;
    while (!is_described(o->reader, JOINTS) && now_ns() < end)
        sleep_ms(1);
    o->said.lease_ms = 10 * WAIT_MS;
    return is_described(o->reader, JOINTS);
}

/* A daemon that led on the other side of a partition is heard again, and so is what it said of the
 * robot: the leader has the last word. */
TEST(the_leader_describes_the_robot_again)
{
    SCOPED_DAEMON daemon = test_daemon_start(test_domain(), NULL);
    const SCOPED_RAW_DDS r = raw_dds_open(test_domain());
    other_daemon o = make_other_daemon(&r);
    raw_dds_await(&r, "arm", TFA_OK);
    assert_true(WAIT_FOR(is_described(o.reader, JOINTS)));
    come(&o);
    assert_true(WAIT_FOR(go_without_a_word(&o)));
    come(&o);
    describe_wrong(&o);
    assert_int_equal(dds_dispose(o.leader, &o.said), DDS_RETCODE_OK);
    assert_true(WAIT_FOR(is_described(o.reader, JOINTS)));
}

/* The daemon's advertisement of the arm is disposed. */
static bool has_resigned(dds_entity_t reader)
{
    totalforce_dds_Leader said;
    dds_sample_info_t info;
    while (dds_take(reader, (void *[]){&said}, &info, 1, 1) == 1)
        if (strcmp(said.robot, "arm") == 0 &&
            info.instance_state == DDS_NOT_ALIVE_DISPOSED_INSTANCE_STATE)
            return true;
    return false;
}

static bool is_matched(dds_entity_t reader)
{
    dds_subscription_matched_status_t status;
    assert_int_equal(dds_get_subscription_matched_status(reader, &status), DDS_RETCODE_OK);
    return status.current_count > 0;
}

/* A leader that lost its place at the worker in a reload lets another daemon lead, and is back
 * after the next. */
TEST(a_leader_that_cannot_answer_resigns)
{
    SCOPED_DAEMON daemon = test_daemon_start(test_domain(), NULL);
    const SCOPED_RAW_DDS r = raw_dds_open(test_domain());
    const dds_entity_t leaders = tfa_dds_create_topic(r.participant, TFA_DDS_LEADER);
    const dds_entity_t reader = tfa_dds_create_reader(r.participant, leaders, TFA_DDS_LEADER, NULL);
    totalforce_dds_Request s = raw_dds_request();
    raw_dds_await(&r, "arm", TFA_OK);
    assert_true(WAIT_FOR(is_matched(reader))); /* best effort */
    assert_int_not_equal(test_daemon_reload(&daemon), TFA_OK);
    assert_true(WAIT_FOR(has_resigned(reader)));
    raw_dds_ask_in_vain(&r, &s);
    assert_int_equal(test_daemon_reload(&daemon), TFA_OK);
    dds_herald(test_domain(), "arm");
    raw_dds_await(&r, "arm", TFA_OK);
    assert_int_equal(raw_dds_ask(&r, &s)->status, TFA_OK);
}

/* A stranger with another model claims the lead for an hour and is gone without a word: the daemon
 * yields, leads again when Cyclone has noticed, and answers. */
TEST(a_leader_that_vanishes_is_forgotten)
{
    static totalforce_dds_RobotInfo arm;
    SCOPED_DAEMON daemon = test_daemon_start(test_domain(), NULL);
    const SCOPED_RAW_DDS r = raw_dds_open(test_domain());
    totalforce_dds_Request s = raw_dds_request();
    raw_dds_await(&r, "arm", TFA_OK);
    const SCOPED_RAW_DDS stranger = raw_dds_open(test_domain());
    other_daemon o = make_other_daemon(&stranger);
    assert_true(WAIT_FOR(is_described(o.reader, JOINTS)));
    o.said.role = totalforce_dds_LEADER_LEADING;
    o.said.lease_ms = 3600000;
    o.said.epoch = raw_dds_ask(&r, &s)->epoch + 1000;
    assert_true(WAIT_FOR(
        (dds_write(o.leader, &o.said), sleep_ms(20), raw_dds_take_info(o.reader, &arm, true))));
    raw_dds_ask_in_vain(&r, &s);
    assert_int_equal(dds_delete(o.leader), DDS_RETCODE_OK);
    raw_dds_await(&r, "arm", TFA_OK);
    assert_true(raw_dds_ask(&r, &s)->epoch > o.said.epoch);
}

/* A daemon that was restarted is believed by those who drop older epochs. */
TEST(epochs_grow_over_restarts)
{
    const SCOPED_RAW_DDS r = raw_dds_open(test_domain());
    totalforce_dds_Request s = raw_dds_request();
    uint64_t last = 0;
    for (int i = 0; i < 3; i++) {
        SCOPED_DAEMON daemon = test_daemon_start(test_domain(), NULL);
        raw_dds_await(&r, "arm", TFA_OK);
        const uint64_t epoch = raw_dds_ask(&r, &s)->epoch;
        assert_true(epoch > last);
        last = epoch;
    }
}

/* A reader has it. */
static bool is_read(dds_entity_t writer)
{
    dds_publication_matched_status_t status;
    assert_int_equal(dds_get_publication_matched_status(writer, &status), DDS_RETCODE_OK);
    return status.current_count > 0 && dds_wait_for_acks(writer, DDS_MSECS(1)) == DDS_RETCODE_OK;
}

static void *connect_soon(void *client)
{
    *(tfa_dds_client **)client = dds_connect(test_domain(), "arm");
    return NULL;
}

/* Another daemon announces its robots before ours does: ours is waited for. */
TEST(a_daemon_that_starts_is_waited_for)
{
    const dds_entity_t p = dds_create_participant(test_domain(), NULL, NULL);
    const dds_entity_t topic = tfa_dds_create_topic(p, TFA_DDS_ROBOT_INFO);
    const dds_entity_t writer = tfa_dds_create_writer(p, topic, TFA_DDS_ROBOT_INFO, NULL);
    totalforce_dds_RobotInfo info = {.q_count = 1};
    tfa_dds_client *client = NULL;
    pthread_t thread;
    assert_true(tfa_dds_set_robot(info.robot, "another"));
    assert_int_equal(dds_write(writer, &info), DDS_RETCODE_OK);
    assert_int_equal(pthread_create(&thread, NULL, connect_soon, &client), 0);
    assert_true(WAIT_FOR(is_read(writer)));
    SCOPED_DAEMON daemon = test_daemon_start(test_domain(), NULL);
    assert_int_equal(pthread_join(thread, NULL), 0);
    assert_non_null(client);
    tfa_dds_client_close(client);
    assert_int_equal(dds_delete(p), DDS_RETCODE_OK);
}

int main(int argc, char **argv)
{
    test_daemon_main(argc, argv);
    return test_run(NULL, NULL);
}
