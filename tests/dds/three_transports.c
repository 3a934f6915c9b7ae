/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * One request through the library, the ring and DDS: the same status and field, the same buffers
 * written with the same bits, the other buffers untouched. Every op with every choice of tips,
 * poses, spectrum, wrenches, payloads and locked joints.
 */
#include "dds_test.h"

#include "harness.h"

#include <signal.h>
#include <string.h>

#include <totalforce/model.h>

#include "dds_client/dds_client.h"

#define BATCH 3
#define V_MAX 12
#define ROWS (6 * 2)
#define CANARY 0xa5

#define GIMBAL "/tests/tools/data/gimbal.urdf"

enum { TIPS = 1, POSES = 2, SPECTRUM = 4, WRENCHES = 8, PAYLOADS = 16, LOCKED = 32, CHOICES = 64 };

typedef struct transports {
    tfa_model *model;
    tfa_workspace *library;
    tfa_client *ring;
    tfa_dds_client *dds;
    uint32_t v_count, base_freedoms;
} transports;

static double numbers[6][BATCH * V_MAX], pose[BATCH * 7];

/* One buffer for every answer that a request of this test can have. */
typedef struct buffers {
    double qdd[BATCH * V_MAX], base_acceleration[BATCH * 6], tau[BATCH * V_MAX];
    double base_wrench[BATCH * 6], lambda_inv[BATCH * ROWS * ROWS];
    double mass_matrix[BATCH * (V_MAX + 6) * (V_MAX + 6)], poses[BATCH * 2 * 7];
    tfa_spectrum spectrum[BATCH];
    tfa_answer answers[BATCH];
} buffers;

static tfa_reply reply_into(buffers *b)
{
    memset(b, CANARY, sizeof *b);
    return (tfa_reply){.qdd = b->qdd,
                       .base_acceleration = b->base_acceleration,
                       .tau = b->tau,
                       .base_wrench = b->base_wrench,
                       .lambda_inv = b->lambda_inv,
                       .mass_matrix = b->mass_matrix,
                       .spectrum = b->spectrum,
                       .poses = b->poses,
                       .answers = b->answers};
}

static tfa_request make_request(const transports *d, tfa_op op, unsigned choice, uint32_t count)
{
    static const double load[TFA_PAYLOAD_NUMBERS] = {0.5,   0.1, 0,    0.2, 0.01,
                                                     0.001, 0,   0.02, 0,   0.03};
    static const uint32_t joint = 2;
    tfa_request r = {.op = op,
                     .estimate = TFA_ESTIMATE_NEVER,
                     .refine = TFA_REFINE_DEFAULT,
                     .count = count,
                     .q = numbers[0],
                     .v = numbers[1],
                     .tau = numbers[2],
                     .qdd = numbers[3],
                     .tips = {5, 3},
                     .wrench_frames = {4},
                     .payload_frames = {5}};
    r.base_pose = d->base_freedoms ? pose : NULL;
    r.base_twist = d->base_freedoms ? numbers[4] : NULL;
    r.tip_count = choice & TIPS ? 2 : 0;
    r.flags = (choice & POSES ? TFA_WANT_POSES : 0) | (choice & SPECTRUM ? TFA_WANT_SPECTRUM : 0);
    r.wrench_count = choice & WRENCHES ? 1 : 0;
    r.wrenches = numbers[5];
    r.payload_count = choice & PAYLOADS ? 1 : 0;
    r.payloads = load;
    r.locked_count = choice & LOCKED ? 1 : 0;
    r.locked = &joint;
    return r;
}

/* What the op of a request is answered with, by the header; the other buffers stay as they are. */
static void assert_written(const tfa_request *r, const transports *d, const buffers *b, int status)
{
    const int ok = status == TFA_OK, forward = r->op == TFA_OP_FORWARD_DYNAMICS;
    const int inverse = r->op == TFA_OP_INVERSE_DYNAMICS, base = d->base_freedoms > 0;
    const int tips = r->tip_count > 0;
    const int lambda = tips && (forward || r->op == TFA_OP_OPERATIONAL_INERTIA);
    const struct {
        const char *name;
        const void *buffer;
        size_t size;
        int expected;
    } rows[] = {
        {"qdd", b->qdd, r->count * d->v_count * sizeof(double), forward},
        {"base_acceleration", b->base_acceleration, r->count * 6 * sizeof(double), forward && base},
        {"tau", b->tau, r->count * d->v_count * sizeof(double), inverse},
        {"base_wrench", b->base_wrench, r->count * 6 * sizeof(double), inverse && base},
        {"lambda_inv", b->lambda_inv, r->count * ROWS * ROWS * sizeof(double), lambda},
        {"mass_matrix", b->mass_matrix, r->count * (d->v_count + d->base_freedoms) * sizeof(double),
         r->op == TFA_OP_MASS_MATRIX},
        {"poses", b->poses, r->count * 2 * 7 * sizeof(double), tips && r->flags & TFA_WANT_POSES},
        {"spectrum", b->spectrum, r->count * sizeof *b->spectrum,
         lambda && r->flags & TFA_WANT_SPECTRUM},
        {"answers", b->answers, r->count * sizeof *b->answers, 1},
    };
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
        const unsigned char *at = rows[k].buffer;
        size_t kept = 0;
        for (size_t i = 0; i + 8 <= rows[k].size; i += 8)
            kept += memcmp(at + i, "\xa5\xa5\xa5\xa5\xa5\xa5\xa5\xa5", 8) == 0;
        if (ok && rows[k].expected ? kept > 0 : kept != rows[k].size / 8)
            fail_msg("op %d, flags %u, %u tips: %s: %zu of %zu words untouched", r->op, r->flags,
                     r->tip_count, rows[k].name, kept, rows[k].size / 8);
    }
}

