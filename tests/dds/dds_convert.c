/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Requests and replies survive the way through a DDS writer and reader bit by bit, and samples of
 * the wrong size are refused with their field.
 */
#include "dds_gateway/dds_convert.h"
#include "dds_gateway/dds_topics.h"
#include "dds_test.h"
#include "same_request.h"

#include <math.h>
#include <string.h>

#define Q 9
#define V 8
#define BATCH 4

static const tfa_dds_shape floating = {Q, V, 6, BATCH};
static const tfa_dds_shape fixed = {Q, V, 0, BATCH};

/* Enough numbers for the largest array of a test. */
static double numbers[16][BATCH * 48 * 48];

static const uint32_t joints[V] = {7, 0, UINT32_MAX, 3, 4, 5, 6, 1};

static void fill_numbers(void)
{
    uint64_t seed = 1;

    for (size_t i = 0; i < 16; i++)
        for (size_t k = 0; k < BATCH * 48 * 48; k++)
            numbers[i][k] = test_random(&seed);
}

/* A request that uses every field. */
static tfa_request full_request(tfa_op op, const tfa_dds_shape *shape)
{
    const bool base = shape->base_freedoms > 0;

    return (tfa_request){
        .op = op,
        .method = TFA_METHOD_ABA,
        .estimate = TFA_ESTIMATE_ALWAYS,
        .frame = TFA_FRAME_WORLD,
        .refine = 2,
        .flags = TFA_WANT_SPECTRUM | TFA_WANT_POSES,
        .count = 3,
        .tip_count = 2,
        .wrench_count = 1,
        .payload_count = 3,
        .locked_count = 3,
        .tips = {4, 7},
        .wrench_frames = {5},
        .payload_frames = {9, UINT32_MAX, 0},
        .locked = joints,
        .q = numbers[0],
        .v = numbers[1],
        .tau = numbers[2],
        .qdd = numbers[3],
        .base_pose = base ? numbers[4] : NULL,
        .base_twist = base ? numbers[5] : NULL,
        .base_wrench = base ? numbers[6] : NULL,
        .base_acceleration = base ? numbers[7] : NULL,
        .gravity = numbers[8],
        .wrenches = numbers[9],
        .payloads = numbers[10],
    };
}

typedef struct pair {
    dds_entity_t participant, writer, reader;
} pair;

static pair open_pair(tfa_dds_topic id)
{
    const dds_entity_t participant = dds_create_participant(test_domain(), NULL, NULL);
    const dds_entity_t topic = tfa_dds_create_topic(participant, id);
    const pair p = {participant, tfa_dds_create_writer(participant, topic, id, NULL),
                    tfa_dds_create_reader(participant, topic, id, NULL)};

    assert_true(p.participant > 0 && topic > 0 && p.writer > 0 && p.reader > 0);
    return p;
}

/* Writes a sample and takes it again: through CDR, and without the network. */
static void pass(const pair *p, const void *in, void *out)
{
    void *samples[1] = {out};
    dds_sample_info_t info;

    assert_int_equal(dds_write(p->writer, in), DDS_RETCODE_OK);
    assert_int_equal(dds_take(p->reader, samples, &info, 1, 1), 1);
    assert_true(info.valid_data);
}

TEST(requests_survive)
{
    const tfa_dds_shape *shapes[] = {&floating, &fixed};
    const pair p = open_pair(TFA_DDS_REQUEST);
    totalforce_dds_Request *out = totalforce_dds_Request__alloc();

    memset(out, 0, sizeof *out);
    for (int s = 0; s < 2; s++)
        for (int op = TFA_OP_FORWARD_DYNAMICS; op <= TFA_OP_MASS_MATRIX; op++) {
            const tfa_request before = full_request((tfa_op)op, shapes[s]);
            totalforce_dds_Request in = {.id = (uint64_t)op, .stamp = -5};
            const request_sizes sizes = {Q, V, shapes[s]->base_freedoms};
            tfa_request after;
            tfa_dds_field_error field_error;

            assert_true(tfa_dds_set_robot(in.robot, "arm"));
            assert_int_equal(tfa_dds_request_fill(&before, shapes[s], &in), TFA_OK);
            pass(&p, &in, out);
            assert_string_equal(out->robot, "arm");
            assert_int_equal(out->id, op);
            assert_int_equal(out->stamp, -5);
            assert_int_equal(tfa_dds_request_view(out, shapes[s], &after, &field_error), TFA_OK);
            assert_same_request(&sizes, &before, &after);
        }
    totalforce_dds_Request_free(out, DDS_FREE_ALL);
    assert_int_equal(dds_delete(p.participant), DDS_RETCODE_OK);
}

