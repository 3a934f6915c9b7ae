/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Through the daemon and in process: the same bits, the same refusals, for every op.
 */
#include "harness.h"
#include "models.h"
#include "test.h"

#include <signal.h>
#include <totalforce/dynamics.h>
#include <totalforce/model.h>

#define BATCH 4
#define TIMEOUT_NS WAIT_NS

typedef struct robot_case {
    const char *name, *file, *yaml;
    tfa_base base;
} robot_case;

static const robot_case robots[] = {
    {"arm", "arm7.urdf", "", TFA_BASE_FIXED},
    {"dog", "quadruped.urdf", "    base: floating\n", TFA_BASE_FLOATING},
    {"man", "humanoid.urdf", "    base: floating\n    wait: block\n", TFA_BASE_FLOATING},
    {"snake", "snake64.urdf", "    wait: spin\n", TFA_BASE_FIXED},
};
#define ROBOTS (sizeof robots / sizeof *robots)

static void robots_yaml(char *out, size_t size)
{
    *out = 0;
    for (size_t i = 0; i < ROBOTS; i++) {
        const size_t used = strlen(out);
        snprintf(out + used, size - used, "  - name: %s\n    urdf: @/config/robots/%s\n%s",
                 robots[i].name, robots[i].file, robots[i].yaml);
    }
}

static double numbers[8][BATCH * 256];
static double base_pose[BATCH * 7];

static void fill_numbers(void)
{
    uint64_t s = 12345;
    for (int k = 0; k < 8; k++)
        for (int i = 0; i < BATCH * 256; i++) {
            s = s * 6364136223846793005u + 1442695040888963407u;
            numbers[k][i] = (double)(int64_t)(s >> 11) / 4503599627370496.0 - 1;
        }
    for (int i = 0; i < BATCH; i++) {
        const double pose[7] = {0.1 * i, 0.2, 0.3, 0.6, 0, 0, 0.8};
        memcpy(base_pose + 7 * (size_t)i, pose, sizeof pose);
    }
}

/* Room for every answer. */
typedef struct answers {
    tfa_reply reply;
    double qdd[BATCH * 256], base_acceleration[BATCH * 6], tau[BATCH * 256], base_wrench[BATCH * 6];
    double lambda_inv[BATCH * 48 * 48], mass_matrix[BATCH * 72 * 72];
    double poses[BATCH * 7 * 2];
    tfa_spectrum spectrum[BATCH];
    tfa_answer answers[BATCH];
} answers;

static answers *make_answers(void)
{
    answers *a = calloc(1, sizeof *a);
    a->reply = (tfa_reply){.qdd = a->qdd,
                           .base_acceleration = a->base_acceleration,
                           .tau = a->tau,
                           .base_wrench = a->base_wrench,
                           .lambda_inv = a->lambda_inv,
                           .mass_matrix = a->mass_matrix,
                           .spectrum = a->spectrum,
                           .poses = a->poses,
                           .answers = a->answers};
    return a;
}

/* @return the status of both */
static int compare(const tfa_request *r, tfa_workspace *workspace, tfa_client *client,
                   const char *what)
{
    answers *here = make_answers(), *there = make_answers();
    tfa_exchange times = {0};
    const int expected = tfa_compute(workspace, r, &here->reply);
    const int status = tfa_client_call(client, r, &there->reply, TIMEOUT_NS, &times);
    if (status != expected)
        fail_msg("%s: %s instead of %s", what, tfa_status_name(status), tfa_status_name(expected));
    assert_int_equal(here->reply.status, there->reply.status);
    assert_int_equal(here->reply.field, there->reply.field);
    assert_int_equal(here->reply.index, there->reply.index);
    assert_int_equal(here->reply.state, there->reply.state);
    const bool sent = times.t_sent != 0; /* the client refuses more than a slot holds by itself */
    assert_true(sent || status != TFA_OK);
    assert_true(there->reply.model == (sent ? here->reply.model : 0));
    const size_t head = offsetof(answers, qdd);
    if (memcmp((char *)here + head, (char *)there + head, sizeof *here - head) != 0)
        fail_msg("%s: other bits through the ring", what);
    assert_true(times.t_sent <= times.t_received && times.t_received <= times.t_start &&
                times.t_start <= times.t_done && times.t_done <= times.t_reply);
    free(here);
    free(there);
    return status;
}

static tfa_request base_request(tfa_op op, uint32_t count)
{
    return (tfa_request){.op = op,
                         .refine = TFA_REFINE_DEFAULT,
                         .estimate = TFA_ESTIMATE_ALWAYS,
                         .count = count,
                         .q = numbers[0],
                         .base_pose = base_pose};
}