static void assert_same(const tfa_reply *expected, const buffers *here, const tfa_reply *got,
                        const buffers *there, const char *what)
{
    if (expected->status != got->status || expected->field != got->field ||
        expected->index != got->index || expected->state != got->state)
        fail_msg("%s: %s, field %d, index %u, state %u instead of %s, %d, %u, %u", what,
                 tfa_status_name(got->status), got->field, got->index, got->state,
                 tfa_status_name(expected->status), expected->field, expected->index,
                 expected->state);
    if (memcmp(here, there, sizeof *here) != 0)
        fail_msg("%s: other bits or other buffers than the library's", what);
}

static void compare(transports *d, const tfa_request *r, unsigned choice)
{
    static buffers here, there;
    tfa_reply expected = reply_into(&here), got = reply_into(&there);
    char what[64];
    const int status = tfa_compute(d->library, r, &expected);
    if (status != TFA_E_NOT_COMPUTED) /* which leaves the numbers of such a state in the buffers */
        assert_written(r, d, &here, status);
    snprintf(what, sizeof what, "ring: op %d, choice %u, count %u", r->op, choice, r->count);
    (void)tfa_client_call(d->ring, r, &got, WAIT_NS, NULL);
    assert_same(&expected, &here, &got, &there, what);
    got = reply_into(&there);
    snprintf(what, sizeof what, "dds: op %d, choice %u, count %u", r->op, choice, r->count);
    (void)tfa_dds_client_call(d->dds, r, &got, WAIT_NS, NULL);
    assert_same(&expected, &here, &got, &there, what);
}

/* Without a buffer for lambda_inv there is nothing to take a spectrum of. */
static void compare_without_lambda_inv(transports *d)
{
    static buffers here, there;
    const tfa_request r =
        make_request(d, TFA_OP_OPERATIONAL_INERTIA, TIPS | POSES | SPECTRUM, BATCH);
    tfa_reply expected = reply_into(&here), got = reply_into(&there);
    expected.lambda_inv = got.lambda_inv = NULL;
    assert_int_equal(tfa_compute(d->library, &r, &expected), TFA_OK);
    assert_int_equal(tfa_client_call(d->ring, &r, &got, WAIT_NS, NULL), TFA_OK);
    assert_same(&expected, &here, &got, &there, "ring: no buffer for lambda_inv");
}

static void fill_numbers(void)
{
    uint64_t seed = 7;
    for (int k = 0; k < 6; k++)
        for (int i = 0; i < BATCH * V_MAX; i++)
            numbers[k][i] = test_random(&seed);
    for (int i = 0; i < BATCH; i++) {
        const double x[7] = {0.1 * i, 0.2, 0.3, 0.6, 0, 0, 0.8};
        memcpy(pose + 7 * (size_t)i, x, sizeof x);
    }
}

static transports open_transports(const harness *h, const char *robot, const char *file,
                                  tfa_base base)
{
    const tfa_model_options options = {.base = base};
    const tfa_dds_client_options over = {
        .domain = test_domain(), .robot = robot, .connect_timeout_ms = 20000};
    tfa_client_options ring = harness_options(h, robot);
    tfa_report report = {0};
    transports d;
    ring.max_batch = BATCH;
    assert_int_equal(tfa_model_load(file, &options, &report, &d.model), TFA_OK);
    assert_int_equal(tfa_workspace_create(d.model, NULL, &d.library), TFA_OK);
    assert_int_equal(tfa_client_connect(&ring, &d.ring), TFA_OK);
    assert_int_equal(tfa_dds_client_connect(&over, &d.dds), TFA_OK);
    d.v_count = tfa_model_v_count(d.model);
    d.base_freedoms = tfa_model_base_freedoms(d.model);
    tfa_report_free(&report);
    return d;
}

