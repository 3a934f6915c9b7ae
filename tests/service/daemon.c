/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Two processes: sending and receiving, greetings and refusals, start and end.
 */
#include "harness.h"
#include "models.h"
#include "test.h"

#include <signal.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <totalforce/dynamics.h>
#include <unistd.h>

#define TIMEOUT_NS WAIT_NS

/* ---- sending and receiving ---- */

TEST(pipelined)
{
    double q[7] = {0}, qdd[7], expected[7];
    const tfa_request r = request_fd(q, NULL, NULL);
    tfa_reply reply = {.qdd = qdd};
    tfa_exchange times;
    uint64_t id = 0, first = 0;
    SCOPED_HARNESS h = harness_serve(ARM, "");
    tfa_client_options options = harness_options(&h, "arm");
    options.slots = 4;
    SCOPED_CLIENT *client = harness_connect_with(&options);
    assert_int_equal(tfa_client_receive(client, &reply, TIMEOUT_NS, NULL), TFA_E_ARGUMENT);
    for (int i = 0; i < 4; i++) {
        q[0] = i;
        assert_int_equal(tfa_client_send(client, &r, &id), TFA_OK);
        first = i ? first : id;
    }
    assert_int_equal(tfa_client_send(client, &r, &id), TFA_E_AGAIN);
    assert_int_equal(tfa_client_call(client, &r, &reply, TIMEOUT_NS, NULL), TFA_E_ARGUMENT);
    for (uint64_t i = 0; i < 4; i++) {
        assert_int_equal(tfa_client_receive(client, &reply, TIMEOUT_NS, &times), TFA_OK);
        assert_int_equal(times.id, first + i);
        memcpy(expected, qdd, sizeof qdd);
    }
    q[0] = 3;
    assert_int_equal(tfa_client_call(client, &r, &reply, TIMEOUT_NS, NULL), TFA_OK);
    assert_memory_equal(qdd, expected, sizeof qdd);
    tfa_request many = r;
    many.count = 2;
    assert_int_equal(tfa_client_call(client, &many, &reply, TIMEOUT_NS, NULL), TFA_E_SIZE);
}

/* A stopped daemon: calls time out, their late replies are nobody's, the next call has its own. */
TEST(timeouts)
{
    static const tfa_wait waits[] = {TFA_WAIT_SPIN, TFA_WAIT_HYBRID, TFA_WAIT_BLOCK};
    double qdd[7], good[7];
    SCOPED_HARNESS h = harness_serve(ARM, "");
    for (int i = 0; i < 3; i++) {
        SCOPED_CLIENT *client = harness_connect(&h, "arm", waits[i]);
        assert_int_equal(tfa_client_get_info(client)->wait, waits[i]);
        assert_int_equal(ask_arm(client, 1, good, TIMEOUT_NS), TFA_OK);
        harness_pause(&h);
        for (int k = 0; k < 3; k++)
            assert_int_equal(ask_arm(client, 2, qdd, 30000000), TFA_E_TIMEOUT);
        kill(h.pid, SIGCONT);
        assert_int_equal(ask_arm(client, 1, qdd, TIMEOUT_NS), TFA_OK);
        assert_memory_equal(qdd, good, sizeof good);
    }
}

/* ---- greetings ---- */

static int connect_with(const tfa_client_options *options)
{
    tfa_client *client;
    int status = tfa_client_connect(options, &client);
    assert_true((status == TFA_OK) == (client != NULL));
    tfa_client_close(client);
    return status;
}

/* Connects; others may still be leaving. */
static tfa_client *connect_soon(const tfa_client_options *options)
{
    tfa_client *client = NULL;
    assert_true(WAIT_FOR((sleep_ms(5), tfa_client_connect(options, &client) == TFA_OK)));
    return client;
}

