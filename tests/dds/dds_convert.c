/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Requests and replies survive the way through a DDS writer and reader bit by bit, and samples of
 * the wrong size are refused with their field.
 */
#include "dds/topics/dds_convert.h"
#include "dds/topics/dds_topics.h"
#include "dds_test.h"
#include "same_request.h"

#include <math.h>
#include <string.h>

#define Q 9
#define V 8
#define BATCH 4

#define FRAMES 11

#define MODES 5

static const tfa_wire_shape floating = {Q, V, 6, FRAMES, MODES, BATCH, TFA_MAX_TIPS};
static const tfa_wire_shape fixed = {Q, V, 0, FRAMES, 0, BATCH, TFA_MAX_TIPS};

/* Enough numbers for the largest array of a test. */
static double numbers[TFA_WIRE_REQUEST_BLOCKS][BATCH * 48 * 48];

static const uint32_t joints[V] = {7, 0, UINT32_MAX, 3, 4, 5, 6, 1};

static void fill_numbers(void)
{
    uint64_t seed = 1;
    for (size_t i = 0; i < TFA_WIRE_REQUEST_BLOCKS; i++)
        for (size_t k = 0; k < BATCH * 48 * 48; k++)
            numbers[i][k] = test_random(&seed);
}

/* A request that uses every field. */
static tfa_request full_request(tfa_op op, const tfa_wire_shape *shape)
{
    tfa_request r = {.op = op,
                     .method = TFA_METHOD_ABA,
                     .estimate = TFA_ESTIMATE_ALWAYS,
                     .frame = TFA_FRAME_WORLD,
                     .refine = 2,
                     .flags = TFA_WANT_ALL,
                     .rows = TFA_ROWS_POINT,
                     .rank_loss = TFA_RANK_DAMP,
                     .count = 3,
                     .tip_count = 2,
                     .wrench_count = 1,
                     .payload_count = 3,
                     .locked_count = 3,
                     .constraints = 0x8000000a,
                     .tips = {4, 7},
                     .wrench_frames = {5},
                     .payload_frames = {9, UINT32_MAX, 0}};
#define SET(block, member, ...) r.member = (const void *)numbers[TFA_WIRE_##block];
    TFA_INPUT_LIST(SET)
#undef SET
    r.locked = joints;
    if (!shape->base_freedoms)
        r.base_pose = r.base_twist = r.base_wrench = r.base_acceleration = NULL;
    if (!shape->modes)
        r.modes = r.mode_velocities = NULL;
    return r;
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
    const tfa_wire_shape *shapes[] = {&floating, &fixed};
    const pair p = open_pair(TFA_DDS_REQUEST);
    totalforce_dds_Request *out = totalforce_dds_Request__alloc();
    memset(out, 0, sizeof *out);
    for (int s = 0; s < 2; s++)
        for (int op = TFA_OP_FORWARD_DYNAMICS; op <= TFA_OP_LAST; op++) {
            const tfa_request before = full_request((tfa_op)op, shapes[s]);
            totalforce_dds_Request in = {.id = (uint64_t)op, .stamp = -5};
            const request_sizes sizes = {Q, V, shapes[s]->base_freedoms, shapes[s]->modes};
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

/* Points every array of a reply at as many numbers as any test needs. */
static void point_at(tfa_reply *reply, double *at, size_t stride, bool all)
{
#define POINT(block, field, ...)                                                                   \
    reply->field = all ? (void *)at : NULL;                                                        \
    at += stride;
    TFA_OUTPUT_LIST(POINT)
#undef POINT
}

TEST(replies_survive)
{
    enum { STRIDE = BATCH * 48 * 48 };
    static double sent[TFA_WIRE_REPLY_BLOCKS][STRIDE], got[TFA_WIRE_REPLY_BLOCKS][STRIDE];
    const totalforce_dds_Hash hash = {1, 2, 3, 4, 5, 6, 7, 8, 9};
    const pair p = open_pair(TFA_DDS_REPLY);
    totalforce_dds_Reply *out = totalforce_dds_Reply__alloc();
    memset(out, 0, sizeof *out);
    for (size_t k = 0; k < TFA_WIRE_REPLY_BLOCKS; k++)
        memcpy(sent[k], numbers[k % 16], sizeof sent[k]);
    for (int op = TFA_OP_FORWARD_DYNAMICS; op <= TFA_OP_LAST; op++) {
        const tfa_request request = full_request((tfa_op)op, &floating);
        const tfa_wire_reply_shape shape = tfa_wire_reply_shape_of(&floating, &request);
        tfa_reply before = {
            .status = TFA_E_NOT_COMPUTED, .field = TFA_FIELD_BODY, .index = 3, .state = 2};
        tfa_reply after = {0};
        totalforce_dds_Reply in = {.id = 77};
        point_at(&before, sent[0], STRIDE, true);
        point_at(&after, got[0], STRIDE, true);
        tfa_dds_set_hash(in.model_hash, hash, 0x0102030405060708u);
        tfa_dds_reply_fill(&before, &floating, &shape, &in);
        pass(&p, &in, out);
        assert_int_equal(out->id, 77);
        assert_int_equal(tfa_dds_reply_read(out, &floating, &shape, &after), TFA_OK);
        assert_int_equal(after.status, TFA_E_NOT_COMPUTED);
        assert_int_equal(after.field, TFA_FIELD_BODY);
        assert_int_equal(after.index, 3);
        assert_int_equal(after.state, 2);
        assert_true(after.model == 0x0102030405060708u);
        for (uint32_t k = 0; k < TFA_WIRE_REPLY_BLOCKS; k++) {
            if (!(shape.want >> k & 1) || k == TFA_WIRE_ANSWERS || k == TFA_WIRE_SPECTRUM ||
                k == TFA_WIRE_RANK)
                continue; /* these have padding */
            const bool is_empty = k == TFA_WIRE_DELASSUS && !shape.constraints;
            assert_int_equal(tfa_wire_reply_width(&floating, k, &shape) > 0, !is_empty);
            assert_memory_equal(got[k], sent[k], tfa_wire_reply_width(&floating, k, &shape));
        }
    }
    totalforce_dds_Reply_free(out, DDS_FREE_ALL);
    assert_int_equal(dds_delete(p.participant), DDS_RETCODE_OK);
}

/* Structures with padding: member by member */
TEST(structures_survive)
{
    const tfa_request request = full_request(TFA_OP_TASK_TORQUES, &fixed);
    const tfa_wire_reply_shape shape = tfa_wire_reply_shape_of(&fixed, &request);
    const pair p = open_pair(TFA_DDS_REPLY);
    tfa_answer answers[3], answers_out[3];
    tfa_spectrum spectrum[3], spectrum_out[3];
    tfa_rank rank[3], rank_out[3];
    static double rest[TFA_WIRE_REPLY_BLOCKS][BATCH * 48 * 48];
    totalforce_dds_Reply *out = totalforce_dds_Reply__alloc();
    totalforce_dds_Reply in = {.id = 1};
    tfa_reply before = {0}, after = {0};
    memset(out, 0, sizeof *out);
    for (uint16_t i = 0; i < 3; i++) {
        answers[i] = (tfa_answer){TFA_E_NOT_COMPUTED, TFA_METHOD_TFA, TFA_ANSWER_FALLBACK, 0.5};
        spectrum[i] = (tfa_spectrum){6u + i, 0, 1e-300, 1e300};
        rank[i] = (tfa_rank){4u + i, 2, 1e-9, INFINITY, 0.3, 1e-14};
    }
    point_at(&before, rest[0], BATCH * 48 * 48, true);
    before.answers = answers;
    before.spectrum = spectrum;
    before.rank = rank;
    after.answers = answers_out;
    after.spectrum = spectrum_out;
    after.rank = rank_out;
    tfa_dds_reply_fill(&before, &fixed, &shape, &in);
    pass(&p, &in, out);
    assert_int_equal(tfa_dds_reply_read(out, &fixed, &shape, &after), TFA_OK);
    for (int i = 0; i < 3; i++) {
        assert_true(answers_out[i].status == answers[i].status &&
                    answers_out[i].method == answers[i].method &&
                    answers_out[i].flags == answers[i].flags &&
                    answers_out[i].error_estimate == 0.5);
        assert_true(spectrum_out[i].rank == spectrum[i].rank && spectrum_out[i].eig_min == 1e-300 &&
                    spectrum_out[i].eig_max == 1e300);
        assert_true(rank_out[i].rank == rank[i].rank && rank_out[i].lost == 2 &&
                    rank_out[i].threshold == 1e-9 && rank_out[i].length == 0.3 &&
                    rank_out[i].error_estimate == 1e-14 && isinf(rank_out[i].condition));
    }
    totalforce_dds_Reply_free(out, DDS_FREE_ALL);
    assert_int_equal(dds_delete(p.participant), DDS_RETCODE_OK);
}

/* A refusal has no arrays; a reply of another shape than the request implies is not believed. */
TEST(other_shapes_are_not_believed)
{
    tfa_request r = full_request(TFA_OP_FORWARD_DYNAMICS, &fixed);
    const tfa_reply bad = {.status = TFA_E_VALUE, .qdd = numbers[0]};
    const tfa_reply good = {.qdd = numbers[0]};
    totalforce_dds_Reply sample = {0};
    tfa_reply out = {0};
    r.flags = r.tip_count = 0;
    const tfa_wire_reply_shape s = tfa_wire_reply_shape_of(&fixed, &r);
    tfa_dds_reply_fill(&bad, &fixed, &s, &sample);
    assert_int_equal(sample.qdd._length, 0);
    assert_int_equal(tfa_dds_reply_read(&sample, &fixed, &s, &out), TFA_OK);
    assert_int_equal(out.status, TFA_E_VALUE);
    tfa_dds_reply_fill(&good, &fixed, &s, &sample); /* without answers */
    assert_int_equal(sample.qdd._length, 3 * V);
    assert_int_equal(tfa_dds_reply_read(&sample, &fixed, &s, &out), TFA_E_PROTOCOL);
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
    REFUSED(s.op = TFA_OP_LAST + 1, TFA_E_ARGUMENT, TFA_FIELD_OP, TFA_OP_LAST + 1);
    REFUSED(s.rows = 2, TFA_E_ARGUMENT, TFA_FIELD_ROWS, 2);
    REFUSED(s.task_acceleration._length = 19, TFA_E_SIZE, TFA_FIELD_TASK_ACCELERATION, 19);
    REFUSED(s.rank_threshold._length = 2, TFA_E_SIZE, TFA_FIELD_RANK_THRESHOLD, 2);
    REFUSED(s.characteristic_length._length = 2, TFA_E_SIZE, TFA_FIELD_CHARACTERISTIC_LENGTH, 2);
    REFUSED(s.count = 0, TFA_E_SIZE, TFA_FIELD_COUNT, 0);
    REFUSED(s.count = BATCH + 1, TFA_E_SIZE, TFA_FIELD_COUNT, BATCH + 1);
    REFUSED(s.count = UINT32_MAX, TFA_E_SIZE, TFA_FIELD_COUNT, UINT32_MAX);
    REFUSED(s.count = 2, TFA_E_SIZE, TFA_FIELD_Q, 3 * Q);
    REFUSED(s.tips._length = 33, TFA_E_SIZE, TFA_FIELD_TIPS, 33);
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
    REFUSED(s.modes._length = MODES, TFA_E_SIZE, TFA_FIELD_MODES, MODES);
    REFUSED(s.mode_velocities._length = 1, TFA_E_SIZE, TFA_FIELD_MODE_VELOCITIES, 1);
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

/* A stream carries modes both ways. */
TEST(torques_of_flexible_links)
{
    tfa_wire_shape flexible = fixed;
    totalforce_dds_JointTorques s = {.q = {Q, Q, numbers[0], false},
                                     .modes = {MODES, MODES, numbers[1], false}};
    totalforce_dds_JointAccelerations out = {0};
    const tfa_reply reply = {.qdd = numbers[2], .modes = numbers[3]};
    tfa_request r;
    tfa_dds_field_error field_error;
    flexible.modes = MODES;
    assert_int_equal(tfa_dds_torques_view(&s, &flexible, &r, &field_error), TFA_OK);
    assert_ptr_equal(r.modes, numbers[1]);
    assert_null(r.mode_velocities);
    assert_int_equal(tfa_dds_torques_view(&s, &fixed, &r, &field_error), TFA_E_SIZE);
    assert_int_equal(field_error.field, TFA_FIELD_MODES);
    tfa_dds_accelerations_fill(&reply, &flexible, &out);
    assert_int_equal(out.modes._length, MODES);
    assert_ptr_equal(out.modes._buffer, numbers[3]);
    tfa_dds_accelerations_fill(&reply, &fixed, &out);
    assert_int_equal(out.modes._length, 0);
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