/* Every op, method, frame, tips, wrenches, gravity, batch; good requests. */
static void compare_good(const char *name, const tfa_client_info *info, tfa_workspace *w,
                         tfa_client *client)
{
    char what[80];
    static const double moon[3] = {0, 0.1, -1.62};
    for (uint32_t op = TFA_OP_FORWARD_DYNAMICS; op <= TFA_OP_MASS_MATRIX; op++)
        for (uint32_t method = 0; method <= TFA_METHOD_PROPAGATION; method++)
            for (uint32_t count = 1; count <= BATCH; count += BATCH - 1) {
                tfa_request r = base_request((tfa_op)op, count);
                r.method = (tfa_method)method;
                r.v = numbers[1];
                r.tau = op == TFA_OP_FORWARD_DYNAMICS ? numbers[2] : NULL;
                r.qdd = op == TFA_OP_INVERSE_DYNAMICS ? numbers[3] : NULL;
                r.base_twist = numbers[4];
                r.base_wrench = numbers[5];
                r.base_acceleration = numbers[6];
                r.frame = (tfa_reference_frame)((op + method) % 3);
                r.flags = method & 1 ? TFA_WANT_SPECTRUM : 0;
                r.gravity = method & 2 ? moon : NULL;
                r.tip_count = op == TFA_OP_OPERATIONAL_INERTIA ? 2 : method % 2;
                r.tips[0] = info->frame_count - 1;
                r.tips[1] = info->frame_count / 2;
                r.wrench_count = op <= TFA_OP_INVERSE_DYNAMICS ? 2 : 0;
                r.wrench_frames[0] = info->frame_count - 1;
                r.wrench_frames[1] = 1;
                r.wrenches = numbers[7];
                snprintf(what, sizeof what, "%s op %u method %u count %u", name, op, method, count);
                (void)compare(&r, w, client, what);
            }
}

/* A request that changes the robot: bits of `variant` say how. */
static tfa_request changed_request(tfa_op op, uint32_t count, uint32_t variant,
                                   const tfa_client_info *info, uint32_t joints[4])
{
    static const double loads[2 * TFA_PAYLOAD_NUMBERS] = {0.5, 0.1,  0, 0.2,  0.01, 0.001,
                                                          0,   0.02, 0, 0.03, 2};
    tfa_request r = base_request(op, count);
    const uint32_t last = info->joint_count - 1;
    joints[0] = last / 2, joints[1] = 0, joints[2] = last, joints[3] = last / 3;
    r.v = numbers[1];
    r.tau = op == TFA_OP_FORWARD_DYNAMICS ? numbers[2] : NULL;
    r.qdd = op == TFA_OP_INVERSE_DYNAMICS ? numbers[3] : NULL;
    r.payload_count = variant & 1 ? 2 : 0;
    r.payload_frames[0] = info->frame_count - 1;
    r.payload_frames[1] = info->frame_count / 2;
    r.payloads = loads;
    r.locked_count = variant & 2 && op != TFA_OP_MASS_MATRIX ? 1 + variant % 2 : 0;
    r.locked = joints;
    if (op == TFA_OP_OPERATIONAL_INERTIA || (op == TFA_OP_FORWARD_DYNAMICS && !(variant & 4))) {
        r.tip_count = 2;
        r.tips[0] = info->frame_count - 1;
        r.tips[1] = info->frame_count / 3;
        r.flags = TFA_WANT_POSES;
    }
    return r;
}

/* Locked joints, payloads and poses; each alone, and what goes together. */
static void compare_changed(const char *name, const tfa_client_info *info, tfa_workspace *w,
                            tfa_client *client)
{
    char what[80];
    uint32_t joints[4];
    for (uint32_t op = TFA_OP_FORWARD_DYNAMICS; op <= TFA_OP_MASS_MATRIX; op++)
        for (uint32_t variant = 0; variant < 8; variant++)
            for (uint32_t count = 1; count <= BATCH; count += BATCH - 1) {
                const tfa_request r = changed_request((tfa_op)op, count, variant, info, joints);
                snprintf(what, sizeof what, "%s changed: op %u variant %u count %u", name, op,
                         variant, count);
                assert_int_equal(compare(&r, w, client, what), TFA_OK);
            }
}

/* Bad requests name the same field. */
static void compare_bad(const char *name, tfa_workspace *w, tfa_client *client)
{
    double q[BATCH * 256];
    memcpy(q, numbers[0], sizeof q);
    tfa_request good = base_request(TFA_OP_FORWARD_DYNAMICS, 2), r;
#define TRY(...)                                                                                   \
    do {                                                                                           \
        r = good;                                                                                  \
        __VA_ARGS__;                                                                               \
        (void)compare(&r, w, client, name);                                                        \
    } while (0)
    TRY(r.op = (tfa_op)0);
    TRY(r.op = (tfa_op)9);
    TRY(r.method = (tfa_method)99);
    TRY(r.method = TFA_METHOD_RNEA);
    TRY(r.frame = (tfa_reference_frame)7);
    TRY(r.estimate = (tfa_estimate)8);
    TRY(r.refine = TFA_MAX_REFINE + 1);
    TRY(r.count = 0);
    TRY(r.q = NULL);
    TRY(r.tip_count = TFA_MAX_TIPS + 1);
    TRY(r.tip_count = 1; r.tips[0] = 100000);
    TRY(r.wrench_count = 9);
    TRY(r.wrench_count = 1);
    TRY(r.wrench_count = 1; r.wrenches = numbers[1]; r.wrench_frames[0] = 5000);
    q[3] = __builtin_nan("");
    TRY(r.q = q);
    TRY(r.v = q);
    q[3] = __builtin_inf();
    TRY(r.tau = q);
    double pose[14] = {0, 0, 0, 0, 0, 0, 2, 0, 0, 0, 0, 0, 0, 1};
    TRY(r.base_pose = pose);
#undef TRY
}

