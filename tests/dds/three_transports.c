/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * One request through the library, the ring and DDS: the same status and field, the same buffers
 * written with the same bits, the other buffers untouched. Every op with every flag, alone and all
 * together, and every choice of tips, rows, wrenches, payloads and locked joints; every policy for
 * rank loss; every buffer alone; as many tips as a request can have.
 */
#include "dds_test.h"

#include "harness.h"
#include "herald.h"
#include "support/closed_dog.h"

#include <signal.h>
#include <string.h>

#include <totalforce/model.h>
#include <totalforce/modes.h>
#include <totalforce/statistics.h>

#include "dds_client/dds_client.h"
#include "ipc/wire_blocks.h"

#define BATCH 3
#define CANARY 0xa5
#define WORDS 2048      /* of the largest answer to few tips */
#define WORDS_MAX 40960 /* to TFA_MAX_TIPS */
#define FLAG_SETS 16    /* none, each of 14, all that the op answers */

#define POLICIES 36 /* for rank loss, thresholds, frames */
#define METHODS 16

#define ARM7 "/config/robots/arm7.urdf"
#define DOG "/config/robots/quadruped.urdf"
#define FLEXIBLE "arm.flexible"
#define CLOSED "dog.closed"
#define MODES "/tests/tools/data/arm7_modes.yaml"
#define GIMBAL "/tests/tools/data/gimbal.urdf"

enum { TIPS = 1, POINT = 2, WRENCHES = 4, PAYLOADS = 8, LOCKED = 16, CHOICES = 32 };

typedef struct transports {
    tfa_model *model;
    tfa_workspace *library;
    tfa_client *ring;
    tfa_dds_client *dds;
    tfa_wire_shape shape;
    size_t words;         /* of each buffer, larger than any answer */
    uint64_t first, last; /* requests over DDS: ids count hellos and requests */
} transports;

/* Over DDS: how many hellos it took to connect is a matter of discovery. */
static uint64_t hellos, requests;

static double numbers[7][BATCH * 6 * TFA_MAX_TIPS], pose[BATCH * 7], modes[2][BATCH * 3];

/* One buffer for every answer. */
typedef struct buffers {
    double block[TFA_WIRE_REPLY_BLOCKS][WORDS_MAX];
} buffers;

static tfa_reply reply_into(buffers *b, const transports *d)
{
    tfa_reply reply = {0};
    for (uint32_t k = 0; k < TFA_WIRE_REPLY_BLOCKS; k++)
        memset(b->block[k], CANARY, d->words * sizeof(double));
#define POINT_AT(name, field, ...) reply.field = (void *)b->block[TFA_WIRE_##name];
    TFA_OUTPUT_LIST(POINT_AT)
#undef POINT_AT
    return reply;
}

/* Flags that an op refuses */
static uint32_t unanswered(tfa_op op)
{
    const uint32_t lambda = TFA_WANT_SPECTRUM | TFA_WANT_LAMBDA | TFA_WANT_MU | TFA_WANT_P;
    return (TFA_OP_BIT(op) & TFA_OPS_SOLVE ? 0 : lambda) |
           (TFA_OP_BIT(op) & TFA_OPS_MOTION ? 0 : TFA_WANT_JOINT_FORCES) |
           (TFA_OP_BIT(op) & TFA_OPS_CONSTRAINED_SOLVE ? 0 : TFA_WANT_DELASSUS);
}

static uint32_t flags_of(tfa_op op, unsigned set)
{
    return set == 0 ? 0 : set < FLAG_SETS - 1 ? 1u << (set - 1) : TFA_WANT_ALL & ~unanswered(op);
}

