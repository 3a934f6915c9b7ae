/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Calls that the daemon does not answer in time: deadlines, a daemon that is stopped, killed, full,
 * and answers in process meanwhile.
 */
#include "harness.h"
#include "models.h"
#include "test.h"

#include <signal.h>

/* A client of an arm, and the same arm in process */
typedef struct scene {
    harness h;
    tfa_client *client;
    tfa_model *model;
    tfa_workspace *workspace;
    double expected[7];
} scene;

static scene open_scene(void)
{
    scene s = {.h = harness_serve(ARM, ""), .model = bundled_model("arm7.urdf", NULL)};
    s.client = harness_connect(&s.h, "arm", TFA_WAIT_BLOCK);
    assert_int_equal(ask_arm(s.client, 1, s.expected, WAIT_NS), TFA_OK);
    s.workspace = workspace_for(s.model, NULL);
    const tfa_client_fallback fallback = {
        .model = s.model, .workspace = s.workspace, .attempt_us = 1000000};
    assert_int_equal(tfa_client_set_fallback(s.client, &fallback), TFA_OK);
    return s;
}

static void close_scene(scene *s)
{
    tfa_client_close(s->client);
    tfa_workspace_free(s->workspace);
    tfa_model_free(s->model);
    harness_remove(&s->h);
}
#define SCOPED_SCENE SCOPED(close_scene) scene

/* One call. @return why the daemon did not answer it; TFA_OK: it did */
static int who_answers(scene *s, uint64_t timeout_ns)
{
    double q[7], v[7], tau[7], qdd[7];
    tfa_exchange exchange = {.daemon = 1};
    tfa_reply reply = {.qdd = qdd};
    const tfa_request r = arm_request(1, q, v, tau);
    assert_int_equal(tfa_client_call(s->client, &r, &reply, timeout_ns, &exchange), TFA_OK);
    assert_memory_equal(qdd, s->expected, sizeof qdd);
    assert_int_equal(reply.model, tfa_model_tag(s->model));
    return exchange.daemon;
}

static void wait_for_the_daemon(scene *s)
{
    assert_true(WAIT_FOR(who_answers(s, WAIT_NS) == TFA_OK));
}

TEST(killed_daemon)
{
    SCOPED_SCENE s = open_scene();
    assert_int_equal(who_answers(&s, WAIT_NS), TFA_OK);
    (void)harness_stop(&s.h, SIGKILL);
    for (int i = 0; i < 20; i++)
        assert_int_equal(who_answers(&s, WAIT_NS), TFA_E_DISCONNECTED);
    harness_start(&s.h, "arm");
    wait_for_the_daemon(&s);
}

#define EVERY_OP_NUMBERS 367

/* Answers to every op. `daemon`: why the daemon does not answer; TFA_OK: it does */
static void ask_every_op(scene *s, double (*x)[EVERY_OP_NUMBERS], int daemon)
{
    for (tfa_op op = TFA_OP_FORWARD_DYNAMICS; op <= TFA_OP_LAST; op++) {
        double q[7], v[7], tau[7], *at = x[op];
        tfa_exchange exchange = {.daemon = 1};
        tfa_request r = arm_request(1, q, v, tau);
        r.op = op;
        r.flags = TFA_WANT_JACOBIAN | TFA_WANT_COM | TFA_WANT_ENERGY;
        r.task_acceleration = tau;
        r.tip_count = 1;
        r.tips[0] = 5;
        tfa_reply reply = {.qdd = at,
                           .tau = at + 7,
                           .lambda_inv = at + 14,
                           .jacobian = at + 50,
                           .com_jacobian = at + 92,
                           .energy = at + 113,
                           .velocity_force = at + 115,
                           .mass_matrix = at + 122,
                           .dqdd_dq = at + 171,
                           .dqdd_dtau = at + 220,
                           .dtau_dq = at + 269,
                           .dtau_dv = at + 318};
        const bool closed = (TFA_OP_BIT(op) & TFA_OPS_CONSTRAINED) != 0; /* the arm has no loop */
        assert_int_equal(tfa_client_call(s->client, &r, &reply, WAIT_NS, &exchange),
                         closed ? TFA_E_SIZE : TFA_OK);
        assert_int_equal(reply.field, closed ? TFA_FIELD_CONSTRAINTS : TFA_FIELD_NONE);
        assert_int_equal(exchange.daemon, daemon);
    }
}

/* In process every op has the bits of the daemon. */
TEST(every_op_in_process)
{
    static double asked[TFA_OP_LAST + 1][EVERY_OP_NUMBERS], here[TFA_OP_LAST + 1][EVERY_OP_NUMBERS];
    SCOPED_SCENE s = open_scene();
    ask_every_op(&s, asked, TFA_OK);
    (void)harness_stop(&s.h, SIGKILL);
    ask_every_op(&s, here, TFA_E_DISCONNECTED);
    assert_memory_equal(asked, here, sizeof here);
}

TEST(stopped_daemon)
{
    SCOPED_SCENE s = open_scene();
    harness_pause(&s.h);
    for (int i = 0; i < 5; i++)
        assert_int_equal(who_answers(&s, 10000000), TFA_E_TIMEOUT);
    assert_int_equal(kill(s.h.pid, SIGCONT), 0);
    wait_for_the_daemon(&s);
}

