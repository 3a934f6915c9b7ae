/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Requests and replies arrive through slots as they were sent, block by block.
 */
#include "fuzz/random.h"
#include "ipc/wire_reply.h"
#include "same_request.h"
#include "test.h"
#include "wire_slot.h"

static struct random_source numbers_from = {1};

static const void *numbers(size_t count)
{
    double *x = malloc((count + 1) * sizeof *x);
    for (size_t i = 0; i < count; i++)
        x[i] = (double)(random_next(&numbers_from) >> 11);
    return x;
}

/* A request with everything; `without` leaves out block k where bit k is set. */
static tfa_request full_request(const tfa_wire_shape *s, uint32_t without)
{
    tfa_request r = {.op = TFA_OP_CONSTRAINED_DYNAMICS,
                     .method = TFA_METHOD_TFA,
                     .estimate = TFA_ESTIMATE_ALWAYS,
                     .frame = TFA_FRAME_WORLD,
                     .refine = TFA_REFINE_DEFAULT,
                     .flags = TFA_WANT_ALL,
                     .rows = TFA_ROWS_POINT,
                     .rank_loss = TFA_RANK_REFUSE,
                     .count = WIRE_BATCH,
                     .tip_count = 3,
                     .wrench_count = 2,
                     .payload_count = 3,
                     .locked_count = s->v_count, /* odd: the block is padded */
                     .constraints = 0x80000005,
                     .tips = {5, 0, 70000},
                     .wrench_frames = {UINT32_MAX, 4},
                     .payload_frames = {1, UINT32_MAX, 0}};
    const tfa_extents n =
        tfa_extents_of(s->q_count, s->v_count, s->base_freedoms, s->frames, s->modes, &r);
#define SET(block, member, a, b, c)                                                                \
    r.member = without >> TFA_WIRE_##block & 1                                                     \
                   ? NULL                                                                          \
                   : numbers(tfa_extent(EXTENT_##a, &n) * tfa_extent(EXTENT_##b, &n) *             \
                             tfa_extent(EXTENT_##c, &n));
    TFA_INPUT_LIST(SET)
#undef SET
    return r;
}

static void free_request(const tfa_request *r)
{
#define FREE(block, member, ...) free((void *)(uintptr_t)r->member);
    TFA_INPUT_LIST(FREE)
#undef FREE
}

static request_sizes sizes_of(const tfa_wire_shape *s)
{
    return (request_sizes){s->q_count, s->v_count, s->base_freedoms, s->modes};
}

/* A copy of the last form is decoded by its frames and estimate alone; one that differs is not. */
TEST(requests_of_one_form_arrive)
{
    const size_t size = tfa_wire_request_capacity(&wire_dog);
    const request_sizes sizes = sizes_of(&wire_dog);
    tfa_request sent = full_request(&wire_dog, 0), got;
    void *slot = wire_slot(size), *copy = wire_slot(size);
    tfa_wire_reply_shape shape;
    tfa_wire_form form = {0};
    tfa_field field;
    for (uint32_t k = 0; k < 4; k++) {
        sent.tips[0] = sent.wrench_frames[0] = sent.payload_frames[0] = k;
        sent.refine += k == 3;
        assert_int_equal(tfa_wire_encode_request(&wire_dog, &sent, tfa_wire_want(&sent, NULL), k, k,
                                                 slot, &shape, NULL),
                         TFA_OK);
        const bool same = tfa_wire_copy_request(&wire_dog, &form, slot, copy);
        assert_int_equal(same, k == 1 || k == 2);
        if (same) {
            tfa_wire_decode_again(&wire_dog, copy, &got);
        } else {
            assert_int_equal(tfa_wire_decode_request(&wire_dog, copy, &got, &shape, &field),
                             TFA_OK);
            tfa_wire_keep_form(&wire_dog, copy, &shape, &form);
        }
        assert_same_request(&sizes, &sent, &got);
        got.estimate = TFA_ESTIMATE_NEVER; /* as an estimate policy settles it */
    }
    free_request(&sent);
    free(slot);
    free(copy);
}

/* Every subset of the optional blocks arrives as it was sent. */
TEST(requests_arrive)
{
    const size_t size = tfa_wire_request_capacity(&wire_dog);
    const request_sizes sizes = sizes_of(&wire_dog);
    for (uint32_t without = 0; without < 1u << TFA_WIRE_REQUEST_BLOCKS; without++) {
        tfa_request sent = full_request(&wire_dog, without), got;
        void *slot = wire_slot(size), *copy = wire_slot(size);
        tfa_wire_reply_shape reply_shape, asked;
        tfa_field invalid_field;
        assert_int_equal(tfa_wire_encode_request(&wire_dog, &sent, tfa_wire_want(&sent, NULL), 7, 8,
                                                 slot, &reply_shape, NULL),
                         TFA_OK);
        tfa_wire_copy_request(&wire_dog, &(tfa_wire_form){0}, slot, copy);
        assert_int_equal(tfa_wire_decode_request(&wire_dog, copy, &got, &asked, &invalid_field),
                         TFA_OK);
        assert_int_equal(((tfa_wire_request *)copy)->id, 7);
        assert_int_equal(reply_shape.count, asked.count);
        assert_int_equal(reply_shape.tip_count, asked.tip_count);
        assert_int_equal(reply_shape.rows, asked.rows);
        assert_int_equal(reply_shape.want, asked.want);
        assert_same_request(&sizes, &sent, &got);
        free_request(&sent);
        free(slot);
        free(copy);
    }
}

/* Values that tfa_request_check refuses must reach it. */
TEST(nonsense_arrives)
{
    const size_t size = tfa_wire_request_capacity(&wire_arm);
    const double none = 0;
    void *slot = wire_slot(size);
    tfa_request r = {.op = (tfa_op)77,
                     .method = (tfa_method)100000,
                     .frame = (tfa_reference_frame)-1,
                     .count = 0,
                     .rows = (tfa_rows)300,
                     .rank_loss = (tfa_rank_loss)-1,
                     .tip_count = 8,
                     .wrench_count = 100,
                     .payload_count = 1000,
                     .locked_count = UINT32_MAX},
                got;
    r.wrenches = r.payloads = &none;
    r.locked = &r.locked_count;
    tfa_wire_reply_shape reply_shape;
    tfa_field invalid_field;
    assert_int_equal(tfa_wire_encode_request(&wire_arm, &r, 0, 1, 1, slot, &reply_shape, NULL),
                     TFA_OK);
    assert_int_equal(tfa_wire_decode_request(&wire_arm, slot, &got, &reply_shape, &invalid_field),
                     TFA_OK);
    assert_int_equal(got.op, 77);
    assert_int_equal(got.method, 255);
    assert_int_equal(got.rows, 255);
    assert_int_equal(got.rank_loss, 255);
    assert_int_equal(got.frame, 255);
    assert_int_equal(got.count, 0);
    assert_int_equal(got.tip_count, 8);
    assert_int_equal(got.wrench_count, 100);
    assert_int_equal(got.payload_count, 255);
    assert_int_equal(got.locked_count, UINT32_MAX);
    assert_null(got.q);
    assert_null(got.wrenches);
    assert_null(got.payloads);
    assert_null(got.locked);
    free(slot);
}

TEST(replies_arrive)
{
    unsigned char *slot = wire_slot(tfa_wire_reply_capacity(&wire_dog));
    const tfa_request r = {.op = TFA_OP_FORWARD_DYNAMICS,
                           .flags = TFA_WANT_SPECTRUM | TFA_WANT_POSES,
                           .count = 2,
                           .tip_count = 1};
    double qdd[22], base[12], lambda[72], poses[14];
    tfa_answer answers[2];
    tfa_spectrum spectrum[2];
    tfa_reply mine = {.qdd = qdd,
                      .base_acceleration = base,
                      .lambda_inv = lambda,
                      .spectrum = spectrum,
                      .poses = poses,
                      .answers = answers};
    const tfa_wire_reply_shape reply_shape = {
        .count = 2, .tip_count = 1, .rows = 6, .want = tfa_wire_want(&r, &mine)};
    tfa_reply there = {.status = TFA_E_NOT_COMPUTED,
                       .field = TFA_FIELD_BODY,
                       .index = UINT32_MAX,
                       .state = 1,
                       .model = 0x0123456789abcdefu};
    tfa_wire_reply_buffers(&wire_dog, &reply_shape, slot, &there);
    assert_null(there.tau);
    assert_null(there.mass_matrix);
    for (int i = 0; i < 22; i++)
        there.qdd[i] = i;
    there.lambda_inv[71] = 71;
    there.base_acceleration[11] = 11;
    there.spectrum[1].rank = 5;
    there.poses[13] = 13;
    there.answers[1] = (tfa_answer){.status = -15, .method = 3, .error_estimate = 0.5};
    tfa_wire_encode_reply(&there, reply_shape.want, slot);
    assert_int_equal(tfa_wire_decode_reply(slot, &mine), reply_shape.want);
    tfa_wire_copy_answers(&wire_dog, &reply_shape, slot, &mine);
    assert_int_equal(mine.status, TFA_E_NOT_COMPUTED);
    assert_int_equal(mine.field, TFA_FIELD_BODY);
    assert_int_equal(mine.index, UINT32_MAX);
    assert_int_equal(mine.state, 1);
    assert_true(mine.model == 0x0123456789abcdefu);
    assert_true(qdd[21] == 21 && lambda[71] == 71 && base[11] == 11);
    assert_int_equal(spectrum[1].rank, 5);
    assert_true(poses[13] == 13);
    assert_true(answers[1].status == -15 && answers[1].method == 3);
    there.status = TFA_E_VALUE;
    there.model = 1;
    tfa_wire_encode_reply(&there, reply_shape.want, slot);
    assert_int_equal(tfa_wire_decode_reply(slot, &mine), 0);
    assert_true(mine.model == 1); /* a refusal names the model, too */
    free(slot);
}

static uint64_t slot_number(uint32_t block, size_t k)
{
    return (uint64_t)(block + 1) << 32 | k;
}

/* Every block of the replies to every op comes back into its buffer, and into no other; a buffer
 * that is not there is passed over. */
TEST(every_answer_arrives)
{
    enum { WORDS = WIRE_BATCH * 18 * TFA_LINK_PARAMETERS * TFA_DEFAULT_TIPS };
    static uint64_t got[TFA_WIRE_REPLY_BLOCKS][WORDS];
    for (uint32_t k = 0; k < 2 * (TFA_OP_LAST + 1); k++) {
        const tfa_request r = {.op = (tfa_op)(k / 2),
                               .flags = TFA_WANT_ALL,
                               .rows = k & 1 ? TFA_ROWS_POINT : TFA_ROWS_POSE,
                               .count = WIRE_BATCH,
                               .tip_count = 3,
                               .constraints = 0x25};
        tfa_wire_reply_shape shape = tfa_wire_reply_shape_of(&wire_dog, &r);
        unsigned char *slot = wire_slot(tfa_wire_reply_capacity(&wire_dog));
        tfa_reply there = {0}, here = {0};
        tfa_wire_reply_buffers(&wire_dog, &shape, slot, &there);
        memset(got, 0, sizeof got);
#define FILL(block, field, ...)                                                                    \
    for (size_t w = 0;                                                                             \
         there.field && w < tfa_wire_reply_width(&wire_dog, TFA_WIRE_##block, &shape) / 8; w++)    \
        ((uint64_t *)(void *)there.field)[w] = slot_number(TFA_WIRE_##block, w);                   \
    here.field = TFA_WIRE_##block == k ? NULL : (void *)got[TFA_WIRE_##block];
        TFA_OUTPUT_LIST(FILL)
#undef FILL
        assert_int_equal(tfa_wire_want(&r, NULL), k < 2 ? 0 : shape.want);
        tfa_wire_copy_answers(&wire_dog, &shape, slot, &here);
        for (uint32_t block = 0; block < TFA_WIRE_REPLY_BLOCKS; block++)
            for (size_t w = 0; w < WORDS; w++) {
                const size_t words = tfa_wire_reply_width(&wire_dog, block, &shape) / 8;
                const bool there_is = shape.want >> block & 1 && block != k && w < words;
                assert_true(words <= WORDS);
                assert_true(got[block][w] == (there_is ? slot_number(block, w) : 0));
            }
        free(slot);
    }
}
