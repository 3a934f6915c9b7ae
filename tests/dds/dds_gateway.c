/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The DDS gateway in a process of its own, or the whole daemon, asked over the loopback interface:
 * the same bits as tfa_compute in process, for every op, and the same statuses.
 */
#include "dds_client/dds_client.h"
#include "dds_test.h"
#include "gateway_process.h"
#include "herald.h"
#include "models.h"
#include "robots.h"
#include "support/any_request.h"
#include "test.h"

#include <math.h>
#include <string.h>

#define JOINTS_MAX 20

static test_robot robots[TEST_ROBOTS];

/* Forward dynamics of one state, another for each `k`. */
static tfa_request forward_dynamics(int robot, size_t k)
{
    const bool base = tfa_model_base_freedoms(robots[robot].model) > 0;
    return (tfa_request){
        .op = TFA_OP_FORWARD_DYNAMICS,
        .estimate = TFA_ESTIMATE_NEVER, /* the daemon has a default of its own */
        .refine = TFA_REFINE_DEFAULT,
        .count = 1,
        .q = any_numbers[0] + k,
        .v = any_numbers[1] + k,
        .tau = any_numbers[2] + k,
        .base_pose = base ? any_pose : NULL,
        .base_twist = base ? any_numbers[4] + k : NULL,
        .base_wrench = base ? any_numbers[5] + k : NULL,
    };
}

/* One for each robot that most tests share: it takes a while until a client hears of the leader. */
static tfa_dds_client *clients[TEST_ROBOTS];

static tfa_dds_client *client_of(int robot)
{
    if (clients[robot] == NULL)
        clients[robot] = dds_connect(test_domain(), robots[robot].name);
    return clients[robot];
}

static int call(void *client, const tfa_request *request, tfa_reply *reply, uint64_t timeout_ns,
                tfa_exchange *times)
{
    return tfa_dds_client_call(client, request, reply, timeout_ns, times);
}

static any_client any_client_of(int robot, tfa_workspace *library)
{
    tfa_dds_client *client = client_of(robot);
    return (any_client){
        robots[robot].name, call, client, tfa_dds_client_get_info(client), library, true};
}

static int start(void **state)
{
    static test_daemon daemon;
    daemon = test_daemon_start(test_domain(), NULL);
    *state = &daemon;
    return 0;
}

static int stop(void **state)
{
    test_daemon *daemon = *state;
    if (daemon->pid > 0)
        test_daemon_stop(daemon);
    return 0;
}

/* What tfa_compute refuses, the gateway refuses with the same field. */
TEST(every_request_has_the_answer_of_the_library)
{
    for (int r = 0; r < TEST_ROBOTS; r++) {
        SCOPED_WORKSPACE *library = workspace_for(robots[r].model, NULL);
        const any_client c = any_client_of(r, library);
        any_check_info(c.info, robots[r].model);
        assert_int_equal(c.info->max_batch, TEST_BATCH);
        any_compare_all(&c, 7);
        any_compare_mistakes(&c);
        tfa_request r9 = forward_dynamics(r, 0);
        tfa_reply none = {0};
        r9.count = TEST_BATCH + 1;
        assert_int_equal(tfa_dds_client_call(c.client, &r9, &none, WAIT_NS, NULL), TFA_E_SIZE);
    }
}

TEST(many_clients_get_their_own_replies)
{
    enum { CLIENTS = 4, ROUNDS = 50 };
    tfa_dds_client *others[CLIENTS];
    double here[JOINTS_MAX], there[JOINTS_MAX];
    SCOPED_WORKSPACE *workspace = workspace_for(robots[0].model, NULL);
    for (uint32_t c = 0; c < CLIENTS; c++)
        others[c] = dds_connect(test_domain(), "arm");
    for (int round = 0; round < ROUNDS; round++) {
        for (uint32_t c = 0; c < CLIENTS; c++) {
            const tfa_request request = forward_dynamics(0, c);
            uint64_t id;
            assert_int_equal(tfa_dds_client_send(others[c], &request, &id), TFA_OK);
        }
        for (uint32_t c = 0; c < CLIENTS; c++) {
            const tfa_request request = forward_dynamics(0, c);
            tfa_reply a = {.qdd = there}, b = {.qdd = here};
            assert_int_equal(tfa_compute(workspace, &request, &b), TFA_OK);
            assert_int_equal(tfa_dds_client_receive(others[c], &a, WAIT_NS, NULL), TFA_OK);
            assert_memory_equal(here, there, 7 * sizeof *here);
        }
    }
    for (uint32_t c = 0; c < CLIENTS; c++)
        tfa_dds_client_close(others[c]);
}