TEST(replies_survive)
{
    static tfa_answer answers[BATCH], answers_out[BATCH];
    static tfa_spectrum spectrum[BATCH], spectrum_out[BATCH];
    static double got[7][BATCH * 48 * 48];
    const totalforce_dds_Hash hash = {1, 2, 3, 4, 5, 6, 7, 8, 9};
    const pair p = open_pair(TFA_DDS_REPLY);
    totalforce_dds_Reply *out = totalforce_dds_Reply__alloc();

    memset(out, 0, sizeof *out);
    for (uint16_t i = 0; i < BATCH; i++) {
        answers[i] = (tfa_answer){TFA_E_NOT_COMPUTED, TFA_METHOD_TFA, TFA_ANSWER_FALLBACK, NAN};
        spectrum[i] = (tfa_spectrum){6u + i, 0, 1e-300, 1e300};
    }
    for (int op = TFA_OP_FORWARD_DYNAMICS; op <= TFA_OP_MASS_MATRIX; op++) {
        const tfa_request request = full_request((tfa_op)op, &floating);
        const tfa_dds_reply_sizes sizes = tfa_dds_sizes_of_reply(&request, &floating);
        const tfa_reply before = {.status = TFA_E_NOT_COMPUTED,
                                  .field = TFA_FIELD_BODY,
                                  .index = 3,
                                  .state = 2,
                                  .qdd = numbers[0],
                                  .base_acceleration = numbers[1],
                                  .tau = numbers[2],
                                  .base_wrench = numbers[3],
                                  .lambda_inv = numbers[4],
                                  .mass_matrix = numbers[5],
                                  .spectrum = spectrum,
                                  .poses = numbers[6],
                                  .answers = answers};
        tfa_reply after = {.qdd = got[0],
                           .base_acceleration = got[1],
                           .tau = got[2],
                           .base_wrench = got[3],
                           .lambda_inv = got[4],
                           .mass_matrix = got[5],
                           .spectrum = spectrum_out,
                           .poses = got[6],
                           .answers = answers_out};
        totalforce_dds_Reply in = {.id = 77};

        tfa_dds_set_hash(in.model_hash, hash, 0x0102030405060708u);
        tfa_dds_reply_fill(&before, &sizes, &in);
        pass(&p, &in, out);
        assert_int_equal(out->id, 77);
        assert_int_equal(tfa_dds_reply_read(out, &sizes, &after), TFA_OK);
        assert_int_equal(after.status, TFA_E_NOT_COMPUTED);
        assert_int_equal(after.field, TFA_FIELD_BODY);
        assert_int_equal(after.index, 3);
        assert_int_equal(after.state, 2);
        assert_true(after.model == 0x0102030405060708u);
        assert_memory_equal(after.answers, answers, sizes.answers * sizeof *answers);
        assert_memory_equal(after.spectrum, spectrum, sizes.spectrum * sizeof *spectrum);
        assert_memory_equal(after.poses, numbers[6], sizes.poses * sizeof(double));
        assert_memory_equal(after.qdd, numbers[0], sizes.qdd * sizeof(double));
        assert_memory_equal(after.base_acceleration, numbers[1],
                            sizes.base_acceleration * sizeof(double));
        assert_memory_equal(after.tau, numbers[2], sizes.tau * sizeof(double));
        assert_memory_equal(after.base_wrench, numbers[3], sizes.base_wrench * sizeof(double));
        assert_memory_equal(after.lambda_inv, numbers[4], sizes.lambda_inv * sizeof(double));
        assert_memory_equal(after.mass_matrix, numbers[5], sizes.mass_matrix * sizeof(double));
    }
    totalforce_dds_Reply_free(out, DDS_FREE_ALL);
    assert_int_equal(dds_delete(p.participant), DDS_RETCODE_OK);
}

