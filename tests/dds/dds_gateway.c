/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The DDS gateway in a process of its own, or the whole daemon, asked over the loopback interface:
 * the same bits as tfa_compute in process, for every op, and the same statuses.
 */
#include "dds_client/dds_client.h"
#include "dds_test.h"
#include "gateway_process.h"
#include "robots.h"

#include <math.h>
#include <string.h>

#define N_MAX 20
#define ROWS (6 * 2)

static test_robot robots[TEST_ROBOTS];

typedef struct inputs {
    double q[TEST_BATCH * N_MAX], v[TEST_BATCH * N_MAX], tau[TEST_BATCH * N_MAX];
    double qdd[TEST_BATCH * N_MAX], pose[TEST_BATCH * 7], twist[TEST_BATCH * 6];
    double wrench[TEST_BATCH * 6], acceleration[TEST_BATCH * 6], external[TEST_BATCH * 6];
} inputs;

typedef struct outputs {
    double qdd[TEST_BATCH * N_MAX], base_acceleration[TEST_BATCH * 6];
    double tau[TEST_BATCH * N_MAX], base_wrench[TEST_BATCH * 6];
    double lambda_inv[TEST_BATCH * ROWS * ROWS], mass_matrix[TEST_BATCH * N_MAX * N_MAX];
    double poses[TEST_BATCH * 7 * 2];
    tfa_spectrum spectrum[TEST_BATCH];
    tfa_answer answers[TEST_BATCH];
} outputs;

static tfa_reply reply_into(outputs *o)
{
    memset(o, 0, sizeof *o);
    return (tfa_reply){
        .qdd = o->qdd,
        .base_acceleration = o->base_acceleration,
        .tau = o->tau,
        .base_wrench = o->base_wrench,
        .lambda_inv = o->lambda_inv,
        .mass_matrix = o->mass_matrix,
        .spectrum = o->spectrum,
        .poses = o->poses,
        .answers = o->answers,
    };
}

static void fill(double *numbers, size_t count, uint64_t *seed)
{
    for (size_t i = 0; i < count; i++)
        numbers[i] = test_random(seed);
}

static void make_inputs(inputs *in, uint64_t seed)
{
    fill((double *)in, sizeof *in / sizeof(double), &seed);
    for (int k = 0; k < TEST_BATCH; k++) {
        double *quat = in->pose + 7 * k + 3;
        const double norm =
            sqrt(quat[0] * quat[0] + quat[1] * quat[1] + quat[2] * quat[2] + quat[3] * quat[3]);
        for (int i = 0; i < 4; i++)
            quat[i] /= norm;
    }
}

static tfa_request make_request(const tfa_model *model, tfa_op op, const inputs *in, uint32_t count)
{
    const bool base = tfa_model_base_freedoms(model) > 0;
    return (tfa_request){
        .op = op,
        .estimate = TFA_ESTIMATE_NEVER, /* the daemon has a default of its own */
        .refine = TFA_REFINE_DEFAULT,
        .count = count,
        .q = in->q,
        .v = in->v,
        .tau = in->tau,
        .qdd = in->qdd,
        .base_pose = base ? in->pose : NULL,
        .base_twist = base ? in->twist : NULL,
        .base_wrench = base ? in->wrench : NULL,
        .base_acceleration = base ? in->acceleration : NULL,
    };
}

static tfa_dds_client *connect_to(const char *robot)
{
    const tfa_dds_client_options options = {
        .domain = test_domain(), .robot = robot, .connect_timeout_ms = WAIT_MS};
    tfa_dds_client *client;
    assert_int_equal(tfa_dds_client_connect(&options, &client), TFA_OK);
    return client;
}

/* One for each robot that most tests share: it takes a while until a client hears of the leader. */
static tfa_dds_client *clients[TEST_ROBOTS];

static tfa_dds_client *client_of(int robot)
{
    if (clients[robot] == NULL)
        clients[robot] = connect_to(robots[robot].name);
    return clients[robot];
}

/* Asks over DDS and in process; status, invalid field and every bit must agree. @return the
 * status */