/* 1000 samples of torques come back as accelerations with their seq and stamp. */
TEST(streams_echo)
{
    tfa_dds_client *client = client_of(1);
    double qdd[JOINTS_MAX], base[6], here[JOINTS_MAX], here_base[6], tau[2 * JOINTS_MAX] = {0};
    tfa_dds_accelerations got = {.qdd = qdd, .base_acceleration = base};
    SCOPED_WORKSPACE *workspace = workspace_for(robots[1].model, NULL);
    assert_int_equal(tfa_dds_stream_open(client, WAIT_MS), TFA_OK);
    for (uint32_t k = 0; k < 1000; k++) {
        const tfa_request r = forward_dynamics(1, k);
        const tfa_dds_torques torques = {.seq = 7000u + k,
                                         .stamp = 1000 + (int64_t)k,
                                         .q = r.q,
                                         .v = r.v,
                                         .tau = r.tau,
                                         .base_pose = r.base_pose,
                                         .base_twist = r.base_twist,
                                         .base_wrench = r.base_wrench};
        tfa_answer answer;
        tfa_reply b = {.qdd = here, .base_acceleration = here_base, .answers = &answer};
        assert_int_equal(tfa_compute(workspace, &r, &b), TFA_OK);
        assert_int_equal(tfa_dds_stream_publish(client, &torques), TFA_OK);
        assert_int_equal(tfa_dds_stream_take(client, &got, WAIT_NS), TFA_OK);
        assert_int_equal(got.status, TFA_OK);
        assert_int_equal(got.seq, torques.seq);
        assert_int_equal(got.stamp, torques.stamp);
        assert_int_equal(got.answer.method, answer.method);
        assert_memory_equal(qdd, here, tfa_model_v_count(robots[1].model) * sizeof(double));
        assert_memory_equal(base, here_base, sizeof base);
    }
    tau[2] = NAN;
    const tfa_dds_torques bad = {
        .seq = 1, .q = tau + JOINTS_MAX, .tau = tau, .base_pose = any_pose};
    assert_int_equal(tfa_dds_stream_publish(client, &bad), TFA_OK);
    assert_int_equal(tfa_dds_stream_take(client, &got, WAIT_NS), TFA_OK);
    assert_int_equal(got.status, TFA_E_VALUE);
    assert_int_equal(got.field, TFA_FIELD_TAU);
    assert_int_equal(got.index, 2);
}

/* By the name; until other robots are found it may be that nobody is there. */
static bool is_refused(const char *robot)
{
    const tfa_dds_client_options options = {
        .domain = test_domain(), .robot = robot, .connect_timeout_ms = 1000};
    tfa_dds_client *client;
    const int status = tfa_dds_client_connect(&options, &client);
    assert_true(status == TFA_E_ROBOT || status == TFA_E_TIMEOUT);
    assert_null(client);
    return status == TFA_E_ROBOT;
}

/* "hidden" is a robot of the daemon, but not for DDS. */
TEST(unknown_robots_are_refused)
{
    assert_true(WAIT_FOR(is_refused("nobody")));
    assert_true(WAIT_FOR(is_refused("hidden")));
}

/* The daemon ends well: its clients hear of it at once, and go on when it is back. */
TEST(a_restart_is_survived)
{
    double qdd[JOINTS_MAX];
    test_daemon *daemon = *state;
    tfa_dds_client *client = client_of(0);
    const tfa_request request = forward_dynamics(0, 0);
    tfa_reply reply = {.qdd = qdd};
    SCOPED_WORKSPACE *library = workspace_for(robots[0].model, NULL);
    test_daemon_stop(daemon);
    assert_int_equal(tfa_dds_client_call(client, &request, &reply, WAIT_NS, NULL),
                     TFA_E_DISCONNECTED);
    *daemon = test_daemon_start(test_domain(), NULL);
    /* A request of a moment in which only one side has found the other is lost. */
    assert_true(
        WAIT_FOR(tfa_dds_client_call(client, &request, &reply, 1000000000, NULL) == TFA_OK));
    const any_client c = any_client_of(0, library);
    assert_int_equal(any_compare(&c, &request), TFA_OK);
}

TEST(nobody_is_found_in_an_empty_domain)
{
    const tfa_dds_client_options options = {
        .domain = TEST_EMPTY_DOMAIN, .robot = "arm", .connect_timeout_ms = 300};
    tfa_dds_client *client;
    assert_int_equal(tfa_dds_client_connect(&options, &client), TFA_E_TIMEOUT);
    assert_null(client);
}

int main(int argc, char **argv)
{
    test_daemon_main(argc, argv);
    test_robots_make(robots);
    const int failures = test_run(start, stop);
    for (int r = 0; r < TEST_ROBOTS; r++)
        tfa_dds_client_close(clients[r]);
    for (int r = 0; r < TEST_ROBOTS; r++)
        tfa_model_free(robots[r].model);
    return failures;
}
