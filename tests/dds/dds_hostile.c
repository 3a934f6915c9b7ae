/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The DDS gateway under clients that are wrong, hasty or dead: each request gets a reply that names
 * its fault, and nobody else notices.
 */
#include "dds/topics/dds_topics.h"
#include "dds_attacks.h"
#include "dds_test.h"
#include "gateway_process.h"
#include "models.h"
#include "raw_dds.h"
#include "robots.h"
#include "support/sanitized.h"
#include "test.h"

#include <math.h>
#include <pthread.h>
#include <signal.h>
#include <stdatomic.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <time.h>

#define JOINTS RAW_DDS_JOINTS

static void assert_refused(const raw_dds *r, totalforce_dds_Request *request, int status,
                           tfa_field field, uint32_t index)
{
    const totalforce_dds_Reply *reply = raw_dds_ask(r, request);
    assert_int_equal(reply->status, status);
    assert_int_equal(reply->field, field);
    assert_int_equal(reply->index, index);
    assert_int_equal(reply->qdd._length, 0);
    totalforce_dds_Request good = raw_dds_request();
    reply = raw_dds_ask(r, &good);
    assert_int_equal(reply->status, TFA_OK);
    assert_int_equal(reply->qdd._length, JOINTS);
}

/* A client stops in its tracks with replies unacknowledged: the others go on. */
TEST(a_stopped_client_holds_nobody_up)
{
    const tfa_request request = request_fd(raw_dds_zeros, NULL, NULL);
    const uint32_t domain = test_domain();
    double qdd[JOINTS];
    int ends[2], silent = 0;
    char one;
    assert_int_equal(pipe(ends), 0);
    const pid_t child = fork(); /* before this process joins the domain */
    if (child == 0) {
        tfa_dds_client *client;
        (void)prctl(PR_SET_PDEATHSIG, SIGKILL); /* a test that fails leaves it stopped */
        const tfa_dds_client_options options = {
            .domain = domain, .robot = "arm", .connect_timeout_ms = WAIT_MS};
        uint64_t id;
        if (tfa_dds_client_connect(&options, &client) == TFA_OK &&
            tfa_dds_client_send(client, &request, &id) == TFA_OK && write(ends[1], "r", 1) == 1)
            raise(SIGSTOP);
        _exit(0);
    }
    test_daemon daemon = test_daemon_start(domain, NULL);
    close(ends[1]); /* a child that fails is heard of */
    assert_int_equal(read(ends[0], &one, 1), 1);
    tfa_dds_client *client = dds_connect(domain, "arm");
    for (int answers = 0; answers < 2000;) {
        tfa_reply reply = {.qdd = qdd};
        const int status = tfa_dds_client_call(client, &request, &reply, WAIT_NS, NULL);
        if (status == TFA_E_DISCONNECTED) /* this process had no processor for five leases */
            assert_true(++silent < 10);
        else
            assert_int_equal(status, TFA_OK);
        answers += status == TFA_OK;
    }
    tfa_dds_client_close(client);
    kill(child, SIGKILL);
    assert_int_equal(waitpid(child, NULL, 0), child);
    close(ends[0]);
    assert_int_equal(test_daemon_stop(&daemon), 0);
}