static int assert_same_answer(tfa_dds_client *client, const tfa_model *model,
                              const tfa_request *request)
{
    static outputs over, here;
    tfa_reply a = reply_into(&over), b = reply_into(&here);
    tfa_workspace *workspace;
    tfa_exchange times;
    assert_int_equal(tfa_workspace_create(model, NULL, &workspace), TFA_OK);
    const int expected = tfa_compute(workspace, request, &b);
    tfa_workspace_free(workspace);
    assert_int_equal(tfa_dds_client_call(client, request, &a, WAIT_NS, &times), expected);
    assert_int_equal(a.status, b.status);
    assert_int_equal(a.field, b.field);
    assert_int_equal(a.index, b.index);
    assert_int_equal(a.state, b.state);
    assert_true(a.model == b.model && a.model == tfa_model_tag(model));
    if (expected == TFA_OK)
        assert_memory_equal(&over, &here, sizeof over);
    assert_true(times.t_sent <= times.t_reply);
    return expected;
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

TEST(the_robot_is_described)
{
    for (int r = 0; r < TEST_ROBOTS; r++) {
        const tfa_model *model = robots[r].model;
        tfa_dds_client *client = client_of(r);
        const tfa_client_info *info = tfa_dds_client_get_info(client);
        assert_int_equal(info->q_count, tfa_model_q_count(model));
        assert_int_equal(info->v_count, tfa_model_v_count(model));
        assert_int_equal(info->base_freedoms, tfa_model_base_freedoms(model));
        assert_int_equal(info->max_batch, TEST_BATCH);
        assert_string_equal(info->model_hash, tfa_model_hash_text(model));
        assert_int_equal(info->joint_count, tfa_model_joint_count(model));
        assert_int_equal(info->frame_count, tfa_model_frame_count(model));
        for (uint32_t i = 0; i < info->joint_count; i++)
            assert_string_equal(info->joint_names[i], tfa_model_joint(model, i).name);
        for (uint32_t i = 0; i < info->frame_count; i++)
            assert_string_equal(info->frame_names[i], tfa_model_frame(model, i).name);
    }
}

TEST(every_op_gives_the_same_bits)
{
    static inputs in;
    const double gravity[3] = {0.1, -0.2, -9.7};
    for (int r = 0; r < TEST_ROBOTS; r++) {
        const tfa_model *model = robots[r].model;
        tfa_dds_client *client = client_of(r);
        for (int op = TFA_OP_FORWARD_DYNAMICS; op <= TFA_OP_MASS_MATRIX; op++)
            for (uint32_t variant = 0; variant < 8; variant++) {
                make_inputs(&in, 100u * (uint32_t)op + variant);
                tfa_request request =
                    make_request(model, (tfa_op)op, &in, variant == 7 ? TEST_BATCH : 1 + variant);
                if (variant & 1) {
                    request.tip_count = 2;
                    request.tips[0] = tfa_model_frame_count(model) - 1;
                    request.tips[1] = 3;
                    request.flags = TFA_WANT_SPECTRUM;
                } else {
                    request.v = NULL;
                    request.tau = NULL;
                }
                if (variant & 2) {
                    request.wrench_count = 1;
                    request.wrench_frames[0] = 2;
                    request.wrenches = in.external;
                    request.gravity = gravity;
                }
                if (variant & 4) {
                    request.estimate = TFA_ESTIMATE_ALWAYS;
                    request.frame = TFA_FRAME_LOCAL;
                    request.refine = 1;
                }
                assert_same_answer(client, model, &request);
            }
    }
}

TEST(every_method_gives_the_same_bits)
{
    static inputs in;
    tfa_dds_client *client = client_of(0);
    make_inputs(&in, 3);
    for (uint32_t method = 0; method < 9; method++)
        for (int op = TFA_OP_FORWARD_DYNAMICS; op <= TFA_OP_MASS_MATRIX; op++) {
            tfa_request request = make_request(robots[0].model, (tfa_op)op, &in, 2);
            request.method = (tfa_method)method;
            request.estimate = method % 2 ? TFA_ESTIMATE_ALWAYS : TFA_ESTIMATE_NEVER;
            request.tip_count = op == TFA_OP_OPERATIONAL_INERTIA ? 1 : 0;
            request.tips[0] = 7;
            assert_same_answer(client, robots[0].model, &request);
        }
}

/* Locked joints, payloads, poses; each alone, and what goes together. */
TEST(a_changed_robot_gives_the_same_bits)
{
    static const uint32_t joint = 0;
    static const double payloads[2 * TFA_PAYLOAD_NUMBERS] = {0.5, 0.1,  0, 0.2,  0.01, 0.001,
                                                             0,   0.02, 0, 0.03, 2};
    static inputs in;
    for (int r = 0; r < TEST_ROBOTS; r++) {
        tfa_dds_client *client = client_of(r);
        for (uint32_t variant = 0; variant < 8; variant++) {
            make_inputs(&in, 1000 + variant);
            tfa_request request =
                make_request(robots[r].model, TFA_OP_FORWARD_DYNAMICS, &in, 1 + variant % 3);
            request.payload_count = variant & 1 ? 2 : 0;
            request.payload_frames[0] = 4;
            request.payload_frames[1] = 1;
            request.payloads = payloads;
            request.locked_count = variant & 2 ? 1 : 0;
            request.locked = &joint;
            if (!(variant & 4)) {
                request.tip_count = 2;
                request.tips[0] = 4;
                request.flags = TFA_WANT_POSES;
            }
            assert_int_equal(assert_same_answer(client, robots[r].model, &request), TFA_OK);
        }
    }
}

/* What tfa_compute refuses, the gateway refuses with the same field; and goes on. */
TEST(bad_values_are_named)
{
    static inputs in;
    const tfa_model *model = robots[1].model;
    tfa_dds_client *client = client_of(1);
    tfa_request good, bad;
    make_inputs(&in, 4);
    good = make_request(model, TFA_OP_FORWARD_DYNAMICS, &in, 3);
    in.tau[7] = NAN;
    assert_same_answer(client, model, &good);
    in.tau[7] = INFINITY;
    assert_same_answer(client, model, &good);
    in.tau[7] = 1;
    in.pose[3] += 0.5;
    assert_same_answer(client, model, &good);
    make_inputs(&in, 4);
#define BAD(change)                                                                                \
    do {                                                                                           \
        bad = good;                                                                                \
        change;                                                                                    \
        assert_same_answer(client, model, &bad);                                                   \
        assert_same_answer(client, model, &good);                                                  \
    } while (0)
    BAD(bad.q = NULL);
    BAD(bad.base_pose = NULL);
    BAD(bad.method = (tfa_method)99);
    BAD(bad.method = TFA_METHOD_RNEA);
    BAD(bad.frame = (tfa_reference_frame)3);
    BAD(bad.estimate = (tfa_estimate)77);
    BAD(bad.refine = TFA_MAX_REFINE + 1);
    BAD((bad.tip_count = 1, bad.tips[0] = 1000));
    BAD((bad.wrench_count = 1, bad.wrench_frames[0] = UINT32_MAX, bad.wrenches = in.external));
    BAD((bad.op = TFA_OP_OPERATIONAL_INERTIA, bad.tip_count = 0));
#undef BAD
    bad = good;
    bad.count = TEST_BATCH + 1;
    tfa_reply none = {0};
    assert_int_equal(tfa_dds_client_call(client, &bad, &none, WAIT_NS, NULL), TFA_E_SIZE);
}

TEST(many_clients_get_their_own_replies)
{
    enum { CLIENTS = 4, ROUNDS = 50 };
    static inputs in[CLIENTS];
    static outputs out;
    tfa_dds_client *others[CLIENTS];
    tfa_workspace *workspace;
    assert_int_equal(tfa_workspace_create(robots[0].model, NULL, &workspace), TFA_OK);
    for (uint32_t c = 0; c < CLIENTS; c++) {
        others[c] = connect_to("arm");
        make_inputs(&in[c], 50 + c);
    }
    for (int round = 0; round < ROUNDS; round++) {
        for (uint32_t c = 0; c < CLIENTS; c++) {
            const tfa_request request =
                make_request(robots[0].model, TFA_OP_FORWARD_DYNAMICS, &in[c], 1);
            uint64_t id;
            assert_int_equal(tfa_dds_client_send(others[c], &request, &id), TFA_OK);
        }
        for (uint32_t c = 0; c < CLIENTS; c++) {
            static outputs here;
            const tfa_request request =
                make_request(robots[0].model, TFA_OP_FORWARD_DYNAMICS, &in[c], 1);
            tfa_reply a = reply_into(&out), b = reply_into(&here);
            assert_int_equal(tfa_compute(workspace, &request, &b), TFA_OK);
            assert_int_equal(tfa_dds_client_receive(others[c], &a, WAIT_NS, NULL), TFA_OK);
            assert_memory_equal(&out, &here, sizeof out);
        }
    }
    tfa_workspace_free(workspace);
    for (uint32_t c = 0; c < CLIENTS; c++)
        tfa_dds_client_close(others[c]);
}

/* 1000 samples of torques come back as accelerations with their seq and stamp. */
TEST(streams_echo)
{
    static inputs in;
    static outputs here;
    tfa_dds_client *client = client_of(1);
    tfa_workspace *workspace;
    double qdd[N_MAX], base[6];
    assert_int_equal(tfa_workspace_create(robots[1].model, NULL, &workspace), TFA_OK);
    assert_int_equal(tfa_dds_stream_open(client, WAIT_MS), TFA_OK);
    for (uint32_t k = 0; k < 1000; k++) {
        make_inputs(&in, k);
        const tfa_dds_torques torques = {
            .seq = 7000u + k,
            .stamp = 1000 + (int64_t)k,
            .q = in.q,
            .v = in.v,
            .tau = in.tau,
            .base_pose = in.pose,
            .base_twist = in.twist,
            .base_wrench = in.wrench,
        };
        tfa_dds_accelerations got = {.qdd = qdd, .base_acceleration = base};
        const tfa_request request = make_request(robots[1].model, TFA_OP_FORWARD_DYNAMICS, &in, 1);
        tfa_reply b = reply_into(&here);
        assert_int_equal(tfa_compute(workspace, &request, &b), TFA_OK);
        assert_int_equal(tfa_dds_stream_publish(client, &torques), TFA_OK);
        assert_int_equal(tfa_dds_stream_take(client, &got, WAIT_NS), TFA_OK);
        assert_int_equal(got.status, TFA_OK);
        assert_int_equal(got.seq, torques.seq);
        assert_int_equal(got.stamp, torques.stamp);
        assert_int_equal(got.answer.method, here.answers[0].method);
        assert_memory_equal(qdd, here.qdd, tfa_model_v_count(robots[1].model) * sizeof(double));
        assert_memory_equal(base, here.base_acceleration, sizeof base);
    }
    in.tau[2] = NAN;
    const tfa_dds_torques bad = {.seq = 1, .q = in.q, .tau = in.tau, .base_pose = in.pose};
    tfa_dds_accelerations got = {.qdd = qdd};
    assert_int_equal(tfa_dds_stream_publish(client, &bad), TFA_OK);
    assert_int_equal(tfa_dds_stream_take(client, &got, WAIT_NS), TFA_OK);
    assert_int_equal(got.status, TFA_E_VALUE);
    assert_int_equal(got.field, TFA_FIELD_TAU);
    assert_int_equal(got.index, 2);
    tfa_workspace_free(workspace);
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
    static inputs in;
    static outputs out;
    test_daemon *daemon = *state;
    tfa_dds_client *client = client_of(0);
    const tfa_request request = make_request(robots[0].model, TFA_OP_FORWARD_DYNAMICS, &in, 1);
    tfa_reply reply = reply_into(&out);
    test_daemon_stop(daemon);
    assert_int_equal(tfa_dds_client_call(client, &request, &reply, WAIT_NS, NULL),
                     TFA_E_DISCONNECTED);
    *daemon = test_daemon_start(test_domain(), NULL);
    /* A request of a moment in which only one side has found the other is lost. */
    assert_true(
        WAIT_FOR(tfa_dds_client_call(client, &request, &reply, 1000000000, NULL) == TFA_OK));
    assert_same_answer(client, robots[0].model, &request);
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
    if (!test_robots_make(robots))
        return 1;
    const int failures = test_run(start, stop);
    for (int r = 0; r < TEST_ROBOTS; r++)
        tfa_dds_client_close(clients[r]);
    for (int r = 0; r < TEST_ROBOTS; r++)
        tfa_model_free(robots[r].model);
    return failures;
}