/* The program's model is not the daemon's any more: then there is no answer in process. */
TEST(exchanged_model)
{
    double qdd[7];
    SCOPED_SCENE s = open_scene();
    harness_reload(&s.h, ARM "    gravity: [0, 0, -1]\n", "");
    assert_true(harness_logged(&s.h, "reload: done"));
    assert_int_equal(ask_arm(s.client, 1, qdd, WAIT_NS), TFA_OK);
    (void)harness_stop(&s.h, SIGKILL);
    assert_int_equal(ask_arm(s.client, 1, qdd, WAIT_NS), TFA_E_DISCONNECTED);
    const tfa_client_fallback old = {.model = s.model, .workspace = s.workspace};
    assert_int_equal(tfa_client_set_fallback(s.client, &old), TFA_E_MODEL);
    assert_int_equal(tfa_client_set_fallback(s.client, NULL), TFA_OK);
}

/* Without a timeout a daemon that stands still is noticed all the same. */
TEST(no_timeout_and_no_progress)
{
    static const tfa_wait waits[] = {TFA_WAIT_SPIN, TFA_WAIT_HYBRID, TFA_WAIT_BLOCK};
    double qdd[7];
    SCOPED_HARNESS h = harness_serve(ARM, "");
    for (int i = 0; i < 3; i++) {
        SCOPED_CLIENT *client = harness_connect(&h, "arm", waits[i]);
        harness_pause(&h);
        assert_int_equal(ask_arm(client, 1, qdd, 0), TFA_E_TIMEOUT);
        assert_int_equal(kill(h.pid, SIGCONT), 0);
        assert_int_equal(ask_arm(client, 1, qdd, WAIT_NS), TFA_OK);
    }
}

/* Requests that wait longer than their deadline are refused by name; others are answered. */
TEST(deadlines)
{
    double q[7], v[7], tau[7], qdd[7];
    SCOPED_HARNESS h = harness_serve(ARM, "");
    tfa_client_options options = harness_options(&h, "arm");
    tfa_client *hurried, *patient;
    assert_int_equal(tfa_client_connect(&options, &patient), TFA_OK);
    options.deadline_us = 20000;
    assert_int_equal(tfa_client_connect(&options, &hurried), TFA_OK);
    const tfa_request r = arm_request(1, q, v, tau);
    tfa_reply reply = {.qdd = qdd};
    harness_pause(&h);
    assert_int_equal(tfa_client_send(hurried, &r, NULL), TFA_OK);
    assert_int_equal(tfa_client_send(patient, &r, NULL), TFA_OK);
    sleep_ms(40); /* longer than the deadline */
    assert_int_equal(kill(h.pid, SIGCONT), 0);
    assert_int_equal(tfa_client_receive(hurried, &reply, WAIT_NS, NULL), TFA_E_LATE);
    assert_int_equal(tfa_client_receive(patient, &reply, WAIT_NS, NULL), TFA_OK);
    tfa_client_close(hurried);
    tfa_client_close(patient);
}

/* A lost request is reported once, before anything else is asked; an answered one never. */
TEST(losses_are_reported_first)
{
    double q[7], v[7], tau[7], qdd[7];
    SCOPED_HARNESS h = harness_serve(ARM, "");
    SCOPED_CLIENT *client = harness_connect(&h, "arm", TFA_WAIT_BLOCK);
    const tfa_request r = arm_request(1, q, v, tau);
    for (uint64_t round = 0; round < 2; round++) {
        tfa_reply reply = {.qdd = qdd};
        tfa_exchange exchange;
        uint64_t id;
        harness_pause(&h);
        assert_int_equal(tfa_client_send(client, &r, &id), TFA_OK);
        (void)harness_stop(&h, SIGKILL);
        harness_start(&h, "arm");
        assert_int_equal(tfa_client_reconnect(client), TFA_OK);
        assert_int_equal(ask_arm(client, 1, qdd, WAIT_NS), TFA_E_ARGUMENT);
        assert_int_equal(tfa_client_receive(client, &reply, WAIT_NS, &exchange), TFA_E_LOST);
        assert_int_equal(exchange.id, id);
        assert_int_equal(ask_arm(client, 1, qdd, WAIT_NS), TFA_OK);
    }
}

/* The daemon's reason reaches the user. */
TEST(refusals_are_explained)
{
    char text[400];
    tfa_client *client;
    SCOPED_HARNESS h = harness_serve(ARM, "limits: {memory_mib_per_user: 1}\n");
    tfa_client_options options = harness_options(&h, "arm");
    options.slots = options.max_batch = 64;
    const int status = tfa_client_connect(&options, &client);
    assert_int_equal(status, TFA_E_REFUSED);
    (void)tfa_client_explain(&options, status, text, sizeof text);
    assert_non_null(strstr(text, "limits.memory_mib_per_user (1)"));
}

TEST(a_stopped_daemon_is_explained)
{
    char text[400];
    tfa_client *client;
    SCOPED_HARNESS h = harness_serve(ARM, "");
    tfa_client_options options = harness_options(&h, "arm");
    options.connect_timeout_ms = 100;
    harness_pause(&h);
    const int status = tfa_client_connect(&options, &client);
    assert_int_equal(status, TFA_E_TIMEOUT);
    (void)tfa_client_explain(&options, status, text, sizeof text);
    assert_non_null(strstr(text, "does not answer"));
    assert_non_null(strstr(text, h.runtime_dir));
}