TEST(wrong_samples_are_refused)
{
    SCOPED_DAEMON daemon = test_daemon_start(test_domain(), NULL);
    const SCOPED_RAW_DDS r = raw_dds_open(test_domain());
    const uint32_t many = 1000;
    double *huge = calloc(many, sizeof *huge);
    totalforce_dds_Request s;
    assert_non_null(huge);
    raw_dds_await(&r, "arm", TFA_OK);
#define REFUSED(change, status, field, index)                                                      \
    do {                                                                                           \
        s = raw_dds_request();                                                                     \
        change;                                                                                    \
        assert_refused(&r, &s, status, field, index);                                              \
    } while (0)
    REFUSED(s.q._length = 6, TFA_E_SIZE, TFA_FIELD_Q, 6);
    REFUSED(s.q._length = 0, TFA_E_ARGUMENT, TFA_FIELD_Q, 0);
    REFUSED(s.count = 0, TFA_E_SIZE, TFA_FIELD_COUNT, 0);
    REFUSED(s.count = TEST_BATCH + 1, TFA_E_SIZE, TFA_FIELD_COUNT, TEST_BATCH + 1);
    REFUSED(s.count = UINT32_MAX, TFA_E_SIZE, TFA_FIELD_COUNT, UINT32_MAX);
    REFUSED(s.op = 12345, TFA_E_ARGUMENT, TFA_FIELD_OP, 12345);
    REFUSED(s.method = 4000000000u, TFA_E_METHOD, TFA_FIELD_METHOD, 4000000000u);
    REFUSED((s.tau = (dds_sequence_double){many, many, huge, false}), TFA_E_SIZE, TFA_FIELD_TAU,
            many);
    REFUSED((s.base_pose = (dds_sequence_double){7, 7, raw_dds_zeros, false}), TFA_E_SIZE,
            TFA_FIELD_BASE_POSE, 7);
    double nan[JOINTS] = {0, 0, NAN};
    REFUSED(s.q._buffer = nan, TFA_E_VALUE, TFA_FIELD_Q, 2);
    uint32_t tips[TFA_MAX_TIPS + 1] = {0};
    REFUSED(
        (s.tips = (dds_sequence_unsigned_long){TFA_MAX_TIPS + 1, TFA_MAX_TIPS + 1, tips, false}),
        TFA_E_SIZE, TFA_FIELD_TIPS, TFA_MAX_TIPS + 1);
    tips[1] = 100;
    REFUSED((s.tips = (dds_sequence_unsigned_long){2, 2, tips, false}), TFA_E_LINK, TFA_FIELD_TIPS,
            1);
    REFUSED((s.payload_frames = (dds_sequence_unsigned_long){5, 5, tips, false}), TFA_E_SIZE,
            TFA_FIELD_PAYLOADS, 5);
    REFUSED((s.payload_frames = (dds_sequence_unsigned_long){1, 1, tips, false}), TFA_E_ARGUMENT,
            TFA_FIELD_PAYLOADS, 0);
    REFUSED((s.payloads = (dds_sequence_double){many, many, huge, false}), TFA_E_SIZE,
            TFA_FIELD_PAYLOADS, many);
    REFUSED((s.locked = (dds_sequence_unsigned_long){8, 8, tips, false}), TFA_E_SIZE,
            TFA_FIELD_LOCKED, 8);
    REFUSED((s.locked = (dds_sequence_unsigned_long){2, 2, tips, false}), TFA_E_JOINT,
            TFA_FIELD_LOCKED, 1);
    REFUSED((s.locked = (dds_sequence_unsigned_long){many, many, (uint32_t *)(void *)huge, false}),
            TFA_E_SIZE, TFA_FIELD_LOCKED, many);
    REFUSED((s.stamp = 1, s.deadline_us = 1), TFA_E_LATE, TFA_FIELD_NONE, 0);
#undef REFUSED
    free(huge);
}

/* Writes torques, which both sides lose until they have found each other. @return an answer came */
static bool stream(const raw_dds *r, const totalforce_dds_JointTorques *torques,
                   totalforce_dds_JointAccelerations *out)
{
    assert_int_equal(dds_write(r->torques, torques), DDS_RETCODE_OK);
    return raw_dds_take(r->accelerations, out);
}

/* A bad sample of torques is answered, too, by status and field. */
TEST(wrong_torques_are_refused)
{
    SCOPED_DAEMON daemon = test_daemon_start(test_domain(), NULL);
    const SCOPED_RAW_DDS r = raw_dds_open(test_domain());
    totalforce_dds_JointTorques s = {.seq = 5, .q = {3, 3, raw_dds_zeros, false}};
    totalforce_dds_JointAccelerations out = {0};
    assert_true(tfa_dds_set_robot(s.robot, "arm"));
    assert_true(WAIT_FOR(stream(&r, &s, &out)));
    assert_int_equal(out.status, TFA_E_SIZE);
    assert_int_equal(out.field, TFA_FIELD_Q);
    assert_int_equal(out.index, 3);
    assert_int_equal(out.seq, 5);
    assert_int_equal(out.qdd._length, 0);
}

/* One sample, old if its number is odd. @return an answer has come, and it is the right one */
static bool stream_young_or_old(const raw_dds *r, totalforce_dds_JointTorques *s,
                                totalforce_dds_JointAccelerations *out)
{
    s->seq++;
    s->stamp = tfa_dds_ros_time() - (s->seq % 2 ? 10 * (int64_t)WAIT_NS : 0);
    if (!stream(r, s, out) || out->status == TFA_E_AGAIN) /* faster than the daemon answers */
        return false;
    assert_int_equal(out->status, out->seq % 2 ? TFA_E_LATE : TFA_OK);
    return true;
}