static tfa_request make_request(const transports *d, tfa_op op, unsigned choice, uint32_t flags,
                                uint32_t count)
{
    static const double load[TFA_PAYLOAD_NUMBERS] = {0.5,   0.1, 0,    0.2, 0.01,
                                                     0.001, 0,   0.02, 0,   0.03};
    static const uint32_t joint = 2;
    static const double gains[2] = {100, 20};
    tfa_request r = {.op = op,
                     .estimate = TFA_ESTIMATE_NEVER,
                     .refine = TFA_REFINE_DEFAULT,
                     .flags = flags,
                     .count = count,
                     .q = numbers[0],
                     .v = numbers[1],
                     .tau = numbers[2],
                     .qdd = numbers[3],
                     .task_acceleration = numbers[6],
                     .tips = {5, 3},
                     .wrench_frames = {4},
                     .payload_frames = {5}};
    r.base_pose = d->shape.base_freedoms ? pose : NULL;
    r.base_twist = d->shape.base_freedoms ? numbers[4] : NULL;
    r.modes = d->shape.modes ? modes[0] : NULL;
    r.mode_velocities = d->shape.modes ? modes[1] : NULL;
    r.tip_count = choice & TIPS ? 2 : 0;
    r.rows = choice & POINT ? TFA_ROWS_POINT : TFA_ROWS_POSE;
    r.wrench_count = choice & WRENCHES ? 1 : 0;
    r.wrenches = numbers[5];
    r.payload_count = choice & PAYLOADS ? 1 : 0;
    r.payloads = load;
    r.locked_count = choice & LOCKED ? 1 : 0;
    r.locked = &joint;
    r.constraints = tfa_all_constraints(tfa_model_constraint_count(d->model));
    r.constraint_acceleration = numbers[6];
    r.stabilisation = gains;
    return r;
}

/* What the wire sends back is what the library writes, also about states that failed; the other
 * buffers stay as they are. */
static void assert_written(const tfa_request *r, const transports *d, const buffers *b, int status)
{
    const tfa_wire_reply_shape shape = tfa_wire_reply_shape_of(&d->shape, r);
    for (uint32_t k = 0; k < TFA_WIRE_REPLY_BLOCKS; k++) {
        const unsigned char *at = (const unsigned char *)b->block[k];
        const size_t size = tfa_wire_reply_width(&d->shape, k, &shape);
        const size_t expected = tfa_wire_has_answers(status) && shape.want >> k & 1 ? size : 0;
        size_t first = 0, last = d->words;
        assert_true(size < 8 * d->words);
        while (first < expected / 8 &&
               memcmp(at + 8 * first, "\xa5\xa5\xa5\xa5\xa5\xa5\xa5\xa5", 8) != 0)
            first++;
        while (last > first &&
               memcmp(at + 8 * (last - 1), "\xa5\xa5\xa5\xa5\xa5\xa5\xa5\xa5", 8) == 0)
            last--;
        if (first != expected / 8 || last != first)
            fail_msg("op %d, flags %x, %u tips, rows %d: block %u: %zu words written, not %zu",
                     r->op, r->flags, r->tip_count, r->rows, k, last, expected / 8);
    }
}

static void assert_same(const transports *d, const tfa_reply *expected, const buffers *here,
                        const tfa_reply *got, const buffers *there, const char *what)
{
    if (expected->status != got->status || expected->field != got->field ||
        expected->index != got->index || expected->state != got->state)
        fail_msg("%s: %s, field %d, index %u, state %u instead of %s, %d, %u, %u", what,
                 tfa_status_name(got->status), got->field, got->index, got->state,
                 tfa_status_name(expected->status), expected->field, expected->index,
                 expected->state);
    for (uint32_t k = 0; k < TFA_WIRE_REPLY_BLOCKS; k++)
        if (memcmp(here->block[k], there->block[k], 8 * d->words) != 0)
            fail_msg("%s: block %u: other bits or another buffer than the library's", what, k);
}