/* Each op asks for its own arrays and no others; a reply of another shape is not believed. */
TEST(sizes_follow_the_op)
{
    tfa_request r = full_request(TFA_OP_FORWARD_DYNAMICS, &floating);
    tfa_dds_reply_sizes s = tfa_dds_sizes_of_reply(&r, &floating);
    const tfa_reply bad = {.status = TFA_E_VALUE, .qdd = numbers[0]};
    const tfa_reply good = {.qdd = numbers[0]};
    totalforce_dds_Reply sample = {0};
    tfa_reply out = {0};

    assert_true(s.qdd == 3 * V && s.base_acceleration == 18 && s.lambda_inv == 3 * 144);
    assert_true(s.spectrum == 3 && s.answers == 3 && s.tau == 0 && s.mass_matrix == 0);
    assert_int_equal(s.poses, 3 * 2 * 7);
    r.flags = 0;
    s = tfa_dds_sizes_of_reply(&r, &floating);
    assert_true(s.poses == 0 && s.spectrum == 0);
    r.flags = TFA_WANT_SPECTRUM | TFA_WANT_POSES;
    r.tip_count = 0;
    s = tfa_dds_sizes_of_reply(&r, &fixed);
    assert_true(s.qdd == 3 * V && s.base_acceleration == 0 && s.lambda_inv == 0 && s.spectrum == 0);
    assert_int_equal(s.poses, 0);
    r.op = TFA_OP_INVERSE_DYNAMICS;
    s = tfa_dds_sizes_of_reply(&r, &floating);
    assert_true(s.tau == 3 * V && s.base_wrench == 18 && s.qdd == 0);
    r.op = TFA_OP_MASS_MATRIX;
    s = tfa_dds_sizes_of_reply(&r, &floating);
    assert_true(s.mass_matrix == 3 * (V + 6) * (V + 6) && s.tau == 0);

    r.op = TFA_OP_FORWARD_DYNAMICS;
    s = tfa_dds_sizes_of_reply(&r, &fixed);
    tfa_dds_reply_fill(&bad, &s, &sample);
    assert_int_equal(sample.qdd._length, 0);
    assert_int_equal(tfa_dds_reply_read(&sample, &s, &out), TFA_OK);
    assert_int_equal(out.status, TFA_E_VALUE);
    tfa_dds_reply_fill(&good, &s, &sample); /* without answers: not what the op implies */
    assert_int_equal(tfa_dds_reply_read(&sample, &s, &out), TFA_E_PROTOCOL);
}

/* A sample whose one field is wrong: refused with that field and what it held. */
TEST(wrong_sizes_are_named)
{
    const tfa_request good = full_request(TFA_OP_FORWARD_DYNAMICS, &floating);
    totalforce_dds_Request s = {0};
    tfa_request out;
    tfa_dds_field_error field_error;

#define REFUSED(change, want_status, want_field, want_index)                                       \
    do {                                                                                           \
        assert_int_equal(tfa_dds_request_fill(&good, &floating, &s), TFA_OK);                      \
        change;                                                                                    \
        assert_int_equal(tfa_dds_request_view(&s, &floating, &out, &field_error), want_status);    \
        assert_int_equal(field_error.field, want_field);                                           \
        assert_int_equal(field_error.index, want_index);                                           \
    } while (0)
    REFUSED(s.op = 0, TFA_E_ARGUMENT, TFA_FIELD_OP, 0);
    REFUSED(s.op = 5, TFA_E_ARGUMENT, TFA_FIELD_OP, 5);
    REFUSED(s.count = 0, TFA_E_SIZE, TFA_FIELD_COUNT, 0);
    REFUSED(s.count = BATCH + 1, TFA_E_SIZE, TFA_FIELD_COUNT, BATCH + 1);
    REFUSED(s.count = UINT32_MAX, TFA_E_SIZE, TFA_FIELD_COUNT, UINT32_MAX);
    REFUSED(s.count = 2, TFA_E_SIZE, TFA_FIELD_Q, 3 * Q);
    REFUSED(s.tips._length = 9, TFA_E_SIZE, TFA_FIELD_TIPS, 9);
    REFUSED(s.wrench_frames._length = UINT32_MAX, TFA_E_SIZE, TFA_FIELD_WRENCHES, UINT32_MAX);
    REFUSED(s.wrench_frames._length = 0, TFA_E_SIZE, TFA_FIELD_WRENCHES, 18);
    REFUSED(s.payload_frames._length = 5, TFA_E_SIZE, TFA_FIELD_PAYLOADS, 5);
    REFUSED(s.payload_frames._length = 2, TFA_E_SIZE, TFA_FIELD_PAYLOADS, 30);
    REFUSED(s.payload_frames._length = 0, TFA_E_SIZE, TFA_FIELD_PAYLOADS, 30);
    REFUSED(s.payloads._length = 29, TFA_E_SIZE, TFA_FIELD_PAYLOADS, 29);
    REFUSED(s.locked._length = V + 1, TFA_E_SIZE, TFA_FIELD_LOCKED, V + 1);
    REFUSED(s.locked._length = UINT32_MAX, TFA_E_SIZE, TFA_FIELD_LOCKED, UINT32_MAX);
    REFUSED(s.q._length = 3 * Q - 1, TFA_E_SIZE, TFA_FIELD_Q, 3 * Q - 1);
    REFUSED(s.v._length += 1, TFA_E_SIZE, TFA_FIELD_V, 3 * V + 1);
    REFUSED(s.tau._length = 1, TFA_E_SIZE, TFA_FIELD_TAU, 1);
    REFUSED(s.qdd._length = 1, TFA_E_SIZE, TFA_FIELD_QDD, 1);
    REFUSED(s.base_pose._length = 18, TFA_E_SIZE, TFA_FIELD_BASE_POSE, 18);
    REFUSED(s.base_twist._length = 21, TFA_E_SIZE, TFA_FIELD_BASE_TWIST, 21);
    REFUSED(s.base_wrench._length = 1, TFA_E_SIZE, TFA_FIELD_BASE_WRENCH, 1);
    REFUSED(s.base_acceleration._length = 1, TFA_E_SIZE, TFA_FIELD_BASE_ACCELERATION, 1);
    REFUSED(s.gravity._length = 4, TFA_E_SIZE, TFA_FIELD_GRAVITY, 4);
    REFUSED(s.wrenches._length = 17, TFA_E_SIZE, TFA_FIELD_WRENCHES, 17);
#undef REFUSED
    assert_int_equal(tfa_dds_request_fill(&good, &floating, &s), TFA_OK);
    assert_int_equal(tfa_dds_request_view(&s, &fixed, &out, &field_error), TFA_E_SIZE);
    assert_int_equal(field_error.field, TFA_FIELD_BASE_POSE);
}