/* Torques that are too old are refused by name, others answered. */
TEST(old_torques_are_refused)
{
    const test_daemon_options young = {.max_age_ms = WAIT_MS};
    SCOPED_DAEMON daemon = test_daemon_start(test_domain(), &young);
    const SCOPED_RAW_DDS r = raw_dds_open(test_domain());
    totalforce_dds_JointTorques s = {.q = {JOINTS, JOINTS, raw_dds_zeros, false}};
    totalforce_dds_JointAccelerations out = {0};
    assert_true(tfa_dds_set_robot(s.robot, "arm"));
    for (unsigned answers[2] = {0}; answers[0] < 10 || answers[1] < 10; answers[out.seq % 2]++)
        assert_true(WAIT_FOR(stream_young_or_old(&r, &s, &out)));
    totalforce_dds_JointAccelerations_free(&out, DDS_FREE_CONTENTS);
}

/* Nothing is taken of a sample that is larger than any the robots could mean. */
TEST(oversized_samples_are_dropped)
{
    SCOPED_DAEMON daemon = test_daemon_start(test_domain(), NULL);
    const SCOPED_RAW_DDS r = raw_dds_open(test_domain());
    const uint32_t many = 1000000;
    double *huge = calloc(many, sizeof *huge);
    totalforce_dds_Request s = raw_dds_request();
    assert_non_null(huge);
    raw_dds_await(&r, "arm", TFA_OK);
    s.tau = (dds_sequence_double){many, many, huge, false};
    for (int i = 0; i < 20; i++)
        raw_dds_ask_in_vain(&r, &s);
    s = raw_dds_request();
    assert_int_equal(raw_dds_ask(&r, &s)->status, TFA_OK);
    free(huge);
}

static long resident_kib(pid_t pid)
{
    char path[64];
    long pages = 0;
    snprintf(path, sizeof path, "/proc/%d/statm", (int)pid);
    FILE *in = fopen(path, "r");
    assert_non_null(in);
    assert_int_equal(fscanf(in, "%*d %ld", &pages), 1);
    fclose(in);
    return pages * (sysconf(_SC_PAGESIZE) / 1024);
}

/* Writes samples about robots that nobody knows, each with a name of its own. */
static void ask_about_strangers(const raw_dds *r, int count)
{
    totalforce_dds_Request good = raw_dds_request();
    static int next;
    for (int i = 0; i < count; i++, next++) {
        totalforce_dds_Request s = raw_dds_request();
        s.id = RAW_DDS_IN_VAIN;
        totalforce_dds_JointTorques t = {.q = {JOINTS, JOINTS, raw_dds_zeros, false}};
        char name[32];
        snprintf(name, sizeof name, "stranger%d", next);
        assert_true(tfa_dds_set_robot(s.robot, name) && tfa_dds_set_robot(t.robot, name));
        assert_int_equal(dds_write(r->writer, &s), DDS_RETCODE_OK);
        assert_int_equal(dds_write(r->torques, &t), DDS_RETCODE_OK);
        (void)dds_unregister_instance(r->torques, &t); /* not in our own memory, either */
        if (i % 64 == 0)
            assert_int_equal(raw_dds_ask(r, &good)->status, TFA_OK);
    }
}

/* Names that nobody knows do not make the daemon grow, and are not answered: the question may be
 * for another daemon. */
TEST(unknown_robots_leave_nothing)
{
    enum { NAMES = 8000 };
    SCOPED_DAEMON daemon = test_daemon_start(test_domain(), NULL);
    const SCOPED_RAW_DDS r = raw_dds_open(test_domain());
    totalforce_dds_Request s = raw_dds_request();
    raw_dds_await(&r, "arm", TFA_OK);
    ask_about_strangers(&r, NAMES);
    const long before = resident_kib(daemon.pid);
    ask_about_strangers(&r, 2 * NAMES);
    const long grown = resident_kib(daemon.pid) - before;
    print_message("%d names: %ld KiB\n", 2 * NAMES, grown);
#ifndef SANITIZED /* sanitizers keep memory that was freed */
    assert_true(grown < 4096);
#endif
    assert_int_equal(raw_dds_ask(&r, &s)->status, TFA_OK);
}

static void *forge(void *forger)
{
    const dds_entity_t p = dds_create_participant(test_domain(), NULL, NULL);
    dds_entity_t topics[TFA_DDS_REPLY + 1];
    for (tfa_dds_topic i = TFA_DDS_ROBOT_INFO; i <= TFA_DDS_REPLY; i++)
        topics[i] = tfa_dds_create_topic(p, i);
    dds_forge(p, topics, forger);
    (void)dds_delete(p);
    return NULL;
}