/* Only buffer `block` of a reply; all of them, if there is no such block. */
static void keep_buffer(tfa_reply *reply, uint32_t block)
{
#define KEEP(name, field, ...)                                                                     \
    if (block < TFA_WIRE_REPLY_BLOCKS && block != TFA_WIRE_##name)                                 \
        reply->field = NULL;
    TFA_OUTPUT_LIST(KEEP)
#undef KEEP
}

static int call_dds(transports *d, const tfa_request *r, tfa_reply *reply)
{
    tfa_exchange exchange = {0};
    const int status = tfa_dds_client_call(d->dds, r, reply, WAIT_NS, &exchange);
    if (exchange.id != 0)
        d->last = exchange.id;
    if (d->first == 0)
        d->first = d->last;
    return status;
}

static void compare_buffer(transports *d, const tfa_request *r, unsigned choice, uint32_t block)
{
    static buffers here, there;
    tfa_reply expected = reply_into(&here, d), got = reply_into(&there, d);
    char what[120];
    keep_buffer(&expected, block);
    keep_buffer(&got, block);
    const int status = tfa_compute(d->library, r, &expected);
    if (block == TFA_WIRE_REPLY_BLOCKS)
        assert_written(r, d, &here, status);
    snprintf(what, sizeof what, "ring: op %d, choice %u, flags %x, count %u, %u tips, block %u",
             r->op, choice, r->flags, r->count, r->tip_count, block);
    (void)tfa_client_call(d->ring, r, &got, WAIT_NS, NULL);
    assert_same(d, &expected, &here, &got, &there, what);
    got = reply_into(&there, d);
    keep_buffer(&got, block);
    memcpy(what, "dds: ", 5);
    (void)call_dds(d, r, &got);
    /* the daemon has a lambda_inv and accelerations to take them of */
    if (block != TFA_WIRE_SPECTRUM && block != TFA_WIRE_JOINT_FORCES)
        assert_same(d, &expected, &here, &got, &there, what);
}

static void compare(transports *d, const tfa_request *r, unsigned choice)
{
    compare_buffer(d, r, choice, TFA_WIRE_REPLY_BLOCKS);
}

static void fill_numbers(void)
{
    uint64_t seed = 7;
    for (int k = 0; k < 7; k++)
        for (size_t i = 0; i < sizeof numbers[k] / sizeof numbers[k][0]; i++)
            numbers[k][i] = test_random(&seed);
    for (int i = 0; i < BATCH; i++) {
        const double x[7] = {0.1 * i, 0.2, 0.3, 0.6, 0, 0, 0.8};
        memcpy(pose + 7 * (size_t)i, x, sizeof x);
    }
    for (int i = 0; i < BATCH * 3; i++) { /* one state is beyond a limit */
        modes[0][i] = 0.02 * (i % 4);
        modes[1][i] = 0.3 * (i % 5) - 0.5;
    }
}

static transports open_transports(const harness *h, const char *robot, const char *file,
                                  tfa_base base, uint32_t max_tips)
{
    const tfa_workspace_options workspace = {.max_tips = max_tips};
    tfa_modes of_links = {0};
    tfa_client_options ring = harness_options(h, robot);
    tfa_report report = {0};
    transports d = {0};
    ring.max_batch = BATCH;
    ring.max_tips = max_tips;
    if (strcmp(robot, FLEXIBLE) == 0)
        assert_int_equal(tfa_modes_load(TFA_SOURCE_DIR MODES, &of_links, &report), TFA_OK);
    const tfa_scene flexible = {.modes = of_links.links, .modes_count = of_links.count};
    const tfa_model_options options = {.base = base,
                                       .scene = of_links.count               ? &flexible
                                                : strcmp(robot, CLOSED) == 0 ? &closed_dog_scene
                                                                             : NULL};
    assert_int_equal(tfa_model_load(file, &options, &report, &d.model), TFA_OK);
    assert_int_equal(tfa_workspace_create(d.model, &workspace, &d.library), TFA_OK);
    assert_int_equal(tfa_client_connect(&ring, &d.ring), TFA_OK);
    d.dds = dds_connect(test_domain(), robot);
    d.shape = (tfa_wire_shape){.q_count = tfa_model_q_count(d.model),
                               .v_count = tfa_model_v_count(d.model),
                               .base_freedoms = tfa_model_base_freedoms(d.model),
                               .frames = tfa_model_frame_count(d.model),
                               .modes = tfa_model_mode_count(d.model),
                               .max_batch = BATCH,
                               .max_tips = max_tips ? max_tips : TFA_DEFAULT_TIPS};
    d.words = max_tips ? WORDS_MAX : WORDS;
    tfa_modes_free(&of_links);
    tfa_report_free(&report);
    return d;
}

static void close_transports(transports *d)
{
    hellos += d->first - 1;
    requests += d->last - d->first + 1;
    tfa_dds_client_close(d->dds);
    tfa_client_close(d->ring);
    tfa_workspace_free(d->library);
    tfa_model_free(d->model);
}

/* Every choice with every set of flags; a fifth of the pairs unless TEST_LONG is set */
static int is_asked(tfa_op op, unsigned choice, unsigned set)
{
    return (choice + 3 * set + (unsigned)op) % test_extent(5, 1) == 0;
}

static void ask_all(transports *d)
{
    for (tfa_op op = TFA_OP_FORWARD_DYNAMICS; op <= TFA_OP_LAST; op++)
        for (unsigned choice = 0; choice < CHOICES; choice++)
            for (unsigned set = 0; set < FLAG_SETS; set++)
                for (uint32_t count = 1; count <= BATCH && is_asked(op, choice, set);
                     count += BATCH - 1) {
                    const tfa_request r = make_request(d, op, choice, flags_of(op, set), count);
                    compare(d, &r, choice);
                }
}

/* Tips that cannot move in all their rows: twice the same one, with every policy and threshold, one
 * of them invalid. */
static void ask_without_rank(transports *d)
{
    static const double thresholds[] = {0, 1e-3, 2};
    for (tfa_op op = TFA_OP_FORWARD_DYNAMICS; op <= TFA_OP_LAST; op++)
        for (unsigned policy = 0; policy < POLICIES; policy++) {
            tfa_request r = make_request(d, op, TIPS, TFA_WANT_ALL, BATCH);
            const double *threshold = &thresholds[policy / 4 % 3];
            r.tips[1] = r.tips[0];
            r.rank_loss = (tfa_rank_loss)(policy % 4); /* the last one does not exist */
            r.rank_threshold = *threshold > 0 ? threshold : NULL;
            r.frame = (tfa_reference_frame)(policy / 12);
            r.flags &= ~unanswered(op);
            compare(d, &r, policy);
        }
}

/* A program has no buffer but one. */
static void ask_for_one_buffer(transports *d)
{
    for (tfa_op op = TFA_OP_FORWARD_DYNAMICS; op <= TFA_OP_LAST; op++)
        for (uint32_t block = 0; block < TFA_WIRE_REPLY_BLOCKS; block++) {
            tfa_request r = make_request(d, op, TIPS, TFA_WANT_ALL, BATCH);
            r.flags &= ~unanswered(op);
            compare_buffer(d, &r, TIPS, block);
        }
}

static void ask_robot(const harness *h, const char *robot, const char *file, tfa_base base)
{
    transports d = open_transports(h, robot, file, base, 0);
    ask_all(&d);
    ask_without_rank(&d);
    ask_for_one_buffer(&d);
    close_transports(&d);
}

/* Constraints of a scene come by name, and their answers with their bits. */
static void ask_closed(const harness *h)
{
    transports d = open_transports(h, CLOSED, TFA_SOURCE_DIR DOG, TFA_BASE_FLOATING, 0);
    const tfa_client_info *infos[] = {tfa_client_get_info(d.ring), tfa_dds_client_get_info(d.dds)};
    for (int k = 0; k < 2; k++) {
        assert_int_equal(infos[k]->constraint_count, 2);
        assert_string_equal(infos[k]->constraint_names[0], "stand");
        assert_string_equal(infos[k]->constraint_names[1], "rod");
    }
    ask_all(&d);
    ask_without_rank(&d);
    ask_for_one_buffer(&d);
    close_transports(&d);
}

/* Modes of links come and go through every gateway, and so does the flag of their limit. */
static void ask_flexible(const harness *h)
{
    transports d = open_transports(h, FLEXIBLE, TFA_SOURCE_DIR ARM7, TFA_BASE_FIXED, 0);
    const tfa_client_info *infos[] = {tfa_client_get_info(d.ring), tfa_dds_client_get_info(d.dds)};
    for (int k = 0; k < 2; k++) {
        assert_int_equal(infos[k]->mode_count, d.shape.modes);
        for (uint32_t i = 0; i < d.shape.modes; i++)
            assert_string_equal(infos[k]->frame_names[infos[k]->mode_frames[i]],
                                tfa_model_mode(d.model, i).link);
    }
    ask_all(&d);
    const tfa_request r = make_request(&d, TFA_OP_FORWARD_DYNAMICS, 0, 0, BATCH);
    tfa_answer answers[BATCH];
    tfa_reply reply = {.answers = answers};
    assert_int_equal(tfa_client_call(d.ring, &r, &reply, WAIT_NS, NULL), TFA_OK);
    for (int k = 0; k < BATCH; k++)
        assert_int_equal((answers[k].flags & TFA_ANSWER_MODE_LIMIT) != 0, k == 1);
    close_transports(&d);
}

/* Links as tips, over and over; one more is refused by all. */
static void ask_many_tips(const harness *h, const char *robot, const char *file, tfa_base base)
{
    transports d = open_transports(h, robot, file, base, TFA_MAX_TIPS);
    for (tfa_op op = TFA_OP_FORWARD_DYNAMICS; op <= TFA_OP_LAST; op++)
        for (unsigned choice = TIPS; choice <= (TIPS | POINT); choice += POINT)
            for (uint32_t tips = TFA_DEFAULT_TIPS; tips <= TFA_MAX_TIPS; tips *= 2) {
                tfa_request r = make_request(&d, op, choice, TFA_WANT_ALL, 1);
                r.flags &= ~unanswered(op);
                r.tip_count = tips;
                for (uint32_t k = 0; k < tips; k++)
                    r.tips[k] = k % d.shape.frames;
                compare(&d, &r, choice);
            }
    close_transports(&d);
}

/* More tips than a connection has are refused by name, whatever the workspace of the daemon has
 * memory for; over DDS they are answered. */
static void ask_beyond_the_connection(const harness *h)
{
    static double lambda_inv[36 * 81];
    transports d = open_transports(h, "dog", TFA_SOURCE_DIR DOG, TFA_BASE_FLOATING, 0);
    tfa_request r = make_request(&d, TFA_OP_OPERATIONAL_INERTIA, TIPS, 0, 1);
    tfa_reply reply = {.lambda_inv = lambda_inv};
    r.tip_count = TFA_DEFAULT_TIPS + 1;
    assert_int_equal(tfa_client_get_info(d.ring)->max_tips, TFA_DEFAULT_TIPS);
    assert_int_equal(tfa_client_call(d.ring, &r, &reply, WAIT_NS, NULL), TFA_E_SIZE);
    assert_int_equal(reply.field, TFA_FIELD_TIPS);
    assert_int_equal(reply.index, TFA_DEFAULT_TIPS + 1);
    assert_int_equal(tfa_client_send(d.ring, &r, NULL), TFA_E_SIZE);
    assert_int_equal(tfa_compute(d.library, &r, &reply), TFA_E_UNSUPPORTED);
    assert_int_equal(call_dds(&d, &r, &reply), TFA_OK);
    close_transports(&d);
}

/* Near gimbal lock: the sentinel's flag, or the refusal with the name of a body, comes through
 * every gateway without being asked for. */
static void ask_gimbal(transports *d, double pitch, int status)
{
    const double q[BATCH * 3] = {0.7, pitch, 0.2, -0.3, pitch, 0.1, 1.1, pitch, -0.6};
    for (uint32_t count = 1; count <= BATCH; count += BATCH - 1) {
        tfa_request r = make_request(d, TFA_OP_FORWARD_DYNAMICS, 0, 0, count);
        tfa_answer answers[BATCH];
        tfa_reply reply = {.answers = answers};
        r.estimate = TFA_ESTIMATE_DEFAULT;
        r.q = q;
        compare(d, &r, 0);
        assert_int_equal(call_dds(d, &r, &reply), status);
        if (status != TFA_OK)
            assert_int_equal(reply.field, TFA_FIELD_BODY);
        for (uint32_t k = 0; k < count && status == TFA_OK; k++)
            assert_true(answers[k].flags & TFA_ANSWER_SENTINEL &&
                        answers[k].flags & TFA_ANSWER_ESTIMATED);
    }
}

/* Methods that cannot have this robot, that answer some of its states, that fall back. */
static void ask_methods(transports *d, double pitch)
{
    const double q[BATCH * 3] = {0.7, pitch, 0.2, -0.3, 0.4, 0.1, 1.1, pitch, -0.6};
    for (tfa_op op = TFA_OP_FORWARD_DYNAMICS; op <= TFA_OP_LAST; op++)
        for (unsigned method = 0; method < METHODS; method++)
            for (unsigned all = 0; all < 2; all++) {
                tfa_request r = make_request(d, op, TIPS, 0, BATCH);
                r.flags = all ? TFA_WANT_ALL & ~unanswered(op) : 0;
                r.method = (tfa_method)method;
                r.q = q;
                r.tips[0] = 1;
                r.tips[1] = 2;
                compare(d, &r, method);
            }
}

static void ask_nearly_singular(const harness *h)
{
    transports d = open_transports(h, "gimbal", TFA_SOURCE_DIR GIMBAL, TFA_BASE_FIXED, 0);
    ask_gimbal(&d, 1.5707, TFA_OK);
    ask_gimbal(&d, 1.5707963267948966, TFA_E_NOT_COMPUTED);
    ask_methods(&d, 1.5707963267948966);
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
    /* robots and ops; choices, flags, counts; policies; buffers; rows and numbers of many tips */
    unsigned asked = TFA_OP_LAST * (3 * (POLICIES + TFA_WIRE_REPLY_BLOCKS) + 2 * 2 * 3);
    for (tfa_op op = TFA_OP_FORWARD_DYNAMICS; op <= TFA_OP_LAST; op++)
        for (unsigned k = 0; k < CHOICES * FLAG_SETS; k++)
            asked += is_asked(op, k % CHOICES, k / CHOICES) ? 4 * 2 : 0;
    char text[128];
    snprintf(text, sizeof text, "dds: domain %u, 5 robots: totalforce/request and", test_domain());
    assert_true(harness_logged(h, text));
    const unsigned more = 48 + TFA_OP_LAST * METHODS * 2; /* the gimbal */
    assert_in_range(requests, asked, asked + more);
    assert_in_range(logged_number(h, "dds: requests "), requests, requests + hellos);
    assert_in_range(logged_number(h, "refused 0, requests "), 2 * asked, 2 * (asked + more));
}

/* Clients of shared memory that the daemon has not seen leave; its gateway is none. */
static uint32_t read_clients(tfa_statistics *statistics, tfa_snapshot *s)
{
    uint32_t clients = 0;
    assert_int_equal(tfa_statistics_read(statistics, s), TFA_OK);
    for (uint32_t i = 0; i < s->robot_count; i++)
        clients += s->robots[i].clients;
    return clients;
}

/* Every message but hellos was counted as a request, by the gateway or by the worker for it; the
 * other requests are those of clients of the ring, most of which have left. */
static void assert_counted(const harness *h)
{
    tfa_statistics *statistics;
    tfa_snapshot *s;
    uint64_t by_dds = 0, by_ring = 0, all = 0;
    assert_int_equal(tfa_statistics_open(h->runtime_dir, 0, &statistics), TFA_OK);
    assert_int_equal(tfa_snapshot_create(statistics, &s), TFA_OK);
    assert_true(WAIT_FOR(read_clients(statistics, s) == 0));
    for (uint32_t i = 0; i < s->client_count; i++) {
        const tfa_client_statistics *c = &s->clients[i];
        by_dds += c->served.kind == TFA_CLIENT_DDS ? c->tally.requests : 0;
        by_ring += c->served.kind == TFA_CLIENT_SHM ? c->tally.requests : 0;
        assert_int_equal(c->tally.queue.count, c->tally.requests);
    }
    for (uint32_t i = 0; i < s->robot_count; i++) {
        assert_true(s->robots[i].served.dds && s->robots[i].dds_request);
        assert_int_equal(s->robots[i].state.floating, i == 0 || i == 1);
        all += s->robots[i].total.requests;
        by_ring += s->robots[i].departed.requests;
    }
    assert_int_equal(by_dds, requests);
    assert_in_range(s->dds.requests, requests, requests + hellos);
    assert_int_equal(by_dds + by_ring, all);
    tfa_snapshot_free(s);
    tfa_statistics_close(statistics);
}

TEST(library_ring_and_dds_agree)
{
    static const char robots[] =
        "  - name: dog\n    urdf: @" DOG "\n"
        "    base: floating\n    max_batch: 3\n    max_tips: 32\n" CLOSED_DOG_YAML
        "  - name: gimbal\n    urdf: @" GIMBAL "\n    max_batch: 3\n    max_tips: 32\n"
        "  - name: arm\n    urdf: @" ARM7 "\n    max_batch: 3\n    max_tips: 32\n"
        "    scenes: [{name: flexible, modes: [@" MODES "]}]\n";
    fill_numbers();
    SCOPED_HARNESS h = harness_make(robots, dds_yaml(test_domain(), TEST_LEASE_MS));
    harness_start(&h, "dog");
    dds_herald(test_domain(), "arm");
    dds_herald(test_domain(), "dog");
    dds_herald(test_domain(), "gimbal");
    dds_herald(test_domain(), FLEXIBLE);
    dds_herald(test_domain(), CLOSED);
    ask_robot(&h, "arm", TFA_SOURCE_DIR ARM7, TFA_BASE_FIXED);
    ask_robot(&h, "dog", TFA_SOURCE_DIR DOG, TFA_BASE_FLOATING);
    ask_many_tips(&h, "arm", TFA_SOURCE_DIR ARM7, TFA_BASE_FIXED);
    ask_many_tips(&h, "dog", TFA_SOURCE_DIR DOG, TFA_BASE_FLOATING);
    ask_flexible(&h);
    ask_closed(&h);
    ask_beyond_the_connection(&h);
    ask_nearly_singular(&h);
    assert_counted(&h);
    assert_int_equal(harness_stop(&h, SIGTERM), 0);
    assert_logged(&h);
}
