/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Clients over shared memory that have a second daemon on the host: they turn to it by themselves.
 */
#include "harness.h"
#include "models.h"
#include "test.h"

#include <limits.h>
#include <signal.h>

#define CALLS 50
#define MS UINT64_C(1000000)

static harness first, second;

static int start_both(void **state)
{
    (void)state;
    first = harness_serve(ARM, "");
    second = harness_serve(ARM, "");
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
    options.standby_dir = second.runtime_dir;
    options.connect_timeout_ms = INT_MAX;
    return harness_connect_with(&options);
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
TEST(calls_go_on)
{
    SCOPED_CLIENT *client = connect_with_standby();
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
}

/* Requests that were sent and not received are reported, each by its id; then the others go on. */
TEST(sent_requests_are_reported)
{
    enum { SENT = 8 };
    tfa_client *client = connect_with_standby();
    double q[7], v[7], tau[7], qdd[7];
    const tfa_request request = arm_request(0.2, q, v, tau);
    tfa_reply reply = {.qdd = qdd};
    tfa_exchange exchange;
    uint64_t ids[SENT];
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
TEST(connection_finds_the_standby)
{
    (void)harness_stop(&first, SIGKILL);
    tfa_client *client = connect_with_standby();
    assert_calls_are_answered(client, &second);
    tfa_client_close(client);
    harness_start(&first, "arm");
}

/* Neither is there: calls say so at once, and are answered when one is back. */
TEST(neither_is_there)
{
    tfa_client *client = connect_with_standby();
    double qdd[7];
    int status = TFA_E_DISCONNECTED;
    (void)harness_stop(&first, SIGKILL);
    (void)harness_stop(&second, SIGKILL);
    for (int i = 0; i < CALLS; i++)
        assert_int_equal(ask_arm(client, 0.2, qdd, WAIT_NS), TFA_E_DISCONNECTED);
    harness_start(&second, "arm");
    assert_true(WAIT_FOR((status = ask_arm(client, 0.2, qdd, WAIT_NS)) != TFA_E_DISCONNECTED));
    assert_int_equal(status, TFA_OK);
    assert_calls_are_answered(client, &second);
    tfa_client_close(client);
    harness_start(&first, "arm");
}

/* Both daemons accept connections and say nothing more, as stopped ones do. The limit of the
 * connection is 25 days: who waits for it does not come back before the test's own limit. */
static tfa_client *client_of_silent_daemons(void)
{
    tfa_client *client = connect_with_standby();
    (void)harness_stop(&first, SIGKILL);
    harness_start(&first, "arm");
    harness_pause(&first);
    harness_pause(&second);
    return client;
}

static void wake_both(tfa_client *client)
{
    assert_int_equal(kill(first.pid, SIGCONT), 0);
    assert_int_equal(kill(second.pid, SIGCONT), 0);
    tfa_client_close(client);
}

static void assert_unanswered(tfa_client *client, uint64_t timeout_ns)
{
    double qdd[7];
    assert_int_not_equal(ask_arm(client, 0.2, qdd, timeout_ns), TFA_OK);
}

/* A call has its own limit, however many daemons it asks. */
TEST(calls_end_by_themselves)
{
    tfa_client *client = client_of_silent_daemons();
    assert_unanswered(client, 100 * MS);
    wake_both(client);
}

/* A call that looks for a daemon takes its timeout at least, because none says anything. */
static bool next_call_does_not_look(tfa_client *client)
{
    const uint64_t timeout = 200 * MS;
    assert_unanswered(client, timeout);
    const uint64_t start = now_ns();
    assert_unanswered(client, timeout);
    return now_ns() - start < timeout;
}

/* After a look that took long there is a pause, too. A client that gets no processor meanwhile
 * looks again: it is asked until it did not. */
TEST(looks_are_apart)
{
    tfa_client *client = client_of_silent_daemons();
    assert_true(WAIT_FOR(next_call_does_not_look(client)));
    wake_both(client);
}

/* A call that is too short for a look at the socket ends with TFA_E_TIMEOUT. */
static void notice_the_end(tfa_client *client)
{
    double qdd[7];
    int status;
    assert_true(WAIT_FOR((status = ask_arm(client, 0.2, qdd, MS)) != TFA_E_TIMEOUT));
    assert_int_equal(status, TFA_E_DISCONNECTED);
}

/* Sending does not wait for the connection's limit. */
TEST(sending_does_not_wait)
{
    tfa_client *client = client_of_silent_daemons();
    double q[7], v[7], tau[7];
    const tfa_request request = arm_request(0.2, q, v, tau);
    notice_the_end(client);
    sleep_ms(50); /* longer than the pause between two looks: sending looks, too */
    assert_int_equal(tfa_client_send(client, &request, NULL), TFA_E_DISCONNECTED);
    wake_both(client);
}

/* The arm in process, for a client. */
typedef struct arm_here {
    tfa_model *model;
    tfa_workspace *workspace;
} arm_here;

static arm_here set_fallback(tfa_client *client)
{
    arm_here arm = {.model = bundled_model("arm7.urdf", NULL)};
    arm.workspace = workspace_for(arm.model, NULL);
    const tfa_client_fallback fallback = {.model = arm.model, .workspace = arm.workspace};
    assert_int_equal(tfa_client_set_fallback(client, &fallback), TFA_OK);
    return arm;
}

static void free_arm(arm_here arm)
{
    tfa_workspace_free(arm.workspace);
    tfa_model_free(arm.model);
}

/* A program with a fallback waits for its attempt_us, not for the connection or for the day that
 * the call may take. */
TEST(fallback_answers_soon)
{
    tfa_client *client = client_of_silent_daemons();
    const arm_here arm = set_fallback(client);
    double qdd[7];
    assert_int_equal(ask_arm(client, 0.2, qdd, 86400 * 1000 * MS), TFA_OK);
    wake_both(client);
    free_arm(arm);
}

/* A daemon with another model is not taken, until the program asks for it. Nothing of it stays. */
TEST(another_model_is_not_taken)
{
    SCOPED_CLIENT *client = connect_with_standby();
    double qdd[7];
    (void)harness_stop(&second, SIGKILL);
    harness_configure(&second, ARM "    gravity: [0, 0, -1.62]\n", "");
    harness_start(&second, "arm");
    assert_calls_are_answered(client, &first);
    const pid_t pid = first.pid;
    char hash[65];
    memcpy(hash, tfa_client_get_info(client)->model_hash, sizeof hash);
    (void)harness_stop(&first, SIGKILL);
    for (int i = 0; i < 20; i++, sleep_ms(2)) /* several looks */
        assert_int_equal(ask_arm(client, 0.2, qdd, WAIT_NS), TFA_E_DISCONNECTED);
    assert_int_equal(tfa_client_get_info(client)->daemon_pid, pid);
    assert_string_equal(tfa_client_get_info(client)->model_hash, hash);
    assert_true(harness_has_clients(&second, 0));
    assert_int_equal(tfa_client_reconnect(client), TFA_OK);
    assert_calls_are_answered(client, &second);
}

/* Nor by a client that computes in process meanwhile: all its answers are of the same model. */
TEST(another_model_is_not_taken_with_a_fallback)
{
    double expected[7], qdd[7];
    harness_start(&first, "arm");
    SCOPED_CLIENT *client = connect_with_standby();
    const arm_here arm = set_fallback(client);
    assert_int_equal(ask_arm(client, 0.2, expected, WAIT_NS), TFA_OK);
    (void)harness_stop(&first, SIGKILL);
    for (int i = 0; i < 100; i++, sleep_ms(2)) { /* several looks */
        assert_int_equal(ask_arm(client, 0.2, qdd, WAIT_NS), TFA_OK);
        assert_memory_equal(qdd, expected, sizeof qdd);
    }
    free_arm(arm);
}

int main(void)
{
    return test_run(start_both, remove_both);
}