static void assert_not_believed(tfa_dds_client *client)
{
    const tfa_request request = request_fd(raw_dds_zeros, NULL, NULL);
    double qdd[JOINTS];
    tfa_reply reply = {.qdd = qdd};
    assert_int_equal(tfa_dds_client_call(client, &request, &reply, WAIT_NS, NULL), TFA_OK);
    assert_true(qdd[0] != DDS_LIE);
}

/* Replies of a participant that is not the daemon are not believed, nor is its word that the robot
 * is gone. */
TEST(forged_replies_are_dropped)
{
    SCOPED_DAEMON daemon = test_daemon_start(test_domain(), NULL);
    SCOPED_DDS_CLIENT *client = dds_connect(test_domain(), "arm");
    dds_forger f = {.forged = 0};
    pthread_t thread;
    assert_int_equal(pthread_create(&thread, NULL, forge, &f), 0);
    assert_true(WAIT_FOR((assert_not_believed(client), atomic_load(&f.forged) > 300)));
    atomic_store(&f.stop, true);
    pthread_join(thread, NULL);
}

/* Claims to lead, each in the name of a daemon that does not exist: nobody yields, they do not make
 * the daemon grow, and it still hears a daemon that speaks for itself. */
TEST(forged_advertisements_are_dropped)
{
    enum { NAMES = 8000 };
    SCOPED_DAEMON daemon = test_daemon_start(test_domain(), NULL);
    const SCOPED_RAW_DDS r = raw_dds_open(test_domain());
    const dds_entity_t topic = tfa_dds_create_topic(r.participant, TFA_DDS_LEADER);
    const dds_entity_t writer = tfa_dds_create_leader_writer(r.participant, topic, DDS_INFINITY);
    const dds_entity_t infos = tfa_dds_create_topic(r.participant, TFA_DDS_ROBOT_INFO);
    const dds_entity_t reader =
        tfa_dds_create_reader(r.participant, infos, TFA_DDS_ROBOT_INFO, NULL);
    static totalforce_dds_RobotInfo arm;
    totalforce_dds_Leader claim = {.epoch = UINT64_C(1) << 61,
                                   .priority = 1000,
                                   .role = totalforce_dds_LEADER_LEADING,
                                   .lease_ms = 10 * WAIT_MS};
    totalforce_dds_Request s = raw_dds_request();
    dds_guid_t guid;
    assert_true(topic > 0 && writer > 0 && reader > 0);
    assert_true(tfa_dds_set_robot(claim.robot, "arm"));
    raw_dds_await(&r, "arm", TFA_OK);
    const uint64_t epoch = raw_dds_ask(&r, &s)->epoch;
    const long before = resident_kib(daemon.pid);
    for (uint32_t i = 0; i < NAMES; i++) {
        memcpy(claim.daemon, &i, sizeof i);
        assert_int_equal(dds_write(writer, &claim), DDS_RETCODE_OK);
        if (i % 64 == 0)
            assert_int_equal(raw_dds_ask(&r, &s)->status, TFA_OK);
    }
    assert_true(raw_dds_ask(&r, &s)->epoch == epoch);
    const long grown = resident_kib(daemon.pid) - before;
    print_message("%d claims: %ld KiB\n", NAMES, grown);
#ifndef SANITIZED /* sanitizers keep memory that was freed */
    assert_true(grown < 8192);
#endif
    assert_int_equal(dds_get_guid(r.participant, &guid), DDS_RETCODE_OK);
    memcpy(claim.daemon, guid.v, sizeof claim.daemon);
    assert_true(WAIT_FOR(raw_dds_take_info(reader, &arm, false)));
    memcpy(claim.model_hash, arm.model_hash, sizeof claim.model_hash);
    assert_int_equal(dds_write(writer, &claim), DDS_RETCODE_OK);
    assert_true(WAIT_FOR(raw_dds_take_info(reader, &arm, true))); /* it stands by */
    raw_dds_ask_in_vain(&r, &s);
    assert_int_equal(dds_dispose(writer, &claim), DDS_RETCODE_OK);
    raw_dds_await(&r, "arm", TFA_OK); /* it leads again */
}

int main(int argc, char **argv)
{
    test_daemon_main(argc, argv);
    return test_run(NULL, NULL);
}