TEST(refusals)
{
    SCOPED_HARNESS h =
        harness_make(ARM "    slots: 32\n    max_batch: 8\n",
                     "allow_spin: no\nlimits: {clients: 5, clients_per_user: 3, memory_mib: 4}\n");
    tfa_client_options o = harness_options(&h, "arm");
    assert_int_equal(connect_with(&o), TFA_E_DISCONNECTED);
    harness_start(&h, "arm");
    assert_int_equal(connect_with(&o), TFA_OK);
    o.robot = "leg";
    assert_int_equal(connect_with(&o), TFA_E_ROBOT);
    o.robot = "../arm";
    assert_int_equal(connect_with(&o), TFA_E_ROBOT);
    o.robot = NULL;
    assert_int_equal(connect_with(&o), TFA_E_ARGUMENT);
    o.robot = "arm";
    o.slots = 64;
    assert_int_equal(connect_with(&o), TFA_E_SIZE);
    o.slots = 3;
    assert_int_equal(connect_with(&o), TFA_E_SIZE);
    o.slots = 32;
    o.max_batch = 9;
    assert_int_equal(connect_with(&o), TFA_E_SIZE);
    o.max_batch = 8;
    assert_int_equal(connect_with(&o), TFA_E_REFUSED); /* memory_mib */
    o.max_batch = o.slots = 0;
    o.wait = TFA_WAIT_SPIN;
    tfa_client *clients[3];
    for (int i = 0; i < 3; i++) {
        clients[i] = connect_soon(&o);
        assert_int_equal(tfa_client_get_info(clients[i])->wait, TFA_WAIT_HYBRID);
    }
    assert_int_equal(connect_with(&o), TFA_E_REFUSED); /* clients_per_user */
    for (int i = 0; i < 3; i++)
        tfa_client_close(clients[i]);
    assert_true(harness_logged(&h, "limits.memory_mib"));
}

/* Full: said before the client could greet, heard all the same. */
TEST(all_clients_connected)
{
    SCOPED_HARNESS h = harness_serve(ARM, "limits: {clients: 1}\n");
    tfa_client_options o = harness_options(&h, "arm");
    SCOPED_CLIENT *client = connect_soon(&o);
    for (int i = 0; i < 200; i++)
        assert_int_equal(connect_with(&o), TFA_E_REFUSED);
}

/* ---- start and end ---- */

TEST(second_daemon_refuses)
{
    double qdd[7];
    SCOPED_HARNESS h = harness_serve(ARM, "");
    harness second = h;
    char text[64];
    snprintf(text, sizeof text, "another totalforced (pid %d)", (int)h.pid);
    harness_assert_refused(&second, text);
    SCOPED_CLIENT *client = harness_connect(&h, "arm", TFA_WAIT_DEFAULT);
    assert_int_equal(ask_arm(client, 1, qdd, TIMEOUT_NS), TFA_OK); /* the first is unharmed */
}

static bool is_gone(const char *path)
{
    return access(path, F_OK) != 0;
}

TEST(stops_clean)
{
    static const int signals[] = {SIGTERM, SIGINT};
    for (int i = 0; i < 2; i++) {
        double qdd[7];
        SCOPED_HARNESS h = harness_serve(ARM, "");
        SCOPED_CLIENT *client = harness_connect(&h, "arm", TFA_WAIT_HYBRID);
        assert_int_equal(ask_arm(client, 1, qdd, TIMEOUT_NS), TFA_OK);
        kill(h.pid, SIGHUP);
        assert_true(harness_logged(&h, "reload: reading"));
        assert_int_equal(harness_named_segments(&h), 0); /* none stays behind */
        assert_int_equal(harness_stop(&h, signals[i]), 0);
        assert_true(is_gone(h.runtime_dir));
        assert_int_equal(ask_arm(client, 1, qdd, TIMEOUT_NS), TFA_E_DISCONNECTED);
    }
}