static void close_transports(transports *d)
{
    tfa_dds_client_close(d->dds);
    tfa_client_close(d->ring);
    tfa_workspace_free(d->library);
    tfa_model_free(d->model);
}

static void ask_all(const harness *h, const char *robot, const char *file, tfa_base base)
{
    transports d = open_transports(h, robot, file, base);
    for (tfa_op op = TFA_OP_FORWARD_DYNAMICS; op <= TFA_OP_MASS_MATRIX; op++)
        for (unsigned choice = 0; choice < CHOICES; choice++)
            for (uint32_t count = 1; count <= BATCH; count += BATCH - 1) {
                const tfa_request r = make_request(&d, op, choice, count);
                compare(&d, &r, choice);
            }
    compare_without_lambda_inv(&d);
    close_transports(&d);
}

/* Near gimbal lock: the sentinel's flag, or the refusal with the name of a body, comes through
 * every gateway without being asked for. */
static void ask_gimbal(transports *d, double pitch, int status)
{
    const double q[BATCH * 3] = {0.7, pitch, 0.2, -0.3, pitch, 0.1, 1.1, pitch, -0.6};
    for (uint32_t count = 1; count <= BATCH; count += BATCH - 1) {
        tfa_request r = make_request(d, TFA_OP_FORWARD_DYNAMICS, 0, count);
        tfa_answer answers[BATCH];
        tfa_reply reply = {.answers = answers};
        r.estimate = TFA_ESTIMATE_DEFAULT;
        r.q = q;
        compare(d, &r, 0);
        assert_int_equal(tfa_dds_client_call(d->dds, &r, &reply, WAIT_NS, NULL), status);
        if (status != TFA_OK)
            assert_int_equal(reply.field, TFA_FIELD_BODY);
        for (uint32_t k = 0; k < count && status == TFA_OK; k++)
            assert_true(answers[k].flags & TFA_ANSWER_SENTINEL &&
                        answers[k].flags & TFA_ANSWER_ESTIMATED);
    }
}

static void ask_nearly_singular(const harness *h)
{
    transports d = open_transports(h, "gimbal", TFA_SOURCE_DIR GIMBAL, TFA_BASE_FIXED);
    ask_gimbal(&d, 1.5707, TFA_OK);
    ask_gimbal(&d, 1.5707963267948966, TFA_E_NOT_COMPUTED);
    close_transports(&d);
}

/* The number after `text` in the log of a daemon that has ended; 0 without it. */
static unsigned logged_number(const harness *h, const char *text)
{
    char path[128], line[512];
    unsigned number = 0;
    snprintf(path, sizeof path, "%s/log", h->directory);
    FILE *log = fopen(path, "r");
    assert_non_null(log);
    while (fgets(line, sizeof line, log)) {
        const char *at = strstr(line, text);
        number = at ? (unsigned)strtoul(at + strlen(text), NULL, 10) : number;
    }
    fclose(log);
    return number;
}

/* The log says that DDS is on and where; its summary counts the requests of both transports. */
static void assert_logged(const harness *h)
{
    const unsigned asked = 2 * 4 * CHOICES * 2; /* robots, ops, choices, counts */
    char text[128];
    snprintf(text, sizeof text, "dds: domain %u, 3 robots: totalforce/request and", test_domain());
    assert_true(harness_logged(h, text));
    assert_in_range(logged_number(h, "dds: requests "), asked, asked + 24); /* and hellos */
    assert_in_range(logged_number(h, "refused 0, requests "), 2 * asked, 2 * asked + 24);
}

TEST(library_ring_and_dds_agree)
{
    static const char robots[] = "  - name: arm\n    urdf: @/config/robots/arm7.urdf\n"
                                 "    max_batch: 3\n"
                                 "  - name: dog\n    urdf: @/config/robots/quadruped.urdf\n"
                                 "    base: floating\n    max_batch: 3\n"
                                 "  - name: gimbal\n    urdf: @" GIMBAL "\n    max_batch: 3\n";
    char dds[64];
    harness h;
    fill_numbers();
    snprintf(dds, sizeof dds, "dds:\n  enabled: true\n  domain: %u\n", test_domain());
    harness_make(&h, robots, dds);
    harness_start(&h, "dog");
    ask_all(&h, "arm", TFA_SOURCE_DIR "/config/robots/arm7.urdf", TFA_BASE_FIXED);
    ask_all(&h, "dog", TFA_SOURCE_DIR "/config/robots/quadruped.urdf", TFA_BASE_FLOATING);
    ask_nearly_singular(&h);
    assert_int_equal(harness_stop(&h, SIGTERM), 0);
    assert_logged(&h);
    harness_remove(&h);
}
