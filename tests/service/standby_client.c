/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Clients over shared memory that have a second daemon on the host: they turn to it by themselves.
 */
#include "harness.h"
#include "test.h"

#include <signal.h>

#define CALLS 50

static harness first, second;

static int start_both(void **state)
{
    (void)state;
    harness_serve(&first, ARM, "");
    harness_serve(&second, ARM, "");
    return 0;
}

static int remove_both(void **state)
{
    (void)state;
    harness_remove(&first);
    harness_remove(&second);
    return 0;
}

static tfa_client *connect_with_standby(void)
{
    tfa_client_options options = harness_options(&first, "arm");
    tfa_client *client;

    options.standby_dir = second.runtime_dir;
    assert_int_equal(tfa_client_connect(&options, &client), TFA_OK);
    return client;
}

static void assert_calls_are_answered(tfa_client *client, const harness *by)
{
    double expected[7], qdd[7];

    assert_int_equal(ask_arm(client, 0.2, expected, WAIT_NS), TFA_OK);
    for (int i = 0; i < CALLS; i++) {
        assert_int_equal(ask_arm(client, 0.2, qdd, WAIT_NS), TFA_OK);
        assert_memory_equal(qdd, expected, sizeof qdd);
    }
    assert_int_equal(tfa_client_get_info(client)->daemon_pid, by->pid);
}

/* There and back: not one call fails, and nobody goes back before it must. */
static void calls_go_on(void **state)
{
    tfa_client *client = connect_with_standby();

    (void)state;
    assert_calls_are_answered(client, &first);
    for (int i = 0; i < 3; i++) {
        (void)harness_stop(&first, SIGKILL);
        assert_calls_are_answered(client, &second);
        harness_start(&first, "arm");
        assert_calls_are_answered(client, &second);
        assert_int_equal(harness_stop(&second, SIGTERM), 0);
        assert_calls_are_answered(client, &first);
        harness_start(&second, "arm");
    }
    tfa_client_close(client);
}

/* Requests that were sent and not received are reported, each by its id; then the others go on. */
static void sent_requests_are_reported(void **state)
{
    enum { SENT = 8 };
    tfa_client *client = connect_with_standby();
    double q[7], v[7], tau[7], qdd[7];
    const tfa_request request = arm_request(0.2, q, v, tau);
    tfa_reply reply = {.qdd = qdd};
    tfa_exchange exchange;
    uint64_t ids[SENT];

    (void)state;
    harness_pause(&first);
    for (int i = 0; i < SENT; i++)
        assert_int_equal(tfa_client_send(client, &request, &ids[i]), TFA_OK);
    (void)harness_stop(&first, SIGKILL);
    for (int i = 0; i < SENT; i++) {
        assert_int_equal(tfa_client_receive(client, &reply, WAIT_NS, &exchange), TFA_E_LOST);
        assert_int_equal(exchange.id, ids[i]);
    }
    assert_int_equal(tfa_client_send(client, &request, &ids[0]), TFA_OK);
    assert_int_equal(tfa_client_receive(client, &reply, WAIT_NS, &exchange), TFA_OK);
    assert_int_equal(exchange.id, ids[0]);
    assert_calls_are_answered(client, &second);
    tfa_client_close(client);
    harness_start(&first, "arm");
}

/* The first daemon is not there at connection. */
static void connection_finds_the_standby(void **state)
{
    (void)state;
    (void)harness_stop(&first, SIGKILL);
    tfa_client *client = connect_with_standby();
    assert_calls_are_answered(client, &second);
    tfa_client_close(client);
    harness_start(&first, "arm");
}

/* Neither is there: calls say so at once, and are answered when one is back. */
static void neither_is_there(void **state)
{
    tfa_client *client = connect_with_standby();
    double qdd[7];
    int status = TFA_E_DISCONNECTED;

    (void)state;
    (void)harness_stop(&first, SIGKILL);
    (void)harness_stop(&second, SIGKILL);
    for (int i = 0; i < CALLS; i++)
        assert_int_equal(ask_arm(client, 0.2, qdd, WAIT_NS), TFA_E_DISCONNECTED);
    harness_start(&second, "arm");
    for (int i = 0; i < 1000 && status == TFA_E_DISCONNECTED; i++, sleep_ms(2))
        status = ask_arm(client, 0.2, qdd, WAIT_NS);
    assert_int_equal(status, TFA_OK);
    assert_calls_are_answered(client, &second);
    tfa_client_close(client);
    harness_start(&first, "arm");
}

/* A daemon with another model is not taken, until the program asks for it. */
static void another_model_is_not_taken(void **state)
{
    tfa_client *client = connect_with_standby();
    double qdd[7];

    (void)state;
    (void)harness_stop(&second, SIGKILL);
    harness_configure(&second, ARM "    gravity: [0, 0, -1.62]\n", "");
    harness_start(&second, "arm");
    assert_calls_are_answered(client, &first);
    (void)harness_stop(&first, SIGKILL);
    for (int i = 0; i < 20; i++, sleep_ms(2))
        assert_int_equal(ask_arm(client, 0.2, qdd, WAIT_NS), TFA_E_DISCONNECTED);
    assert_int_equal(tfa_client_reconnect(client), TFA_OK);
    assert_calls_are_answered(client, &second);
    tfa_client_close(client);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(calls_go_on),
        cmocka_unit_test(sent_requests_are_reported),
        cmocka_unit_test(connection_finds_the_standby),
        cmocka_unit_test(neither_is_there),
        cmocka_unit_test(another_model_is_not_taken),
    };

    return cmocka_run_group_tests(tests, start_both, remove_both);
}