TEST(bad_robots_are_named)
{
    static const struct {
        const char *yaml, *text;
    } cases[] = {
        {"  - name: bad\n    urdf: @/config/minimal.yaml\n", "malformed file"},
        {ARM "    armature: [{joint: nobody, value: 1}]\n", "no joint 'nobody'"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        SCOPED_HARNESS h = harness_make(cases[i].yaml, "");
        harness_assert_refused(&h, cases[i].text);
        assert_true(is_gone(h.runtime_dir));
    }
}

static void check_heavy(const char *heavy)
{
    harness plain, with_payload;
    double a[7], b[7];
    plain = harness_make(ARM, "");
    with_payload = harness_make(heavy, "");
    harness_start(&plain, "arm");
    harness_start(&with_payload, "arm");
    SCOPED_CLIENT *light = harness_connect(&plain, "arm", TFA_WAIT_DEFAULT);
    SCOPED_CLIENT *slow = harness_connect(&with_payload, "arm", TFA_WAIT_DEFAULT);
    assert_int_equal(ask_arm(light, 1, a, TIMEOUT_NS), TFA_OK);
    assert_int_equal(ask_arm(slow, 1, b, TIMEOUT_NS), TFA_OK);
    assert_true(b[0] * b[0] < 1e-4 * a[0] * a[0]);
    assert_string_not_equal(tfa_client_get_info(light)->model_hash,
                            tfa_client_get_info(slow)->model_hash);
    harness_remove(&plain);
    harness_remove(&with_payload);
}

TEST(armature_and_rotors_count)
{
    check_heavy(ARM "    armature: [{joint: joint_1, value: 1000}]\n");
    check_heavy(ARM "    rotors: [{joint: joint_1, value: 1000}]\n");
}

/* One daemon, whose configuration changes: float is another answer, a refined one nearly the
 * same. */
TEST(precision_is_taken_in_a_reload)
{
    static const struct {
        const char *yaml;
        double nearest, farthest; /* relative, from double */
    } cases[] = {{ARM "    precision: f32\n", 1e-9, 1e-4},
                 {ARM "    precision: f32\n    residual: f64\n", 0, 1e-13},
                 {ARM "    residual: f128\n", 0, 1e-13}};
    double plain[7], qdd[7];
    SCOPED_HARNESS h = harness_serve(ARM, "");
    SCOPED_CLIENT *client = harness_connect(&h, "arm", TFA_WAIT_DEFAULT);
    assert_int_equal(ask_arm(client, 1, plain, TIMEOUT_NS), TFA_OK);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        double difference = 0, size = 0;
        harness_reload(&h, cases[i].yaml, "");
        assert_true(harness_logged_times(&h, "reload: done, 1 of 1", (unsigned)i + 1));
        assert_int_equal(ask_arm(client, 1, qdd, TIMEOUT_NS), TFA_OK);
        for (int k = 0; k < 7; k++) {
            difference += (qdd[k] - plain[k]) * (qdd[k] - plain[k]);
            size += plain[k] * plain[k];
        }
        assert_true(difference >= cases[i].nearest * cases[i].nearest * size);
        assert_true(difference <= cases[i].farthest * cases[i].farthest * size);
    }
}

static const struct {
    const char *yaml;
    int measured;        /* of 20 */
} policies[] = {{"", 0}, /* the default: where the sentinel trips */
                {"    estimate: never\n", 0},
                {"    estimate: always\n", 20},
                {"    estimate: sampled\n    estimate_every: 5\n", 4}};
#define POLICIES (sizeof policies / sizeof *policies)

static harness start_with_policy(size_t policy)
{
    char yaml[256];
    snprintf(yaml, sizeof yaml, ARM "%s", policies[policy].yaml);
    return harness_serve(yaml, "");
}

/* The estimate policy: one in `estimate_every` is measured, never, always, or as asked. */
TEST(estimates_follow_the_policy)
{
    for (size_t i = 0; i < POLICIES; i++) {
        const double q[7] = {0.1, 0.2, 0.3};
        SCOPED_HARNESS h = start_with_policy(i);
        SCOPED_CLIENT *client = harness_connect(&h, "arm", TFA_WAIT_DEFAULT);
        int measured = 0;
        for (int k = 0; k < 20; k++) {
            const tfa_request r = {.op = TFA_OP_FORWARD_DYNAMICS,
                                   .method = TFA_METHOD_ABA,
                                   .refine = TFA_REFINE_DEFAULT,
                                   .count = 1,
                                   .q = q};
            double qdd[7];
            tfa_answer answer;
            tfa_reply reply = {.qdd = qdd, .answers = &answer};
            assert_int_equal(tfa_client_call(client, &r, &reply, TIMEOUT_NS, NULL), TFA_OK);
            measured += (answer.flags & TFA_ANSWER_ESTIMATED) != 0;
        }
        assert_int_equal(measured, policies[i].measured);
    }
}