/* What a sample cannot carry is refused where it is made. */
TEST(too_much_is_not_sent)
{
    const tfa_request good = full_request(TFA_OP_FORWARD_DYNAMICS, &floating);
    totalforce_dds_Request s = {0};
    tfa_request bad;

#define NOT_SENT(change)                                                                           \
    do {                                                                                           \
        bad = good;                                                                                \
        change;                                                                                    \
        assert_int_equal(tfa_dds_request_fill(&bad, &floating, &s), TFA_E_SIZE);                   \
    } while (0)
    NOT_SENT(bad.tip_count = TFA_MAX_TIPS + 1);
    NOT_SENT(bad.wrench_count = TFA_MAX_WRENCHES + 1);
    NOT_SENT(bad.payload_count = TFA_MAX_PAYLOADS + 1);
    NOT_SENT(bad.locked_count = V + 1);
#undef NOT_SENT
}

/* The hash that goes with an answer is that of the model which gave it. */
TEST(hash_follows_the_model)
{
    const totalforce_dds_Hash present = {0xff, 2, 3, 4, 5, 6, 7, 8, 9};
    const totalforce_dds_Hash other = {0x80, 0, 0, 0, 0, 0, 0, 1};
    totalforce_dds_Hash hash;

    tfa_dds_set_hash(hash, present, 0xff02030405060708u);
    assert_memory_equal(hash, present, sizeof hash);
    tfa_dds_set_hash(hash, present, 0); /* refused before a model saw it */
    assert_memory_equal(hash, present, sizeof hash);
    tfa_dds_set_hash(hash, present, 0x8000000000000001u);
    assert_memory_equal(hash, other, sizeof hash);
}

TEST(torques_become_requests)
{
    totalforce_dds_JointTorques s = {.q = {Q, Q, numbers[0], false},
                                     .tau = {V, V, numbers[2], false}};
    tfa_request r;
    tfa_dds_field_error field_error;

    assert_int_equal(tfa_dds_torques_view(&s, &fixed, &r, &field_error), TFA_OK);
    assert_int_equal(r.op, TFA_OP_FORWARD_DYNAMICS);
    assert_int_equal(r.count, 1);
    assert_int_equal(r.refine, TFA_REFINE_DEFAULT);
    assert_ptr_equal(r.q, numbers[0]);
    assert_null(r.v);
    assert_ptr_equal(r.tau, numbers[2]);
    s.tau._length = V - 1;
    assert_int_equal(tfa_dds_torques_view(&s, &fixed, &r, &field_error), TFA_E_SIZE);
    assert_int_equal(field_error.field, TFA_FIELD_TAU);
    assert_int_equal(field_error.index, V - 1);
}

TEST(names_fit_or_not)
{
    char key[totalforce_dds_ROBOT_NAME_MAX + 1];
    char name[80];

    memset(name, 'a', sizeof name);
    name[63] = '\0';
    assert_true(tfa_dds_set_robot(key, name));
    assert_string_equal(key, name);
    name[63] = 'a';
    name[64] = '\0';
    assert_false(tfa_dds_set_robot(key, name));
}

int main(void)
{
    fill_numbers();
    return test_run(NULL, NULL);
}