/* Bad changes of the robot, too. */
static void compare_bad_changes(const char *name, const tfa_client_info *info, tfa_workspace *w,
                                tfa_client *client)
{
    uint32_t joints[4];
    const tfa_request good = changed_request(TFA_OP_FORWARD_DYNAMICS, 2, 7, info, joints);
    const uint32_t stranger = info->joint_count;
    double loads[2 * TFA_PAYLOAD_NUMBERS];
    tfa_request r;
#define REFUSED(status, ...)                                                                       \
    do {                                                                                           \
        r = good;                                                                                  \
        memcpy(loads, good.payloads, sizeof loads);                                                \
        r.payloads = loads;                                                                        \
        __VA_ARGS__;                                                                               \
        assert_int_equal(compare(&r, w, client, name), status);                                    \
    } while (0)
    REFUSED(TFA_OK, );
    REFUSED(TFA_E_SIZE, r.payload_count = TFA_MAX_PAYLOADS + 1);
    REFUSED(TFA_E_ARGUMENT, r.payloads = NULL);
    REFUSED(TFA_E_LINK, r.payload_frames[1] = info->frame_count);
    REFUSED(TFA_E_VALUE, loads[13] = __builtin_nan(""));
    REFUSED(TFA_E_ARGUMENT, loads[0] = -1);
    REFUSED(TFA_E_ARGUMENT, loads[14] = -1);
    REFUSED(TFA_E_SIZE, r.locked_count = info->v_count + 1);
    REFUSED(TFA_E_SIZE, r.locked_count = UINT32_MAX);
    REFUSED(TFA_E_ARGUMENT, r.locked = NULL);
    REFUSED(TFA_E_JOINT, r.locked_count = 1, r.locked = &stranger);
    REFUSED(TFA_E_METHOD, r.method = TFA_METHOD_CRBA);
    REFUSED(TFA_E_UNSUPPORTED, r.op = TFA_OP_MASS_MATRIX);
#undef REFUSED
}

static void check_info(const tfa_client_info *info, const tfa_model *model)
{
    assert_int_equal(info->q_count, tfa_model_q_count(model));
    assert_int_equal(info->v_count, tfa_model_v_count(model));
    assert_int_equal(info->base_freedoms, tfa_model_base_freedoms(model));
    assert_int_equal(info->joint_count, tfa_model_joint_count(model));
    assert_int_equal(info->frame_count, tfa_model_frame_count(model));
    assert_string_equal(info->model_hash, tfa_model_hash_text(model));
    for (uint32_t i = 0; i < info->joint_count; i++) {
        assert_string_equal(info->joint_names[i], tfa_model_joint(model, i).name);
        assert_int_equal(info->joint_types[i], tfa_model_joint(model, i).type);
    }
    for (uint32_t i = 0; i < info->frame_count; i++)
        assert_string_equal(info->frame_names[i], tfa_model_frame(model, i).name);
}

static void same_bits_with(const harness *h, const robot_case *robot)
{
    char path[256];
    const tfa_model_options options = {.base = robot->base};
    tfa_report report = {0};
    tfa_model *model;
    snprintf(path, sizeof path, "%s/config/robots/%s", TFA_SOURCE_DIR, robot->file);
    assert_int_equal(tfa_model_load(path, &options, &report, &model), TFA_OK);
    tfa_workspace *workspace = workspace_for(model, NULL);
    tfa_client_options client_options = harness_options(h, robot->name);
    tfa_client *client;
    client_options.max_batch = BATCH;
    client_options.slots = 2;
    assert_int_equal(tfa_client_connect(&client_options, &client), TFA_OK);
    const tfa_client_info *info = tfa_client_get_info(client);
    check_info(info, model);
    compare_good(robot->name, info, workspace, client);
    compare_changed(robot->name, info, workspace, client);
    compare_bad(robot->name, workspace, client);
    compare_bad_changes(robot->name, info, workspace, client);
    tfa_client_close(client);
    tfa_workspace_free(workspace);
    tfa_model_free(model);
    tfa_report_free(&report);
}

TEST(same_bits)
{
    static const char *const settings[] = {"", "backend: memfd\nworkers: 2\n"};
    char yaml[1024];
    fill_numbers();
    robots_yaml(yaml, sizeof yaml);
    for (int i = 0; i < 2; i++) {
        harness h;
        harness_serve(&h, yaml, settings[i]);
        for (size_t k = 0; k < ROBOTS; k++)
            same_bits_with(&h, &robots[k]);
        assert_int_equal(harness_stop(&h, SIGTERM), 0);
        harness_remove(&h);
    }
}
